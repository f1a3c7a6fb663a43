// What a repair did to a mesh: data, and from one list of facts JSON, text and warnings.
#pragma once

#include "vdbpack/mesh/mesh_check.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
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

}  // namespace vdbpack
