#include "vdbpack/domain/domain_source.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/depth.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/domain/intersection_domain.h"
#include "vdbpack/domain/slice_domain.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/coordinate_step.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/mesh/mesh_sides.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

namespace vdbpack {

namespace {

/// A requested voxel size is used if it is within these factors of the default.
constexpr double kFinest = 0.6, kCoarsest = 1.3;
/// Diagonal below which voxels in 32-bit floats have no digits left, mm.
constexpr double kSmallestExtent = 1e-4;
/// Points by which the volume of a clipped mesh is estimated, to about 1 %, and the steps between
/// them.
constexpr std::size_t kVolumePoints = 20000;
constexpr double kWeyl[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};

/// A clip of space as a clip of the plane z = height.
std::vector<HalfSpace<2>> inPlane(const std::vector<HalfSpace<3>>& planes, double height) {
    std::vector<HalfSpace<2>> lines;
    for (const auto& p : planes) {
        HalfSpace<2> line;
        line.normal = {{p.normal[0], p.normal[1]}};
        line.offset = p.offset - p.normal[2] * height;
        if (squaredLength(line.normal) > 0) {
            lines.push_back(line);
        } else if (line.offset < 0) {
            throw InputError(fmt::format(
                "`clips` leave nothing of the plane z={} mm; choose another height, or clips that "
                "cross it",
                height));
        }
    }
    return lines;
}

/// The wall of a shape, as verify knows it.
WallShape<3> spaceWall(const NamedShape& shape) {
    WallShape<3> wall;
    switch (shape.kind) {
        case NamedShape::Kind::ball:
            return WallShape<3>::ofBall(shape.radius);
        case NamedShape::Kind::cylinder:
            return WallShape<3>::ofCylinder(shape.radius, shape.height);
        case NamedShape::Kind::box:
            wall = WallShape<3>::ofBox(shape.box);
            wall.wraps = shape.wraps;
            return wall;
        case NamedShape::Kind::rect:
        case NamedShape::Kind::disc:
            break;
    }
    throw ParameterError("a shape of the plane has no wall in space");
}

WallShape<2> planeWall(const NamedShape& shape) {
    if (shape.kind == NamedShape::Kind::disc) return WallShape<2>::ofBall(shape.radius);
    WallShape<2> wall = WallShape<2>::ofBox(shape.rect);
    std::copy_n(shape.wraps.begin(), 2, wall.wraps.begin());
    return wall;
}

/// Steps between coordinates larger than this share of an edge are steps in the surface; those of a
/// mesh about the origin (within so many of its lengths) are how it was made.
constexpr double kStepOfEdge = 0.02, kFarOff = 20;

void warnOfLostDigits(const TriangleMesh& mesh, const DomainRecipe& recipe,
                      const Callbacks& callbacks) {
    const Box<3> box = mesh.bounds();
    const double extent = length(box.size()), away = length(box.center());
    if (!(away > kFarOff * extent)) return;
    const double step = coordinateStep(mesh, recipe.scale * millimetersPer(recipe.unit));
    const double edge = medianEdge(mesh);
    if (!(step > kStepOfEdge * edge)) return;
    callbacks.warn(fmt::format(
        "{}: lies {:.3g} mm from the origin, and its coordinates come in steps of {:.2g} mm, with "
        "edges of {:.2g} mm: the file itself has lost digits of the shape; move the mesh to the "
        "origin where it was made, and export it again",
        recipe.source, away, step, edge));
}

/// @throws ParameterError for axes along which no box is to repeat.
void requireShape(const DomainRecipe& recipe) {
    const std::string axes = textOf(recipe.periodic);
    if (axes.empty()) return;
    throw ParameterError(fmt::format(
        "`periodic` {}: {} is no shape; it is for box: and rect:", axes, recipe.source));
}

/// The level set of a .vdb. @throws InputError, which asks for a threshold if there is a fog volume
/// instead.
std::shared_ptr<const VdbGrid> domainLevelSet(const DomainRecipe& recipe, double scale) {
    try {
        return levelSetGrid(recipe.source, recipe.gridName, scale);
    } catch (const InputError&) {
        const auto fog = findFogVolume(recipe.source, recipe.gridName, false);
        if (!fog) throw;
        throw InputError(fmt::format(
            "{}: grid '{}' is no level set but a fog volume, with values from {:g} to {:g}. Set "
            "`threshold` to the value at the surface",
            recipe.source, fog->grid, fog->lowest, fog->highest));
    }
}

}  // namespace

DomainSource::DomainSource(const DomainRecipe& recipe, const Callbacks& callbacks)
    : recipe_(recipe) {
    const std::string& text = recipe.source;
    takeCuts();
    if (!(recipe.scale > 0) || !std::isfinite(recipe.scale))
        throw ParameterError(fmt::format("`scale` {} must be positive", recipe.scale));

    if (isInMemory(recipe)) {
        requireShape(recipe);
        if (recipe.levelSet) {
            levelSet_ = recipe.levelSet;
            mesh_ = levelSetMesh(*levelSet_, text);
        } else {
            mesh_ = recipe.image ? imageMesh(recipe, callbacks, imageGrid_, spaced_)
                                 : readDomainMesh(recipe, callbacks, repair_);
        }
        takeMesh(callbacks);
        return;
    }
    if (const auto shape = parseShape(text, recipe.periodic)) {
        space_ = shape->space;
        plane_ = shape->plane;
        if (plane_)
            wall2_ = planeWall(*shape);
        else
            wall3_ = spaceWall(*shape);
        if (slice_ && plane_)
            throw ParameterError("`slice` cuts a domain of space; '" + text + "' is plane already");
        if (isPeriodic() && (slice_ || !clips_.empty()))
            throw ParameterError(fmt::format("`{}`: {} is periodic; it cannot be cut",
                                             slice_ ? "slice" : "clips", text));
        return;
    }
    requireShape(recipe);
    std::error_code ignored;
    if (namesUnknownShape(text) && !std::filesystem::exists(text, ignored))
        throw ParameterError(fmt::format("'{}' is neither a file nor a shape. The shapes are {}",
                                         text, kShapeForms));
    const double scale = recipe.scale * millimetersPer(recipe.unit);
    if (extensionOf(text) == ".vdb" && recipe.threshold) {
        mesh_ = fogVolumeMesh(text, recipe.gridName, scale, *recipe.threshold);
    } else if (extensionOf(text) == ".vdb") {
        levelSet_ = domainLevelSet(recipe, scale);
        mesh_ = levelSetMesh(*levelSet_, text);
    } else if (namesImage(text)) {
        mesh_ = imageMesh(recipe, callbacks, imageGrid_, spaced_);
    } else {
        mesh_ = readDomainMesh(recipe, callbacks, repair_);
    }
    takeMesh(callbacks);
    if (!levelSet_ && !namesImage(text)) warnOfLostDigits(*mesh_, recipe, callbacks);
}

DomainSource::DomainSource(const DomainRecipe& recipe, TriangleMesh mesh,
                           const Callbacks& callbacks)
    : recipe_(recipe), mesh_(std::move(mesh)) {
    takeCuts();
    takeMesh(callbacks);
}

void DomainSource::takeCuts() {
    for (const Clip& clip : recipe_.clips)
        clips_.insert(clips_.end(), clip.planes.begin(), clip.planes.end());
    slice_ = recipe_.slice;
}

void DomainSource::takeMesh(const Callbacks& callbacks) {
    callbacks.stopIfCancelled();
    fileBounds_ = mesh_->bounds();
    analysis_ = std::make_shared<const MeshAnalysis>(analyzeMesh(*mesh_));
    checkSize(fileBounds_, recipe_, callbacks);
}

void DomainSource::cutBy(const DomainSource& other) {
    for (const DomainSource* one : {static_cast<const DomainSource*>(this), &other})
        if (!one->mesh_ || one->slice_ || (one == &other && !one->clips_.empty()))
            throw ParameterError(one->recipe_.source +
                                 ": overlaps another part; only meshes and images can, without "
                                 "`slice`, and without `clips` of the part that is listed later");
    // The space around the other: a box with a cavity.
    Box<3> box = fileBounds_;
    box.add(other.fileBounds_.lo);
    box.add(other.fileBounds_.hi);
    TriangleMesh around =
        joinedAsCavity(boxMesh(box.grown(0.02 * length(box.size()))), *other.mesh_);
    DomainRecipe recipe;
    recipe.source = other.recipe_.source;
    recipe.voxelSize = other.recipe_.voxelSize;
    outsides_.push_back(
        std::make_shared<const DomainSource>(recipe, std::move(around), Callbacks{}));
}

void checkSize(const Box<3>& bounds, const DomainRecipe& recipe, const Callbacks& callbacks) {
    const double extent = length(bounds.size());
    if (!(extent > kSmallestExtent))
        throw InputError(fmt::format(
            "{}: is {:.3g} mm across, too small to compute with; the file is read in {}: check "
            "`unit` and `scale`",
            recipe.source, extent, unitName(recipe.unit)));
    if (extent < 2 || extent > 5000)
        callbacks.warn(fmt::format(
            "{}: is {:.3g} mm across, which is unlikely for a bone; the file is read in {}: give "
            "`unit` m, cm, mm or um if that is wrong",
            recipe.source, extent, unitName(recipe.unit)));
}

DomainSource::DomainSource(TriangleMesh mesh, const std::string& name, double voxelSize)
    : mesh_(std::move(mesh)), sound_(true) {
    recipe_.source = name;
    recipe_.voxelSize = voxelSize;
    fileBounds_ = mesh_->bounds();
    analysis_ = std::make_shared<const MeshAnalysis>(analyzeMesh(*mesh_));
}

void warnOfUnused(const DomainRecipe& recipe, const DomainSource& source,
                  const Callbacks& callbacks) {
    const std::string& text = recipe.source;
    const bool levelSet = extensionOf(text) == ".vdb" || recipe.levelSet;
    if (!recipe.gridName.empty() && !levelSet)
        callbacks.warn("`gridName` " + recipe.gridName + " has no effect: " + text + " is no .vdb");
    const bool image = source.isFile() && isImage(recipe);
    if (recipe.threshold && !levelSet && !image)
        callbacks.warn(fmt::format("`threshold` {:g} has no effect: {} is no .vdb and no image",
                                   *recipe.threshold, text));
    if (!image && !recipe.label.empty())
        callbacks.warn("`label` " + recipe.label + " has no effect: " + text + " is no image");
    if ((levelSet || image) && (recipe.repair || recipe.cavities.any()))
        callbacks.warn("`repair` and `cavities` have no effect: " + text +
                       (image ? " is an image" : " is a level set"));
    if (recipe.shellFrom == ShellFrom::outer && recipe.clips.empty() && !source.hasCavities())
        callbacks.warn("`shellFrom` outer changes nothing: " + text +
                       " has neither cavities nor clips");
    if (source.isFile()) return;
    if (recipe.repair || recipe.cavities.any())
        callbacks.warn("`repair` and `cavities` have no effect: " + text + " is a shape");
    if (recipe.unit != Unit::millimeter)
        callbacks.warn("`unit` has no effect: " + text + " is a shape, in mm");
    if (recipe.voxelSize > 0)
        callbacks.warn(
            fmt::format("`voxelSize` {:g} has no effect: {} is a shape, whose distances are exact",
                        recipe.voxelSize, text));
    if (recipe.scale != 1) callbacks.warn("`scale` has no effect: " + text + " is a shape, in mm");
}

int DomainSource::dim() const {
    return plane_ || slice_ ? 2 : 3;
}

double DomainSource::fileVolume() const {
    return std::fabs(analysis_->health.enclosedVolume);
}

double DomainSource::volume() const {
    if (plane_ || slice_) return build(0, 0).plane->volume();
    if (space_) return build(0, 0).space->volume();
    return fileVolume();
}

FieldOptions DomainSource::fieldOptions(double minRadius, double maxRadius,
                                        double voxelSize) const {
    FieldOptions options;
    options.voxelSize = recipe_.voxelSize;
    options.detail = minRadius;
    const double chosen = voxelSize > 0 ? defaultVoxelSize(*mesh_, minRadius) : 0;
    if (!(options.voxelSize > 0) && voxelSize > kFinest * chosen && voxelSize < kCoarsest * chosen)
        options.voxelSize = voxelSize;
    // A pivot must know its clearance up to its reach, and so must the interior fraction.
    options.depth = 3 * maxRadius;
    options.name = recipe_.source;
    options.sound = sound_;
    options.analysis = analysis_;
    options.repair = repair_;
    return options;
}

FieldPlan DomainSource::plan(double minRadius, double maxRadius, double voxelSize) const {
    FieldPlan plan;
    if (!mesh_) return plan;
    const FieldOptions options = fieldOptions(minRadius, maxRadius, voxelSize);
    plan.triangles = mesh_->triangles.size();
    plan.vertices = mesh_->vertices.size();
    plan.watertight = !levelSet_ && analysis_->health.isWatertight();
    plan.area = analysis_->health.area;
    plan.volume = fileVolume();
    plan.voxelSize =
        options.voxelSize > 0 ? options.voxelSize : defaultVoxelSize(*mesh_, options.detail);
    plan.depth = options.depth;
    if (recipe_.shellFrom == ShellFrom::outer && hasCavities()) plan.fields = 2;
    return plan;
}

double FieldPlan::voxels() const {
    if (triangles == 0) return 0;
    // Layers of voxels in leaves that the band enters, measured.
    constexpr double kBeyond = 14;
    return fields * (std::min(volume, area * depth) / voxelSize + kBeyond * area) /
           (voxelSize * voxelSize);
}

double DomainSource::clippedVolume() const {
    if (!mesh_) return 0;
    if (clips_.empty()) return fileVolume();
    // Clips along the axes, which most are, narrow the box that is looked at.
    Box<3> box = fileBounds_;
    for (const HalfSpace<3>& h : clips_)
        for (int d = 0; d < 3; ++d) {
            const double along = h.normal[d];
            if (std::fabs(std::fabs(along) - length(h.normal)) > 1e-12) continue;
            if (along > 0)
                box.hi[d] = std::min(box.hi[d], h.offset / along);
            else
                box.lo[d] = std::max(box.lo[d], h.offset / along);
        }
    if (box.empty()) return 0;
    const MeshSides sides(*mesh_, false);
    std::size_t inside = 0;
    for (std::size_t n = 0; n < kVolumePoints; ++n) {
        Vec<3> x;
        // Weyl's sequence: spread evenly, without a lattice to resonate with the bone.
        for (int d = 0; d < 3; ++d) {
            const double part = std::fmod((static_cast<double>(n) + 0.5) * kWeyl[d], 1.0);
            x[d] = box.lo[d] + part * (box.hi[d] - box.lo[d]);
        }
        const bool kept = std::all_of(clips_.begin(), clips_.end(), [&](const HalfSpace<3>& h) {
            return dot(h.normal, x) <= h.offset;
        });
        if (kept && sides.inside(x)) ++inside;
    }
    return box.volume() * static_cast<double>(inside) / static_cast<double>(kVolumePoints);
}

bool DomainSource::hasCavities() const {
    if (!analysis_) return false;
    const auto& shells = analysis_->shells.shells;
    return std::any_of(shells.begin(), shells.end(),
                       [](const Shell& shell) { return shell.depth > 0; });
}

std::shared_ptr<const MeshDomain> DomainSource::meshEnvelope(FieldOptions options,
                                                             const Callbacks& callbacks) const {
    options.analysis = nullptr;
    Callbacks quiet;
    quiet.cancelled = callbacks.cancelled;
    return meshDomain(outermostShells(*mesh_, analysis_->shells), options, quiet);
}

template <int Dim>
std::shared_ptr<const Domain<Dim>> DomainSource::envelopeOf(
    const std::shared_ptr<const Domain<Dim>>& domain) const {
    if (recipe_.shellFrom == ShellFrom::walls) return nullptr;
    return {domain, &domain->envelope()};
}

DomainSource::Built DomainSource::build(double minRadius, double maxRadius,
                                        const Callbacks& callbacks, double voxelSize) const {
    Built built;
    if (plane_) {
        built.plane = clips_.empty()
                          ? plane_
                          : clippedDomain<2>(plane_, inPlane(clips_, 0), envelopeOf(plane_));
        return built;
    }
    const bool fromOuter = recipe_.shellFrom == ShellFrom::outer;
    if (mesh_) {
        FieldOptions options = fieldOptions(minRadius, maxRadius, voxelSize);
        if (fromOuter && hasCavities()) options.envelope = meshEnvelope(options, callbacks);
        built.mesh = levelSet_ ? levelSetDomain(levelSet_, *mesh_, options, callbacks)
                               : meshDomain(*mesh_, options, callbacks);
    }
    built.space = built.mesh ? std::static_pointer_cast<const Domain<3>>(built.mesh) : space_;
    if (slice_) {
        built.sliceHeight = *slice_;
        built.plane = sliceDomain(built.space, *slice_);
        if (!clips_.empty())
            built.plane =
                clippedDomain<2>(built.plane, inPlane(clips_, *slice_), envelopeOf(built.plane));
        built.space = nullptr;
    } else if (!clips_.empty()) {
        built.space = clippedDomain<3>(built.space, clips_, envelopeOf(built.space));
    }
    for (const auto& outside : outsides_)
        built.space = cutDomain(built.space, outside->build(minRadius, maxRadius, callbacks).space,
                                fromOuter);
    return built;
}

ProtrusionCheck DomainSource::protrusion(const std::vector<Sphere<3>>& spheres,
                                         std::vector<double>* distances) const {
    if (wall3_) {
        WallShape<3> wall = *wall3_;
        wall.clips = clips_;
        return checkProtrusion(spheres, wall);
    }
    ProtrusionCheck check = checkProtrusion(spheres, *mesh_, clips_, distances);
    for (const auto& outside : outsides_) {
        std::vector<double> others;
        const ProtrusionCheck beyond = outside->protrusion(spheres, distances ? &others : nullptr);
        if (distances)
            for (std::size_t i = 0; i < others.size(); ++i)
                (*distances)[i] = std::min((*distances)[i], others[i]);
        const std::uint64_t sum = check.spheres + beyond.spheres;
        if (beyond.max > check.max) check = beyond;
        check.spheres = sum;
    }
    return check;
}

ProtrusionCheck DomainSource::protrusion(const std::vector<Sphere<2>>& circles,
                                         std::vector<double>* distances) const {
    if (wall2_ || wall3_) {
        auto wall = wall2_ ? wall2_ : sliceShape(*wall3_, *slice_);
        if (!wall)
            throw InputError(fmt::format("`slice` z={} mm misses {}; choose a height within it",
                                         *slice_, recipe_.source));
        wall->clips = inPlane(clips_, slice_.value_or(0));
        return checkProtrusion(circles, *wall);
    }
    return checkProtrusion(circles, sliceSegments(*mesh_, *slice_), inPlane(clips_, *slice_),
                           distances);
}

std::vector<float> DomainSource::depths(const std::vector<Sphere<3>>& spheres,
                                        const Domain<3>& domain,
                                        const std::vector<double>& distances) const {
    return centerDepths<3>(spheres, domain, distances, clips_);
}

std::vector<float> DomainSource::depths(const std::vector<Sphere<2>>& circles,
                                        const Domain<2>& domain,
                                        const std::vector<double>& distances) const {
    return centerDepths<2>(circles, domain, distances,
                           mesh_ ? inPlane(clips_, *slice_) : std::vector<HalfSpace<2>>{});
}

}  // namespace vdbpack
