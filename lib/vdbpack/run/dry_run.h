// What to expect of a run, without packing.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/options/recipes.h"
#include "vdbpack/report/report.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace vdbpack {

/// Bytes of memory at the peak of a run by what takes them, and of each file that it writes.
struct Estimate {
    struct Part {
        const char* name;    ///< key in reports
        double bytes;        ///< at the peak
        std::string what;    ///< for messages: "4e+05 spheres"
        const char* remedy;  ///< what makes it smaller
    };
    struct File {
        std::string name;  ///< as in the outputs
        double bytes;
    };
    std::vector<Part> parts;
    std::vector<File> files;

    double memory() const;
    /// The parts that matter, for people: "820 MiB for about 4e+05 spheres, ...".
    std::string memoryText() const;
};

/// Refuses memory beyond `limit` bytes (as `memoryLimit`), and any file larger than the free space
/// of its disk. @throws ResourceError with the parts of the estimate, what is available, a remedy.
void requireResources(const Estimate& estimate, double limit);
/// What to expect of a run.
struct DryRun {
    int dim = 3, threads = 1;
    double volume = 0;         ///< of the domain, mm^dim
    double voxelSize = 0;      ///< of its field, mm; 0: it is a shape
    double count = 0;          ///< spheres, with the existing ones
    double existing = 0;       ///< of these
    double solidFraction = 0;  ///< of the domain, with existing spheres
    bool densified = true;     ///< whether `densify` reaches its solid fraction
    std::string sizes;         ///< radii as they would be packed
    Report::Seconds seconds;   ///< on `threads` threads
    Estimate estimate;
};
/// Reads the domain, and estimates; nothing is packed or written. Packs that exceed memory or disk
/// space are predicted, too: `requireResources(dryRun.estimate, recipe.memoryLimit)` throws what
/// `runPack` would. @throws as `runPack` for its recipe and its domain
DryRun dryRunPack(const PackRecipe& recipe, const Callbacks& callbacks = {});
/// The keys of a report, where they apply, `dryRun`, and the usual errors.
nlohmann::ordered_json toJson(const DryRun& dryRun);
/// For people; ends with a newline.
std::string summary(const DryRun& dryRun);

}  // namespace vdbpack
