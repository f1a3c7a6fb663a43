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
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

using Json = nlohmann::ordered_json;

/// With more than this share of a bounding box solid, the solid seems to be cut at its faces.
constexpr double kCutShare = 0.05;

bool isImageSolid(const MeasureRecipe& recipe) {
    return recipe.solidImage || (!recipe.given && namesImage(recipe.pack));
}

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

/// Warns of a total volume that seems to be chosen wrong.
void warnOfBorder(const Morphometry& m, const VoxelImage& image, bool hasDomain,
                  const std::string& file, const Callbacks& callbacks) {
    if (m.solidFraction == 0) return;
    if (hasDomain && m.border.solid == 0)
        callbacks.warn(
            file +
            ": the solid does not reach the wall of the domain, so that the space around "
            "it counts as pores. Set `domain` to the bone itself or to a box inside it");
    if (hasDomain || m.border.solid < kCutShare) return;
    const Vec<3> size{{static_cast<double>(image.size[0] - 2),
                       static_cast<double>(image.size[1] - 2),
                       static_cast<double>(image.size[2] - 2)}};
    const Vec<3> low = image.origin + Vec<3>{{1, 1, 1}} * (0.5 * image.voxelSize);
    const Vec<3> high = low + size * image.voxelSize;
    callbacks.warn(fmt::format(
        "{}: {:.3g} % of the faces of its bounding box are solid, and Conn.D counts it as a whole "
        "body. If it was cut there from a larger sample, set `domain` to "
        "box:{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}",
        file, 100 * m.border.solid, low[0], low[1], low[2], high[0], high[1], high[2]));
}

/// The steps of an image along the axes of the world, for one that lies askew.
void alongAxes(ImageGrid& grid) {
    for (std::size_t d = 0; d < 3; ++d) {
        const double step = length(grid.step[d]);
        const auto axis = static_cast<int>(d);
        if (std::fabs(std::fabs(grid.step[d][axis]) - step) > 1e-6 * step) {
            for (std::size_t e = 0; e < 3; ++e) {
                Vec<3> along;
                along[static_cast<int>(e)] = length(grid.step[e]);
                grid.step[e] = along;
            }
            return;
        }
    }
}

/// The solid of an image, read. @param whole  set to the box of all its voxels, mm, if there is no
/// domain; @param voxel  mm; if 0, set to its least step.
DomainRecipe imageSolid(const MeasureRecipe& recipe, std::optional<Box<3>>& whole, double& voxel,
                        const Callbacks& callbacks) {
    DomainRecipe solid;
    solid.source = recipe.pack;
    solid.unit = recipe.packUnit;
    solid.image = recipe.solidImage;
    if (recipe.domain.source.empty() || !isImage(recipe.domain)) {
        solid.label = recipe.domain.label;
        solid.threshold = recipe.domain.threshold;
        solid.voxelSpacing = recipe.domain.voxelSpacing;
        solid.space = recipe.domain.space;
    }
    Image image = readDomainImage(solid, callbacks);
    if (recipe.domain.source.empty()) {
        alongAxes(image.grid);
        whole = image.grid.bounds();
    }
    const Vec<3> spacing = image.grid.spacing();
    if (!(voxel > 0)) voxel = *std::min_element(spacing.c.begin(), spacing.c.end());
    solid.unit = Unit::millimeter;
    solid.space = ImageSpace::lps;
    solid.image = std::make_shared<const Image>(std::move(image));
    return solid;
}

/// The level set of a mesh or an image. @param voxel  mm; if 0, set to 1/256 of the longest side.
std::shared_ptr<const VdbGrid> gridOfMesh(DomainRecipe solid, const MeasureRecipe& recipe,
                                          double& voxel, const Callbacks& callbacks) {
    solid.voxelSize = voxel;
    std::optional<DomainSource> source(std::in_place, solid, callbacks);
    const Vec<3> size = source->fileBounds().size();
    if (!(voxel > 0)) {
        voxel = *std::max_element(size.c.begin(), size.c.end()) / 256;
        solid.voxelSize = voxel;
        TriangleMesh mesh = *source->mesh();
        source.emplace(solid, std::move(mesh), Callbacks{});
    }
    Extent extent = extentOf(*source, voxel, voxel);
    extent.imageVoxels = (recipe.domain.source.empty() ? 1 : kWalledVoxel) * size[0] * size[1] *
                         size[2] / (voxel * voxel * voxel);
    requireResources(extent, recipe);
    return source->build(voxel, voxel, callbacks).mesh->grid();
}

