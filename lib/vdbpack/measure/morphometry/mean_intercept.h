// Private to measure: mean intercept lengths and the ellipsoid fitted to them.
#pragma once

#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/labels.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/measure/morphometry/surface_distance.h"

#include <optional>
#include <vector>

namespace vdbpack {

/// Directions distributed evenly over the half sphere z > 0: a spherical Fibonacci lattice.
std::vector<Vec<3>> halfSphereDirections(int count);

/// Crossings of the surface per voxel of line length, for lines of each direction through the
/// voxels of one label or the total volume: the sum of area |n . u| over the surface, divided by
/// the volume. This is the limit of infinitely many parallel lines (Cauchy, Crofton), without
/// sampling error. The volume is that between the voxel centers, which contains the surface points.
std::vector<double> crossingRates(const SurfaceDistance& surface,
                                  const std::vector<Vec<3>>& directions, int label = kAllLabels);

/// The same from plain voxels: changes of phase between samples `kVoxelStep` apart on parallel
/// lines, each sample being that of the nearest voxel, both in the part of the label. A line along
/// a wall crosses the voxel steps of the wall repeatedly at any resolution, so the rates of all
/// directions become more alike. Source: Odgaard (1997), doi:10.1016/S8756-3282(97)00007-0; step as
/// BoneJ's default.
std::vector<double> voxelCrossingRates(const VoxelImage& image,
                                       const std::vector<Vec<3>>& directions,
                                       int label = kAllLabels);

/// Distance of samples on a line, voxels.
inline constexpr double kVoxelStep = 2.3;

/// Fits the ellipsoid u' M u = 1 / MIL(u)^2 by least squares of the relative error, and derives the
/// anisotropy; nothing if no line crosses the surface.
/// @param rates  crossings per voxel of line length, one per direction.
std::optional<Anisotropy> fitAnisotropy(const std::vector<Vec<3>>& directions,
                                        const std::vector<double>& rates, double voxelSize);

}  // namespace vdbpack
