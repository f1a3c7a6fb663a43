#include "vdbpack/image/ball_means.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/image/ball_voxels.h"
#include "vdbpack/image/image_values.h"

#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

/// Points in a ball that no center of a voxel lies in.
constexpr int kPoints = 100;

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

template <class T>
double meanOver(const ImageGrid& grid, const ImageValues<T>& values, const Sphere<3>& ball,
                const Vec<3>& reach, const std::vector<Vec<3>>& points) {
    const Vec<3> center = grid.indexOf(ball.center);
    for (std::size_t d = 0; d < 3; ++d) {
        const double r = reach.c[d] * ball.radius, x = center.c[d];
        if (!(x + r >= -0.5 && x - r <= static_cast<double>(grid.size[d]) - 0.5))
            return std::numeric_limits<double>::quiet_NaN();
    }
    double sum = 0;
    std::uint64_t count = 0;
    forEachVoxelIn(grid, reach, ball, slicesOf(grid, reach, ball), [&](std::size_t voxel) {
        sum += values.value(voxel);
        ++count;
    });
    if (count > 0) return sum / static_cast<double>(count);
    sum = 0;
    for (const Vec<3>& p : points)
        sum += values.interpolated(grid.indexOf(ball.center + ball.radius * p));
    return sum / kPoints;
}

void requireOneLayer(const Image& image) {
    if (image.layers != 1)
        throw InputError("an image with several values at each voxel has no mean; give one layer");
}

}  // namespace

std::vector<double> ballMeans(const Image& image, const std::vector<Sphere<3>>& spheres) {
    requireOneLayer(image);
    requireUsable(spheres);
    const Vec<3> reach = image.grid.reach();
    const std::vector<Vec<3>> points = unitBall();
    std::vector<double> means(spheres.size());
    image.visit([&](const auto* numbers) {
        const ImageValues values(image, numbers);
        parallelFor(IndexRange(0, spheres.size(), 256), [&](const IndexRange& block) {
            for (std::size_t i = block.begin(); i < block.end(); ++i)
                means[i] = meanOver(image.grid, values, spheres[i], reach, points);
        });
    });
    return means;
}

ImageSampler::ImageSampler(Image image) : image_(std::move(image)), indexer_(image_.grid) {
    requireOneLayer(image_);
}

double ImageSampler::at(const Vec<3>& point) const {
    return image_.visit([&](const auto* numbers) {
        return ImageValues(image_, numbers).interpolated(indexer_.indexOf(point));
    });
}

}  // namespace vdbpack
