// How the components and the topology of a surface differ before and after its repair.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>
#include <cstdint>

namespace vdbpack {

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

SurfaceTopology topologyOf(const TriangleMesh& mesh);

/// Compares two surfaces. A component before has become the component after that has vertices at
/// most of its corners. Up to about 500 corners per component are looked up.
/// @param before  oriented outward, without collapsed triangles.
/// @param after   closed, oriented outward.
/// @param reach   how far the vertices lie apart at most, mm; 0: they are the same.
RepairChanges compareSurfaces(const TriangleMesh& before, const TriangleMesh& after, double reach);

}  // namespace vdbpack
