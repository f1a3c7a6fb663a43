// What a pack will give and cost, predicted from small trials.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/run/memory_estimate.h"
#include "vdbpack/run/recipe.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <string>

namespace vdbpack {

/// What to expect of a pack before it is made.
struct DryRun {
    int dim = 3;
    double count = 0;          ///< spheres, with the existing ones
    double solidFraction = 0;  ///< of the domain, with those inside it
    bool densified = true;     ///< whether `densify` reaches its solid fraction
    std::string sizes;         ///< radii as they would be packed
    std::uint64_t existing = 0;
    double volume = 0;     ///< of the domain, mm^dim
    double voxelSize = 0;  ///< of its field, mm; 0: none
    struct Seconds {
        double mesh = 0, domain = 0, pack = 0, densify = 0, measure = 0, total = 0;
    } seconds;          ///< on `threads` of this machine, without writing
    Estimate estimate;  ///< of memory, and what the files will take
    int threads = 0;
    double trialSeconds = 0;       ///< of the trials themselves
    std::uint64_t trialCount = 0;  ///< spheres of the largest trial
};

/// Packs the domain twice with larger radii and goes on along the lines through both: the solid
/// fraction falls in proportion to the radii (walls), the field costs a share for its triangles
/// and one for its voxels, packing and checks one for the wall and one for each sphere. A pack
/// small enough is made as it is. Outputs are checked as `runPack` does, and not written.
/// Packs that exceed memory or disk space are predicted, too: `requireResources(dryRun.estimate,
/// memoryLimit(recipe.memoryLimit))` throws what `runPack` would. @throws as `runPack` otherwise.
DryRun dryRunPack(const PackRecipe& recipe, const Callbacks& callbacks = {});

/// The keys of a report, where they apply, and `dryRun`.
nlohmann::ordered_json toJson(const DryRun& dryRun);
/// For people; ends with a newline.
std::string summary(const DryRun& dryRun);

}  // namespace vdbpack
