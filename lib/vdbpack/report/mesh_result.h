// What `mesh` returns: the health of a mesh, and its repair.
#pragma once

#include "vdbpack/domain/mesh_fitness.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/repair/mesh_repair.h"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

struct MeshResult {
    TriangleMesh mesh;                   ///< as it was read, or repaired; mm
    MeshHealth health;                   ///< of the mesh; with `repair`, of the repaired mesh
    std::optional<RepairReport> repair;  ///< contains the health before the repair
    MeshFitness fitness;
    bool passed = true;  ///< false: `check` was requested, and the mesh cannot be packed
    std::string source;  ///< its file
    std::vector<std::string> files;
};

/// The members of the health, `fit` and `reasons`; `repair` and `files` where there are any;
/// without a repair `withRepair`, what it would do, null if it is not needed.
nlohmann::json toJson(const MeshResult& result);
std::string summary(const MeshResult& result);
/// Why a mesh did not pass, a line each.
std::string failures(const MeshResult& result);

}  // namespace vdbpack
