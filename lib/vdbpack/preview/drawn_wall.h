// The wall of a domain as pictures and views show it.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/preview/preview.h"
#include "vdbpack/voids/make_voids.h"

#include <cstddef>
#include <limits>

namespace vdbpack {

/// The wall of a 3D domain as triangles: its own where it has some, else a contour.
class WallMesh {
public:
    /// @param known  the wall, if it is known already.
    /// @param mostTriangles  of a wall that is taken as it is.
    /// @param voxels  of the contour along the diagonal of the domain.
    WallMesh(const DomainSource& source, const DomainSource::Built& built,
             const TriangleMesh* known,
             std::size_t mostTriangles = std::numeric_limits<std::size_t>::max(),
             double voxels = 300);
    WallMesh(const WallMesh&) = delete;
    WallMesh& operator=(const WallMesh&) = delete;
    const TriangleMesh* get() const { return mesh_; }
    double voxelSize() const { return voxelSize_; }  ///< of the contour, mm; 0: it is none

private:
    TriangleMesh made_;
    const TriangleMesh* mesh_ = nullptr;
    double voxelSize_ = 0;
};

/// Distances to the wall of a plane domain, less its voids, on a lattice of about `columns` along
/// its longer side, and a little beyond.
/// @param voids  null: none.
PlaneField planeField(const Domain<2>& domain, const StampedVoids<2>* voids, int columns);

}  // namespace vdbpack
