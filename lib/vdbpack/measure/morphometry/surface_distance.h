// Private to measure: where the surface of a voxel image lies, and which point of it is nearest.
#pragma once

#include "vdbpack/field/voxel_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A place in units of the voxel size about the center of voxel (0, 0, 0), or a direction.
using Place = std::array<float, 3>;

inline float dot(const Place& a, const Place& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Where an edge between the centers of two neighboring voxels leaves the solid.
struct SurfacePoint {
    Place at;
    Place normal;  ///< unit, out of the solid
    /// Surface that the point stands for, voxel faces; 0 if its solid is not in the total volume.
    float area = 0;
    std::uint32_t axis = 0;  ///< of the edge
};

/// All surface points of an image, and the nearest one of each voxel.
struct SurfaceDistance {
    std::vector<SurfacePoint> points;
    std::vector<std::uint32_t> nearest;  ///< one a voxel; empty if there is no surface
    std::array<double, 3> edges{};       ///< along each axis, of the total volume: half to a voxel
};

/// The surface where the distances between voxels of opposite sign vanish (a parabola through
/// four of them), its normals by differences, and the exact Euclidean feature transform of the
/// points.
///
/// A surface element of normal n is met by |n_x| + |n_y| + |n_z| edges a voxel face of it, hence
/// the area of a point.
///
/// Points on edges along one axis share their lines: a pass along that axis finds the nearest
/// point on each line between lattice places, lower envelopes of parabolas along the two others do
/// the rest (Felzenszwalb, Huttenlocher 2012, doi:10.4086/toc.2012.v008a019); the nearest of the
/// three axes wins. The same for any number of threads.
/// @throws ResourceError above 2^32 - 2 points.
SurfaceDistance surfaceDistance(const VoxelImage& image);

/// Second difference of the distances a, b of two neighbors from those before and after them on
/// their line. Beyond a radius of curvature of two voxels it is an edge or the next wall.
inline float boundedBend(float before, float a, float b, float after, float voxelSize) {
    const float bend = 0.5f * (before - a - b + after);
    return std::min(std::max(bend, -0.5f * voxelSize), 0.5f * voxelSize);
}

/// How far a place is from the surface around a surface point, and which way leads off.
struct Clearance {
    float distance = 0;  ///< voxels
    Place direction{};   ///< unit
    bool flat = false;   ///< by the tangent plane of the point; else by the point itself
};

/// The surface is taken to be flat up to half a voxel's diagonal around each point, as far as the
/// nearest one can be off; beyond that lies an edge or another wall, and the point itself counts.
inline Clearance clearance(const Place& x, const SurfacePoint& point, float side) {
    constexpr float kFlat = 0.87f;
    const Place w{x[0] - point.at[0], x[1] - point.at[1], x[2] - point.at[2]};
    const Place n{side * point.normal[0], side * point.normal[1], side * point.normal[2]};
    const float square = dot(w, w);
    const float height = dot(w, n);
    if (height > 0 && square - height * height <= kFlat * kFlat) return {height, n, true};
    const float length = std::sqrt(square);
    if (!(length > 0)) return {0, n, false};
    return {length, {w[0] / length, w[1] / length, w[2] / length}, false};
}

}  // namespace vdbpack
