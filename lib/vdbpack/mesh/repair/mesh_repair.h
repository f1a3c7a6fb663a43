// A watertight surface from a mesh with holes, inverted or duplicate triangles, or overlaps.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/mesh/repair/facing.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>

namespace vdbpack {

struct RepairOptions {
    NestedShells nested = NestedShells::cavity;
    /// Voxel size where the surface is remeshed, mm; 0: `repairVoxelSize`.
    double voxelSize = 0;
    std::string name = "mesh";  ///< in messages
};

/// What was done to a mesh, lengths in mm.
struct RepairReport {
    enum class Method {
        none,       ///< the mesh needed no repair
        triangles,  ///< triangles that bound the inside are kept, holes are filled
        resurfaced  ///< remeshed where the winding number is 1/2 (resurface.h)
    };
    Method method = Method::none;
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
TriangleMesh joinedAsCavity(TriangleMesh outer, const TriangleMesh& inner);

/// The inside of `outer` without that of `inner`, where the two intersect: a remeshed surface
/// (resurface.h). Both are watertight, as `repairMesh` returns them. @throws as `repairMesh`
RepairedMesh subtractMesh(const TriangleMesh& outer, const TriangleMesh& inner,
                          const RepairOptions& options = {}, const Callbacks& callbacks = {});

/// Default voxel size, mm: three tenths of a typical edge, at most half of the mean wall thickness,
/// and larger where that would take millions of triangles.
double repairVoxelSize(const TriangleMesh& mesh);

/// All members by name; `before` as in mesh_check.h.
nlohmann::json toJson(const RepairReport& report);

/// What was done, in one line, such as "413 triangles flipped, 12 holes filled (35 mm²)".
std::string describe(const RepairReport& report);

}  // namespace vdbpack
