// How the components and the topology of a surface differ before and after its repair.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// The topology of an oriented surface, taken as a manifold: edges with more than two triangles,
/// and vertices where the surface only touches itself, are split (sheets.h).
struct SurfaceTopology {
    std::size_t components = 0;    ///< surfaces around a solid: closed or nearly closed, outward
    std::size_t cavities = 0;      ///< closed or nearly closed surfaces that face inward
    std::size_t fragments = 0;     ///< other surface components, with wide holes
    std::size_t holes = 0;         ///< loops of boundary edges
    std::int64_t eulerNumber = 0;  ///< 2 per surface component, less 1 per hole and 2 per handle
    std::int64_t handles = 0;      ///< such as a foramen through a bone

    bool operator==(const SurfaceTopology& o) const {
        return components == o.components && cavities == o.cavities && fragments == o.fragments &&
               holes == o.holes && eulerNumber == o.eulerNumber && handles == o.handles;
    }
    bool operator!=(const SurfaceTopology& o) const { return !(*this == o); }
};

/// What became of the surface components of a mesh.
struct RepairChanges {
    SurfaceTopology before, after;

    /// A surface component after the repair that was several before.
    struct Fused {
        std::size_t components = 0;  ///< number before
        double volume = 0;           ///< of the second largest of them, mm³
        Vec<3> at;                   ///< center of that one's bounds, mm
    };
    std::vector<Fused> fused;  ///< by falling volume

    std::size_t removed = 0;   ///< components and cavities of which nothing is left
    double removedVolume = 0;  ///< enclosed by them, mm³
    Vec<3> removedAt;          ///< center of the largest one's bounds, mm
    std::size_t fragmentsRemoved = 0;

    /// Components before the repair that are parts of others now.
    std::size_t fusedComponents() const;
};

SurfaceTopology topologyOf(const TriangleMesh& mesh);

/// Compares two surfaces. A component before has become the component after that has vertices at
/// most of its corners. Up to about 500 corners per component are looked up.
/// @param before  oriented outward, without collapsed triangles.
/// @param after   closed, oriented outward.
/// @param reach   how far the vertices lie apart at most, mm; 0: they are the same.
RepairChanges compareSurfaces(const TriangleMesh& before, const TriangleMesh& after, double reach);

nlohmann::json toJson(const RepairChanges& changes);

/// Such as "components 12, then 2; handles 14, then 9", of what differs; empty if nothing does.
std::string describe(const RepairChanges& changes);

}  // namespace vdbpack
