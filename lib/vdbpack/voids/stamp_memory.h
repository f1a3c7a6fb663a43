// Estimates the memory of stamping voids.
#pragma once

#include "vdbpack/voids/stamp.h"

#include <vector>

namespace vdbpack {

/// Upper estimate of the bytes of stamping, including the level sets `voids` and `solid`.
template <int Dim>
double stampBytes(const std::vector<Ellipsoid<Dim>>& voids, const Domain<Dim>& domain,
                  const StampOptions<Dim>& options);

/// @throws ResourceError with the numbers if not enough memory is available.
template <int Dim>
void requireStampMemory(const std::vector<Ellipsoid<Dim>>& voids, const Domain<Dim>& domain,
                        const StampOptions<Dim>& options);

/// The same for `count` voids like `one`, before they are drawn.
template <int Dim>
void requireStampMemory(double count, const Ellipsoid<Dim>& one, const Domain<Dim>& domain,
                        const StampOptions<Dim>& options);

}  // namespace vdbpack
