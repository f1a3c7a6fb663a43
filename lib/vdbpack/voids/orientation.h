// Directions of the axes of voids.
#pragma once

#include "vdbpack/core/box.h"

#include <memory>
#include <optional>
#include <string>

namespace vdbpack {

class RandomStream;

/// A distribution of angles: a constant, uniform, or normal within bounds.
class AngleDistribution {
public:
    /// Always 0.
    AngleDistribution() = default;

    /// Parses V, constant:V, uniform:A,B or normal:MEAN,SD,A,B (truncated to [A, B]). Each number
    /// is in radians, or in degrees with the suffix `deg`: "uniform:-10deg,10deg".
    /// @throws ParameterError if the text is malformed, A > B, an angle exceeds two full turns (a
    ///         sign of degrees without their suffix), SD is not positive, or the normal
    ///         distribution has no share in [A, B]
    static AngleDistribution parse(const std::string& spec);

    /// The quantile at `u` in [0, 1], rad. Thread-safe.
    double quantile(double u) const;

private:
    double lo_ = 0, hi_ = 0;        ///< rad
    double mean_ = 0, spread_ = 0;  ///< rad; spread 0: uniform
};

/// Angles by which axes are turned.
struct VoidAngles {
    std::string text;        ///< as `parse` reads it
    bool isotropic = false;  ///< all directions are equally likely
    /// In space the axis is turned from z by `tx` about x, then by `tz` about z; in the plane from
    /// x by `phi`. What is missing is 0.
    std::optional<AngleDistribution> tz, tx, phi;

    /// "isotropic", or specs of `AngleDistribution`: "tz=SPEC;tx=SPEC" in space, "phi=SPEC" in the
    /// plane. @throws ParameterError
    static VoidAngles parse(const std::string& text);
};

/// A direction of any length and sign.
struct VoidAxis {
    std::string text;
    Vec<3> direction;
    int components = 3;   ///< 2: of the plane alone
    bool isLong = false;  ///< the long axis of the domain, which is not known yet

    explicit VoidAxis(const Vec<3>& along);
    /// "X,Y,Z", or "X,Y" for the plane, or "long". @throws ParameterError
    static VoidAxis parse(const std::string& text);
};

/// The unit vector along an axis. @throws ParameterError if it has no direction (2D: in the plane)
template <int Dim>
Vec<Dim> directionOf(const VoidAxis& axis);

/// How the direction of a void's axis a is drawn: by angles alone, or scattered about a direction.
struct OrientationRecipe {
    std::optional<VoidAngles> angles;  ///< nothing: the axis is not turned
    std::optional<VoidAxis> axis;      ///< the same direction everywhere; nothing: none
    std::string field;                 ///< that `readDirectionField` reads; empty: none

    /// Whether a direction is requested.
    bool any() const { return angles || axis || !field.empty(); }
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
/// @throws ParameterError if angles or axis belong to the other dimension, the axis has no length
///         (2D: in the plane), or two of axis, field and "isotropic" are given
/// @throws InputError if the field does not cover `bounds`; the errors of `readDirectionField`
template <int Dim>
std::shared_ptr<const Orientation<Dim>> makeOrientation(const OrientationRecipe& recipe,
                                                        const Box<Dim>& bounds,
                                                        double sliceHeight = 0);

}  // namespace vdbpack
