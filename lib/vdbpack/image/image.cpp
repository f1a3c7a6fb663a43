#include "vdbpack/image/image.h"

#include "vdbpack/core/error.h"

#include <algorithm>

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

Image copyOf(const Image& image) {
    Image copy;
    copy.grid = image.grid;
    copy.layers = image.layers;
    copy.type = image.type;
    copy.slope = image.slope;
    copy.intercept = image.intercept;
    copy.names = image.names;
    copy.format = image.format;
    copy.isSpaced = image.isSpaced;
    const std::size_t bytes = image.values() * bytesOf(image.type);
    copy.bytes.reset(static_cast<std::byte*>(std::malloc(std::max<std::size_t>(bytes, 1))));
    if (!copy.bytes) throw ResourceError("an image of this size does not fit into memory");
    std::copy_n(image.bytes.get(), bytes, copy.bytes.get());
    return copy;
}

}  // namespace vdbpack
