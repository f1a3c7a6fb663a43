// Whether a mesh can be packed: as it is, once repaired, or not.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/repair/mesh_repair.h"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

struct DomainRecipe;
struct TriangleMesh;

struct MeshFitness {
    enum class Verdict {
        yes,         ///< a pack can be made of it as it is
        withRepair,  ///< only once repaired
        no
    };
    Verdict verdict = Verdict::no;
    std::vector<std::string> reasons;    ///< why it is not fit as it is, or flaws that do no harm
    std::optional<RepairReport> repair;  ///< what a repair does, if it was tried
};

/// Decides by what a run does: the field of a default pack is made of the mesh; where that is
/// refused, the repair is made, and the field of what it returns.
/// @param mesh    of `recipe`, not repaired; `health` is its own.
MeshFitness fitnessOf(const TriangleMesh& mesh, const MeshHealth& health,
                      const DomainRecipe& recipe, const Callbacks& callbacks);

/// The same of a mesh that was repaired already. @param repaired  the result
MeshFitness fitnessOf(const TriangleMesh& repaired, const RepairReport& report,
                      const DomainRecipe& recipe, const Callbacks& callbacks);

/// "yes", "with repair" or "no".
const char* nameOf(MeshFitness::Verdict verdict);

/// Adds the keys `fit`, `reasons` and, if a repair was only tried, `withRepair`.
void addJson(nlohmann::json& json, const MeshFitness& fitness, const std::string& name);

}  // namespace vdbpack
