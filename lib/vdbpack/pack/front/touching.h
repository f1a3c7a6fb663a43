// Moves a sphere to where it touches given bodies exactly.
#pragma once

#include "vdbpack/core/vec.h"

#include <array>

namespace vdbpack {

/// An object from which a center must have a given distance: a point (the center of a sphere) or a
/// plane.
template <int Dim>
struct Contact {
    Vec<Dim> at;          ///< the point, or a point of the plane, mm
    Vec<Dim> normal;      ///< of the plane, unit, towards the center; not used for a point
    double distance = 0;  ///< mm
    bool flat = false;    ///< a plane
};

/// Moves `center` to where it is at its distance from all of `Dim` contacts, by Newton's method
/// from where it is.
/// @param precision  steps shorter than a tenth of this end the search, mm.
/// @param farthest   a step longer than this gives it up, mm.
/// @return false if no such position is near; `center` is then undefined.
template <int Dim>
bool moveToTouch(const std::array<Contact<Dim>, static_cast<std::size_t>(Dim)>& contacts,
                 double precision, double farthest, Vec<Dim>& center);

}  // namespace vdbpack
