#include "vdbpack/domain/mesh_domain.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/facet_bins.h"
#include "vdbpack/domain/mesh_slice.h"
#include "vdbpack/domain/shape.h"
#include "vdbpack/field/vdb_field.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/mesh_sides.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

constexpr double kVolumeTolerance = 0.01;
// Half the thickness of a wall, in voxels, below which its volume cannot come out so well.
constexpr double kThinnestInVoxels = 0.05;
constexpr double kMostDefaultVoxels = 4e7;
// Active voxels beyond this (some 40 GB) are a slip of the units rather than a wish.
constexpr double kMostVoxels = 5e9;
// Layers of voxels in a common band: six radii inside, three outside.
constexpr double kCommonLayers = 9;

void checkMeshIsUsable(const TriangleMesh& mesh, const std::string& name) {
    if (mesh.triangles.empty())
        throw InputError(
            fmt::format("{}: the mesh has no triangles; give a closed triangle mesh", name));
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        if (!isFinite(mesh.vertices[i]))
            throw InputError(fmt::format("{}: vertex {} is not finite; repair the file", name, i));
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        for (const std::uint32_t corner : mesh.triangles[i])
            if (corner >= mesh.vertices.size())
                throw InputError(
                    fmt::format("{}: triangle {} names vertex {} of {}; repair the file", name, i,
                                corner, mesh.vertices.size()));
}

/// Active voxels of a field, about.
double voxelsOf(double area, double voxelSize, double depth) {
    return area * (depth + 5 * voxelSize) / (voxelSize * voxelSize * voxelSize);
}

/// Refuses voxels that are a slip of the units.
void requireVoxels(const std::string& name, const TriangleMesh& mesh, double area, double voxelSize,
                   double depth) {
    const Vec<3> size = mesh.bounds().size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    if (!(voxelSize <= longest))
        throw ParameterError(fmt::format(
            "{}: voxels of {:.4g} mm are larger than all of it, which is {:.4g} mm across; give "
            "smaller ones, or check the unit of the mesh",
            name, voxelSize, longest));
    const double voxels = voxelsOf(area, voxelSize, depth);
    if (!(voxels < kMostVoxels) || !(longest / voxelSize < 1e6))
        throw ResourceError(fmt::format(
            "{}: voxels of {:.4g} mm would take about {:.2g} of them for a surface of {:.4g} mm² "
            "and {:.4g} mm across; give larger voxels, or check the unit of the mesh",
            name, voxelSize, voxels, area, longest));
}

/// Area and volume, about a vertex so that digits survive far from zero.
std::pair<double, double> areaAndVolume(const TriangleMesh& mesh) {
    double area = 0;
    double volume = 0;
    if (mesh.vertices.empty()) return {area, volume};
    const Vec<3> origin = mesh.vertices.front();
    for (const auto& t : mesh.triangles) {
        const Vec<3> a = mesh.vertices[t[0]] - origin;
        const Vec<3> b = mesh.vertices[t[1]] - origin;
        const Vec<3> c = mesh.vertices[t[2]] - origin;
        area += 0.5 * length(cross(b - a, c - a));
        volume += dot(a, cross(b, c)) / 6;
    }
    return {area, std::abs(volume)};
}

class MeshDomainSampler : public DomainSampler<3> {
public:
    /// @param contour  the triangles are the field's own contour: none passes between voxels alike.
    MeshDomainSampler(const VdbField& field, const FacetBins<3>& bins, const MeshSides& sides,
                      bool contour)
        : field_(field),
          bins_(bins),
          sides_(sides),
          contour_(contour),
          depth_(field.depth()),
          slack_(0.3 * field.voxelSize()) {}

    double signedDistance(const Vec<3>& x) override {
        if (x != last_) {
            last_ = x;
            distance_ = std::max(-depth_, field_(x));
        }
        return distance_;
    }

    bool contains(const Vec<3>& x) override {
        const int side = contour_ ? field_.sideAround(x) : 0;
        return side != 0 ? side < 0 : sides_.inside(x);
    }

    // A search that knows about how far to look meets fewer triangles; if the field was too wrong
    // for that, it is repeated with the full reach.
    bool nearestWall(const Vec<3>& x, double reach, WallPoint<3>& wall) override {
        const double guess = std::abs(signedDistance(x)) + slack_;
        if (guess < reach && bins_.nearest(x, guess, wall)) return true;
        return bins_.nearest(x, reach, wall);
    }

