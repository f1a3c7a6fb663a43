// Private to runs: where parts of a pack meet, and what joins them there.
#pragma once

#include "vdbpack/run/run_parts.h"

namespace vdbpack {

/// Lists the interfaces between parts in the report of their joined pack, with their bonds (of
/// `RunSettings::bonds`). Warns, where outputs list pairs, of interfaces with fewer than half as
/// many bonds per area as a plane through the weaker of their parts cuts.
void measureInterfaces(const Parts& parts, Run<3>& all);

}  // namespace vdbpack
