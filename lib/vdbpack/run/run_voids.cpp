// Runs that cut voids without packing: voids and carve.
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/run/needs.h"
#include "vdbpack/run/outputs.h"
#include "vdbpack/run/preview_stage.h"
#include "vdbpack/run/recipe_file.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/run_given.h"
#include "vdbpack/run/run_stages.h"
#include "vdbpack/run/void_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace vdbpack {

namespace {

/// Share of the spheres outside of the domain from which on it seems to be another one.
constexpr double kManyOutside = 0.05;

/// The smallest feature that the field of a domain has to resolve, mm; 0: unknown. The wall itself
/// is asked where it matters, so that voxels may be larger than those of the voids.
double detailFor(const VoidRecipe& recipe) {
    if (recipe.voxelSize > 0) return 4 * recipe.voxelSize;
    return recipe.radius.empty() ? 0 : SizeDistribution::parse(recipe.radius, 3).min();
}

/// Refuses what memory or disks have no room for.
template <class Recipe>
void requireRoom(const Recipe& recipe, Extent extent, double count, double largest) {
    extent.count = count;
    addVoids(extent, recipe.voids, largest);
    extent.outputs = recipe.outputs;
    extent.preview = recipe.preview;
    extent.reportFile = recipe.reportFile;
    extent.threads = effectiveThreads(recipe.threads);
    requireResources(needsOf(extent), memoryLimit(recipe.memoryLimit));
}

template <int Dim>
void voidsOf(const VoidsRecipe& recipe, const DomainSource& source, RunResult& run, Clock& clock,
             const Callbacks& callbacks) {
    Report& report = run.report;
    requireShell(recipe.voids.shell, source);
    const double detail = detailFor(recipe.voids), reach = depthForShell(recipe.voids) / 3;
    const double voxel = plannedVoxel(recipe.voids, Dim);
    requireRoom(recipe, extentOf(source, detail, reach, voxel), 0, 0);
    const auto built = source.build(detail, reach, callbacks, voxel);
    const Domain<Dim>& domain = *ofDim<Dim>(built);
    report.dim = Dim;
    report.domain = domain.facts();
    report.volume = domain.volume();
    report.area = domain.wallArea();
    report.seconds.domain = clock.lap();
    callbacks.stopIfCancelled();
    const VoidSetting<Dim> setting{recipe.voids, domain, built.sliceHeight,
                                   recipe.seed,  0,      callbacks};
    checkRoom(setting, false);
    checkPreview<Dim>(recipe.preview, domain, nullptr);
    MadeVoids<Dim> made = makeVoids(setting);
    report.seconds.voids = clock.lap();
    measureVoids<Dim>(setting, 0, nullptr, made);
    report.chosen = made.report.chosen;
    report.voids = made.report;
    report.seconds.measure = clock.lap();
    RunOutputs<Dim> have;
    have.voidList = &made.list;
    have.sliceHeight = built.sliceHeight;
    if (built.mesh) have.wall = &built.mesh->wall();
    have.options.unit = recipe.outUnit;
    have.options.generator = "vdb_pack " + report.version;
    have.options.levelSets = made.levelSets();
    report.files = writeOutputs(recipe.outputs, have, callbacks);
    run.picture = drawPreview<Dim>(recipe.preview, recipe.reportFile, source, built, made, nullptr,
                                   callbacks);
    if (!recipe.preview.file.empty()) report.files.push_back(recipe.preview.file);
    leaveRecipe(recipe.optionsText, recipe.outputs, report, callbacks);
    report.seconds.write = clock.lap();
}

/// Cuts, measures and writes a pack that was read.
template <int Dim>
void carve(const CarveRecipe& recipe, const DomainSource& source, Pack<Dim>& pack, RunResult& run,
           Clock& clock, const Callbacks& callbacks) {
    Report& report = run.report;
    const RadiusStatistics radius = radiusStatistics(pack.spheres);
    requireShell(recipe.voids.shell, source);
    const double detail = fieldDetail(radius.min, radius.mean);
    const double reach = std::max(radius.max, depthForShell(recipe.voids) / 3);
    const double voxel = plannedVoxel(recipe.voids, Dim);
    requireRoom(recipe, extentOf(source, detail, reach, voxel),
                static_cast<double>(pack.spheres.size()), radius.max);
    const auto built = source.build(detail, reach, callbacks, voxel);
    const Domain<Dim>& domain = *ofDim<Dim>(built);
    report.seconds.domain = clock.lap();
    const VoidSetting<Dim> setting{recipe.voids, domain,     built.sliceHeight,
                                   recipe.seed,  radius.max, callbacks};
    checkRoom(setting, false);
    checkPreview<Dim>(recipe.preview, domain, &pack);
    if (!recipe.radius.empty())
        measureSizes(pack, SizeDistribution::parse(recipe.radius, Dim, recipe.weightBy), report);
    callbacks.stopIfCancelled();
    MadeVoids<Dim> made = makeVoids(setting);
    cullPack(setting, recipe.contactTolerance, 0, made, pack);
    report.seconds.voids = clock.lap();
    measureVoids(setting, recipe.contactTolerance, &pack, made);
    report.chosen = made.report.chosen;
    report.voids = made.report;
    measurePack(pack, &source, &domain, nullptr, recipe.contactTolerance, report, callbacks);
    if (report.interrupted) throw Interrupted();
    // Whoever made them: told, not judged.
    report.givenOverlaps = report.overlap->pairs;
    report.givenProtrusions = report.protrusion->spheres;
    if (static_cast<double>(report.givenProtrusions) >
        kManyOutside * static_cast<double>(report.count))
        callbacks.warn(fmt::format(
            "{}: {} of {} {} are not wholly inside the domain; does the pack belong to it, and are "
            "--unit and --pack-unit right?",
            recipe.pack, report.givenProtrusions, report.count, Measure<Dim>::kSpheres));
    report.seconds.measure = clock.lap();
    RunOutputs<Dim> have;
    have.pack = &pack;
    have.domain = &domain;
    have.voidList = &made.list;
    have.sliceHeight = built.sliceHeight;
    if (built.mesh) have.wall = &built.mesh->wall();
    have.options.contactTolerance = recipe.contactTolerance;
    PackWriteOptions& write = have.options;
    write.unit = recipe.outUnit;
    write.generator = "vdb_pack " + report.version;
    write.particleDensity = particleDensity(recipe.density, report.solidFractionTotal);
    write.levelSets = made.levelSets();
    if (write.levelSets.empty() && built.mesh) write.levelSets = {built.mesh->grid()};
    if constexpr (Dim == 2) write.frame = domain.bounds();
    report.files = writeOutputs(recipe.outputs, have, callbacks);
    if (!pack.spheres.empty()) {
        run.picture =
            drawPreview(recipe.preview, recipe.reportFile, source, built, made, &pack, callbacks);
        if (!recipe.preview.file.empty()) report.files.push_back(recipe.preview.file);
    }
    leaveRecipe(recipe.optionsText, recipe.outputs, report, callbacks);
    report.seconds.write = clock.lap();
}

/// What a report of either run begins with.
template <class Recipe>
void begin(Report& report, const Recipe& recipe, const std::string& task,
           const std::string& subject) {
    report.version = VDBPACK_VERSION;
    report.task = task;
    report.command = recipe.command.empty() ? task + " " + subject : recipe.command;
    report.seed = recipe.seed;
    report.threads = effectiveThreads(recipe.threads);
}

/// Cutting is not judged: `passed` is true.
template <class Recipe>
void finish(RunResult& run, const Recipe& recipe) {
    run.report.peakMemoryBytes = peakMemory();
    run.passed = true;
    if (recipe.reportFile.empty()) return;
    run.report.files.push_back(recipe.reportFile);
    writeReport(run, recipe);
}

}  // namespace

