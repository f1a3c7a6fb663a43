// What voids leave of a bone: surface minus voids, as a level set.
#pragma once

#include <cstdint>
#include <memory>

namespace vdbpack {

class VdbGrid;

struct Solid {
    std::shared_ptr<const VdbGrid> grid;  ///< named `solid`
    std::uint64_t pieces = 0;             ///< that no voxel joins to one another
    /// Share of its volume that is connected with the wall of the bone: the pieces that contain a
    /// part of it. With voids that open the wall, the share of the largest piece.
    double attached = 0;
    double dropped = 0;  ///< volume of what was dropped, mm³
};

/// Cuts `voids` out of `surface` by CSG; both on the same lattice and three voxels wide.
///
/// @param shell          thickness of the layer along the wall that voids leave alone, mm.
/// @param keepConnected  drop the pieces that are not attached.
/// Voxels inside are connected where they share a face.
/// @throws ParameterError if the lattices differ, ResourceError if memory does not suffice.
Solid cutVoids(const VdbGrid& surface, const VdbGrid& voids, double shell, bool keepConnected);

}  // namespace vdbpack
