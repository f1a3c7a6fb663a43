// Private to runs on packs that exist: reading them.
#pragma once

#include "vdbpack/run/run.h"

namespace vdbpack {

/// The spheres of a run's pack; warns of a size that no bone has.
/// @throws as readPack; InputError if there are none
Pack<3> readGiven(const GivenPack& recipe, const Callbacks& callbacks);

/// Refuses options that say something of a domain that is not there. @throws ParameterError
void requireDomain(const GivenPack& recipe);

/// Whether a pack is one of circles in a plane.
bool isPlane(const Pack<3>& pack);

}  // namespace vdbpack
