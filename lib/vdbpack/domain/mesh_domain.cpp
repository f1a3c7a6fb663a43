#include "vdbpack/domain/mesh_domain.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/facet_bins.h"
#include "vdbpack/domain/mesh_requirements.h"
#include "vdbpack/domain/mesh_slice.h"
#include "vdbpack/domain/volume_integrals.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/vdb_field.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/mesh_sides.h"
#include "vdbpack/mesh/wall_clearance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

namespace vdbpack {

namespace {

// Largest relative difference of the volumes of the field and the mesh.
constexpr double kVolumeTolerance = 0.01;
constexpr double kMostDefaultVoxels = 4e7;
// Layers of voxels in a common band: six radii inside, three outside.
constexpr double kCommonLayers = 9;

/// Area, and integrals over the inside, about a vertex so that digits survive far from zero.
/// @param facing  as in MeshNesting.
std::pair<double, VolumeIntegrals<3>> areaAndIntegrals(
    const TriangleMesh& mesh, const std::vector<std::int8_t>& facing = {}) {
    double area = 0;
    VolumeIntegrals<3> inside;
    if (mesh.vertices.empty()) return {area, inside};
    const Vec<3> origin = mesh.vertices.front();
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
        const auto& t = mesh.triangles[k];
        const Vec<3> a = mesh.vertices[t[0]] - origin;
        const Vec<3> b = mesh.vertices[t[1]] - origin;
        const Vec<3> c = mesh.vertices[t[2]] - origin;
        area += 0.5 * length(cross(b - a, c - a));
        inside.add((facing.empty() ? 1 : facing[k]) * dot(a, cross(b, c)) / 6, (a + b + c) * 0.25);
    }
    inside.moment += origin * inside.volume;
    return {area, inside};
}

class MeshDomainSampler : public DomainSampler<3> {
public:
    /// @param contour  the triangles are the field's own contour: none passes between voxels of the
    ///                 same sign.
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

    DepthRange depthRange(const Vec<3>& x) override { return field_.depthRange(x); }

    bool contains(const Vec<3>& x) override {
        const int side = contour_ ? field_.sideAround(x) : 0;
        return side != 0 ? side < 0 : sides_.inside(x);
    }

    // A search with a reach of about the distance meets fewer triangles; where the field is too
    // inaccurate for that, it is repeated with the full reach.
    bool nearestWall(const Vec<3>& x, double reach, WallPoint<3>& wall) override {
        const double guess = std::abs(signedDistance(x)) + slack_;
        if (guess < reach && bins_.nearest(x, guess, wall)) return true;
        return bins_.nearest(x, reach, wall);
    }

    void wallsWithin(const Vec<3>& x, double reach, std::vector<WallPoint<3>>& points) override {
        bins_.within(x, reach, points);
    }