    void wallsWithin(const Vec<3>& x, double reach, std::vector<WallPoint<3>>& points) override {
        bins_.within(x, reach, points);
    }

    bool isWallCloser(const Vec<3>& x, double reach) override { return bins_.anyCloser(x, reach); }

private:
    VdbField::Sampler field_;
    const FacetBins<3>& bins_;
    const MeshSides& sides_;
    bool contour_;
    double depth_;
    double slack_;
    Vec<3> last_{{std::numeric_limits<double>::quiet_NaN(), 0, 0}};
    double distance_ = 0;
};

struct Parts {
    TriangleMesh mesh;
    std::unique_ptr<const VdbField> field;
    std::vector<std::int8_t> facing;
    std::vector<std::uint8_t> depthOfTriangle;  // empty: no shell lies in another
    std::string name;
    bool contour = false;  // the mesh is the contour of the field
    double volume = 0;
    double area = 0;
    DomainFacts facts;
};

std::vector<Facet<3>> facetsOf(const TriangleMesh& mesh) {
    std::vector<Facet<3>> facets;
    facets.reserve(mesh.triangles.size());
    for (const auto& t : mesh.triangles)
        facets.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
    return facets;
}

class FieldDomain : public MeshDomain,
                    public Sliceable,
                    public std::enable_shared_from_this<FieldDomain> {
public:
    explicit FieldDomain(Parts parts)
        : parts_(std::move(parts)),
          bins_(facetsOf(parts_.mesh)),
          sides_(parts_.mesh,
                 parts_.facts.boundaryEdges == 0 && parts_.facts.nonManifoldEdges == 0),
          bounds_(parts_.mesh.bounds()) {}

    Box<3> bounds() const override { return bounds_; }
    double volume() const override { return parts_.volume; }
    double wallArea() const override { return parts_.area; }
    double volumeDeeperThan(double depth) const override {
        return depth > 0 ? parts_.field->volumeDeeperThan(depth) : parts_.volume;
    }
    double fieldDepth() const override { return parts_.field->depth(); }
    std::unique_ptr<DomainSampler<3>> sampler() const override {
        return std::make_unique<MeshDomainSampler>(*parts_.field, bins_, sides_, parts_.contour);
    }
    DomainFacts facts() const override { return parts_.facts; }
    std::shared_ptr<const VdbGrid> grid() const override { return parts_.field->surface(); }
    std::shared_ptr<const VdbGrid> gridOf(double voxelSize) const override {
        if (std::abs(voxelSize - parts_.field->voxelSize()) < 1e-9 * voxelSize) return grid();
        requireVoxels(parts_.name, parts_.mesh, parts_.area, voxelSize, 0);
        return VdbField(parts_.mesh, parts_.depthOfTriangle, voxelSize, 0).surface();
    }
    const TriangleMesh& wall() const override { return parts_.mesh; }
    std::shared_ptr<const Domain<2>> slice(double height) const override {
        return meshSlice(shared_from_this(), parts_.facing, height);
    }

private:
    Parts parts_;
    FacetBins<3> bins_;
    MeshSides sides_;
    Box<3> bounds_;
};

double relativeDifference(double value, double reference) {
    return std::abs(value - reference) / std::abs(reference);
}

/// Whether every edge has two triangles that face alike, so that the mesh has a volume.
bool isClean(const MeshHealth& health) {
    return health.isWatertight() && health.inconsistentEdges == 0;
}

struct Verdict {
    bool sound = false;
    double fieldVolume = 0;
};

/// Compares the field with the mesh, as the docstring of `meshDomain` says.
Verdict judge(const VdbField& field, const MeshHealth& health) {
    Verdict verdict;
    verdict.fieldVolume = field.volumeDeeperThan(0);
    if (!(verdict.fieldVolume > 0)) return verdict;
    const double difference = relativeDifference(verdict.fieldVolume, health.enclosedVolume);
    verdict.sound = difference <= kVolumeTolerance;
    return verdict;
}

