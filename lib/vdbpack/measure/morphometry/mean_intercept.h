// Private to measure: mean intercept lengths and the ellipsoid through them.
#pragma once

#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/measure/morphometry/surface_distance.h"

#include <optional>
#include <vector>

namespace vdbpack {

/// Directions spread evenly over the half sphere z > 0: a spherical Fibonacci lattice.
std::vector<Vec<3>> halfSphereDirections(int count);

/// Crossings of the surface a voxel of line, for lines of each direction through the total volume:
/// sum over the surface of area |n . u| / volume, which is what ever denser parallel lines
/// converge to (Cauchy, Crofton), without their chance. The volume is that between the voxel
/// centers, in which the points lie.
std::vector<double> crossingRates(const SurfaceDistance& surface,
                                  const std::vector<Vec<3>>& directions);

/// The same as it is done on plain voxels: changes of phase between samples `kVoxelStep` apart on
/// parallel lines, each sample the nearest voxel's, both in the total volume. A line along a wall
/// crosses its staircase again and again, whatever the resolution: rates of all directions draw
/// nearer to one another.
/// Source: Odgaard (1997), doi:10.1016/S8756-3282(97)00007-0; step as BoneJ's default.
std::vector<double> voxelCrossingRates(const VoxelImage& image,
                                       const std::vector<Vec<3>>& directions);

/// Of samples on a line, voxels.
inline constexpr double kVoxelStep = 2.3;

/// The ellipsoid u' M u = 1 / MIL(u)^2 by least squares of the relative error of that, and what
/// follows from it; nothing if no direction meets the surface.
/// @param rates  crossings a voxel of line, one a direction.
std::optional<Anisotropy> fitAnisotropy(const std::vector<Vec<3>>& directions,
                                        const std::vector<double>& rates, double voxelSize);

}  // namespace vdbpack
