// Label maps and grey images as arrays.
#pragma once

#include "vdbpack/image/image_grid.h"
#include "vdbpack/io/byte_order.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace vdbpack {

/// A name that a file gives to a label.
struct LabelName {
    std::string name;
    std::int64_t value = 0;
    std::size_t layer = 0;
};

/// Memory for voxels, not set to anything; null where there is not enough.
inline std::shared_ptr<std::byte[]> voxelMemory(std::size_t bytes) {
    return {static_cast<std::byte*>(std::malloc(std::max<std::size_t>(bytes, 1))), std::free};
}

/// Values at the voxels of a grid, as a file has them.
struct Image {
    ImageGrid grid;
    std::size_t layers = 1;  ///< values of each voxel, one after another: overlapping segmentations
    NumberType type = NumberType::u8;  ///< no integer of 64 bits
    /// Of all values in this machine's order; copies of an image share them.
    std::shared_ptr<std::byte[]> bytes;
    double slope = 1, intercept = 0;  ///< value = slope * number + intercept
    bool isRounded = false;           ///< each value is the nearest whole number to that
    std::vector<LabelName> names;     ///< empty: the file has none
    std::string format;               ///< such as "NIfTI"
    bool isSpaced = true;             ///< the file states the distances of its voxels
    /// The file says which sides of a patient its axes point to; else they are taken as LPS.
    bool isSided = true;
    double unit = 0;  ///< mm, of the unit that the file states; 0: it states none

    std::size_t values() const { return grid.voxels() * layers; }
    /// What a number of the file stands for.
    template <class T>
    double value(T number) const {
        const double exact = slope * static_cast<double>(number) + intercept;
        return isRounded ? std::round(exact) : exact;
    }
    /// Calls `work(numbers)` with the array in its own type.
    template <class Work>
    decltype(auto) visit(const Work& work) const {
        const std::byte* const data = bytes.get();
        switch (type) {
            case NumberType::i8:
                return work(reinterpret_cast<const std::int8_t*>(data));
            case NumberType::u16:
                return work(reinterpret_cast<const std::uint16_t*>(data));
            case NumberType::i16:
                return work(reinterpret_cast<const std::int16_t*>(data));
            case NumberType::u32:
                return work(reinterpret_cast<const std::uint32_t*>(data));
            case NumberType::i32:
                return work(reinterpret_cast<const std::int32_t*>(data));
            case NumberType::f32:
                return work(reinterpret_cast<const float*>(data));
            case NumberType::f64:
                return work(reinterpret_cast<const double*>(data));
            default:
                break;
        }
        return work(reinterpret_cast<const std::uint8_t*>(data));
    }
};

}  // namespace vdbpack
