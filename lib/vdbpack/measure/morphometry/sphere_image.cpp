#include "vdbpack/measure/morphometry/sphere_image.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdbpack {

namespace {

constexpr double kBand = 3;        // voxels
constexpr std::int64_t kSlab = 8;  // slices that one task fills

/// Lowers the distances of one slab to those to a sphere.
class SlabStamp {
public:
    SlabStamp(VoxelImage& image, std::int64_t slab)
        : image_(image), low_(slab * kSlab), end_(std::min(image.size[2], low_ + kSlab)) {}

    void clear(float value) {
        const std::int64_t slice = image_.size[0] * image_.size[1];
        std::fill(image_.distance.begin() + low_ * slice, image_.distance.begin() + end_ * slice,
                  value);
    }

    void add(const Sphere<3>& s, double radius) {
        const double h = image_.voxelSize, deepest = kBand * h, reach = radius + deepest;
        std::array<std::int64_t, 3> from{}, to{};
        for (std::size_t j = 0; j < 3; ++j) {
            const double c = s.center.c[j] - image_.origin.c[j];
            const double last = static_cast<double>(image_.size[j] - 1);
            from[j] = static_cast<std::int64_t>(std::clamp(std::ceil((c - reach) / h), 0.0, last));
            to[j] = static_cast<std::int64_t>(std::clamp(std::floor((c + reach) / h), 0.0, last));
        }
        for (std::int64_t z = std::max(from[2], low_); z <= std::min(to[2], end_ - 1); ++z)
            for (std::int64_t y = from[1]; y <= to[1]; ++y) {
                const double dy = at(1, y) - s.center[1], dz = at(2, z) - s.center[2];
                const double across = dy * dy + dz * dz;
                float* row = &image_.distance[static_cast<std::size_t>((z * image_.size[1] + y) *
                                                                       image_.size[0])];
                for (std::int64_t x = from[0]; x <= to[0]; ++x) {
                    const double dx = at(0, x) - s.center[0];
                    const double d = std::sqrt(dx * dx + across) - radius;
                    row[x] = std::min(row[x], static_cast<float>(std::max(d, -deepest)));
                }
            }
    }

private:
    double at(int axis, std::int64_t i) const {
        return image_.origin[axis] + static_cast<double>(i) * image_.voxelSize;
    }

    VoxelImage& image_;
    std::int64_t low_, end_;
};

}  // namespace

VoxelImage sphereImage(const std::vector<Sphere<3>>& spheres, double dilation, const Box<3>& bounds,
                       double voxelSize, double margin) {
    if (!(dilation >= 0) || !std::isfinite(dilation))
        throw ParameterError(fmt::format("`dilation` {} mm; give 0 or more", dilation));
    if (!(voxelSize > 0) || !std::isfinite(voxelSize) || bounds.empty())
        throw ParameterError(
            fmt::format("image of spheres: voxel size {} mm; give a positive one, and bounds that "
                        "are not empty",
                        voxelSize));
    std::array<double, 3> count{};
    Vec<3> first;
    for (int j = 0; j < 3; ++j) {
        count[static_cast<std::size_t>(j)] =
            std::max(1.0, std::ceil((bounds.hi[j] - bounds.lo[j]) / voxelSize - 1e-6));
        first[j] = bounds.lo[j] + 0.5 * voxelSize;
    }
    VoxelImage image =
        emptyImage(first, count, voxelSize, std::ceil(std::max(margin / voxelSize - 1e-9, 0.0)));
    const std::int64_t slabs = (image.size[2] + kSlab - 1) / kSlab;
    std::vector<std::vector<std::size_t>> members(static_cast<std::size_t>(slabs));
    const double slab = static_cast<double>(kSlab) * voxelSize;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const double reach = spheres[i].radius + dilation + kBand * voxelSize;
        const double z = spheres[i].center[2] - image.origin[2];
        const double low = std::floor((z - reach) / slab), high = std::floor((z + reach) / slab);
        const double last = static_cast<double>(slabs - 1);
        if (high < 0 || low > last) continue;
        for (auto s = static_cast<std::size_t>(std::max(low, 0.0));
             s <= static_cast<std::size_t>(std::min(high, last)); ++s)
            members[s].push_back(i);
    }
    parallelFor(std::int64_t{0}, slabs, [&](std::int64_t s) {
        SlabStamp stamp(image, s);
        stamp.clear(static_cast<float>(kBand * voxelSize));
        for (const std::size_t i : members[static_cast<std::size_t>(s)])
            stamp.add(spheres[i], spheres[i].radius + dilation);
    });
    return image;
}

}  // namespace vdbpack
