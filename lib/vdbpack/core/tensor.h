// Symmetric tensors of space, such as stress and fabric.
#pragma once

#include "vdbpack/core/vec.h"

#include <array>

namespace vdbpack {

/// Components xx, yy, zz, xy, yz, xz.
using Tensor = std::array<double, 6>;

/// A tensor at a point, mm.
struct TensorSample {
    Vec<3> x;
    Tensor tensor{};
};

/// u⊗u of the direction `u` scaled to length one; zero for zero.
Tensor dyad(const Vec<3>& u);
/// The eigenvector to the eigenvalue of largest magnitude, of length one.
Vec<3> mainAxis(const Tensor& t);
void addScaled(Tensor& sum, double weight, const Tensor& t);
/// The largest magnitude of a component.
double magnitude(const Tensor& t);

}  // namespace vdbpack
