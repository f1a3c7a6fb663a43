// Planar slices of 3D domains.
#pragma once

#include "vdbpack/domain/domain.h"

#include <memory>

namespace vdbpack {

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
