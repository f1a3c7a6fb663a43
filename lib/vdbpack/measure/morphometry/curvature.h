// Private to measure: how much the surface of a solid bends.
#pragma once

#include "vdbpack/field/voxel_image.h"

#include <vector>

namespace vdbpack {

/// By label, the integral of div n over the surface of the solid, n its unit normal out of the
/// solid: twice the integral of the mean curvature, in voxel lengths. It is the rate dS/dr at which
/// the area S grows if the surface moves outward by r. A ball has 8 pi r, a cylinder 2 pi times its
/// length, a plane 0, a straight edge its exterior angle times its length; concave parts are
/// negative. What the total volume cuts off counts for nothing, the border not being surface.
///
/// The surface is parted into pieces, one for each cube between eight voxel centers that it passes,
/// each with the direction of the distances' trilinear gradient at the middle of the cube. Two
/// pieces meet on the square between two cubes, in a line t between points of the surface, and
/// contribute the angle from one normal to the other about t, times the length of t. Of a
/// polyhedron this is the integral of Steiner's formula. Here it is exact where the normal changes
/// linearly along the surface, since the terms of a piece add up to its area times div n, and along
/// edges, where the angles add up to that of the edge however many pieces they come in. No second
/// differences are taken, and the length of the gradient does not matter, so distances that are not
/// Euclidean (unions, differences, blends) do as well. A term is at most pi times sqrt(2).
///
/// Each line counts by the labels of the solid voxels at its two ends. The outer half voxels of an
/// image, in which there are no squares, take the values next to them, so that the integral
/// belongs to the same surface as `SurfacePoint::area`.
///
/// @return nothing for an image of fewer than three voxels along an axis.
/// The same for any number of threads. Cost: 13 ns a voxel on two threads (200³ voxels of BV/TV
/// 0.16: 0.11 s, of 4.9 s for all of morphometry).
std::vector<double> curvatureIntegrals(const VoxelImage& image);

}  // namespace vdbpack
