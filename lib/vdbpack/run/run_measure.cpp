// The run that measures any pack or solid: `vdb_pack measure`.
#include "vdbpack/core/error.h"
#include "vdbpack/domain/label_voxels.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/io/text.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/report_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <vector>

namespace vdbpack {

namespace {

/// An image narrower than this is warned about.
constexpr std::int64_t kFewVoxels = 16;

/// What is measured as a pack, or nothing if it is a solid. A grid's name says which of both.
std::optional<Pack<3>> packToMeasure(const MeasureRecipe& recipe, const Callbacks& callbacks) {
    if (!recipe.packGrid.empty()) return readInputPack(recipe, callbacks);
    const bool namesLevelSet = extensionOf(recipe.pack) == ".vdb" &&
                               !recipe.domain.gridName.empty() &&
                               extensionOf(recipe.domain.source) != ".vdb";
    if (namesLevelSet) return std::nullopt;
    return readInputPackUnlessSolid(recipe, callbacks);
}

/// How far beyond the total volume the solid is looked at, mm, so that balls do not grow through
/// the faces of a box cut from a larger sample: a tenth of its shortest side, if the sample reaches
/// that far on all sides. Else 0: what ends at those faces was cut there.
double marginFor(const VdbGrid& grid, const std::optional<Box<3>>& bounds) {
    if (!bounds) return 0;
    const Vec<3> size = bounds->size();
    const double margin = 0.1 * *std::min_element(size.c.begin(), size.c.end());
    const Box<3> band = bandBounds(grid);
    for (int d = 0; d < 3; ++d)
        if (band.lo[d] > bounds->lo[d] - margin || band.hi[d] < bounds->hi[d] + margin) return 0;
    return margin;
}

MeasureResult measureSolid(const MeasureRecipe& recipe, Report report, const Callbacks& callbacks) {
    if (!recipe.outputs.empty())
        throw ParameterError(recipe.outputs.front() +
                             ": a solid has no contacts to list; measure "
                             "a pack, or leave the output out");
    Clock clock;
    requireDomain(recipe);
    const double voxel = recipe.domain.voxelSize;
    const bool boxed = recipe.domain.source.rfind("box:", 0) == 0 && recipe.domain.clips.empty();
    std::shared_ptr<const VdbGrid> grid;
    double imageVoxel = voxel;
    const bool mesh = extensionOf(recipe.pack) != ".vdb";
    if (mesh) {
        DomainRecipe solid;
        solid.source = recipe.pack;
        solid.unit = recipe.packUnit;
        const Vec<3> size = DomainSource(solid, callbacks).fileBounds().size();
        if (!(voxel > 0)) imageVoxel = *std::max_element(size.c.begin(), size.c.end()) / 256;
        solid.voxelSize = imageVoxel;
        Extent extent = extentOf(DomainSource(solid), imageVoxel, imageVoxel);
        extent.imageVoxels = size[0] * size[1] * size[2] / (imageVoxel * imageVoxel * imageVoxel);
        requireResources(extent, recipe);
        grid = DomainSource(solid).build(imageVoxel, imageVoxel, callbacks).mesh->grid();
    } else {
        grid = levelSetGrid(recipe.pack, recipe.domain.gridName, millimetersPer(recipe.packUnit));
    }
    report.seconds.mesh = clock.lap();
    std::optional<DomainSource> source;
    DomainSource::Built built;
    std::optional<Box<3>> bounds;
    if (!recipe.domain.source.empty()) {
        DomainRecipe total = recipe.domain;
        total.voxelSize = 0;
        if (mesh || extensionOf(total.source) != ".vdb") total.gridName.clear();
        source.emplace(total, callbacks);
        if (source->dim() != 3)
            throw ParameterError(total.source + ": is plane; a solid needs a domain of space");
        // Its wall need not be known as well as that of the solid.
        const double fine = 2 * (imageVoxel > 0 ? imageVoxel : voxelSizeOf(*grid));
        built = source->build(fine, std::max(recipe.shell * 1.05, fine) / 3, callbacks);
        bounds = built.space->bounds();
    }
    report.seconds.domain = clock.lap();
    callbacks.stopIfCancelled();
    VoxelImage image = sampleLevelSet(*grid, bounds, imageVoxel, marginFor(*grid, bounds));
    grid.reset();
    if (built.space && (!boxed || recipe.shell > 0)) labelVoxels(image, *built.space, recipe.shell);
    callbacks.stopIfCancelled();
    const auto fewest = *std::min_element(image.size.begin(), image.size.end());
    if (fewest < kFewVoxels)
        callbacks.warn(
            fmt::format("{}: the total volume is {} voxels of {:.3g} mm across; figures "
                        "are coarse: choose a larger domain or a smaller `voxelSize`",
                        recipe.pack, fewest, image.voxelSize));
    MeasureResult result;
    result.morphometry = measureMorphometry(image);
    // One region is the whole.
    if (result.morphometry->regions.size() == 1) result.morphometry->regions.clear();
    if (result.morphometry->solidFraction == 0)
        callbacks.warn(recipe.pack + ": no solid lies in the total volume");
    report.seconds.measure = clock.lap();
    report.seconds.total = clock.total();
    report.peakMemoryBytes = peakMemory();
    result.run.report = std::move(report);
    result.run.passed = true;
    return result;
}

template <int Dim>
std::vector<std::string> writeMeasured(const Pack<Dim>& pack, const MeasureRecipe& recipe,
                                       const Callbacks& callbacks) {
    RunOutputs<Dim> have;
    have.pack = &pack;
    have.options.contactTolerance = recipe.contactTolerance;
    have.options.unit = recipe.outUnit;
    return writeOutputs(recipe.outputs, have, callbacks);
}

}  // namespace

MeasureResult runMeasure(const MeasureRecipe& recipe, const Callbacks& callbacks) {
    if (recipe.shell > 0 && recipe.domain.source.empty())
        throw ParameterError("`shell` lies along the wall of a domain; set `domain`");
    checkSettings(recipe, RunKind::measure, {}, inputFiles(recipe));
    Report report = begunReport(recipe, "measure", recipe.pack);
    std::vector<std::string> warnings;
    const Callbacks heard = keepingWarnings(withinMemory(callbacks, recipe.memoryLimit), warnings);
    MeasureResult result = withThreads(recipe.threads, [&] {
        Clock clock;
        std::optional<Pack<3>> pack = packToMeasure(recipe, heard);
        if (!pack) return measureSolid(recipe, std::move(report), heard);
        report.seconds.mesh = clock.lap();
        const auto depthFor = [&](const RadiusStatistics& r) {
            return structureDepth(r, recipe.shell);
        };
        MeasureResult found;
        found.run = measureInputPack(
            recipe, std::move(*pack), std::move(report), depthFor, heard,
            [&](const auto& spheres, const auto* domain, const Report& measured) {
                found.structure = measureStructure(spheres, domain, measured, recipe.shell, heard);
                if (recipe.shell > 0 && found.structure.regions.size() == 1)
                    heard.warn(fmt::format(
                        "`shell` {:g} mm: no part of the domain lies deeper than the shell",
                        recipe.shell));
            });
        clock.lap();
        found.run.report.files = std::visit(
            [&](const auto& p) { return writeMeasured(p, recipe, heard); }, found.run.pack);
        found.run.report.seconds.write = clock.lap();
        found.run.report.seconds.total = clock.total();
        return found;
    });
    result.run.report.warnings = std::move(warnings);
    if (!recipe.reportFile.empty()) result.run.report.files.push_back(recipe.reportFile);
    writeReport(result, recipe);
    return result;
}

nlohmann::ordered_json toJson(const MeasureResult& result) {
    if (!result.morphometry) {
        auto json = toJson(result.run);
        addTo(json, result.structure);
        return json;
    }
    const Report& report = result.run.report;
    return {{"version", report.version},
            {"command", report.command},
            {"threads", report.threads},
            {"morphometry", toJson(*result.morphometry)},
            {"seconds",
             {{"mesh", report.seconds.mesh},
              {"domain", report.seconds.domain},
              {"measure", report.seconds.measure},
              {"total", report.seconds.total}}},
            {"peakMemoryBytes", report.peakMemoryBytes}};
}

std::string summary(const MeasureResult& result) {
    const Report& report = result.run.report;
    if (!result.morphometry) return summary(report) + summary(result.structure);
    return summary(*result.morphometry) +
           fmt::format(
               "{:<11}read {:.2f}, domain {:.2f}, measure {:.2f}, total {:.2f} on {} "
               "threads\n{:<11}{:.0f} MiB at most\n",
               "seconds", report.seconds.mesh, report.seconds.domain, report.seconds.measure,
               report.seconds.total, report.threads, "memory",
               static_cast<double>(report.peakMemoryBytes) / (1 << 20));
}

}  // namespace vdbpack
