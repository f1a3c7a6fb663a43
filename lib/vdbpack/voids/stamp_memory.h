// Memory that stamping voids takes, before it is taken.
#pragma once

#include "vdbpack/voids/stamp.h"

#include <vector>

namespace vdbpack {

/// Bytes that stamping takes at most, and the level sets `voids` and `solid` with it.
template <int Dim>
double stampBytes(const std::vector<Ellipsoid<Dim>>& voids, const Domain<Dim>& domain,
                  const StampOptions<Dim>& options);

/// @throws ResourceError with the numbers if there is not as much memory.
template <int Dim>
void requireStampMemory(const std::vector<Ellipsoid<Dim>>& voids, const Domain<Dim>& domain,
                        const StampOptions<Dim>& options);

/// The same for `count` voids like one, known before they are drawn.
template <int Dim>
void requireStampMemory(double count, const Ellipsoid<Dim>& one, const Domain<Dim>& domain,
                        const StampOptions<Dim>& options);

}  // namespace vdbpack
