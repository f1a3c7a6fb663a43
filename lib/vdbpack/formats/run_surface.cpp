#include "vdbpack/formats/run_surface.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/mesh/made_mesh.h"

#include <fmt/format.h>

namespace vdbpack {

const VdbGrid& chosenLevelSet(const std::string& output, const std::string& name,
                              const std::vector<std::shared_ptr<const VdbGrid>>& levelSets) {
    const auto named = [&](const std::string& wanted) -> const VdbGrid* {
        for (const auto& set : levelSets)
            if (set && levelSetName(*set) == wanted) return set.get();
        return nullptr;
    };
    const VdbGrid* found = name.empty() ? named(kSolid) : named(name);
    if (!found && name.empty()) found = named(kSurface);
    if (!found && name.empty() && !levelSets.empty()) found = levelSets.front().get();
    if (!found)
        throw ParameterError(fmt::format("{}: this run has no level set{} to write; leave it out",
                                         output, name.empty() ? "" : " '" + name + "'"));
    return *found;
}

template <int Dim>
std::vector<std::shared_ptr<const VdbGrid>> levelSetsOf(const RunOutputs<Dim>& have) {
    if constexpr (Dim == 3) {
        if (have.options.levelSets.empty() && have.domain)
            return {surfaceLevelSet(*have.domain, shapeVoxelSize(have.domain->bounds()))};
    }
    return have.options.levelSets;
}

template <int Dim>
TriangleMesh contourOf(const OutputTarget& target, const RunOutputs<Dim>& have) {
    if constexpr (Dim == 3) {
        // What fills its bounding box is that box, whose edges a level set would cut.
        const bool isAsked = target.grid.empty() || target.grid == kSurface;
        if (isAsked && have.options.levelSets.empty() && have.domain &&
            have.domain->volume() >= (1 - 1e-12) * have.domain->bounds().volume())
            return boxMesh(have.domain->bounds());
    }
    return levelSetMesh(chosenLevelSet(target.text, target.grid, levelSetsOf(have)), target.text);
}

template std::vector<std::shared_ptr<const VdbGrid>> levelSetsOf(const RunOutputs<2>&);
template std::vector<std::shared_ptr<const VdbGrid>> levelSetsOf(const RunOutputs<3>&);
template TriangleMesh contourOf(const OutputTarget&, const RunOutputs<2>&);
template TriangleMesh contourOf(const OutputTarget&, const RunOutputs<3>&);

}  // namespace vdbpack
