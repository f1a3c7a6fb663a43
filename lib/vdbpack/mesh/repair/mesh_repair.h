// A sound surface from one with holes, turned triangles, overlaps or copies.
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
    /// Edge of the lattice's cubes where the surface is rebuilt, mm; 0: `repairVoxelSize`.
    double voxelSize = 0;
    std::string name = "mesh";  ///< in messages
};

/// What was done to a mesh, lengths in mm.
struct RepairReport {
    enum class Method {
        none,       ///< the surface was sound already
        triangles,  ///< its own triangles stay where they bound the inside; holes are filled
        resurfaced  ///< rebuilt where the winding number is 1/2 (resurface.h)
    };
    Method method = Method::none;
    MeshHealth before;
    std::size_t duplicates = 0;     ///< copies and collapsed triangles taken out
    std::size_t turned = 0;         ///< triangles that faced the wrong way
    std::size_t holesFilled = 0;    ///< by triangles between the vertices of their rims
    double filledArea = 0;          ///< of those triangles, mm²
    std::size_t dropped = 0;        ///< triangles with the inside, or the outside, on both sides
    std::size_t piecesDropped = 0;  ///< pieces of a rebuilt surface, smaller than ten voxels
    double voxelSize = 0;           ///< of a rebuilt surface
    double bridgedShare = 0;        ///< share of such a surface that lies over holes
    double thinArea = 0;            ///< of walls too thin for its voxels, mm²
    double volume = 0;              ///< that the repaired surface encloses, mm³
    /// Volume where the winding number is nearer to 1/2 than to a whole number: inside or outside
    /// by a judgement on holes.
    double doubtfulVolume = 0;
    double overlapVolume = 0;   ///< that the file's surface encloses twice or more
    double invertedVolume = 0;  ///< that it encloses the wrong way round: taken for outside
};

struct RepairedMesh {
    TriangleMesh mesh;  ///< watertight, facing outward (cavities: into them)
    RepairReport report;
};

/// Makes a surface watertight, with a sound inside: where the generalized winding number of its
/// triangles, turned to face outward, is at least 1/2 (Jacobson et al. 2013,
/// doi:10.1145/2461912.2461916).
///
/// Triangles stay as they are if that suffices: copies go, wrong ones are turned, small holes are
/// filled, triangles inside the solid are taken out. Where this leaves no closed surface that the
/// winding number of the open one agrees with (large holes, pieces that cut through each other),
/// the surface is rebuilt from a lattice, with vertices on the triangles of the file. A mesh that
/// is sound already comes back as it is.
///
/// The same mesh for any number of threads. Deterministic, so that a pack can be verified later
/// against the file repaired again.
///
/// @param mesh  welded (welding.h), mm.
/// @throws InputError if nothing is inside. ParameterError for a negative voxel size. ResourceError
/// if memory does not suffice, Interrupted once cancelled.
RepairedMesh repairMesh(TriangleMesh mesh, const RepairOptions& options = {},
                        const Callbacks& callbacks = {});

/// Both surfaces in one, the second as the wall of a cavity in the first, where it lies wholly.
TriangleMesh joinedAsCavity(TriangleMesh outer, const TriangleMesh& inner);

/// The inside of `outer` without that of `inner`, both as by `repairMesh`, where they cut through
/// each other: rebuilt (resurface.h). @throws as `repairMesh`
RepairedMesh subtractMesh(const TriangleMesh& outer, const TriangleMesh& inner,
                          const RepairOptions& options = {}, const Callbacks& callbacks = {});

/// Three tenths of a typical edge, larger where that would take millions of triangles, and at most
/// half of a mean wall's thickness, mm.
double repairVoxelSize(const TriangleMesh& mesh);

/// All members by name; `before` as by mesh_check.h.
nlohmann::json toJson(const RepairReport& report);

/// Such as "413 triangles turned, 12 holes filled (35 mm²)": what was done, in a line.
std::string describe(const RepairReport& report);

}  // namespace vdbpack
