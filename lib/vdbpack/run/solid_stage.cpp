#include "vdbpack/run/solid_stage.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/domain/image_voxels.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/label_outputs.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/measure/morphometry/solid_image.h"
#include "vdbpack/measure/morphometry/sphere_image.h"
#include "vdbpack/report/found_value.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/input_pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

/// Dilation of spheres in mean radii, so that contacts become necks of 0.3 radii; voxels in mean
/// radii, narrow enough for the holes between three spheres; those at which connectivity was found
/// a third too low; and the most voxels that are taken by default.
constexpr double kDilation = 0.05, kSphereVoxel = 1.0 / 6, kCoarseVoxel = 0.25, kManyVoxels = 5e7;

/// With more than this share of a bounding box solid, the solid seems to be cut at its faces.
constexpr double kCutShare = 0.05;

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

/// A solid as a level set.
struct SolidGrid {
    std::shared_ptr<const VdbGrid> grid{};
    double voxel = 0;  ///< to measure in, mm; 0: those of the level set
    /// Of a mesh: volume, mm³, and bounds. Of all of an image: those of its voxels, and around it.
    std::optional<double> volume{};
    Box<3> bounds{};
    /// Of all of an image in cubes, measured in its own voxels: which of them are solid.
    std::vector<std::uint8_t> solid{};
    ImageGrid image{};
    bool isWholeImage = false;
    FoundValues found{};

    double pitch() const { return voxel > 0 ? voxel : voxelSizeOf(*grid); }
};

/// Voxels beyond the border of an image, so that no surface closes the solid there.
constexpr std::size_t kRim = 5;
/// Steps of an image alike to this share are those of cubes.
constexpr double kCube = 1e-3;

/// The image is all of the total volume: counts its voxels, and continues it beyond its border.
void takeWhole(const DomainRecipe& solid, Image& image, bool ownVoxels, SolidGrid& found) {
    image.grid = alongAxes(image.grid);
    found.image = image.grid;
    found.isWholeImage = true;
    found.bounds = image.grid.bounds();
    found.solid = solidVoxels(solid, image);
    const auto count = std::count(found.solid.begin(), found.solid.end(), std::uint8_t{1});
    found.volume = static_cast<double>(count) * std::fabs(image.grid.signedVoxelVolume());
    const Vec<3> spacing = image.grid.spacing();
    const auto [least, most] = std::minmax_element(spacing.c.begin(), spacing.c.end());
    if (!ownVoxels || *most > (1 + kCube) * *least) found.solid.clear();
    image = withRim(image, kRim);
}

/// The file of the solid. Without a domain, unit, scale and repair are its own.
DomainRecipe fileOf(const MeasureRecipe& recipe) {
    const DomainRecipe& domain = recipe.domain;
    DomainRecipe solid;
    solid.source = recipe.pack;
    solid.mesh = recipe.solidMesh;
    solid.image = recipe.solidImage;
    solid.unit = recipe.packUnit;
    if (!domain.source.empty()) return solid;
    if (domain.unit != Unit::millimeter) {
        if (recipe.packUnit != Unit::millimeter)
            throw ParameterError("`unit` and `packUnit`: both are the unit of " + recipe.pack +
                                 "; give one of them");
        solid.unit = domain.unit;
    }
    solid.scale = domain.scale;
    solid.repair = domain.repair;
    solid.repairVoxel = domain.repairVoxel;
    solid.repairComponents = domain.repairComponents;
    solid.cavities = domain.cavities;
    return solid;
}

/// The solid of an image, read. Without a domain, all of the image is the total volume. Voxels that
/// are not requested get the least step of the image.
DomainRecipe imageSolid(const MeasureRecipe& recipe, SolidGrid& found, const Callbacks& callbacks) {
    DomainRecipe solid = fileOf(recipe);
    if (recipe.domain.source.empty() || !isImage(recipe.domain)) {
        solid.label = recipe.domain.label;
        solid.threshold = recipe.domain.threshold;
        solid.voxelSpacing = recipe.domain.voxelSpacing;
        solid.space = recipe.domain.space;
    }
    Image image = readDomainImage(solid, callbacks);
    if (image.isSpaced) warnOfSpacing(solid, true, callbacks);
    if (solid.threshold) solid.threshold = solid.threshold->of(image, solid.source, callbacks);
    addThreshold(found.found, solid);
    const bool ownVoxels = !(found.voxel > 0);
    if (recipe.domain.source.empty()) takeWhole(solid, image, ownVoxels, found);
    const Vec<3> spacing = image.grid.spacing();
    if (ownVoxels) found.voxel = *std::min_element(spacing.c.begin(), spacing.c.end());
    solid.unit = Unit::millimeter;
    solid.scale = 1;
    solid.space = ImageSpace::lps;
    solid.image = std::make_shared<const Image>(std::move(image));
    return solid;
}

