// Domains from a function of the caller.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/mesh_domain.h"

#include <functional>
#include <memory>
#include <string>

namespace vdbpack {

struct FunctionOptions {
    /// Largest gradient of the function within the bounds: 1 for a true signed distance. The
    /// function divided by it is taken as the distance to the wall.
    double steepest = 1;
    /// Name of the function in messages.
    std::string name = "function";
};

/// The points of `bounds` where a signed distance is negative, for any number of dimensions.
///
/// Exact where the function is a true signed distance (mm, negative inside, gradients of length
/// one): nothing protrudes from the surface f = 0 or from the bounds beyond rounding. Of another
/// function, pass its largest gradient as `steepest`, or take `implicitDomain`: f / steepest is
/// then a lower bound of the distance, so that nothing protrudes either, but gaps remain at the
/// wall where the gradient is smaller. A function whose gradient exceeds `steepest` lets spheres
/// protrude; where it does so between the points of a coarse lattice, it is refused.
///
/// Volumes and areas are sums over up to 1.2e7 samples, without the exactness of chords: within
/// 0.1 % for domains much larger than 1 / 200 of the bounds. Slices are not available.
///
/// @param f       mm; must be thread-safe: it is called from many threads at once. Deterministic
///                results need a function that depends on its argument alone.
/// @param bounds  mm; part of the wall where the function is negative there.
/// @throws ParameterError for an empty function, unusable bounds or a steepest gradient that is
/// not positive; InputError for values that are not finite, for a function that is steeper than
/// `steepest`, or negative nowhere.
///
/// Cost: one call per signed distance, 2 Dim + 2 calls per nearest wall point; 1.2e7 calls for the
/// volume at construction.
template <int Dim>
std::shared_ptr<const Domain<Dim>> functionDomain(std::function<double(const Vec<Dim>&)> f,
                                                  const Box<Dim>& bounds,
                                                  const FunctionOptions& options = {});

/// The points of `bounds` where any continuous function is negative: a mesh domain (field, slices,
/// exact queries), whose wall is the contour f = 0 in voxels of `field.voxelSize` (0: half of
/// `field.detail`, or 1/128 of the longest side of the bounds).
///
/// Nothing protrudes from the triangles of the contour; these deviate from the surface f = 0 by
/// about voxelSize² / (8 R) where its radius of curvature is R, more at edges (about half a voxel).
/// The sides of the bounds are exact.
///
/// @param f        as for `functionDomain`, in any unit.
/// @param options  `steepest` must be the largest gradient of `f` (or more) here too, since the
///                 contour is sampled where f / steepest is within some voxels of zero: a function
///                 that is steeper between the points of a coarse lattice is refused.
/// @throws as `functionDomain` and as `meshDomain`.
std::shared_ptr<const Domain<3>> implicitDomain(std::function<double(const Vec<3>&)> f,
                                                const Box<3>& bounds,
                                                const FunctionOptions& options,
                                                const FieldOptions& field,
                                                const Callbacks& callbacks = {});

}  // namespace vdbpack