std::string flawsOf(const MeshHealth& health) {
    std::string text;
    const auto add = [&](std::size_t count, const char* what) {
        if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
    };
    if (!health.isClosed()) text = health.describeLeak();
    add(health.nonManifoldEdges, "edges of more than two triangles");
    add(health.inconsistentEdges, "edges between triangles that face opposite ways");
    add(health.duplicateTriangles, "duplicate triangles");
    return text;
}

[[noreturn]] void refuse(const std::string& name, const MeshHealth& health, double fieldVolume,
                         double voxelSize) {
    const std::string volumes =
        fmt::format("the field of {:.4g} mm voxels encloses {:.6g} mm³, the mesh {:.6g} mm³",
                    voxelSize, fieldVolume, health.enclosedVolume);
    if (!health.isClosed())
        throw InputError(
            fmt::format("{}: the mesh is not closed: {}; {}; close the holes or pass --repair",
                        name, health.describeLeak(), volumes));
    throw InputError(fmt::format(
        "{}: inside and outside cannot be told apart: {}{}{}; the likely cause is {}; separate or "
        "join the pieces, or pass --repair",
        name, volumes, isClean(health) ? "" : "; ", isClean(health) ? "" : flawsOf(health),
        health.shells > 1 ? "pieces that overlap" : "a surface that cuts through itself"));
}

/// Refuses a closed mesh that is far thinner than the voxels of its field, before that is made.
void requireThickness(const std::string& name, const MeshHealth& health, double voxelSize) {
    const double half = health.enclosedVolume / health.area;  // of a plate's thickness
    if (!(half > 0) || half > kThinnestInVoxels * voxelSize) return;
    throw InputError(fmt::format(
        "{}: the mesh is about {:.2g} mm thick (twice its volume by its area), too thin "
        "for a field of {:.4g} mm voxels; check the mesh and its unit, or give --voxel "
        "{:.2g}",
        name, 2 * half, voxelSize, half));
}

/// Whether a level set in voxels of `voxelSize` can be the field, where `wanted` is the size of
/// those that would be made.
bool isAbout(double voxelSize, double wanted) {
    return voxelSize > 0.4 * wanted && voxelSize < 1.5 * wanted;
}