    bool isWallCloser(const Vec<3>& x, double reach) override {
        // The field decides, unless the wall is about that far away.
        const DepthRange depth = field_.depthRange(x);
        if (depth.least >= reach || depth.most <= -reach) return false;
        if (depth.least > -reach && depth.most < reach) return true;
        return bins_.anyCloser(x, reach);
    }

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

/// What questions to the triangles take.
struct Triangles {
    std::unique_ptr<const FacetBins<3>> bins;
    std::unique_ptr<const MeshSides> sides;
};

struct Parts {
    SharedMesh mesh;
    std::unique_ptr<const VdbField> field;
    mutable std::shared_ptr<const Triangles> triangles;  // null: not made yet
    MeshNesting nesting;
    std::shared_ptr<const MeshDomain> envelope;  // null: the domain itself
    std::string name;
    bool contour = false;  // the mesh is the contour of the field
    double volume = 0;
    double area = 0;
    DomainFacts facts;
};

std::vector<Facet<3>> facetsOf(const TriangleMesh& mesh) {
    std::vector<Facet<3>> facets(mesh.triangles.size());
    forAll(facets.size(), [&](std::size_t i) {
        for (std::size_t k = 0; k < 3; ++k) facets[i][k] = mesh.vertices[mesh.triangles[i][k]];
    });
    return facets;
}

std::shared_ptr<const Triangles> trianglesOf(const SharedMesh& mesh, bool watertight) {
    auto triangles = std::make_shared<Triangles>();
    // Each is partly serial.
    invokeAll([&] { triangles->bins = std::make_unique<const FacetBins<3>>(facetsOf(*mesh)); },
              [&] { triangles->sides = std::make_unique<const MeshSides>(mesh, watertight); });
    return triangles;
}

class FieldDomain : public MeshDomain,
                    public Sliceable,
                    public std::enable_shared_from_this<FieldDomain> {
public:
    explicit FieldDomain(Parts parts) : parts_(std::move(parts)), bounds_(parts_.mesh->bounds()) {}

    Box<3> bounds() const override { return bounds_; }
    double volume() const override { return parts_.volume; }
    std::optional<Vec<3>> centroid() const override {
        const auto inside = areaAndIntegrals(*parts_.mesh, parts_.nesting.facing).second;
        // What surfaces with flaws enclose may not be what the field has inside.
        const double difference = std::abs(std::abs(inside.volume) - parts_.volume);
        if (!(difference <= kVolumeTolerance * parts_.volume)) return std::nullopt;
        return inside.centroid();
    }
    double wallArea() const override { return parts_.area; }
    double volumeDeeperThan(double depth) const override { return volumesDeeperThan({depth})[0]; }
    std::vector<double> volumesDeeperThan(const std::vector<double>& depths) const override {
        std::vector<double> volumes = parts_.field->volumesDeeperThan(depths);
        for (std::size_t i = 0; i < depths.size() && depths[i] == 0; ++i)
            volumes[i] = parts_.volume;
        return volumes;
    }
    double fieldDepth() const override { return parts_.field->depth(); }
    std::unique_ptr<DomainSampler<3>> sampler() const override {
        std::call_once(once_, [&] {
            if (!parts_.triangles)
                parts_.triangles = trianglesOf(parts_.mesh, parts_.nesting.watertight);
        });
        const Triangles& triangles = *parts_.triangles;
        return std::make_unique<MeshDomainSampler>(*parts_.field, *triangles.bins, *triangles.sides,
                                                   parts_.contour);
    }
    DomainFacts facts() const override { return parts_.facts; }
    const Domain<3>& envelope() const override {
        return parts_.envelope ? *parts_.envelope : static_cast<const Domain<3>&>(*this);
    }
    std::shared_ptr<const VdbGrid> grid() const override { return parts_.field->surface(); }
    std::shared_ptr<const VdbGrid> gridOf(double voxelSize) const override {
        if (std::abs(voxelSize - parts_.field->voxelSize()) < 1e-9 * voxelSize) return grid();
        requireVoxels(parts_.name, *parts_.mesh, parts_.area, voxelSize, 0);
        return VdbField(*parts_.mesh, parts_.nesting, voxelSize, 0).surface();
    }
    const TriangleMesh& wall() const override { return *parts_.mesh; }
    std::shared_ptr<const Domain<2>> slice(double height) const override {
        auto envelope = parts_.envelope ? sliceDomain(parts_.envelope, height) : nullptr;
        return meshSlice(shared_from_this(), parts_.nesting.facing, height, std::move(envelope));
    }

private:
    Parts parts_;
    Box<3> bounds_;
    mutable std::once_flag once_;  // of the triangles
};

/// Whether a level set in voxels of `voxelSize` can be the field where `wanted` is the size of the
/// voxels of a new field.
bool isAbout(double voxelSize, double wanted) {
    return voxelSize > 0.4 * wanted && voxelSize < 1.5 * wanted;
}

/// Builds the field of a mesh, or takes a level set for it, such that inside and outside are as the
/// mesh has them.
class FieldBuilder {
public:
    double voxelSize;  // mm
    std::unique_ptr<const VdbField> field;
    double volume = 0;     // that the field encloses, mm³
    bool contour = false;  // the field is a level set, the mesh its contour

    FieldBuilder(const TriangleMesh& mesh, const MeshAnalysis& analysis, const MeshNesting& nesting,
                 const FieldOptions& options, const Callbacks& callbacks)
        : voxelSize(options.voxelSize > 0 ? options.voxelSize
                                          : defaultVoxelSize(mesh, options.detail)),
          mesh_(mesh),
          analysis_(analysis),
          health_(analysis.health),
          nesting_(nesting),
          options_(options),
          callbacks_(callbacks) {
        requireVoxels(options.name, mesh, health_.area, voxelSize, options.depth);
    }

