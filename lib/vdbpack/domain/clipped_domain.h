// Parts of domains: cut by planes, and planar slices.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain.h"

#include <memory>
#include <vector>

namespace vdbpack {

/// `domain` cut by half-spaces: the points of `domain` inside all of them. Distances inside stay
/// exact; outside, signs are right and distances are to the nearest wall of the parts, a lower
/// bound. Volumes and areas are integrals: of exact chords for shapes (error below 0.05 %), of
/// samples for others (below 0.5 % for meshes in voxels that suit the bone).
/// @param envelope  what `Domain::envelope` is to be; null: the cut domain itself.
/// @throws ParameterError for a zero normal, InputError if nothing is left.
template <int Dim>
std::shared_ptr<const Domain<Dim>> clippedDomain(std::shared_ptr<const Domain<Dim>> domain,
                                                 const std::vector<HalfSpace<Dim>>& planes,
                                                 std::shared_ptr<const Domain<Dim>> envelope = {});

/// The error of clips that leave nothing of a domain within `whole`.
template <int Dim>
InputError nothingLeft(const Box<Dim>& whole);

/// The plane z = `height` of a 3D domain, as a domain of the plane (x, y).
/// @throws InputError if the plane misses the domain, ParameterError if the height is not finite
/// or the domain is one that cannot be sliced.
std::shared_ptr<const Domain<2>> sliceDomain(std::shared_ptr<const Domain<3>> domain,
                                             double height);

/// Private to domain: a 3D domain that knows its own slices.
class Sliceable {
public:
    virtual ~Sliceable() = default;
    /// @throws InputError if the plane misses the domain.
    virtual std::shared_ptr<const Domain<2>> slice(double height) const = 0;
};

}  // namespace vdbpack
