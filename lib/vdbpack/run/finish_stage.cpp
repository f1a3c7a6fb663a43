// The last stage of a run: outputs, picture, recipe file.
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/distributed/rank_outputs.h"
#include "vdbpack/formats/grey_values.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/sphere_density.h"
#include "vdbpack/options/recipe_file.h"
#include "vdbpack/preview/result_picture.h"
#include "vdbpack/run/interfaces.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/solid_stage.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/view/pack_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

namespace vdbpack {

SolidTest solidOf(const Run<3>& run) {
    return run.voids.made.solid.grid ? solidTest(run.voids.made.solid.grid)
                                     : solidTest(run.built.space);
}

namespace {

LabelSource labelsOf(const Run<3>& run) {
    LabelSource labels;
    std::vector<const DomainSource*> sources;
    for (const auto& source : run.parts.sources) sources.push_back(source.get());
    labels.solids = run.parts.solids;
    if (sources.empty()) {
        sources.push_back(run.source.get());
        labels.solids.push_back(solidOf(run));
    }
    labels.grid = labelGridOf(run.settings.outputs, sources, run.settings.memoryLimit);
    for (const DomainSource* source : sources)
        if (source->recipe().space == ImageSpace::ras) labels.space = ImageSpace::ras;
    return labels;
}

/// The wall of all parts; null: there is one domain, whose wall is its own.
template <int Dim>
const TriangleMesh* joinedWall(const Run<Dim>& run) {
    return run.parts.walls.triangles.empty() ? nullptr : &run.parts.walls;
}

template <int Dim>
RunOutputs<Dim> outputsOf(const Run<Dim>& run) {
    RunOutputs<Dim> have;
    have.pack = run.hasPack ? &run.pack : nullptr;
    have.domain = &run.domain();
    if (run.built.mesh) have.wall = &run.built.mesh->wall();
    if (const TriangleMesh* wall = joinedWall(run)) have.wall = wall;
    have.voidList = &run.voids.made.list;
    if (!run.report.parts.empty()) have.interfaces = &run.report.interfaces;
    have.sliceHeight = run.built.sliceHeight;
    PackWriteOptions& write = have.options;
    write.bonds = bondOptionsOf(run.settings);
    write.unit = run.settings.outUnit;
    write.images = run.settings.images;
    write.generator = generatorWith(
        "vdb_pack " + run.report.version + (run.report.interrupted ? ", interrupted" : ""),
        run.pack.origin);
    const SphereDensity density =
        particleDensity(run.settings.density, run.report.solidFractionTotal);
    write.particleDensity = density.all;
    if (run.settings.grey.calibration.empty())
        write.materialDensity =
            run.parts.properties.density.empty() ? density.ofRegions : run.parts.properties.density;
    write.levelSets =
        run.parts.levelSets.empty() ? run.voids.made.levelSets() : run.parts.levelSets;
    const auto& outputs = run.settings.outputs;
    if (write.levelSets.empty() && run.built.mesh &&
        std::any_of(outputs.begin(), outputs.end(),
                    [](const OutputTarget& output) { return output.usesLevelSets(); }))
        write.levelSets = {run.built.mesh->grid()};
    if constexpr (Dim == 2)
        write.frame = run.domain().bounds();
    else
        have.labels = labelsOf(run);
    // 25 bits of a voxel's edge are exact in the file: no coarser than the positions.
    if (run.facts.positionStep > 0)
        write.pointVoxel = std::min(
            pointVoxelSize(static_cast<double>(run.report.count), run.filled().volume(), Dim),
            run.facts.positionStep * 0x1p25);
    return have;
}

/// Removes those outputs that an interrupted run has not made: voids and what they leave.
template <int Dim>
void leaveOutIncomplete(const Run<Dim>& run, std::vector<OutputTarget>& outputs) {
    if (!run.parts.sources.empty()) {
        // Parts may be missing, and voids of those that are there.
        outputs.erase(
            std::remove_if(outputs.begin(), outputs.end(),
                           [](const OutputTarget& output) { return output.labels == "solid"; }),
            outputs.end());
        return;
    }
    if (!run.cuts() || !run.voids.made.levelSets().empty()) return;
    const auto isMissing = [&](const OutputTarget& output) {
        const OutputKind kind = output.kind;
        const bool missing = kind == OutputKind::contour || kind == OutputKind::levelSets ||
                             kind == OutputKind::fog ||
                             (kind == OutputKind::labels && output.labels == "solid") ||
                             (kind == OutputKind::voidList && run.voids.made.list.empty());
        if (missing)
            run.callbacks.warn(output.text +
                               ": is not written; the run was interrupted before its "
                               "voids were complete");
        return missing;
    };
    outputs.erase(std::remove_if(outputs.begin(), outputs.end(), isMissing), outputs.end());
}

/// Writes the outputs and the recipe that repeats the run.
template <int Dim>
void write(Run<Dim>& run) {
    const RunSettings& settings = run.settings;
    Report& report = run.report;
    report.seconds.measure += run.clock.lap();
    std::vector<OutputTarget> outputs = settings.outputs;
    if (report.interrupted) {
        if (report.count == 0) return;
        leaveOutIncomplete(run, outputs);
        for (OutputTarget& output : outputs) output = interruptedName(output.text);
    }
    const BondOptions bonds = bondOptionsOf(settings);
    warnOfUnusedBonds(run.pack, run.pack.origin, bonds, run.callbacks);
    run.pack.origin = {report.axes, bonds.tolerance,
                       std::max(bonds.interfaceTolerance, run.pack.origin.interfaceTolerance),
                       bonds.law.shearRatio == BondLaw().shearRatio ? run.pack.origin.shearRatio
                                                                    : bonds.law.shearRatio};
    const RunOutputs<Dim> have = outputsOf(run);
    if (have.pack)
        keepDensities(run.pack, run.pack.spheres.size(), have.options.particleDensity,
                      have.options.materialDensity);
    if (have.pack) warnOfLostOrigin(outputs, run.pack.origin, run.pack.cell.any(), run.callbacks);
    warnOfModuli(run.pack, bonds.law, run.callbacks);
    warnOfBondLaw(bonds.law, run.callbacks);
    if (have.pack && !run.ranks()) report.materials = materialsOf(run.pack);
    report.files = run.ranks()
                       ? writeOverRanks(outputs, have,
                                        PackShare<Dim>{run.ranks(), run.pack, run.share.spans,
                                                       run.share.pieces.size() + 1},
                                        run.callbacks)
                       : writeOutputs(outputs, have, run.callbacks);
    if (settings.repeatedHash && !report.interrupted && report.hash != *settings.repeatedHash) {
        report.repeatedHash = settings.repeatedHash;
        run.callbacks.warn(fmt::format(
            "hash {:016x}, where the recipe that was repeated states {:016x}: the pack is another "
            "one. An input file, an option or the version differs",
            report.hash, *settings.repeatedHash));
    }
    if (!report.files.empty() && run.isFirst())
        leaveRecipe(settings.optionsText, outputs, report, run.callbacks);
}

/// The preview, or the picture of the report page, drawn.
template <int Dim>
PagePicture drawn(Run<Dim>& run) {
    const RunSettings& settings = run.settings;
    const std::string& file = settings.preview.file;
    const bool missing = run.report.interrupted || (run.hasPack && run.pack.spheres.empty());
    if (run.ranks() || missing || (file.empty() && !isPage(settings.reportFile))) return {};
    run.callbacks.report("write", 0, 0);
    const TriangleMesh* wall =
        run.parts.drawn.triangles.empty() ? joinedWall(run) : &run.parts.drawn;
    try {
        PagePicture picture =
            drawPreview(settings.preview, settings.reportFile, *run.source, run.built,
                        run.voids.made, run.hasPack ? &run.pack : nullptr, run.callbacks, wall);
        if (run.hasPack && isPage(settings.reportFile))
            addView(settings.preview, run.source.get(), run.built, run.pack, wall, false, picture);
        if (!file.empty()) run.report.files.push_back(file);
        return picture;
    } catch (const Interrupted&) {
        // All else is complete, and written.
        run.callbacks.warn("the picture is left out, since the run was interrupted");
        return {};
    }
}

}  // namespace

template <int Dim>
RunResult finishStage(Run<Dim>& run) {
    // The pack is written whatever happens to the images.
    std::exception_ptr greyFailure;
    Callbacks uncancelled = run.callbacks;
    uncancelled.cancelled = nullptr;
    try {
        addGreyValues(run.settings.grey, run.source->recipe(), run.parts.properties, run.pack,
                      uncancelled);
    } catch (const Error&) {
        greyFailure = std::current_exception();
    }
    write(run);
    if (greyFailure) {
        run.callbacks.warn("the pack is written without the columns of grey values");
        std::rethrow_exception(greyFailure);
    }
    RunResult result;
    result.picture = drawn(run);
    Report& report = run.report;
    report.seconds.write = run.clock.lap();
    if (run.voids.recipe.measureSolid && report.voids && !report.interrupted) {
        if (Dim == 3)
            report.voids->solid = measureSolidIn(run.voids.made.levelSets(), run.source->recipe(),
                                                 report.voids->shell, run.settings, run.callbacks);
        else
            run.callbacks.warn("`measureSolid`: solids of a plane are not measured");
        report.seconds.measure += run.clock.lap();
    }
    report.seconds.total = run.clock.total();
    report.peakMemoryBytes =
        static_cast<std::uint64_t>(maxOver(run.ranks(), static_cast<double>(peakMemory())));
    result.passed = !failedChecks(report).any();
    const std::string reportFile = reportFileOf(run.settings, report);
    if (!reportFile.empty()) report.files.push_back(reportFile);
    result.report = std::move(report);
    result.levelSets = run.voids.made.levelSets();
    result.voids = std::move(run.voids.made.list);
    if (run.hasPack) result.pack = std::move(run.ranks() ? run.share.named : run.pack);
    return result;
}

template RunResult finishStage(Run<2>&);
template RunResult finishStage(Run<3>&);

}  // namespace vdbpack
