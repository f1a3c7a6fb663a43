// `vdb_pack mesh`: the health of a mesh, and its repair.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/repair/mesh_repair.h"
#include "vdbpack/run/domain_source.h"
#include "vdbpack/run/settings.h"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// Outputs are .stl, in mm.
struct MeshRecipe : RunSettings {
    DomainRecipe domain;  ///< source, unit, scale, and how to repair
};

struct MeshResult {
    MeshHealth health;                   ///< of the mesh; with `repair`, of the repaired mesh
    std::optional<RepairReport> repair;  ///< contains the health before the repair
    std::vector<std::string> files;
};

/// Checks a mesh, repairs it if `domain.repair` is set, and writes it.
/// @throws ParameterError (an output that is no .stl, or the input itself), InputError, IoError,
/// ResourceError
MeshResult runMesh(const MeshRecipe& recipe, const Callbacks& callbacks = {});

/// The members of the health, and `repair` and `files` where there are any.
nlohmann::json toJson(const MeshResult& result);
std::string summary(const MeshResult& result);

}  // namespace vdbpack