/// Whether the solid is no level set.
bool isMeshed(const MeasureRecipe& recipe) {
    return !recipe.solid &&
           (isImageSolid(recipe) || recipe.solidMesh || extensionOf(recipe.pack) != ".vdb");
}

/// Warns of settings of images where neither the solid nor the domain is one.
void warnOfNoImage(const MeasureRecipe& recipe, const Callbacks& callbacks) {
    DomainRecipe solid = recipe.domain;
    if (isImageSolid(recipe) || (!solid.source.empty() && isImage(solid))) return;
    solid.source = recipe.pack;
    warnOfSpacing(solid, false, callbacks);
    if (!solid.label.empty())
        callbacks.warn("`label` " + solid.label + " has no effect: " + solid.source +
                       " is no image");
    if (solid.threshold)
        callbacks.warn(fmt::format("`threshold` {} has no effect: {} is no image",
                                   solid.threshold->text(), solid.source));
}

SolidGrid readSolid(const MeasureRecipe& recipe, const Callbacks& callbacks) {
    SolidGrid found{recipe.solid, recipe.domain.voxelSize};
    warnOfNoImage(recipe, callbacks);
    if (found.grid) return found;
    DomainRecipe solid = fileOf(recipe);
    if (!isMeshed(recipe)) {
        found.grid = levelSetGrid(recipe.pack, recipe.domain.gridName, solid.scale, solid.unit);
        return found;
    }
    // An image may end within the solid, and a specimen may be smaller than a bone.
    Callbacks quiet = callbacks;
    if (isImageSolid(recipe)) {
        solid = imageSolid(recipe, found, callbacks);
        quiet.warning = nullptr;
    }
    const double images = recipe.domain.source.empty() ? 1 : kWalledVoxel;
    TriangleMesh mesh = *DomainSource(solid, quiet).mesh();
    // Where voxels count, none of them is lost, however thin the walls of their surface are.
    const auto field = fieldOfMesh(std::move(mesh), std::move(solid), images, recipe, found.voxel,
                                   quiet, !found.solid.empty());
    found.grid = field->grid();
    if (!found.isWholeImage) {
        found.volume = field->volume();
        found.bounds = field->bounds();
    }
    return found;
}

/// The domain whose volume is the total one; null: none is given.
std::shared_ptr<const Domain<3>> totalVolume(const MeasureRecipe& recipe, const SolidGrid& solid,
                                             const Callbacks& callbacks) {
    if (recipe.domain.source.empty()) return nullptr;
    DomainRecipe total = recipe.domain;
    total.voxelSize = 0;
    if (isMeshed(recipe) || extensionOf(total.source) != ".vdb") total.gridName.clear();
    const DomainSource source(total, callbacks);
    if (isImage(total)) warnOfUnusedSpacing({}, {&source}, callbacks);
    if (source.dim() != 3)
        throw ParameterError(total.source + ": is plane; a solid needs a 3D domain");
    const double fine = solid.pitch();
    return source.build(fine, std::max(recipe.shell * 1.05, fine) / 3, callbacks).space;
}

bool isBox(const DomainRecipe& domain) {
    return domain.source.rfind("box:", 0) == 0 && domain.clips.empty();
}

/// The solid in its total volume, and its surroundings where it continues there.
VoxelImage voxelsOf(const MeasureRecipe& recipe, const SolidGrid& solid, const Domain<3>* total) {
    const VdbGrid& grid = *solid.grid;
    if (!total || (isBox(recipe.domain) && !(recipe.shell > 0))) {
        if (solid.isWholeImage) {
            VoxelImage voxels = sampleLevelSet(grid, solid.bounds, solid.voxel);
            if (!solid.solid.empty()) takeVoxels(solid.solid, solid.image, voxels);
            return voxels;
        }
        const auto bounds = total ? std::optional<Box<3>>(total->bounds()) : std::nullopt;
        return sampleLevelSet(grid, bounds, solid.voxel, marginFor(grid, bounds));
    }
    const SolidSampler sample = [&](const Box<3>& box, double margin) {
        return sampleLevelSet(grid, box, solid.voxel, margin);
    };
    return imageInDomain(*total, recipe.shell, solid.pitch(), sample);
}

/// Takes the volumes that are known, of the total volume and of a solid all of which lies in it;
/// voxels count the rest. Regions keep theirs, so that they add up.
void takeVolumes(const MeasureRecipe& recipe, const SolidGrid& solid, const Domain<3>* total,
                 Morphometry& m) {
    if (!m.regions.empty() || !(total || solid.volume)) return;
    const double volume = total ? total->volume() : solid.bounds.volume();
    const bool within = solid.volume && (!total || (isBox(recipe.domain) &&
                                                    total->bounds().contains(solid.bounds.lo) &&
                                                    total->bounds().contains(solid.bounds.hi)));
    setVolumes(m, volume, within ? *solid.volume : m.solidFraction * volume);
}

}  // namespace

