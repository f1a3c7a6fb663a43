// The part that two domains have in common.
#pragma once

#include "vdbpack/domain/domain.h"

#include <memory>

namespace vdbpack {

/// The points inside both domains. Distances to the wall inside are exact where the distances of
/// both are: whatever leaves the intersection leaves one of the two.
///
/// Volumes, areas and facts are taken from `inner`, which must lie within `outer` but for the error
/// of its contour.
template <int Dim>
std::shared_ptr<const Domain<Dim>> intersectionDomain(std::shared_ptr<const Domain<Dim>> inner,
                                                      std::shared_ptr<const Domain<Dim>> outer);

/// As `intersectionDomain`, with the envelope of `outer`: what voids have left of it.
std::shared_ptr<const Domain<3>> partDomain(std::shared_ptr<const Domain<3>> inner,
                                            std::shared_ptr<const Domain<3>> outer);

/// What `outside` leaves of `base`: the points inside both, neither of which lies within the other.
/// Volumes are sums over samples (`integralsBySamples`); facts are taken from `base`.
/// @param fromBase  whether its envelope is that of `base`.
std::shared_ptr<const Domain<3>> cutDomain(std::shared_ptr<const Domain<3>> base,
                                           std::shared_ptr<const Domain<3>> outside, bool fromBase);

}  // namespace vdbpack
