// The run that cuts voids into a pack that was read: `vdb_pack carve`.
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/structure_sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace vdbpack {

namespace {

/// Share of protruding spheres from which on the pack seems to belong to another domain.
constexpr double kManyOutside = 0.05;

/// Overlaps and protrusions of the input pack are reported, and no failure.
template <int Dim>
void acceptInput(Run<Dim>& run, const CarveRecipe& recipe) {
    Report& report = run.report;
    report.inputOverlaps = report.overlap->pairs;
    report.inputProtrusions = report.protrusion->spheres;
    if (static_cast<double>(report.inputProtrusions) >
        kManyOutside * static_cast<double>(report.count))
        run.callbacks.warn(fmt::format(
            "{}: {} of {} {} protrude from the domain. Check that the pack belongs to it, and that "
            "`unit` and `packUnit` are right",
            recipe.pack, report.inputProtrusions, report.count, Measure<Dim>::kSpheres));
}

/// Spheres without ids go by their positions in the file, which change once others are removed.
template <int Dim>
void keepNames(Pack<Dim>& pack) {
    if (!pack.id.empty()) return;
    pack.id.resize(pack.spheres.size());
    std::iota(pack.id.begin(), pack.id.end(), 0);
}

template <int Dim>
RunResult carve(Run<Dim>& run, const CarveRecipe& recipe) {
    const RadiusStatistics radius = radiusStatistics(run.pack.spheres);
    if (const auto sizes = recipe.sizes(Dim)) run.sizes = PackSizes{*sizes};
    run.voids.recipe = recipe.voids;
    // Without a shell there are no regions but those of the input pack.
    if (!recipe.voids.hasShell()) run.facts.labelled = run.pack.region.size();
    keepNames(run.pack);
    run.voids.largestRadius = radius.max;
    const double detail = fieldDetail(radius.min, radius.mean);
    const double voxel = plannedVoxel(recipe.voids, Dim);
    const double reach =
        std::max(radius.max, depthForVoids(recipe.voids, voxel, radius.max, Dim) / 3);
    Extent extent = extentOf(*run.source, detail, reach, voxel);
    extent.count = static_cast<double>(run.pack.spheres.size());
    addVoids(extent, recipe.voids, radius.max);
    domainStage(run, extent, detail, reach, voxel);
    requireOneBody(run.pack, run.domain(), recipe.pack, "voids");
    cutStage(run);
    measureStage(run);
    acceptInput(run, recipe);
    return reported(finishStage(run), recipe);
}

}  // namespace

RunResult runCarve(const CarveRecipe& asked, const Callbacks& callbacks) {
    CarveRecipe recipe = asked;
    checkVoids(recipe.voids, true, false);
    if (recipe.voids.empty() && !recipe.voids.hasShell())
        throw ParameterError(
            "there is nothing to cut; set how `voids` are made (grid, overlay, concentric, "
            "threshold, boolean, foam or list:FILE)");
    auto inputs = voidInputs(recipe.voids);
    for (auto& file : inputFiles(recipe)) inputs.push_back(std::move(file));
    refuseInterfaces(recipe);
    checkSettings(recipe, RunKind::pack, recipe.voids, inputs);
    recipe.voids = withThreads(recipe.threads,
                               [&] { return withSample(recipe.voids, recipe.domain, callbacks); });
    return runOnInputPack(recipe, "carve", asked.voids, callbacks,
                          [&](auto& run) { return carve(run, recipe); });
}

}  // namespace vdbpack