RunResult runVoids(const VoidsRecipe& recipe, const Callbacks& callbacks) {
    checkVoids(recipe.voids, false, false);
    if (recipe.voids.empty())
        throw ParameterError(
            "no voids are asked for; say how they are made with --voids (grid, "
            "overlay, boolean or list:FILE)");
    checkOutputKinds(recipe.outputs, RunKind::voids, recipe.voids);
    auto inputs = voidInputs(recipe.voids);
    for (auto& file : domainInputs(recipe.domain)) inputs.push_back(std::move(file));
    checkPreview(recipe.preview, recipe.reportFile);
    checkFiles(recipe.outputs, recipe.reportFile, inputs, recipe.preview.file);
    RunResult run;
    Report& report = run.report;
    begin(report, recipe, "voids", recipe.domain.source);
    const Callbacks heard =
        keepingWarnings(withinMemory(callbacks, memoryLimit(recipe.memoryLimit)), report.warnings);
    withThreads(recipe.threads, [&] {
        Clock clock;
        const DomainSource source(recipe.domain, heard);
        report.seconds.mesh = clock.lap();
        warnOfUnused(recipe.domain, source, heard);
        checkOutputKinds(recipe.outputs, RunKind::voids, recipe.voids, source.dim());
        if (source.dim() == 3)
            voidsOf<3>(recipe, source, run, clock, heard);
        else
            voidsOf<2>(recipe, source, run, clock, heard);
        report.seconds.total = clock.total();
    });
    finish(run, recipe);
    return run;
}

RunResult runCarve(const CarveRecipe& recipe, const Callbacks& callbacks) {
    checkVoids(recipe.voids, true, false);
    if (recipe.voids.empty() && !(recipe.voids.shell > 0))
        throw ParameterError(
            "nothing is to be cut; say how voids are made with --voids (grid, "
            "overlay, concentric, threshold, boolean or list:FILE)");
    if (recipe.domain.source.empty())
        throw ParameterError("voids are cut into a domain; give that of the pack with --domain");
    checkOutputKinds(recipe.outputs, RunKind::pack, recipe.voids);
    checkDensity(recipe.density);
    requireContactTolerance(recipe.contactTolerance);
    auto inputs = voidInputs(recipe.voids);
    for (auto& file : domainInputs(recipe.domain)) inputs.push_back(std::move(file));
    inputs.push_back(recipe.pack);
    inputs.push_back(recipe.radius);  // table:FILE
    checkPreview(recipe.preview, recipe.reportFile);
    checkFiles(recipe.outputs, recipe.reportFile, inputs, recipe.preview.file);
    RunResult run;
    Report& report = run.report;
    begin(report, recipe, "carve", recipe.pack);
    const Callbacks heard =
        keepingWarnings(withinMemory(callbacks, memoryLimit(recipe.memoryLimit)), report.warnings);
    withThreads(recipe.threads, [&] {
        Clock clock;
        Pack<3> given = readGiven(recipe, heard);
        const DomainSource source(recipe.domain, heard);
        report.seconds.mesh = clock.lap();
        checkOutputKinds(recipe.outputs, RunKind::pack, recipe.voids, source.dim());
        if (source.dim() == 2) {
            Pack<2> circles = asCircles(given);
            carve<2>(recipe, source, circles, run, clock, heard);
            run.pack = std::move(circles);
        } else {
            carve<3>(recipe, source, given, run, clock, heard);
            run.pack = std::move(given);
        }
        report.seconds.total = clock.total();
    });
    finish(run, recipe);
    return run;
}

}  // namespace vdbpack
