// What a check can compute with.
#pragma once

#include "vdbpack/core/sphere.h"

#include <vector>

namespace vdbpack {

/// Largest length that verify computes with, mm: products of larger ones would overflow.
inline constexpr double kLargestVerified = 1e30;

/// @throws InputError naming the first sphere whose position or radius is not a usable number;
/// ResourceError above 4e9 spheres.
template <int Dim>
void requireVerifiable(const std::vector<Sphere<Dim>>& spheres);

}  // namespace vdbpack
