#include "vdbpack/domain/domain_source.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/depth.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/domain/intersection_domain.h"
#include "vdbpack/domain/pose.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/mesh/mesh_shells.h"

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

/// @throws ParameterError for axes along which no box is to repeat.
void requireShape(const DomainRecipe& recipe) {
    const std::string axes = textOf(recipe.periodic);
    if (axes.empty()) return;
    throw ParameterError(fmt::format(
        "`periodic` {}: {} is no shape; it is for box: and rect:", axes, recipe.source));
}

/// The level set of a .vdb. @throws InputError, which asks for a threshold if there is a fog volume
/// instead.
std::shared_ptr<const VdbGrid> domainLevelSet(const DomainRecipe& recipe) {
    try {
        return levelSetGrid(recipe.source, recipe.gridName, recipe.scale, recipe.unit);
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
    takeCuts();
    if (!(recipe.scale > 0) || !std::isfinite(recipe.scale))
        throw ParameterError(fmt::format("`scale` {} must be positive", recipe.scale));
    if (!isInMemory(recipe)) {
        const std::string& text = recipe.source;
        if (const auto shape = parseShape(text, recipe.periodic)) {
            takeShape(*shape);
            return;
        }
        std::error_code ignored;
        if (namesUnknownShape(text) && !std::filesystem::exists(text, ignored))
            throw ParameterError(fmt::format(
                "'{}' is neither a file nor a shape. The shapes are {}", text, kShapeForms));
    }
    requireShape(recipe);
    takeSurface(callbacks);
}

void DomainSource::takeShape(const NamedShape& shape) {
    space_ = shape.space;
    plane_ = shape.plane;
    if (plane_)
        wall2_ = planeWall(shape);
    else
        wall3_ = spaceWall(shape);
    const std::string& text = recipe_.source;
    if (recipe_.slice && plane_)
        throw ParameterError("`slice` cuts a 3D domain; '" + text + "' is plane already");
    if (recipe_.pose.any())
        throw ParameterError(text +
                             ": is a shape about the origin, and only files can be moved by "
                             "`transform`, `matrix`, `rotate` and `translate`; write it to one: "
                             "vdb_pack convert " +
                             text + " -o shape.stl");
    if (isPeriodic() && (recipe_.slice || !clips_.empty()))
        throw ParameterError(fmt::format("`{}`: {} is periodic; it cannot be cut",
                                         recipe_.slice ? "slice" : "clips", text));
}

void DomainSource::takeSurface(const Callbacks& callbacks) {
    const bool isFile = !isInMemory(recipe_);
    const bool isVdb = isFile && extensionOf(recipe_.source) == ".vdb";
    TriangleMesh mesh;
    if (isVdb && recipe_.threshold) {
        if (!recipe_.threshold->value)
            throw ParameterError(
                fmt::format("`threshold` {}: is found for images, and {} is none; give a number",
                            recipe_.threshold->text(), recipe_.source));
        mesh = fogVolumeMesh(recipe_.source, recipe_.gridName, recipe_.scale,
                             *recipe_.threshold->value, recipe_.unit);
        place(mesh, recipe_, callbacks);
    } else if (isVdb || recipe_.levelSet) {
        levelSet_ = isVdb ? domainLevelSet(recipe_) : recipe_.levelSet;
        mesh = levelSetMesh(*levelSet_, recipe_.source);
        place(mesh, recipe_, callbacks);
        // What is moved is the contour alone.
        if (recipe_.pose.any()) levelSet_ = nullptr;
    } else {
        mesh = isImage(recipe_) ? imageMesh(recipe_, callbacks, imageGrid_, spaced_, sided_)
                                : readDomainMesh(recipe_, callbacks, repair_);
    }
    if (isFile && !levelSet_ && !isImage(recipe_)) warnOfLostDigits(mesh, recipe_, callbacks);
    mesh_ = std::make_shared<const TriangleMesh>(std::move(mesh));
    takeMesh(callbacks);
}

DomainSource::DomainSource(const DomainRecipe& recipe, TriangleMesh mesh,
                           const Callbacks& callbacks)
    : recipe_(recipe), mesh_(std::make_shared<const TriangleMesh>(std::move(mesh))) {
    takeCuts();
    takeMesh(callbacks);
}

void DomainSource::takeCuts() {
    for (const Clip& clip : recipe_.clips)
        clips_.insert(clips_.end(), clip.planes.begin(), clip.planes.end());
}

void DomainSource::takeMesh(const Callbacks& callbacks) {
    callbacks.stopIfCancelled();
    fileBounds_ = mesh_->bounds();
    analysis_ = std::make_shared<const MeshAnalysis>(analyzeMesh(*mesh_, isImage(recipe_)));
    checkSize(fileBounds_, recipe_, callbacks);
}

void DomainSource::cutBy(const DomainSource& other) {
    for (const DomainSource* one : {static_cast<const DomainSource*>(this), &other})
        if (!one->mesh_ || one->recipe_.slice || (one == &other && !one->clips_.empty()))
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

DomainSource::DomainSource(TriangleMesh mesh, const std::string& name, double voxelSize)
    : mesh_(std::make_shared<const TriangleMesh>(std::move(mesh))), sound_(true) {
    recipe_.source = name;
    recipe_.voxelSize = voxelSize;
    fileBounds_ = mesh_->bounds();
    analysis_ = std::make_shared<const MeshAnalysis>(analyzeMesh(*mesh_, true));
}

int DomainSource::dim() const {
    return plane_ || recipe_.slice ? 2 : 3;
}

double DomainSource::fileVolume() const {
    return std::fabs(analysis_->health.enclosedVolume);
}

double DomainSource::volume() const {
    if (plane_ || recipe_.slice) return build(0, 0).plane->volume();
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

bool DomainSource::isWatertight() const {
    return analysis_ && analysis_->health.hasParity();
}

FieldPlan DomainSource::plan(double minRadius, double maxRadius, double voxelSize) const {
    FieldPlan plan;
    if (!mesh_) return plan;
    const FieldOptions options = fieldOptions(minRadius, maxRadius, voxelSize);
    plan.triangles = mesh_->triangles.size();
    plan.vertices = mesh_->vertices.size();
    plan.watertight = !levelSet_ && analysis_->health.hasParity();
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

std::shared_ptr<const MeshDomain> DomainSource::field(double voxelSize, bool sound,
                                                      const Callbacks& callbacks) const {
    FieldOptions options = fieldOptions(voxelSize, voxelSize, 0);
    options.fieldFirst = true;
    options.sound |= sound;
    return meshDomain(mesh_, options, callbacks);
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
        built.mesh = levelSet_ ? levelSetDomain(levelSet_, mesh_, options, callbacks)
                               : meshDomain(mesh_, options, callbacks);
    }
    built.space = built.mesh ? std::static_pointer_cast<const Domain<3>>(built.mesh) : space_;
    if (recipe_.slice) {
        built.sliceHeight = *recipe_.slice;
        built.plane = sliceDomain(built.space, *recipe_.slice);
        if (!clips_.empty())
            built.plane = clippedDomain<2>(built.plane, inPlane(clips_, *recipe_.slice),
                                           envelopeOf(built.plane));
        built.space = nullptr;
    } else if (!clips_.empty()) {
        built.space = clippedDomain<3>(built.space, clips_, envelopeOf(built.space));
    }
    Callbacks quiet = callbacks;
    quiet.warning = nullptr;  // the part that has the space warns of its mesh
    for (const auto& outside : outsides_)
        built.space =
            cutDomain(built.space, outside->build(minRadius, maxRadius, quiet).space, fromOuter);
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
        auto wall = wall2_ ? wall2_ : sliceShape(*wall3_, *recipe_.slice);
        if (!wall)
            throw InputError(fmt::format("`slice` z={} mm misses {}; choose a height within it",
                                         *recipe_.slice, recipe_.source));
        wall->clips = inPlane(clips_, recipe_.slice.value_or(0));
        return checkProtrusion(circles, *wall);
    }
    return checkProtrusion(circles, sliceSegments(*mesh_, *recipe_.slice),
                           inPlane(clips_, *recipe_.slice), distances);
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
                           mesh_ ? inPlane(clips_, *recipe_.slice) : std::vector<HalfSpace<2>>{});
}

}  // namespace vdbpack
