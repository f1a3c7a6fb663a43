// Files of a pack whose spheres several ranks share.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/formats/pack_parts.h"

#include <string>
#include <vector>

namespace vdbpack {

/// Writes outputs of the spheres of all ranks. @return the files, on each rank.
/// @throws ParameterError, IoError
template <int Dim>
std::vector<std::string> writeOverRanks(const std::vector<OutputTarget>& outputs,
                                        const RunOutputs<Dim>& have, const PackShare<Dim>& share,
                                        const Callbacks& callbacks);

}  // namespace vdbpack
