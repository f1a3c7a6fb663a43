// Cubes about the origin.
#pragma once

#include "vdbpack/core/box.h"

namespace vdbpack::test {

/// The cube (2D: square) of this side about the origin.
template <int Dim>
Box<Dim> cube(double side) {
    return {Box<Dim>::filled(-side / 2), Box<Dim>::filled(side / 2)};
}

}  // namespace vdbpack::test
