#include "vdbpack/image/ball_means.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/image/ball_voxels.h"
#include "vdbpack/image/image_values.h"

#include <cmath>
#include <limits>
#include <type_traits>
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
    const auto add = [&](double value) {
        if (std::isnan(value)) return;
        sum += value;
        ++count;
    };
    forEachVoxelIn(grid, reach, ball, slicesOf(grid, reach, ball),
                   [&](std::size_t voxel) { add(values.value(voxel)); });
    if (count == 0)
        for (const Vec<3>& p : points)
            add(values.interpolated(grid.indexOf(ball.center + ball.radius * p)));
    return sum / static_cast<double>(count);
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

std::size_t fillFromNearest(Image& image) {
    if (!isReal(image.type)) return 0;
    requireOneLayer(image);
    std::vector<std::size_t> open;  // known voxels, the nearest to the first ones first
    std::size_t filled = 0;
    const auto& size = image.grid.size;
    const std::size_t step[3] = {1, size[0], size[0] * size[1]};
    image.visit([&](auto* constant) {
        using T = std::remove_const_t<std::remove_pointer_t<decltype(constant)>>;
        auto* const numbers = const_cast<T*>(constant);
        const auto unknown = [&](std::size_t i) { return numbers[i] != numbers[i]; };
        const auto forEachUnknownBeside = [&](std::size_t i, const auto& work) {
            for (std::size_t d = 0; d < 3; ++d) {
                const std::size_t at = i / step[d] % size[d];
                if (at > 0 && unknown(i - step[d])) work(i - step[d]);
                if (at + 1 < size[d] && unknown(i + step[d])) work(i + step[d]);
            }
        };
        for (std::size_t i = 0; i < image.values(); ++i) {
            bool border = false;
            if (!unknown(i)) forEachUnknownBeside(i, [&](std::size_t) { border = true; });
            if (border) open.push_back(i);
        }
        if (open.empty() && unknown(0)) throw InputError("no voxel of the image is a number");
        for (std::size_t k = 0; k < open.size(); ++k)
            forEachUnknownBeside(open[k], [&](std::size_t i) {
                numbers[i] = numbers[open[k]];
                open.push_back(i);
                ++filled;
            });
    });
    return filled;
}

}  // namespace vdbpack
