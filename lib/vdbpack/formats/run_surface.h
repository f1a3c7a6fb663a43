// Private: level sets and surfaces of what a run has, for its outputs.
#pragma once

#include "vdbpack/formats/outputs.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <memory>
#include <string>
#include <vector>

namespace vdbpack {

/// The level set that a target is made from. @throws ParameterError if it is not there
const VdbGrid& chosenLevelSet(const std::string& output, const std::string& name,
                              const std::vector<std::shared_ptr<const VdbGrid>>& levelSets);

/// The level sets of the run; where it has none, one of its domain.
template <int Dim>
std::vector<std::shared_ptr<const VdbGrid>> levelSetsOf(const RunOutputs<Dim>& have);

/// The surface of the run's solid or domain, of which it has level sets: a box has its six sides.
/// @throws as `chosenLevelSet`
template <int Dim>
TriangleMesh contourOf(const OutputTarget& target, const RunOutputs<Dim>& have);

}  // namespace vdbpack
