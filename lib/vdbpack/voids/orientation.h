// Directions of the axes of voids.
#pragma once

#include "vdbpack/core/box.h"

#include <memory>
#include <string>

namespace vdbpack {

class RandomStream;

/// How the direction of a void's axis a is drawn: by angles alone, or scattered about a direction.
struct OrientationRecipe {
    /// "isotropic": all directions are equally likely. Otherwise specs of `AngleDistribution`: in
    /// space "tz=SPEC;tx=SPEC", which turns the axis from z by tx about x, then by tz about z (a
    /// missing angle is 0); in the plane "phi=SPEC", which turns the axis from x by phi. Empty: the
    /// axis is not turned.
    std::string angles;
    /// "X,Y,Z" (2D: also "X,Y"), the same direction everywhere, of any length and sign; empty:
    /// none.
    std::string axis;
    /// A file that `readDirectionField` reads; empty: none.
    std::string field;

    /// Whether a direction is requested.
    bool any() const { return !angles.empty() || !axis.empty() || !field.empty(); }
};

/// Draws the axes of voids.
template <int Dim>
class Orientation {
public:
    virtual ~Orientation() = default;
    /// The unit axis of a void centered at `at` (mm). Always draws two numbers (2D: one) from
    /// `random`, so that streams stay aligned between recipes. Thread-safe except for `random`.
    virtual Vec<Dim> axis(const Vec<Dim>& at, RandomStream& random) const = 0;
};

/// The orientation that a recipe describes.
///
/// With an axis or a field, the angles are relative to that direction: the shortest rotation that
/// maps z to the direction (its sign chosen so that it points upward) is applied to the axis given
/// by the angles; in 2D phi is added to the angle of the direction. In 2D directions are projected
/// into the plane, and fields are sampled at the height of the slice; a direction normal to the
/// plane is replaced by x.
///
/// @param bounds       the box that a field must cover, mm.
/// @param sliceHeight  2D: height of the plane in the field, mm.
/// @throws ParameterError if angles or axis are malformed or belong to the other dimension, the
///         axis has no length (2D: in the plane), or two of axis, field and "isotropic" are given
/// @throws InputError if the field does not cover `bounds`; the errors of `readDirectionField`
template <int Dim>
std::shared_ptr<const Orientation<Dim>> makeOrientation(const OrientationRecipe& recipe,
                                                        const Box<Dim>& bounds,
                                                        double sliceHeight = 0);

}  // namespace vdbpack
