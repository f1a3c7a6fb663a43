// Protrusion of spheres from their domain.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/verify/wall_shape.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

struct ProtrudingSphere {
    std::size_t i = 0;      ///< index into the pack
    double protrusion = 0;  ///< share of its radius; above 1: the center is outside
};

struct ProtrusionCheck {
    double max = 0;                    ///< largest (r - inner distance to the wall) / r; 0 without
    std::uint64_t spheres = 0;         ///< spheres above `kVerifyTolerance`
    std::uint64_t centersOutside = 0;  ///< of those
    bool closed = true;  ///< false: the wall has open edges, so that a majority of lines decides
    std::vector<ProtrudingSphere> worst;  ///< up to `kWorstNamed` of them, by falling protrusion
};

/// Two checks of different spheres of one pack as one.
ProtrusionCheck joined(ProtrusionCheck a, const ProtrusionCheck& b);

/// Protrusion through the triangles of a mesh, cut by `clips`.
///
/// The inner distance is exact, and negative for a center outside. A center is inside if a line
/// from it crosses the mesh an odd number of times: nested shells bound cavities, whichever way
/// they face. With edges that join an odd number of triangles, six lines along the axes vote.
/// @param mesh       in the pack's coordinates, mm; need not be welded.
/// @param distances  if given, takes the distance of each center to the nearest triangle, mm; to
///                   know it for spheres that do not touch the wall takes longer.
/// @throws InputError for an empty mesh or one with unusable vertices or indices, or as
/// `checkOverlap`.
///
/// Cost: about 1 microsecond a sphere and 1 a triangle on two threads.
ProtrusionCheck checkProtrusion(const std::vector<Sphere<3>>& spheres, const TriangleMesh& mesh,
                                const std::vector<HalfSpace<3>>& clips = {},
                                std::vector<double>* distances = nullptr);

/// The same in the plane; the segments' directions and order do not matter.
ProtrusionCheck checkProtrusion(const std::vector<Sphere<2>>& circles,
                                const std::vector<WallPiece<2>>& wall,
                                const std::vector<HalfSpace<2>>& clips = {},
                                std::vector<double>* distances = nullptr);

/// Protrusion through the wall of a shape.
/// @throws ParameterError for a clip whose normal is zero or not finite, or as `checkOverlap`.
template <int Dim>
ProtrusionCheck checkProtrusion(const std::vector<Sphere<Dim>>& spheres,
                                const WallShape<Dim>& wall);

}  // namespace vdbpack
