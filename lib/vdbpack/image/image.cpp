#include "vdbpack/image/image.h"

namespace vdbpack {

std::size_t bytesOf(VoxelType type) {
    switch (type) {
        case VoxelType::uint8:
        case VoxelType::int8:
            return 1;
        case VoxelType::uint16:
        case VoxelType::int16:
            return 2;
        case VoxelType::uint32:
        case VoxelType::int32:
        case VoxelType::float32:
            return 4;
        case VoxelType::float64:
            break;
    }
    return 8;
}

const char* nameOf(VoxelType type) {
    constexpr const char* kNames[] = {"uint8",  "int8",  "uint16",  "int16",
                                      "uint32", "int32", "float32", "float64"};
    return kNames[static_cast<std::size_t>(type)];
}

}  // namespace vdbpack
