// The run that packs: `vdb_pack pack`.
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/formats/pack_parts.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/preview/result_picture.h"
#include "vdbpack/report/measured_pack.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/pack_stage.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/run_parts.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/run/structure_sample.h"
#include "vdbpack/voids/local_values.h"
#include "vdbpack/voids/shell_field.h"
#include "vdbpack/voids/void_families.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

namespace vdbpack {

namespace {

using SourcePtr = std::shared_ptr<const DomainSource>;

/// Reads the spheres to pack around, and counts what is wrong with them already.
template <int Dim>
void prepareExisting(const PackRecipe& recipe, const DomainSource& source, Prepared<Dim>& prepared,
                     const Callbacks& callbacks) {
    if (recipe.existing.empty()) return;
    prepared.existing = readExisting<Dim>(recipe, prepared.built.sliceHeight, callbacks);
    requireSameAxes(recipe.existing, prepared.existing.origin, source);
    const auto& spheres = prepared.existing.spheres;
    const OverlapCheck among = checkOverlap(spheres, ofDim<Dim>(prepared.built)->cell());
    if (!among.complete)
        throw InputError(fmt::format(
            "{}: more than {} pairs of its {} {} overlap one another. Remove the spheres that lie "
            "in others",
            recipe.existing, among.pairs, spheres.size(), Measure<Dim>::kSpheres));
    prepared.inputOverlaps = among.pairs;
    prepared.inputProtrusions = source.protrusion(spheres).spheres;
    if (prepared.inputOverlaps > 0)
        callbacks.warn(
            fmt::format("{}: {} pairs of its {} overlap one another; they are kept as "
                        "they are",
                        recipe.existing, prepared.inputOverlaps, Measure<Dim>::kSpheres));
    if (prepared.inputProtrusions > 0)
        callbacks.warn(
            fmt::format("{}: {} of its {} protrude from the domain; they are kept as "
                        "they are",
                        recipe.existing, prepared.inputProtrusions, Measure<Dim>::kSpheres));
}

/// Warns of sizes for a shell that no sphere of them lies in.
template <int Dim>
void warnOfEmptyShell(const LocalSizes& local, const Callbacks& callbacks) {
    const auto& own = local.shellSizes;
    if (!own || local.shell.most() > own->min()) return;
    callbacks.warn(fmt::format(
        "no {} of `shellRadius` lies in the shell: its thickness is at most {:.4g} mm, the "
        "radii are at least {:.4g} mm, and centers are at least a radius below the wall; give "
        "smaller radii, or a thicker shell",
        Measure<Dim>::kSphere, local.shell.most(), own->min()));
}

template <int Dim>
Prepared<Dim> prepare(const PackRecipe& recipe, const DomainSource& source,
                      const Callbacks& callbacks) {
    PackPlan plan = planPack(recipe, source);
    requireResources(plan.extent, recipe);
    if (Dim == 2 && recipe.voids.fill == Fill::solid)
        throw ParameterError(recipe.domain.source +
                             ": `fill` solid needs a 3D domain; leave it out");
    const FieldRadii& radii = plan.radii;
    Prepared<Dim> prepared{std::move(plan.requested), radii};
    prepared.built =
        source.build(radii.detail, radii.reach, callbacks, plannedVoxel(recipe.voids, Dim));
    const Domain<Dim>& domain = *ofDim<Dim>(prepared.built);
    const double height = prepared.built.sliceHeight;
    RunVoids<Dim>& voids = prepared.voids;
    voids.recipe = recipe.voids;
    takeLongAxis(voids, source, prepared.built);
    voids.largestRadius = prepared.requested.largest() * radii.scale;
    voids.shell = shellOver(recipe.voids, domain.bounds(), height);
    if (voids.areCut())
        checkRoom(VoidSetting<Dim>{voids.recipe,
                                   domain,
                                   height,
                                   recipe.seed,
                                   voids.largestRadius,
                                   callbacks,
                                   nullptr,
                                   {},
                                   voids.shell},
                  true);
    prepared.local = localSizes(recipe, prepared.requested, domain, height, voids.shell);
    warnOfEmptyShell<Dim>(prepared.local, callbacks);
    voids.bvtv = bvtvField<Dim>(recipe.voids, source.recipe(), domain.bounds(), height, callbacks);
    checkPreview<Dim>(recipe.preview, domain, nullptr);
    prepareExisting(recipe, source, prepared, callbacks);
    return prepared;
}

/// All stages after those that the seeds share.
template <int Dim>
RunResult packPrepared(const PackRecipe& recipe, const SourcePtr& source,
                       const Prepared<Dim>& prepared, const Report& begun, const Clock& clock,
                       const Parts& centers, const Callbacks& callbacks) {
    const auto packed = packMeasured(recipe, source, prepared, begun, clock, callbacks);
    Run<Dim>& run = *packed;
    if constexpr (Dim == 3)
        if (!centers.empty()) takeCenters(centers, run);
    PageDetails details;
    if (isPage(recipe.reportFile))
        run.unlessInterrupted([&] {
            Callbacks own = callbacks;
            if (run.ranks()) own.cancelled = nullptr;
            details = pageDetails(run.pack, run.facts.fixed, run.filledSource(),
                                  run.solid ? run.source.get() : nullptr, run.filled(),
                                  run.sizes->all, run.report, own, rowsOf(run));
        });
    RunResult result = finishStage(run);
    if (run.isFirst()) writeReport(result, recipe.domain.source, recipe, details);
    return result;
}

template <int Dim>
void packAll(const std::vector<PackRecipe>& recipes, const SourcePtr& source, const Report& begun,
             Clock clock, const Parts& centers, const Callbacks& callbacks,
             const std::function<bool(RunResult&&)>& done) {
    Report first = begun;
    clock.lap();
    const Prepared<Dim> prepared =
        prepare<Dim>(recipes.front(), *source, keepingWarnings(callbacks, first.warnings));
    first.seconds.domain = clock.lap();
    for (const PackRecipe& recipe : recipes) {
        const Callbacks own = namingRun(recipe, recipe.seed, recipes.size(), callbacks);
        if (!done(packPrepared(recipe, source, prepared, first, clock, centers, own))) return;
        // Seconds spent once are reported once.
        first.seconds = {};
        clock = Clock();
    }
}

void refuse(bool wanted, const char* what, const char* instead) {
    if (wanted)
        throw ParameterError(
            fmt::format("{}: is not done over several processes; {}", what, instead));
}

/// Refuses what is not done over ranks.
void checkRanks(const PackRecipe& recipe) {
    const char* const alone = "leave it out, or start one process with all threads";
    refuse(recipe.densify.fraction > 0 && !recipe.existing.empty(),
           "`densify` around `existing` spheres", alone);
    refuse(recipe.settle && !recipe.existing.empty(), "`settle` around `existing` spheres", alone);
    refuse(recipe.randomStart, "`start` random", alone);
    refuse(recipe.images, "`images` of a periodic cell", "convert a file that was written");
    refuse(recipe.voids.keepConnected, "`keepConnected`", alone);
    refuse(recipe.voids.as<Thinning>() || recipe.voids.as<FrontHoles>(),
           "`voids` chosen among the spheres",
           "use voids such as boolean, overlay, grid or a list");
    const PreviewOptions& preview = recipe.preview;
    refuse(!preview.file.empty() || preview.cut || preview.color != PreviewColor::chosen,
           "a picture", "draw it from a file that was written");
    for (const OutputTarget& output : recipe.outputs) {
        const OutputKind kind = output.kind;
        if (kind == OutputKind::pack) checkShareFormat(output.text);
        refuse(output.listsPairs() || kind == OutputKind::materials || kind == OutputKind::labels ||
                   kind == OutputKind::blender,
               output.text.c_str(), "write it from a file of the spheres");
    }
}

/// The same in a periodic cell; any other domain passes.
void checkRanksIn(const DomainSource& source, const PackRecipe& recipe) {
    if (!source.isPeriodic()) return;
    refuse(isPage(recipe.reportFile), "a page of a periodic cell", "write a report as .json");
}

}  // namespace

std::unique_ptr<Run<3>> packPart(const PackRecipe& recipe, const SourcePtr& source,
                                 const Report& begun, Clock clock, const Callbacks& callbacks) {
    Report first = begun;
    const auto prepared = prepare<3>(recipe, *source, keepingWarnings(callbacks, first.warnings));
    first.seconds.domain = clock.lap();
    auto run = packMeasured<3>(recipe, source, prepared, first, clock, callbacks);
    run->voids.bvtv = {};  // it holds an image
    return run;
}

void packEach(const std::vector<PackRecipe>& asked, const Callbacks& caller,
              const std::function<bool(RunResult&&)>& done) {
    std::vector<PackRecipe> recipes = asked;
    const PackRecipe& recipe = recipes.front();
    const Callbacks callbacks = withinMemory(caller, recipe.memoryLimit);
    for (const auto& r : recipes) checkRecipe(r);
    if (recipe.ranks) checkRanks(recipe);
    Clock clock;
    Report report = begunReport(recipe, "pack", recipe.domain.source);
    const auto work = [&] {
        const Callbacks heard = keepingWarnings(callbacks, report.warnings);
        const VoidRecipe sampled = withSample(recipe.voids, recipe.domain, heard);
        for (PackRecipe& r : recipes) {
            r.voids = sampled;
            for (PackRecipe& part : r.parts)
                part.voids = withSample(part.voids, part.domain, heard);
        }
        warnOfUnusedWeights(recipe.weightBy, {&recipe.radius, &recipe.shellRadius}, heard);
        const Parts centers = partsByCenter(recipes.front(), heard);
        if (!centers.empty())
            for (PackRecipe& r : recipes) r.domain = recipe.domain;
        if (Parts parts = partsOf(recipe, heard); !parts.empty()) {
            report.seconds.mesh = clock.lap();
            if (recipes.size() > 1)
                throw ParameterError("several parts are packed with one `seed`");
            done(packParts(recipe, std::move(parts), report, clock, callbacks));
            return;
        }
        const auto source = std::make_shared<const DomainSource>(recipe.domain, heard);
        report.seconds.mesh = clock.lap();
        if (recipe.ranks) checkRanksIn(*source, recipe);
        beginOn({source.get()}, recipe, asked.front().voids, report, heard, false,
                recipe.sizeField);
        warnOfUnused(recipe.domain, *source, heard);
        checkOutputKinds(recipe.outputs, RunKind::pack, recipe.voids, source->dim());
        if (source->dim() == 3)
            packAll<3>(recipes, source, report, clock, centers, callbacks, done);
        else
            packAll<2>(recipes, source, report, clock, centers, callbacks, done);
    };
    try {
        // One thread more speaks with the other ranks.
        withThreads(recipe.threads, work, recipe.ranks ? 1 : 0);
    } catch (const Interrupted&) {
        if (recipe.ranks) throw;  // the others may have come farther
        RunResult none;
        none.report = report;
        none.report.interrupted = true;
        none.passed = true;
        done(std::move(none));
    }
}

RunResult runPack(const PackRecipe& recipe, const Callbacks& callbacks) {
    RunResult result;
    packEach({recipe}, callbacks, [&result](RunResult&& run) {
        result = std::move(run);
        return true;
    });
    return result;
}

}  // namespace vdbpack
