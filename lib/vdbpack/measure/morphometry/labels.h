// Private to measure: the labels of a voxel image.
#pragma once

#include "vdbpack/field/voxel_image.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace vdbpack {

/// The total volume: all labels but 0.
inline constexpr int kAllLabels = -1;

/// Of a voxel; 1 in an image without labels.
inline int labelOf(const VoxelImage& image, std::size_t voxel) {
    return image.label.empty() ? 1 : image.label[voxel];
}

/// Whether a voxel has `label`, or one of all but 0.
inline bool isLabeled(const VoxelImage& image, std::size_t voxel, int label) {
    const int own = labelOf(image, voxel);
    return label == kAllLabels ? own != 0 : own == label;
}

/// One more than the highest label, at least 2.
inline std::size_t labelCount(const VoxelImage& image) {
    std::size_t count = 2;
    for (const std::uint8_t label : image.label) count = std::max<std::size_t>(count, label + 1u);
    return count;
}

}  // namespace vdbpack
