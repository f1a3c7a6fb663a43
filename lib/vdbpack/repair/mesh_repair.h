// A watertight surface from a mesh with holes, inverted or duplicate triangles, or overlaps.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// How the surface components of a mesh are repaired.
enum class RepairComponents {
    together,  ///< the inside of all triangles counts; what lies closer than a voxel can fuse
    separate   ///< each by itself; only those that intersect are fused (component_repair.h)
};

/// The topology of an oriented surface, taken as a manifold: edges with more than two triangles,
/// and vertices where the surface only touches itself, are split (sheets.h).
struct SurfaceTopology {
    std::int64_t components = 0;   ///< surfaces around a solid: closed or nearly closed, outward
    std::int64_t cavities = 0;     ///< closed or nearly closed surfaces that face inward
    std::int64_t fragments = 0;    ///< other surface components, with wide holes
    std::int64_t holes = 0;        ///< loops of boundary edges
    std::int64_t handles = 0;      ///< such as a foramen through a bone
    std::int64_t eulerNumber = 0;  ///< 2 per surface component, less 1 per hole and 2 per handle
};

/// What became of the surface components of a mesh.
struct RepairChanges {
    SurfaceTopology before, after;
    std::size_t fusedComponents = 0;  ///< components before that are parts of larger ones after
    std::size_t fusedInto = 0;        ///< number of these larger ones
    double fusedVolume = 0;           ///< of the largest component that joined a larger one, mm³
    Vec<3> fusedAt;                   ///< center of its bounds, mm
    std::size_t removed = 0;          ///< components and cavities of which nothing is left
    double removedVolume = 0;         ///< enclosed by them, mm³
    Vec<3> removedAt;                 ///< center of the bounds of the largest, mm
    std::size_t fragmentsRemoved = 0;
};

/// What was done to a mesh, lengths in mm.
struct RepairReport {
    enum class Method {
        none,       ///< the mesh needed no repair
        triangles,  ///< triangles that bound the inside are kept, holes are filled
        resurfaced  ///< remeshed where the winding number is 1/2 (resurface.h)
    };
    Method method = Method::none;
    RepairComponents components = RepairComponents::together;  ///< as requested
    MeshHealth before;
    std::size_t duplicates = 0;     ///< removed triangles: duplicates, or with a vertex used twice
    std::size_t turned = 0;         ///< triangles whose orientation was inverted
    std::size_t holesFilled = 0;    ///< by triangles between the vertices of their boundary
    double filledArea = 0;          ///< of those triangles, mm²
    std::size_t dropped = 0;        ///< removed triangles with both sides inside, or both outside
    std::size_t piecesDropped = 0;  ///< removed shells of a remeshed surface, below ten voxels
    double voxelSize = 0;           ///< of a remeshed surface
    double bridgedShare = 0;        ///< share of a remeshed surface that covers holes
    double thinArea = 0;  ///< area of walls lost since they are thinner than a voxel, mm²
    double volume = 0;    ///< enclosed by the repaired surface, mm³
    /// Ambiguous volume: where the winding number is closer to 1/2 than to an integer, next to
    /// holes.
    double doubtfulVolume = 0;
    double overlapVolume = 0;   ///< enclosed more than once by the surface of the file
    double invertedVolume = 0;  ///< enclosed by inverted triangles, treated as outside
    /// Components and topology before and after; nothing where they were not compared.
    std::optional<RepairChanges> changes;
};

/// All facts by name; `before` as in mesh_check.h.
nlohmann::json toJson(const RepairReport& report);

/// What was done and found, a line a fact, such as "413 triangles flipped"; without what the
/// warnings say.
std::vector<std::string> repairLines(const RepairReport& report);

/// What a user must know of a repair, a message each: ambiguous volume, components that were fused
/// or removed, holes that were closed, a topology that changed. @param name  of the mesh.
std::vector<std::string> repairWarnings(const RepairReport& report, const std::string& name);

/// The meaning of closed shells inside others.
enum class NestedShells {
    cavity,  ///< they bound cavities; shells inside a cavity are solid again
    solid    ///< they are ignored: everything inside the outermost shell is solid
};

struct RepairOptions {
    RepairComponents components = RepairComponents::together;
    NestedShells nested = NestedShells::cavity;
    /// Voxel size where the surface is remeshed, mm; 0: chosen (whole_repair.h).
    double voxelSize = 0;
    std::string name = "mesh";  ///< in messages
};

struct RepairedMesh {
    TriangleMesh mesh;  ///< watertight; normals point out of the solid
    RepairReport report;
};

/// Makes a mesh watertight. The inside is where the generalized winding number of the triangles,
/// oriented outward, is at least 1/2 (Jacobson et al. 2013, doi:10.1145/2461912.2461916).
///
/// The triangles of the file are kept if possible: duplicates are removed, inverted triangles are
/// oriented, small holes are filled, and triangles inside the solid are removed. If the result is
/// not a closed surface that agrees with the winding number of the open one (large holes,
/// components that intersect), the surface is remeshed on a lattice, with vertices on the
/// triangles of the file. A mesh without defects is returned unchanged.
///
/// Deterministic, and the same for any number of threads, so that a pack can be verified later
/// against the file repaired again.
///
/// @param mesh  welded (welding.h), mm.
/// @throws InputError if no point is inside. ParameterError for a negative voxel size.
/// ResourceError if memory does not suffice, Interrupted once cancelled.
RepairedMesh repairMesh(TriangleMesh mesh, const RepairOptions& options = {},
                        const Callbacks& callbacks = {});

/// Both surfaces in one mesh, `inner` as the wall of a cavity in `outer`, which encloses it.
TriangleMesh joinedAsCavity(TriangleMesh outer, TriangleMesh inner);

/// The inside of `outer` without the inside of `inner`, where the two intersect: a remeshed surface
/// (resurface.h). Both are watertight, as `repairMesh` returns them. @throws as `repairMesh`
RepairedMesh subtractMesh(const TriangleMesh& outer, const TriangleMesh& inner,
                          const RepairOptions& options = {}, const Callbacks& callbacks = {});

}  // namespace vdbpack
