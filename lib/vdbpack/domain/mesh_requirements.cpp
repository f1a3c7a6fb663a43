#include "vdbpack/domain/mesh_requirements.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/field/smallest_voxel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

// Half the thickness of a wall, in voxels, below which its volume cannot come out within tolerance.
constexpr double kThinnestInVoxels = 0.05;
/// Half of a thickness, as a share of the extent, at which volumes cancel up to rounding.
constexpr double kCancelled = 1e-12;
// Triangles of a component, on average, below which they are loose.
constexpr std::size_t kFewTriangles = 16;
// More active voxels than this (some 40 GB) result from a wrong unit.
constexpr double kMostVoxels = 5e9;

/// Copies of a few triangles are a flaw, of all of them another mistake.
void refuseCopies(const std::string& name, const MeshHealth& health) {
    if (20 * health.duplicateTriangles > 9 * health.triangles)
        throw InputError(
            fmt::format("{}: holds the same surface more than once: {} of its {} triangles are "
                        "copies of others. Remove the copy, or set `repair`",
                        name, health.duplicateTriangles, health.triangles));
}

}  // namespace

void requireLengths(const FieldOptions& options) {
    for (const double value : {options.voxelSize, options.depth, options.detail})
        if (!(value >= 0) || !std::isfinite(value))
            throw ParameterError(fmt::format(
                "{}: voxel size {}, depth {} and detail {} must be lengths in mm, 0 or more",
                options.name, options.voxelSize, options.depth, options.detail));
}

