// The run that makes a pack denser, whoever made it.
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/run/densify_stage.h"
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

#include <cmath>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

template <int Dim>
void densifyGiven(const DensifyRecipe& recipe, const DomainSource& source, Pack<Dim>& pack,
                  RunResult& run, Clock& clock, const Callbacks& callbacks) {
    Report& report = run.report;
    std::optional<SizeDistribution> sizes;
    if (!recipe.radius.empty())
        sizes = SizeDistribution::parse(recipe.radius, Dim, recipe.weightBy);
    RadiusStatistics radius = radiusStatistics(pack.spheres);
    if (sizes) {
        radius.min = std::min(radius.min, sizes->min());
        radius.max = std::max(radius.max, sizes->max());
    }
    const double detail = fieldDetail(radius.min, radius.mean), reach = radius.max + recipe.gap;
    Extent extent = extentOf(source, detail, reach);
    extent.count = static_cast<double>(pack.spheres.size());
    extent.densifying = true;
    extent.outputs = recipe.outputs;
    extent.preview = recipe.preview;
    extent.reportFile = recipe.reportFile;
    extent.threads = report.threads;
    requireResources(needsOf(extent), memoryLimit(recipe.memoryLimit));
    const auto built = source.build(detail, reach, callbacks);
    const Domain<Dim>& domain = *ofDim<Dim>(built);
    checkPreview<Dim>(recipe.preview, domain, &pack);
    report.seconds.domain = clock.lap();
    callbacks.stopIfCancelled();
    pack.sliceHeight = built.sliceHeight;
    densifyPack(domain, {recipe.fraction, sizes ? &*sizes : nullptr, recipe.gap, recipe.seed, 0},
                pack, report, callbacks);
    report.seconds.densify = clock.lap();
    callbacks.report("measure", 0, 0);
    measurePack(pack, &source, &domain, sizes ? &*sizes : nullptr, recipe.contactTolerance, report,
                callbacks);
    report.seconds.measure = clock.lap();
    RunOutputs<Dim> have;
    have.pack = &pack;
    have.domain = &domain;
    have.sliceHeight = built.sliceHeight;
    if (built.mesh) have.wall = &built.mesh->wall();
    have.options.contactTolerance = recipe.contactTolerance;
    PackWriteOptions& write = have.options;
    write.unit = recipe.outUnit;
    write.generator = "vdb_pack " + report.version;
    write.particleDensity = particleDensity(recipe.density, report.solidFractionTotal);
    if (built.mesh) write.levelSets = {built.mesh->grid()};
    if constexpr (Dim == 2) write.frame = domain.bounds();
    // 25 bits of a voxel's edge are exact in the file: no coarser than the positions.
    write.pointVoxel =
        std::min(pointVoxelSize(static_cast<double>(report.count), domain.volume(), Dim),
                 std::exp2(std::floor(std::log2(radius.mean))) * 8);
    report.files = writeOutputs(recipe.outputs, have, callbacks);
    try {
        if (!report.interrupted)
            run.picture = drawPreview<Dim>(recipe.preview, recipe.reportFile, source, built,
                                           MadeVoids<Dim>(), &pack, callbacks);
        if (!report.interrupted && !recipe.preview.file.empty())
            report.files.push_back(recipe.preview.file);
    } catch (const Interrupted&) {  // the pack is written
        report.interrupted = true;
    }
    if (!report.files.empty()) leaveRecipe(recipe.optionsText, recipe.outputs, report, callbacks);
    report.seconds.write = clock.lap();
}

}  // namespace

RunResult runDensify(const DensifyRecipe& recipe, const Callbacks& callbacks) {
    if (recipe.domain.source.empty())
        throw ParameterError(
            "spheres are moved within a domain; give that of the pack with "
            "--domain");
    checkOutputKinds(recipe.outputs, RunKind::pack, {});
    checkDensity(recipe.density);
    requireContactTolerance(recipe.contactTolerance);
    auto inputs = domainInputs(recipe.domain);
    inputs.push_back(recipe.pack);
    inputs.push_back(recipe.radius);  // table:FILE
    checkPreview(recipe.preview, recipe.reportFile);
    checkFiles(recipe.outputs, recipe.reportFile, inputs, recipe.preview.file);
    RunResult run;
    Report& report = run.report;
    report.version = VDBPACK_VERSION;
    report.task = "densify";
    report.command = recipe.command.empty() ? "densify " + recipe.pack : recipe.command;
    report.seed = recipe.seed;
    report.threads = effectiveThreads(recipe.threads);
    report.gapAsked = recipe.gap;
    const Callbacks heard =
        keepingWarnings(withinMemory(callbacks, memoryLimit(recipe.memoryLimit)), report.warnings);
    withThreads(recipe.threads, [&] {
        Clock clock;
        Pack<3> given = readGiven(recipe, heard);
        requireRoomToNumber(given, recipe.pack);
        const DomainSource source(recipe.domain, heard);
        report.seconds.mesh = clock.lap();
        checkOutputKinds(recipe.outputs, RunKind::pack, {}, source.dim());
        if (source.dim() == 2) {
            Pack<2> circles = asCircles(given);
            densifyGiven<2>(recipe, source, circles, run, clock, heard);
            run.pack = std::move(circles);
        } else {
            densifyGiven<3>(recipe, source, given, run, clock, heard);
            run.pack = std::move(given);
        }
        report.seconds.total = clock.total();
    });
    report.peakMemoryBytes = peakMemory();
    run.passed = passed(report);
    if (!recipe.reportFile.empty()) {
        report.files.push_back(recipe.reportFile);
        writeReport(run, recipe);
    }
    return run;
}

}  // namespace vdbpack