MeasureResult measureSolid(const MeasureRecipe& recipe, Report report, const Callbacks& callbacks) {
    if (!recipe.outputs.empty())
        throw ParameterError(recipe.outputs.front().text +
                             ": a solid has no contacts to list; measure "
                             "a pack, or leave the output out");
    if (recipe.sphereMorphometry)
        throw ParameterError(recipe.pack +
                             ": is a solid, which is measured as it is; leave out "
                             "`sphereMorphometry`, or measure a pack");
    Clock clock;
    requireDomain(recipe);
    const double voxel = recipe.domain.voxelSize;
    const bool boxed = recipe.domain.source.rfind("box:", 0) == 0 && recipe.domain.clips.empty();
    std::shared_ptr<const VdbGrid> grid;
    double imageVoxel = voxel;
    const bool image = isImageSolid(recipe);
    const bool mesh =
        !recipe.solid && (image || recipe.solidMesh || extensionOf(recipe.pack) != ".vdb");
    std::optional<Box<3>> bounds;
    if (recipe.solid) {
        grid = recipe.solid;
    } else if (mesh) {
        DomainRecipe solid;
        solid.source = recipe.pack;
        solid.unit = recipe.packUnit;
        solid.mesh = recipe.solidMesh;
        if (image) solid = imageSolid(recipe, bounds, imageVoxel, callbacks);
        // An image may end within the solid, and a specimen may be smaller than a bone.
        Callbacks quiet = callbacks;
        if (image) quiet.warning = nullptr;
        grid = gridOfMesh(std::move(solid), recipe, imageVoxel, quiet);
    } else {
        grid = levelSetGrid(recipe.pack, recipe.domain.gridName, millimetersPer(recipe.packUnit));
    }
    report.seconds.mesh = clock.lap();
    std::optional<DomainSource> source;
    DomainSource::Built built;
    if (!recipe.domain.source.empty()) {
        DomainRecipe total = recipe.domain;
        total.voxelSize = 0;
        if (mesh || extensionOf(total.source) != ".vdb") total.gridName.clear();
        source.emplace(total, callbacks);
        if (source->dim() != 3)
            throw ParameterError(total.source + ": is plane; a solid needs a domain of space");
        const double fine = imageVoxel > 0 ? imageVoxel : voxelSizeOf(*grid);
        built = source->build(fine, std::max(recipe.shell * 1.05, fine) / 3, callbacks);
        bounds = built.space->bounds();
        report.domain = built.space->facts();
    }
    report.seconds.domain = clock.lap();
    callbacks.stopIfCancelled();
    const double pitch = imageVoxel > 0 ? imageVoxel : voxelSizeOf(*grid);
    const SolidSampler sample = [&](const Box<3>& box, double margin) {
        return sampleLevelSet(*grid, box, imageVoxel, margin);
    };
    const bool inDomain = built.space && (!boxed || recipe.shell > 0);
    VoxelImage voxels = inDomain
                            ? imageInDomain(*built.space, recipe.shell, pitch, sample)
                            : sampleLevelSet(*grid, bounds, imageVoxel, marginFor(*grid, bounds));
    grid.reset();
    MeasureResult result;
    result.morphometry = measuredImage(voxels, recipe.pack, callbacks);
    warnOfBorder(*result.morphometry, voxels, built.space != nullptr || image, recipe.pack,
                 callbacks);
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
        const auto depthFor = [&](const RadiusStatistics& r) {
            return structureDepth(r, recipe.shell);
        };
        MeasureResult found;
        found.run = measureInputPack(
            recipe, std::move(*pack), std::move(report), depthFor, heard,
            [&](const auto& spheres, const auto* domain, const Report& measured) {
                if (recipe.shell > 0 && spheres.cell.any())
                    throw ParameterError(
                        "`shell`: is not available in a periodic cell; leave it out");
                found.structure = measureStructure(spheres, domain, measured, recipe.shell, heard);
                if (measured.count > 0)
                    found.structure.crystalline = solidLikeShare(spheres.spheres, spheres.cell);
                if (recipe.shell > 0 && found.structure.regions.size() == 1)
                    heard.warn(fmt::format(
                        "`shell` {:g} mm: no part of the domain lies deeper than the shell",
                        recipe.shell));
                if constexpr (std::is_same_v<std::decay_t<decltype(spheres)>, Pack<3>>) {
                    if (recipe.sphereMorphometry && spheres.cell.any())
                        throw ParameterError(
                            "`sphereMorphometry`: is not available in a periodic cell; leave it "
                            "out, or measure in a box");
                    if (recipe.sphereMorphometry)
                        found.spheres = sphereMorphometry(spheres.spheres, domain,
                                                          measured.radius.mean, recipe, heard);
                } else if (recipe.sphereMorphometry) {
                    throw ParameterError(
                        recipe.pack +
                        ": holds circles of a plane; `sphereMorphometry` needs spheres of space");
                }
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
        if (result.spheres) {
            auto solid = toJson(result.spheres->morphometry);
            solid["of"] = "spheres";
            solid["dilation"] = result.spheres->dilation;
            solid["dilationOfMeanRadius"] = result.spheres->dilationOfMeanRadius;
            json["morphometry"] = std::move(solid);
        }
        return json;
    }
    const Report& report = result.run.report;
    return {{"version", report.version},
            {"command", report.command},
            {"threads", report.threads},
            {"domain", {{"kind", report.domain.kind.empty() ? Json() : Json(report.domain.kind)}}},
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
    if (!result.morphometry) {
        std::string text = summary(report) + summary(result.structure);
        if (!result.spheres) return text;
        return text +
               fmt::format(
                   "union of the spheres as a solid, radii increased by {:.4g} mm ({:.3g} of "
                   "the mean):\n",
                   result.spheres->dilation, result.spheres->dilationOfMeanRadius) +
               summary(result.spheres->morphometry);
    }
    return (report.domain.kind.empty()
                ? fmt::format("{:<11}none: TV is the bounding box of the solid, or the image\n",
                              "domain")
                : fmt::format("{:<11}{}\n", "domain", report.domain.kind)) +
           summary(*result.morphometry) +
           fmt::format(
               "{:<11}read {:.2f}, domain {:.2f}, measure {:.2f}, total {:.2f} on {} "
               "threads\n{:<11}{:.0f} MiB at most\n",
               "seconds", report.seconds.mesh, report.seconds.domain, report.seconds.measure,
               report.seconds.total, report.threads, "memory",
               static_cast<double>(report.peakMemoryBytes) / (1 << 20));
}

}  // namespace vdbpack
