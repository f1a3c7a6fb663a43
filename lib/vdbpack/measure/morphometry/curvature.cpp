#include "vdbpack/measure/morphometry/curvature.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/measure/morphometry/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace vdbpack {

namespace {

/// The squares between the centers of four voxels in one plane, and what the surface does there.
class Squares {
public:
    explicit Squares(const VoxelImage& image)
        : image_(image),
          size_{static_cast<std::size_t>(image.size[0]), static_cast<std::size_t>(image.size[1]),
                static_cast<std::size_t>(image.size[2])},
          stride_{1, size_[0], size_[0] * size_[1]} {}

    /// Adds the terms of the squares across `axis` that begin in slice `z`.
    void addSlice(std::size_t axis, std::size_t z, std::vector<double>& byLabel) const {
        std::array<std::size_t, 3> from{0, 0, 0}, to{size_[0] - 1, size_[1] - 1, size_[2] - 1};
        from[axis] = 1;  // a square has a cube on either side
        if (z < from[2] || z >= to[2]) return;
        const std::size_t b = stride_[(axis + 1) % 3], c = stride_[(axis + 2) % 3];
        const float* d = image_.distance.data();
        for (std::size_t y = from[1]; y < to[1]; ++y)
            for (std::size_t x = from[0]; x < to[0]; ++x) {
                const std::size_t voxel = z * stride_[2] + y * stride_[1] + x;
                const bool solid = d[voxel] < 0;
                if ((d[voxel + b] < 0) != solid || (d[voxel + c] < 0) != solid ||
                    (d[voxel + b + c] < 0) != solid)
                    addSquare(axis, voxel, weight(axis, {x, y, z}), byLabel);
            }
    }

private:
    /// A point of the surface on the rim of a square.
    struct RimPoint {
        double b = 0, c = 0;    // along the two axes of the square
        std::size_t label = 0;  // of its solid voxel
        bool enters = false;    // the solid, going around from axis b to axis c
    };

    /// More than 1 next to the faces of the image, for the half voxels beyond the outer centers.
    double weight(std::size_t axis, const std::array<std::size_t, 3>& at) const {
        double product = 1;
        for (std::size_t j = 0; j < 3; ++j) {
            const std::size_t first = j == axis ? 1 : 0;
            const int outer = int{at[j] == first} + int{at[j] + 2 == size_[j]};
            product *= 1 + (j == axis ? 1.0 : 0.5) * outer;
        }
        return product;
    }

    void addSquare(std::size_t axis, std::size_t voxel, double weight,
                   std::vector<double>& byLabel) const {
        const std::size_t b = stride_[(axis + 1) % 3], c = stride_[(axis + 2) % 3];
        const std::array<std::size_t, 4> corner{voxel, voxel + b, voxel + b + c, voxel + c};
        constexpr std::array<std::array<double, 2>, 4> kPlace{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
        std::array<RimPoint, 4> rim;
        std::size_t points = 0;
        double sum = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t l = (k + 1) % 4;
            const double p = image_.distance[corner[k]], q = image_.distance[corner[l]];
            sum += p;
            if ((p < 0) == (q < 0)) continue;
            const double t = p / (p - q);
            RimPoint& point = rim[points++];
            point.b = kPlace[k][0] + t * (kPlace[l][0] - kPlace[k][0]);
            point.c = kPlace[k][1] + t * (kPlace[l][1] - kPlace[k][1]);
            point.label = static_cast<std::size_t>(labelOf(image_, corner[p < 0 ? k : l]));
            point.enters = q < 0;
        }
        const Vec<3> turn = rotation(normal(voxel - stride_[axis]), normal(voxel));
        for (std::size_t k = 0; k < points; ++k) {
            if (!rim[k].enters) continue;
            // Two solid voxels at opposite corners are connected if the mean distance is negative;
            // then the lines part the other two corners from them.
            const RimPoint& from = rim[k];
            const RimPoint& to = rim[(k + (points == 4 && sum < 0 ? points - 1 : 1)) % points];
            // The solid lies to the right of the line from one to the other, so that the line
            // times the normal points from the lower cube to the upper one.
            const double term = weight * (turn[static_cast<int>((axis + 1) % 3)] * (to.b - from.b) +
                                          turn[static_cast<int>((axis + 2) % 3)] * (to.c - from.c));
            byLabel[from.label] += 0.5 * term;
            byLabel[to.label] += 0.5 * term;
        }
    }

    /// Direction of the gradient in the middle of the cube that begins at a voxel.
    Vec<3> normal(std::size_t voxel) const {
        const float* d = image_.distance.data() + voxel;
        const std::size_t y = stride_[1], z = stride_[2];
        const double d0 = d[0], dx = d[1], dy = d[y], dxy = d[y + 1];
        const double dz = d[z], dxz = d[z + 1], dyz = d[z + y], dxyz = d[z + y + 1];
        return normalized(Vec<3>{{(dx - d0) + (dxy - dy) + (dxz - dz) + (dxyz - dyz),
                                  (dy - d0) + (dxy - dx) + (dyz - dz) + (dxyz - dxz),
                                  (dz - d0) + (dxz - dx) + (dyz - dy) + (dxyz - dxy)}});
    }

    /// From one direction to another, as axis times angle; none between opposite ones.
    static Vec<3> rotation(const Vec<3>& from, const Vec<3>& to) {
        const Vec<3> across = cross(from, to);
        const double sine = length(across);
        return sine > 0 ? across * (std::atan2(sine, dot(from, to)) / sine) : Vec<3>{};
    }

    const VoxelImage& image_;
    std::array<std::size_t, 3> size_, stride_;
};

}  // namespace

std::vector<double> curvatureIntegrals(const VoxelImage& image) {
    if (*std::min_element(image.size.begin(), image.size.end()) < 3) return {};
    const Squares squares(image);
    const auto slices = static_cast<std::size_t>(image.size[2]);
    const std::size_t labels = labelCount(image);
    std::vector<std::vector<double>> bySlice(slices);
    parallelFor(std::size_t{0}, slices, [&](std::size_t z) {
        bySlice[z].assign(labels, 0.0);
        for (std::size_t axis = 0; axis < 3; ++axis) squares.addSlice(axis, z, bySlice[z]);
    });
    std::vector<double> total(labels, 0.0);
    for (const auto& sums : bySlice)
        for (std::size_t label = 0; label < labels; ++label) total[label] += sums[label];
    return total;
}

}  // namespace vdbpack
