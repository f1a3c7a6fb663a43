// The run that measures any pack or solid: `vdb_pack measure`.
#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/measure/bond_order.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/solid_stage.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// What is measured as a pack, or nothing if it is a solid. A grid's name says which of both.
std::optional<Pack<3>> packToMeasure(const MeasureRecipe& recipe, const Callbacks& callbacks) {
    if (recipe.solid || recipe.solidMesh || isImageSolid(recipe)) return std::nullopt;
    if (!recipe.packGrid.empty()) return readInputPack(recipe, callbacks);
    const bool namesLevelSet = extensionOf(recipe.pack) == ".vdb" &&
                               !recipe.domain.gridName.empty() &&
                               extensionOf(recipe.domain.source) != ".vdb";
    if (namesLevelSet) return std::nullopt;
    return readInputPackUnlessSolid(recipe, callbacks);
}

/// The union of the spheres of a pack as a solid, if it is requested.
void measureUnion(const Pack<3>& pack, const Domain<3>* domain, double meanRadius,
                  const MeasureRecipe& recipe, MeasureResult& found, const Callbacks& callbacks) {
    if (!recipe.sphereMorphometry) return;
    if (pack.cell.any())
        throw ParameterError(
            "`sphereMorphometry`: is not available in a periodic cell; leave it out, or measure in "
            "a box");
    found.spheres = sphereMorphometry(pack.spheres, domain, meanRadius, recipe, callbacks);
}
void measureUnion(const Pack<2>&, const Domain<2>*, double, const MeasureRecipe& recipe,
                  MeasureResult&, const Callbacks&) {
    if (recipe.sphereMorphometry)
        throw ParameterError(
            recipe.pack + ": holds circles of a plane; `sphereMorphometry` needs spheres of space");
}

/// What `measure` adds to the figures of a report.
template <int Dim>
void measureFurther(const Pack<Dim>& pack, const Domain<Dim>* domain, const Report& measured,
                    const MeasureRecipe& recipe, MeasureResult& found, const Callbacks& callbacks) {
    if (recipe.shell > 0 && pack.cell.any())
        throw ParameterError("`shell`: is not available in a periodic cell; leave it out");
    found.structure = measureStructure(pack, domain, measured, recipe.shell, callbacks);
    if (measured.count > 0) found.structure.crystalline = solidLikeShare(pack.spheres, pack.cell);
    if (recipe.shell > 0 && found.structure.regions.size() == 1)
        callbacks.warn(fmt::format(
            "`shell` {:g} mm: no part of the domain lies deeper than the shell", recipe.shell));
    measureUnion(pack, domain, measured.radius.mean, recipe, found, callbacks);
}

template <int Dim>
std::vector<std::string> writeMeasured(const Pack<Dim>& pack, const MeasureRecipe& recipe,
                                       const Callbacks& callbacks) {
    RunOutputs<Dim> have;
    have.pack = &pack;
    have.options.bonds = bondOptionsOf(recipe);
    have.options.unit = recipe.outUnit;
    return writeOutputs(recipe.outputs, have, callbacks);
}

}  // namespace

MeasureResult runMeasure(const MeasureRecipe& recipe, const Callbacks& callbacks) {
    if (recipe.dilation && !recipe.sphereMorphometry)
        throw ParameterError("`dilation` applies to the union of spheres; set `sphereMorphometry`");
    if (recipe.dilation && !(*recipe.dilation >= 0 && std::isfinite(*recipe.dilation)))
        throw ParameterError(fmt::format("`dilation` {} mm; give 0 or more", *recipe.dilation));
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
        MeasureResult found;
        found.run = measureInputPack(
            recipe, std::move(*pack), std::move(report),
            [&](const RadiusStatistics& r) { return structureDepth(r, recipe.shell); }, heard,
            [&](const auto& spheres, const auto* domain, const Report& measured) {
                if (measured.protrusion)
                    warnOfOutside(measured.protrusion->centersOutside, measured.count,
                                  describe(recipe.domain), heard);
                measureFurther(spheres, domain, measured, recipe, found, heard);
            },
            recipe.sphereMorphometry);
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

}  // namespace vdbpack