/// @param levelSet  that the mesh is the contour of; null: none.
Parts makeParts(TriangleMesh mesh, const VdbGrid* levelSet, const FieldOptions& options,
                const std::string& kind, const Callbacks& callbacks) {
    const std::string& name = options.name;
    for (const double value : {options.voxelSize, options.depth, options.detail})
        if (!(value >= 0) || !std::isfinite(value))
            throw ParameterError(fmt::format(
                "{}: voxel size {}, depth {} and detail {} must be lengths in mm, 0 or more", name,
                options.voxelSize, options.depth, options.detail));
    checkMeshIsUsable(mesh, name);

    Parts parts;
    const MeshHealth health = checkMesh(mesh);
    const ShellAnalysis shells = analyzeShells(mesh);
    if (!(health.area > 0))
        throw InputError(fmt::format("{}: no triangle has an area; repair the mesh", name));
    std::vector<std::uint8_t> depthOfTriangle(mesh.triangles.size());
    parts.facing.resize(mesh.triangles.size());
    bool nested = false;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Shell& shell = shells.shells[shells.shellOfTriangle[i]];
        depthOfTriangle[i] = static_cast<std::uint8_t>(std::min(shell.depth, 255));
        nested = nested || shell.depth > 0;
        parts.facing[i] = (shell.signedVolume > 0) == (shell.depth % 2 == 0) ? 1 : -1;
    }
    if (!nested) depthOfTriangle.clear();

    double voxelSize =
        options.voxelSize > 0 ? options.voxelSize : defaultVoxelSize(mesh, options.detail);
    requireVoxels(name, mesh, health.area, voxelSize, options.depth);

    const bool fits = levelSet != nullptr && health.isWatertight() && liesAlongAxes(*levelSet);
    if (!fits && isClean(health)) requireThickness(name, health, voxelSize);
    callbacks.report("domain", 0, 0);
    callbacks.stopIfCancelled();
    const auto takeLevelSet = [&] {
        parts.contour = true;
        voxelSize = voxelSizeOf(*levelSet);
        parts.field = std::make_unique<VdbField>(*levelSet, options.depth);
        // Its signs are those of its contour, however thin its walls are.
        return Verdict{true, health.enclosedVolume};
    };
    Verdict verdict;
    if (fits && isAbout(voxelSizeOf(*levelSet), voxelSize)) {
        verdict = takeLevelSet();
    } else {
        parts.field =
            std::make_unique<VdbField>(mesh, depthOfTriangle, voxelSize, options.depth, callbacks);
        verdict = judge(*parts.field, health);
        if (!verdict.sound && fits) verdict = takeLevelSet();
    }
    callbacks.report("domain", 0.8, static_cast<double>(parts.field->activeVoxels()));
    if (!verdict.sound) {
        // Thin walls in coarse voxels are no fault of the mesh; a hole shows at any size.
        const double coarseVolume = verdict.fieldVolume;
        const double half = 0.5 * voxelSize;
        if (voxelsOf(health.area, half, options.depth) < kMostDefaultVoxels) {
            auto finer =
                std::make_unique<VdbField>(mesh, depthOfTriangle, half, options.depth, callbacks);
            verdict = judge(*finer, health);
            if (verdict.sound) {
                callbacks.warn(fmt::format(
                    "{}: voxels of {:.4g} mm are too coarse for its thin walls; {:.4g} mm taken",
                    name, voxelSize, half));
                parts.field = std::move(finer);
                voxelSize = half;
            }
        }
        if (!verdict.sound) refuse(name, health, coarseVolume, voxelSize);
    }
    if (!isClean(health))
        callbacks.warn(fmt::format(
            "{}: the mesh has flaws: {}; its field is sound and is used ({:.6g} mm³, the mesh "
            "itself {:.6g} mm³)",
            name, flawsOf(health), verdict.fieldVolume, health.enclosedVolume));

    if (!isClean(health)) parts.facing.clear();
    parts.volume = isClean(health) ? health.enclosedVolume : verdict.fieldVolume;
    parts.area = health.area;
    parts.facts.kind = kind;
    parts.facts.repair = options.repair;
    parts.facts.triangles = mesh.triangles.size();
    parts.facts.meshVolume = health.enclosedVolume;
    parts.facts.voxelSize = voxelSize;
    parts.facts.activeVoxels = parts.field->activeVoxels();
    parts.facts.boundaryEdges = health.boundaryEdges;
    parts.facts.nonManifoldEdges = health.nonManifoldEdges;
    parts.mesh = std::move(mesh);
    parts.depthOfTriangle = std::move(depthOfTriangle);
    parts.name = name;
    return parts;
}

}  // namespace

std::shared_ptr<const MeshDomain> meshDomain(TriangleMesh mesh, const FieldOptions& options,
                                             const Callbacks& callbacks) {
    auto domain = std::make_shared<FieldDomain>(
        makeParts(std::move(mesh), nullptr, options, "mesh", callbacks));
    callbacks.report("domain", 1, static_cast<double>(domain->facts().activeVoxels));
    return domain;
}

std::shared_ptr<const MeshDomain> levelSetDomain(std::shared_ptr<const VdbGrid> grid,
                                                 TriangleMesh mesh, const FieldOptions& options,
                                                 const Callbacks& callbacks) {
    return std::make_shared<FieldDomain>(
        makeParts(std::move(mesh), grid.get(), options, "levelset", callbacks));
}

std::shared_ptr<const MeshDomain> levelSetDomain(const std::string& path,
                                                 const std::string& gridName, double scale,
                                                 const FieldOptions& options,
                                                 const Callbacks& callbacks) {
    const auto grid = levelSetGrid(path, gridName, scale);
    return levelSetDomain(grid, levelSetMesh(*grid, path), options, callbacks);
}

double defaultVoxelSize(const TriangleMesh& mesh, double detail) {
    const auto [area, volume] = areaAndVolume(mesh);
    const Box<3> bounds = mesh.bounds();
    if (bounds.empty() || !(area > 0)) return detail > 0 ? detail : 1;
    const Vec<3> size = bounds.size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    // Twice volume over area is the thickness of a plate; two voxels across it.
    double largest = longest / 32;
    if (volume > 0) largest = std::min(largest, volume / area);
    const double smallest =
        std::max(std::sqrt(kCommonLayers * area / kMostDefaultVoxels), longest * 1e-5);
    const double wanted = detail > 0 ? 1.1 * detail : largest;
    return std::max(std::min(wanted, largest), smallest);
}

}  // namespace vdbpack
