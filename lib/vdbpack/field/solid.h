// What voids leave of a bone: surface minus voids, as a level set.
#pragma once

#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/vec.h"

#include <cstdint>
#include <functional>
#include <memory>

namespace vdbpack {

class VdbGrid;

struct Solid {
    std::shared_ptr<const VdbGrid> grid;  ///< named `solid`
    /// Number of connected components. Voxels inside are connected where they share a face.
    std::uint64_t components = 0;
    /// Share of the volume of the attached components: with a shell, those that contain a part of
    /// the wall of the bone; without one, the largest.
    double attached = 0;
    double dropped = 0;  ///< volume of the components that were removed, mm³
};

/// Cuts `voids` out of `surface` by CSG; both on the same lattice and three voxels wide.
///
/// @param shell          thickness of the layer along the wall that voids leave alone, mm.
/// @param inShell        whether a point (mm) of the wall belongs to the shell; empty: all do.
/// @param keepConnected  remove the components that are not attached.
/// @param cell           in which the solid repeats: components go on across its faces.
/// @throws ParameterError if the lattices differ, ResourceError if memory does not suffice.
Solid cutVoids(const VdbGrid& surface, const VdbGrid& voids, double shell, bool keepConnected,
               const std::function<bool(const Vec<3>&)>& inShell = {},
               const PeriodicCell<3>& cell = {});

}  // namespace vdbpack
