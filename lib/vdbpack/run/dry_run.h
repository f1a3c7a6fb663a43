// What a pack will give and cost, predicted from small trials.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/report/report.h"
#include "vdbpack/run/memory_estimate.h"
#include "vdbpack/run/recipe.h"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace vdbpack {

/// What to expect of a pack before it is made.
struct DryRun {
    double count = 0;          ///< spheres, with the existing ones
    double solidFraction = 0;  ///< of the domain, with those inside it
    bool densified = true;     ///< whether `densify` reaches its solid fraction
    std::string sizes;         ///< radii as they would be packed
    double voxelSize = 0;      ///< of the field, mm; 0: none
    Report::Seconds seconds;   ///< on as many threads, without writing
    Estimate estimate;         ///< of memory, and what the files will take
    Report trial;              ///< of the larger trial
    double trialSeconds = 0;   ///< of both
};

/// Runs the recipe twice with larger radii, without files, and goes on along the line through both:
/// the solid fraction falls in proportion to the radii (walls), the field costs time for its
/// voxels, packing and measuring for each sphere. Voids keep their sizes; their voxels are larger,
/// and cost time in proportion to those that their walls meet. A small pack is made as it is. Packs
/// that exceed memory or disk space are predicted, too: `requireResources(dryRun.estimate,
/// recipe.memoryLimit)` throws what `runPack` would. @throws as `runPack` otherwise.
DryRun dryRunPack(const PackRecipe& recipe, const Callbacks& callbacks = {});

/// The keys of a report, where they apply, and `dryRun`.
nlohmann::ordered_json toJson(const DryRun& dryRun);
/// For people; ends with a newline.
std::string summary(const DryRun& dryRun);

}  // namespace vdbpack