std::shared_ptr<const MeshDomain> fieldOfMesh(TriangleMesh mesh, DomainRecipe solid, double images,
                                              const RunSettings& settings, double& voxel,
                                              const Callbacks& callbacks, bool sound) {
    constexpr double kVoxelsAcross = 256;
    const Vec<3> size = mesh.bounds().size();
    if (!(voxel > 0)) voxel = *std::max_element(size.c.begin(), size.c.end()) / kVoxelsAcross;
    solid.voxelSize = voxel;
    const DomainSource source(solid, std::move(mesh), Callbacks{});
    Extent extent = extentOf(source, voxel, voxel);
    extent.imageVoxels = images * size[0] * size[1] * size[2] / (voxel * voxel * voxel);
    requireResources(extent, settings);
    return source.field(voxel, sound, callbacks);
}

bool isImageSolid(const MeasureRecipe& recipe) {
    return recipe.solidImage || (!recipe.given && namesImage(recipe.pack));
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
    requireDomain(recipe, true);
    SolidGrid solid = readSolid(recipe, callbacks);
    report.seconds.mesh = clock.lap();
    const auto total = totalVolume(recipe, solid, callbacks);
    report.found = solid.found;
    if (total) report.domain = total->facts();
    report.seconds.domain = clock.lap();
    callbacks.stopIfCancelled();
    const VoxelImage voxels = voxelsOf(recipe, solid, total.get());
    solid.grid.reset();
    MeasureResult result;
    result.morphometry = measuredImage(voxels, recipe.pack, callbacks);
    result.morphometry->ofVoxels = !solid.solid.empty();
    result.ofImage = solid.isWholeImage && !total;
    takeVolumes(recipe, solid, total.get(), *result.morphometry);
    warnOfBorder(*result.morphometry, voxels, total || isImageSolid(recipe), recipe.pack,
                 callbacks);
    report.seconds.measure = clock.lap();
    report.seconds.total = clock.total();
    report.peakMemoryBytes = peakMemory();
    result.run.report = std::move(report);
    result.run.passed = true;
    return result;
}

SolidMeasures measureSolidIn(const std::vector<std::shared_ptr<const VdbGrid>>& levelSets,
                             const DomainRecipe& domain, double shell, const RunSettings& settings,
                             const Callbacks& callbacks) {
    MeasureRecipe recipe;
    for (const auto& set : levelSets)
        if (set && levelSetName(*set) == kSolid) recipe.solid = set;
    if (!recipe.solid)
        throw ParameterError(
            "`measureSolid`: there is no solid of space to measure; leave it out in a plane");
    recipe.pack = domain.source;
    recipe.domain = domain;
    recipe.shell = shell;
    recipe.memoryLimit = settings.memoryLimit;
    const Morphometry all = *measureSolid(recipe, {}, callbacks).morphometry;
    if (all.regions.empty()) return all;
    return all.regions.back();
}

SphereMorphometry sphereMorphometry(const std::vector<Sphere<3>>& spheres, const Domain<3>* domain,
                                    double meanRadius, const MeasureRecipe& recipe,
                                    const Callbacks& callbacks) {
    SphereMorphometry result;
    result.dilation = recipe.dilation.value_or(kDilation * meanRadius);
    result.dilationOfMeanRadius = result.dilation / meanRadius;
    Box<3> around;
    for (const Sphere<3>& s : spheres) {
        const Vec<3> reach = Vec<3>{{1, 1, 1}} * (s.radius + result.dilation);
        around.add(s.center - reach);
        around.add(s.center + reach);
    }
    const double volume = (domain ? domain->bounds() : around).volume();
    double voxel = recipe.domain.voxelSize;
    if (!(voxel > 0)) {
        voxel = std::max(kSphereVoxel * meanRadius, std::cbrt(volume / kManyVoxels));
        if (voxel > kCoarseVoxel * meanRadius)
            callbacks.warn(fmt::format(
                "{}: the spheres are measured as a solid in voxels of {:.3g} mm, {:.2g} of the "
                "mean "
                "radius, so that narrow pores and necks are lost. Set `voxelSize` to {:.3g}, or "
                "measure a part of the domain with `clips`",
                recipe.pack, voxel, voxel / meanRadius, kSphereVoxel * meanRadius));
    }
    Extent extent;
    extent.count = static_cast<double>(spheres.size());
    extent.imageVoxels = (domain ? kWalledVoxel : 1) * volume / (voxel * voxel * voxel);
    requireResources(extent, recipe);
    const SolidSampler sample = [&](const Box<3>& bounds, double margin) {
        callbacks.stopIfCancelled();
        return sphereImage(spheres, result.dilation, bounds, voxel, margin);
    };
    result.morphometry = measuredImage(domain ? imageInDomain(*domain, recipe.shell, voxel, sample)
                                              : sample(around, kWallMargin * voxel),
                                       recipe.pack, callbacks);
    return result;
}

}  // namespace vdbpack
