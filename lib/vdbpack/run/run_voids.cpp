// The run that cuts voids into a domain without spheres: `vdb_pack voids`.
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/run/structure_sample.h"

#include <memory>
#include <utility>

namespace vdbpack {

namespace {

/// The smallest feature that the field of a domain has to resolve, mm; 0: unknown. Where the voxels
/// of the voids are known, the field gets the same.
double detailFor(const VoidRecipe& recipe, double voxel) {
    if (voxel > 0) return voxel / kVoxelPerDetail;
    const VoidShapeRecipe* const shape = shapeOf(recipe);
    return !shape || shape->radius.empty() || scalesVoids(recipe) ? 0 : shape->radius.in(3).min();
}

template <int Dim>
RunResult cutDomain(const VoidsRecipe& recipe, const std::shared_ptr<const DomainSource>& source,
                    const Report& report, const Clock& clock, const Callbacks& callbacks) {
    Run<Dim> run(recipe, source, report, clock, callbacks);
    run.hasPack = false;
    run.voids.recipe = recipe.voids;
    const double voxel = plannedVoxel(recipe.voids, Dim);
    const double detail = detailFor(recipe.voids, voxel);
    const double reach = depthForVoids(recipe.voids, voxel, 0, Dim) / 3;
    Extent extent = extentOf(*source, detail, reach, voxel);
    addVoids(extent, recipe.voids, 0);
    domainStage(run, extent, detail, reach, voxel);
    cutStage(run);
    measureStage(run);
    RunResult result = finishStage(run);
    writeReport(result, recipe.domain.source, recipe);
    return result;
}

}  // namespace

void voidsEach(const std::vector<VoidsRecipe>& asked, const Callbacks& caller,
               const std::function<bool(RunResult&&)>& done) {
    std::vector<VoidsRecipe> recipes = asked;
    const VoidsRecipe& first = recipes.front();
    checkVoids(first.voids, false, false);
    if (first.voids.empty())
        throw ParameterError(
            "there are no voids; set how `voids` are made (grid, overlay, boolean or list:FILE)");
    auto inputs = voidInputs(first.voids);
    for (auto& file : domainInputs(first.domain)) inputs.push_back(std::move(file));
    for (const auto& recipe : recipes) checkSettings(recipe, RunKind::voids, recipe.voids, inputs);
    const Callbacks callbacks = withinMemory(caller, first.memoryLimit);
    Report report = begunReport(first, "voids", first.domain.source);
    withThreads(first.threads, [&] {
        Clock clock;
        const Callbacks heard = keepingWarnings(callbacks, report.warnings);
        const VoidRecipe sampled = withSample(first.voids, first.domain, heard);
        for (VoidsRecipe& r : recipes) r.voids = sampled;
        const auto source = std::make_shared<const DomainSource>(first.domain, heard);
        report.seconds.mesh = clock.lap();
        beginOn({source.get()}, first, asked.front().voids, report, heard);
        warnOfUnused(first.domain, *source, heard);
        checkOutputKinds(first.outputs, RunKind::voids, first.voids, source->dim());
        for (const auto& recipe : recipes) {
            report.seed = recipe.seed;
            const Callbacks own = namingRun(recipe, recipe.seed, recipes.size(), callbacks);
            if (!done(source->dim() == 3 ? cutDomain<3>(recipe, source, report, clock, own)
                                         : cutDomain<2>(recipe, source, report, clock, own)))
                return;
            // Seconds spent once are reported once.
            report.seconds = {};
            clock = Clock();
        }
    });
}

RunResult runVoids(const VoidsRecipe& recipe, const Callbacks& callbacks) {
    RunResult result;
    voidsEach({recipe}, callbacks, [&result](RunResult&& run) {
        result = std::move(run);
        return true;
    });
    return result;
}

}  // namespace vdbpack