    /// Refuses a mesh whose field cannot agree with it, before anything is made of it.
    /// @param levelSet  whose contour the mesh is; null: none.
    void check(const VdbGrid* levelSet) const {
        if (!fits(levelSet) && !options_.sound) requireVolume(options_.name, health_, voxelSize);
    }

    void build(const VdbGrid* levelSet) {
        callbacks_.report("domain", 0, 0);
        callbacks_.stopIfCancelled();
        if (fits(levelSet) && isAbout(voxelSizeOf(*levelSet), voxelSize)) {
            takeLevelSet(*levelSet);
        } else if (!voxelize(voxelSize)) {
            if (fits(levelSet))
                takeLevelSet(*levelSet);
            else
                refine();
        }
        callbacks_.report("domain", 0.8, static_cast<double>(field->activeVoxels()));
    }

private:
    bool fits(const VdbGrid* levelSet) const {
        return levelSet != nullptr && health_.isWatertight() && liesAlongAxes(*levelSet);
    }

    /// Its signs are those of its contour, however thin its walls are.
    void takeLevelSet(const VdbGrid& levelSet) {
        contour = true;
        voxelSize = voxelSizeOf(levelSet);
        field = std::make_unique<VdbField>(levelSet, options_.depth);
        volume = health_.enclosedVolume;
    }

    /// @return whether the volume of the field agrees with that of the mesh.
    bool voxelize(double size) {
        field = std::make_unique<VdbField>(mesh_, nesting_, size, options_.depth, callbacks_);
        volume = field->volume();
        if (!(volume > 0)) return false;
        if (options_.sound) return true;
        const double difference =
            std::abs(volume - health_.enclosedVolume) / std::abs(health_.enclosedVolume);
        return difference <= kVolumeTolerance;
    }

    /// Whether voxels of `size` are few enough, whatever the radii: `mesh` decides by the same.
    bool isAffordable(double size) const {
        return estimatedVoxels(health_.area, size, 0) < kMostDefaultVoxels;
    }

    /// Tries voxels of half the size, and ever smaller ones if none was asked for: walls and gaps
    /// too thin for the voxels are no flaw of the mesh, while a hole shows at any size.
    void refine() {
        const double coarseVolume = volume;
        const WallClearance clearance =
            isSound(health_) ? wallClearance(mesh_, analysis_) : WallClearance{};
        const bool once = options_.voxelSize > 0 || !clearance.isSolid;
        double size = voxelSize;
        do {
            size *= 0.5;
            if (!isAffordable(size) || !voxelize(size)) continue;
            callbacks_.warn(fmt::format(
                "{}: voxels of {:.4g} mm are too coarse for its thin walls; {:.4g} mm taken",
                options_.name, voxelSize, size));
            voxelSize = size;
            return;
        } while (!once && isAffordable(size));
        if (!clearance.isSolid) refuseMesh(options_.name, health_, coarseVolume, voxelSize);
        refuseVoxels(options_.name, health_, coarseVolume, voxelSize, clearance,
                     0.5 * std::min({size, clearance.gap, defaultVoxelSize(mesh_, 0)}));
    }

