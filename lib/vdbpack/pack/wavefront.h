// Private to pack: the blocks of a domain, filled in the order of a wavefront.
#pragma once

#include "vdbpack/core/ranks.h"
#include "vdbpack/pack/packer.h"

#include <vector>

namespace vdbpack {

/// Packs radii grown by a shell of half the gap: where these do not overlap, the spheres inside
/// keep the gap.
/// @param domain    its wall moved inwards by the shell.
/// @param outer     the domain itself.
/// @param existing  as in `packSpheres`.
template <int Dim>
PackResult<Dim> packBlocks(const Domain<Dim>& domain, const Domain<Dim>& outer,
                           const PackOptions& options, const Callbacks& callbacks,
                           const std::vector<Sphere<Dim>>& existing);

}  // namespace vdbpack
