// Private to image: values of an image at and between its voxels.
#pragma once

#include "vdbpack/image/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace vdbpack {

template <class T>
class ImageValues {
public:
    /// @param image  of one layer.
    ImageValues(const Image& image, const T* numbers) : image_(image), numbers_(numbers) {}

    double value(std::size_t voxel) const { return image_.value(numbers_[voxel]); }
    /// Trilinear; beyond the voxels, the value at the nearest one.
    double interpolated(const Vec<3>& index) const {
        const auto& size = image_.grid.size;
        std::array<std::size_t, 3> low{};
        std::array<double, 3> share{};
        for (std::size_t d = 0; d < 3; ++d) {
            const auto last = static_cast<double>(size[d] - 1);
            const double x = std::clamp(index.c[d], 0.0, last);
            low[d] = static_cast<std::size_t>(
                static_cast<std::ptrdiff_t>(std::min(x, std::max(0.0, last - 1))));
            share[d] = x - static_cast<double>(low[d]);
        }
        // Along an axis on which it lies at a voxel's center, that voxel alone counts.
        double sum = 0;
        const auto up = [&](std::size_t d) { return std::size_t{share[d] > 0}; };
        const auto weight = [&](std::size_t d, std::size_t at) {
            return at > 0 ? share[d] : 1 - share[d];
        };
        for (std::size_t k = 0; k <= up(2); ++k)
            for (std::size_t j = 0; j <= up(1); ++j)
                for (std::size_t i = 0; i <= up(0); ++i)
                    sum += weight(0, i) * weight(1, j) * weight(2, k) *
                           value(((low[2] + k) * size[1] + low[1] + j) * size[0] + low[0] + i);
        return sum;
    }

private:
    const Image& image_;
    const T* numbers_;
};

}  // namespace vdbpack
