// Private to domain: the half-spaces of a box, and the bounds of a box cut by half-spaces.
#pragma once

#include "vdbpack/core/box.h"

#include <vector>

namespace vdbpack {

/// The half-spaces that a box is the intersection of, two per axis, with normals of length one.
template <int Dim>
std::vector<HalfSpace<Dim>> halfSpacesOf(const Box<Dim>& box);

/// The bounds of the part of a box inside half-spaces (unit normals); empty if none is left.
template <int Dim>
Box<Dim> cutBounds(const Box<Dim>& box, std::vector<HalfSpace<Dim>> planes);

}  // namespace vdbpack