    const TriangleMesh& mesh_;
    const MeshAnalysis& analysis_;
    const MeshHealth& health_;
    const MeshNesting& nesting_;
    const FieldOptions& options_;
    const Callbacks& callbacks_;
};

DomainFacts factsOf(const TriangleMesh& mesh, const MeshHealth& health, const FieldOptions& options,
                    const std::string& kind) {
    DomainFacts facts;
    facts.kind = kind;
    facts.repair = options.repair;
    facts.triangles = mesh.triangles.size();
    facts.meshVolume = health.enclosedVolume;
    facts.boundaryEdges = health.boundaryEdges;
    facts.nonManifoldEdges = health.nonManifoldEdges;
    return facts;
}

/// @param levelSet  whose contour the mesh is; null: none.
Parts makeParts(SharedMesh shared, const VdbGrid* levelSet, const FieldOptions& options,
                const std::string& kind, const Callbacks& callbacks) {
    const TriangleMesh& mesh = *shared;
    requireLengths(options);
    requireUsableMesh(mesh, options.name);
    const auto analysis = options.analysis
                              ? options.analysis
                              : std::make_shared<const MeshAnalysis>(analyzeMesh(mesh));
    const MeshHealth& health = analysis->health;
    if (!(health.area > 0))
        throw InputError(fmt::format("{}: no triangle has an area; repair the mesh", options.name));
    Parts parts;
    parts.nesting = nestingOf(*analysis);
    FieldBuilder builder(mesh, *analysis, parts.nesting, options, callbacks);
    builder.check(levelSet);
    // The field, too, is partly serial.
    invokeAll([&] { builder.build(levelSet); },
              [&] {
                  if (!options.fieldFirst)
                      parts.triangles = trianglesOf(shared, parts.nesting.watertight);
              });
    if (!isClean(health)) {
        const std::string taken = hasVolume(health)
                                      ? std::string("what it encloses is known all the same")
                                      : fmt::format(
                                            "its field is sound and is used ({:.6g} mm³, the mesh "
                                            "itself {:.6g} mm³)",
                                            builder.volume, health.enclosedVolume);
        callbacks.warn(fmt::format("{}: the mesh has flaws: {}; {}{}", options.name,
                                   flawsOf(health), taken,
                                   isSound(health) ? "" : "; set `repair` to mend them"));
    }
    parts.volume = hasVolume(health) ? health.enclosedVolume : builder.volume;
    parts.area = health.area;
    parts.facts = factsOf(mesh, health, options, kind);
    parts.facts.voxelSize = builder.voxelSize;
    parts.facts.activeVoxels = builder.field->activeVoxels();
    parts.field = std::move(builder.field);
    parts.contour = builder.contour;
    parts.envelope = options.envelope;
    parts.mesh = std::move(shared);
    parts.name = options.name;
    return parts;
}

}  // namespace

std::shared_ptr<const MeshDomain> meshDomain(TriangleMesh mesh, const FieldOptions& options,
                                             const Callbacks& callbacks) {
    return meshDomain(std::make_shared<const TriangleMesh>(std::move(mesh)), options, callbacks);
}

std::shared_ptr<const MeshDomain> meshDomain(SharedMesh mesh, const FieldOptions& options,
                                             const Callbacks& callbacks) {
    auto domain = std::make_shared<FieldDomain>(
        makeParts(std::move(mesh), nullptr, options, "mesh", callbacks));
    callbacks.report("domain", 1, static_cast<double>(domain->facts().activeVoxels));
    return domain;
}

std::shared_ptr<const MeshDomain> levelSetDomain(std::shared_ptr<const VdbGrid> grid,
                                                 SharedMesh mesh, const FieldOptions& options,
                                                 const Callbacks& callbacks) {
    return std::make_shared<FieldDomain>(
        makeParts(std::move(mesh), grid.get(), options, "levelset", callbacks));
}

std::shared_ptr<const MeshDomain> levelSetDomain(const std::string& path,
                                                 const std::string& gridName, double scale,
                                                 const FieldOptions& options,
                                                 const Callbacks& callbacks) {
    const auto grid = levelSetGrid(path, gridName, scale);
    return levelSetDomain(grid, std::make_shared<const TriangleMesh>(levelSetMesh(*grid, path)),
                          options, callbacks);
}

double defaultVoxelSize(const TriangleMesh& mesh, double detail) {
    const auto [area, inside] = areaAndIntegrals(mesh);
    const double volume = std::abs(inside.volume);
    const Box<3> bounds = mesh.bounds();
    if (bounds.empty() || !(area > 0)) return detail > 0 ? detail : 1;
    const Vec<3> size = bounds.size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    // Twice volume over area is the thickness of a plate; two voxels across it.
    double largest = longest / 32;
    if (volume > 0) largest = std::min(largest, volume / area);
    const double smallest =
        std::max(std::sqrt(kCommonLayers * area / kMostDefaultVoxels), longest * 1e-5);
    const double wanted = detail > 0 ? kVoxelPerDetail * detail : largest;
    return std::max(std::min(wanted, largest), smallest);
}

}  // namespace vdbpack
