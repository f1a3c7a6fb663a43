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

    double value(std::size_t voxel) const {
        return image_.slope * static_cast<double>(numbers_[voxel]) + image_.intercept;
    }
    /// Trilinear; beyond the voxels, the value at the nearest one.
    double interpolated(const Vec<3>& index) const {
        const auto& size = image_.grid.size;
        std::array<std::size_t, 3> low{};
        std::array<double, 3> share{};
        for (std::size_t d = 0; d < 3; ++d) {
            const auto last = static_cast<double>(size[d] - 1);
            const double x = std::clamp(index.c[d], 0.0, last);
            low[d] = static_cast<std::size_t>(std::min(std::floor(x), std::max(0.0, last - 1)));
            share[d] = x - static_cast<double>(low[d]);
        }
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            auto at = low;
            double weight = 1;
            for (std::size_t d = 0; d < 3; ++d) {
                const bool up = corner >> d & 1;
                weight *= up ? share[d] : 1 - share[d];
                at[d] += up ? 1 : 0;
            }
            if (weight > 0) sum += weight * value((at[2] * size[1] + at[1]) * size[0] + at[0]);
        }
        return sum;
    }

private:
    const Image& image_;
    const T* numbers_;
};

}  // namespace vdbpack
