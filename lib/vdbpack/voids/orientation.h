// Directions of the long axes of voids.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/rng.h"

#include <memory>
#include <string>

namespace vdbpack {

/// How a void's long axis is drawn: the angles alone, or as scatter about a direction.
struct OrientationRecipe {
    /// "isotropic": all directions alike. Else specs of `AngleDistribution`: in space
    /// "tz=SPEC;tx=SPEC", the axis turned from z by tx about x, then by tz about z (one of them may
    /// be missing: 0); in the plane "phi=SPEC", the axis turned from x by phi. Empty: no turn.
    std::string angles;
    /// "X,Y,Z" (2D: "X,Y" too), a direction of any length and sign, the same everywhere; empty:
    /// none.
    std::string axis;
    /// A file that `readDirectionField` reads; empty: none.
    std::string field;
    double fieldScale = 1;  ///< mm in one unit of the field's file
};

/// Draws the long axes of voids.
template <int Dim>
class Orientation {
public:
    virtual ~Orientation() = default;
    /// The axis of a void at `at` (mm), of length one. Draws two numbers (2D: one) from `random`,
    /// whatever the recipe, so that streams stay aligned. Thread-safe but for `random`.
    virtual Vec<Dim> axis(const Vec<Dim>& at, RandomStream& random) const = 0;
};

/// The orientation that a recipe asks for.
///
/// With an axis or a field, the angles turn about that direction: z is laid on it by the shortest
/// turn (its sign chosen such that it points upward) and the angled axis goes along; in 2D phi is
/// added. In 2D directions are projected into the plane, fields taken at the height of the slice;
/// where one stands across the plane, the axis is x.
///
/// @param bounds       what a field has to cover, mm.
/// @param sliceHeight  2D: height of the plane in the field, mm.
/// @throws ParameterError if angles or axis are malformed, or those of the other dimension, the
///         axis has no length (2D: in the plane), or two of axis, field and "isotropic" are given
/// @throws InputError if the field does not cover `bounds`; what `readDirectionField` throws
template <int Dim>
std::shared_ptr<const Orientation<Dim>> makeOrientation(const OrientationRecipe& recipe,
                                                        const Box<Dim>& bounds,
                                                        double sliceHeight = 0);

extern template std::shared_ptr<const Orientation<2>> makeOrientation<2>(const OrientationRecipe&,
                                                                         const Box<2>&, double);
extern template std::shared_ptr<const Orientation<3>> makeOrientation<3>(const OrientationRecipe&,
                                                                         const Box<3>&, double);

}  // namespace vdbpack
