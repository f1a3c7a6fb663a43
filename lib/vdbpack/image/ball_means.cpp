#include "vdbpack/image/ball_means.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

/// Voxels in a ball whose mean is its own, and points in one that has fewer.
constexpr int kVoxels = 20, kPoints = 100;

/// Points spread evenly over the unit ball.
std::vector<Vec<3>> unitBall() {
    std::vector<Vec<3>> points;
    // The additive recurrence of three dimensions (Roberts 2018), in a cube around the ball.
    constexpr double kSteps[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (int k = 0; static_cast<int>(points.size()) < kPoints; ++k) {
        Vec<3> x;
        for (int d = 0; d < 3; ++d) x[d] = 2 * std::fmod((k + 0.5) * kSteps[d], 1.0) - 1;
        if (squaredLength(x) <= 1) points.push_back(x);
    }
    return points;
}

/// An image that knows its value anywhere.
template <class T>
class Values {
public:
    Values(const Image& image, const T* numbers) : image_(image), numbers_(numbers) {}

    /// @param at  whole indices, within the image.
    double value(const std::array<std::int64_t, 3>& at) const {
        const auto& size = image_.grid.size;
        const std::size_t i =
            (static_cast<std::size_t>(at[2]) * size[1] + static_cast<std::size_t>(at[1])) *
                size[0] +
            static_cast<std::size_t>(at[0]);
        return image_.slope * static_cast<double>(numbers_[i]) + image_.intercept;
    }
    /// Trilinear.
    double interpolated(const Vec<3>& index) const {
        std::array<std::int64_t, 3> low{};
        std::array<double, 3> share{};
        for (std::size_t d = 0; d < 3; ++d) {
            const auto last = static_cast<double>(image_.grid.size[d] - 1);
            const double x = std::clamp(index.c[d], 0.0, last);
            low[d] = static_cast<std::int64_t>(std::min(std::floor(x), std::max(0.0, last - 1)));
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
            if (weight > 0) sum += weight * value(at);
        }
        return sum;
    }
    double meanOver(const Sphere<3>& ball, const Vec<3>& reach,
                    const std::vector<Vec<3>>& points) const {
        const ImageGrid& grid = image_.grid;
        const Vec<3> center = grid.indexOf(ball.center);
        std::array<std::int64_t, 3> low{}, high{};
        for (std::size_t d = 0; d < 3; ++d) {
            const double r = reach.c[d] * ball.radius, x = center.c[d];
            const auto last = static_cast<double>(grid.size[d] - 1);
            if (!(x + r >= -0.5 && x - r <= last + 0.5))
                return std::numeric_limits<double>::quiet_NaN();
            low[d] = static_cast<std::int64_t>(std::ceil(std::max(0.0, x - r)));
            high[d] = static_cast<std::int64_t>(std::floor(std::min(last, x + r)));
        }
        double sum = 0;
        std::uint64_t count = 0;
        for (std::int64_t z = low[2]; z <= high[2]; ++z)
            for (std::int64_t y = low[1]; y <= high[1]; ++y)
                for (std::int64_t x = low[0]; x <= high[0]; ++x) {
                    const Vec<3> at = grid.at(
                        {{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}});
                    if (squaredLength(at - ball.center) > ball.radius * ball.radius) continue;
                    sum += value({x, y, z});
                    ++count;
                }
        if (count >= kVoxels) return sum / static_cast<double>(count);
        sum = 0;
        for (const Vec<3>& p : points)
            sum += interpolated(grid.indexOf(ball.center + ball.radius * p));
        return sum / kPoints;
    }

private:
    const Image& image_;
    const T* numbers_;
};

}  // namespace

std::vector<double> ballMeans(const Image& image, const std::vector<Sphere<3>>& spheres) {
    if (image.layers != 1)
        throw InputError("an image with several values at each voxel has no mean; give one layer");
    requireUsable(spheres);
    // How far a ball of radius 1 reaches along each index: lengths of the dual steps.
    const ImageGrid& grid = image.grid;
    const double volume = std::fabs(grid.signedVoxelVolume());
    const Vec<3> reach{{length(cross(grid.step[1], grid.step[2])) / volume,
                        length(cross(grid.step[2], grid.step[0])) / volume,
                        length(cross(grid.step[0], grid.step[1])) / volume}};
    const std::vector<Vec<3>> points = unitBall();
    std::vector<double> means(spheres.size());
    image.visit([&](const auto* numbers) {
        const Values values(image, numbers);
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, spheres.size(), 256),
                          [&](const tbb::blocked_range<std::size_t>& block) {
                              for (std::size_t i = block.begin(); i < block.end(); ++i)
                                  means[i] = values.meanOver(spheres[i], reach, points);
                          });
    });
    return means;
}

}  // namespace vdbpack
