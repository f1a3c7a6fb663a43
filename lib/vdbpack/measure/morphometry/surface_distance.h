// Private to measure: points on the surface of a voxel image, and the nearest one of each voxel.
#pragma once

#include "vdbpack/field/voxel_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A position in voxels relative to the center of voxel (0, 0, 0), or a direction.
using Place = std::array<float, 3>;

inline float dot(const Place& a, const Place& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The point where an edge between the centers of two neighboring voxels leaves the solid.
struct SurfacePoint {
    Place at;
    Place normal;  ///< unit, pointing out of the solid
    /// Area that the point represents, in voxel faces; 0 if its solid voxel is not in the total
    /// volume.
    float area = 0;
    std::uint8_t axis = 0;   ///< of the edge
    std::uint8_t label = 0;  ///< of its solid voxel; 1 in images without labels
};

/// All surface points of an image, and the nearest one of each voxel.
struct SurfaceDistance {
    std::vector<SurfacePoint> points;
    std::vector<std::uint32_t> nearest;  ///< one per voxel; empty if there is no surface
    /// By label, number of edges along each axis; each voxel counts half an edge on either side.
    std::vector<std::array<double, 3>> edges;
};

/// The surface points between voxels of opposite sign, where a parabola through four distances
/// vanishes; their normals by finite differences; and the exact Euclidean feature transform of the
/// points.
///
/// A surface element with normal n and the area of one voxel face is crossed by
/// |n_x| + |n_y| + |n_z| edges, from which the area of a point follows.
///
/// The nearest point is found for the points on edges along each axis separately: a pass along that
/// axis finds the nearest point on each line, and lower envelopes of parabolas along the two other
/// axes complete the search (Felzenszwalb, Huttenlocher 2012, doi:10.4086/toc.2012.v008a019). The
/// nearest of the three results is kept. The same for any number of threads.
/// @throws ResourceError above 2^32 - 2 points.
SurfaceDistance surfaceDistance(const VoxelImage& image);

/// Mean of the second differences at two neighbors with distances a and b, from the
/// distances before and after them on their line. Bounded: a larger value than that of a radius of
/// curvature of two voxels comes from an edge of the surface or from the next wall.
inline float boundedBend(float before, float a, float b, float after, float voxelSize) {
    const float bend = 0.5f * (before - a - b + after);
    return std::min(std::max(bend, -0.5f * voxelSize), 0.5f * voxelSize);
}

/// Distance of a position from the surface around a surface point, and the direction away from it.
struct Clearance {
    float distance = 0;  ///< voxels
    Place direction{};   ///< unit
    bool flat = false;   ///< from the tangent plane of the point; otherwise from the point itself
};

/// The surface counts as flat within half a voxel diagonal of each point, since the true nearest
/// point can be as far from it. Farther away there is an edge or another wall, and the distance to
/// the point itself is returned.
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
