#include "vdbpack/repair/mesh_repair.h"

#include "vdbpack/core/error.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/repair/component_repair.h"
#include "vdbpack/repair/repair_changes.h"
#include "vdbpack/repair/whole_repair.h"
#include "vdbpack/repair/winding_number.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// @param oriented  the mesh, its components outermost facing outward.
[[noreturn]] void nothingInside(const std::string& name, const MeshHealth& health,
                                const TriangleMesh& oriented) {
    constexpr double kCopied = 0.99;
    const auto shells = analyzeShells(oriented).shells;
    if (shells.size() > 1 && std::fabs(shells[0].signedVolume) > 0 &&
        std::fabs(shells[1].signedVolume) > kCopied * std::fabs(shells[0].signedVolume))
        throw InputError(fmt::format(
            "{}: encloses no volume: two of its components, of {:.6g} and {:.6g} mm³, lie in one "
            "place, so that one bounds a cavity in the other; give one of them",
            name, std::fabs(shells[0].signedVolume), std::fabs(shells[1].signedVolume)));
    throw InputError(
        fmt::format("{}: encloses no volume: the winding number of its {} triangles is below 1/2 "
                    "everywhere{}{}; give a surface around a volume",
                    name, health.triangles, health.leak ? "; " : "", health.describeLeak()));
}

}  // namespace

RepairedMesh repairMesh(TriangleMesh mesh, const RepairOptions& options,
                        const Callbacks& callbacks) {
    if (!(options.voxelSize >= 0) || !std::isfinite(options.voxelSize))
        throw ParameterError(fmt::format("{}: voxel size {} for the repair must be positive, in mm",
                                         options.name, options.voxelSize));
    callbacks.report("repair", 0, 0);
    WholeRepairOptions how;
    how.nested = options.nested;
    how.voxelSize = options.voxelSize;
    WholeRepair done = options.components == RepairComponents::separate
                           ? repairComponents(std::move(mesh), how, callbacks)
                           : repairWhole(std::move(mesh), how, callbacks);
    if (done.mesh.triangles.empty()) nothingInside(options.name, done.report.before, done.oriented);
    done.report.components = options.components;
    callbacks.stopIfCancelled();
    // A new vertex lies in a voxel that the surface crosses.
    done.report.changes = compareSurfaces(done.oriented, done.mesh, 2 * done.report.voxelSize);
    callbacks.report("repair", 1, static_cast<double>(done.mesh.triangles.size()));
    return {std::move(done.mesh), std::move(done.report)};
}

TriangleMesh joinedAsCavity(TriangleMesh outer, TriangleMesh inner) {
    for (auto& t : inner.triangles) std::swap(t[1], t[2]);
    append(outer, inner);
    return outer;
}

RepairedMesh subtractMesh(const TriangleMesh& outer, const TriangleMesh& inner,
                          const RepairOptions& options, const Callbacks& callbacks) {
    RepairedMesh result;
    const TriangleMesh both = joinedAsCavity(outer, inner);
    result.report.before = checkMesh(both);
    const double voxelSize = options.voxelSize > 0 ? options.voxelSize : repairVoxelSize(both);
    result.mesh = remesh(both, WindingNumber(both), voxelSize, result.report, callbacks);
    if (result.mesh.triangles.empty()) nothingInside(options.name, result.report.before, both);
    result.report.changes = compareSurfaces(both, result.mesh, 2 * voxelSize);
    result.report.volume = analyzeShells(result.mesh).enclosedVolume();
    return result;
}

}  // namespace vdbpack