void requireUsableMesh(const TriangleMesh& mesh, const std::string& name) {
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

double estimatedVoxels(double area, double voxelSize, double depth) {
    return area * (depth + 5 * voxelSize) / (voxelSize * voxelSize * voxelSize);
}

void requireVoxels(const std::string& name, const TriangleMesh& mesh, double area, double voxelSize,
                   double depth) {
    const Vec<3> size = mesh.bounds().size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    if (!(voxelSize <= longest))
        throw ParameterError(
            fmt::format("{}: voxels of {:.4g} mm are larger than the mesh, which is {:.4g} mm "
                        "across; give smaller voxels, or check the unit of the mesh",
                        name, voxelSize, longest));
    if (voxelSize < kSmallestVoxel)
        throw ParameterError(
            fmt::format("{}: voxels of {:.4g} mm are smaller than a field can have, {:g} mm; check "
                        "`unit` and `scale` of the mesh, which is {:.4g} mm across",
                        name, voxelSize, kSmallestVoxel, longest));
    const double voxels = estimatedVoxels(area, voxelSize, depth);
    if (!(voxels < kMostVoxels) || !(longest / voxelSize < 1e6))
        throw ResourceError(
            fmt::format("{}: a surface of {:.4g} mm², {:.4g} mm across, takes about {:.2g} voxels "
                        "of {:.4g} mm; give larger voxels, or check the unit of the mesh",
                        name, area, longest, voxels, voxelSize));
}

void requireVolume(const std::string& name, const MeshHealth& health, double voxelSize) {
    const double half = health.enclosedVolume / health.area;  // of a plate's thickness
    const bool isThin = !(half > kThinnestInVoxels * voxelSize);
    // Pieces of a few triangles are no surface, whatever each of them seems to enclose.
    const bool isLoose =
        health.boundaryEdges > health.triangles && kFewTriangles * health.shells > health.triangles;
    if (!health.isClosed() && (isThin || isLoose))
        throw InputError(
            fmt::format("{}: the mesh is not closed: {}. What it encloses is no volume ({:.3g} mm³ "
                        "within {:.6g} mm² of triangles); close the holes, or set `repair`",
                        name, health.describeLeak(), health.enclosedVolume, health.area));
    if (health.isClosed() && !(half > kCancelled * length(health.bounds.size()))) {
        refuseCopies(name, health);
        throw InputError(fmt::format(
            "{}: the surface is closed but encloses no volume ({:.3g} mm³ within {:.6g} mm²): it "
            "is folded flat, or two layers of it cancel; correct the mesh, or set `repair`",
            name, health.enclosedVolume, health.area));
    }
    if (!(half > 0) || !isThin || !isClean(health)) return;
    throw InputError(
        fmt::format("{}: the mesh is about {:.2g} mm thick (twice its volume divided by its area), "
                    "too thin for a field of {:.4g} mm voxels; check the mesh and its unit, or set "
                    "`voxelSize` to {:.2g} mm",
                    name, 2 * half, voxelSize, half));
}

bool isSound(const MeshHealth& health) {
    return health.isClosed() && health.inconsistentEdges == 0 && health.intersections == 0;
}

bool isClean(const MeshHealth& health) {
    return health.isWatertight() && isSound(health);
}

bool hasVolume(const MeshHealth& health) {
    constexpr double kRounding = 1e-6;
    return health.hasParity() && health.inconsistentEdges == 0 &&
           health.intersectionVolume <= kRounding * health.enclosedVolume;
}

std::string flawsOf(const MeshHealth& health) {
    std::string text;
    const auto add = [&](std::size_t count, const char* what) {
        if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
    };
    if (!health.isClosed()) text = health.describeLeak();
    add(health.nonManifoldEdges, "edges with more than two triangles");
    add(health.inconsistentEdges, "edges between triangles of opposite orientation");
    add(health.duplicateTriangles, "duplicate triangles");
    if (health.intersections > 0)
        text += (text.empty() ? "" : ", ") + health.describeIntersections() +
                ", which counts as outside";
    return text;
}

void refuseMesh(const std::string& name, const MeshHealth& health, double fieldVolume,
                double voxelSize) {
    const std::string volumes =
        fmt::format("the field of {:.4g} mm voxels encloses {:.6g} mm³, the mesh {:.6g} mm³",
                    voxelSize, fieldVolume, health.enclosedVolume);
    if (!health.isClosed())
        throw InputError(
            fmt::format("{}: the mesh is not closed: {}; {}; close the holes, or set `repair`",
                        name, health.describeLeak(), volumes));
    refuseCopies(name, health);
    const std::string flaws = flawsOf(health);
    throw InputError(fmt::format(
        "{}: inside and outside are ambiguous: {}; {}; correct the mesh, or set `repair`", name,
        volumes, flaws.empty() ? "the surface intersects itself" : flaws));
}

void refuseVoxels(const std::string& name, const MeshHealth& health, double fieldVolume,
                  double voxelSize, const WallClearance& clearance, double fineEnough) {
    const std::string gaps =
        std::isfinite(clearance.gap)
            ? fmt::format(", with gaps of about {:.2g} mm between walls", clearance.gap)
            : "";
    constexpr double kManyVoxels = 1e8;
    const double voxels = estimatedVoxels(health.area, fineEnough, 0);
    throw InputError(fmt::format(
        "{}: voxels of {:.4g} mm are too coarse for the mesh, whose thinnest walls are about "
        "{:.2g} mm thick{}: their field encloses {:.6g} mm³, the mesh {:.6g} mm³. Set `voxelSize` "
        "to {:.2g} mm or less{}{}",
        name, voxelSize, clearance.thickness, gaps, fieldVolume, health.enclosedVolume, fineEnough,
        voxels > kManyVoxels ? fmt::format(" (about {:.1g} voxels)", voxels) : "",
        health.duplicateTriangles > 0
            ? ", or set `repair`, which removes walls that solids have in common"
            : ""));
}

MeshNesting nestingOf(const MeshAnalysis& analysis) {
    const ShellAnalysis& shells = analysis.shells;
    const std::size_t n = shells.shellOfTriangle.size();
    MeshNesting nesting;
    nesting.watertight = analysis.health.hasParity();
    if (std::any_of(shells.shells.begin(), shells.shells.end(),
                    [](const Shell& shell) { return shell.depth > 0; })) {
        nesting.depthOfTriangle.resize(n);
        forAll(n, [&](std::size_t i) {
            const int depth = shells.shells[shells.shellOfTriangle[i]].depth;
            nesting.depthOfTriangle[i] = static_cast<std::uint8_t>(std::min(depth, 255));
        });
    }
    if (isClean(analysis.health)) {
        nesting.facing.resize(n);
        forAll(n, [&](std::size_t i) {
            const Shell& shell = shells.shells[shells.shellOfTriangle[i]];
            nesting.facing[i] = (shell.signedVolume > 0) == (shell.depth % 2 == 0) ? 1 : -1;
        });
    }
    return nesting;
}

}  // namespace vdbpack
