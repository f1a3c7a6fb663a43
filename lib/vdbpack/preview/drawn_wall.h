// The wall of a domain as pictures and views show it.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/preview/preview.h"
#include "vdbpack/voids/make_voids.h"

namespace vdbpack {

/// The wall of a domain of space as triangles: its own where it has some.
class WallMesh {
public:
    /// @param known  the wall, if it is known already.
    WallMesh(const DomainSource& source, const DomainSource::Built& built,
             const TriangleMesh* known);
    WallMesh(const WallMesh&) = delete;
    WallMesh& operator=(const WallMesh&) = delete;
    const TriangleMesh* get() const { return mesh_; }

private:
    TriangleMesh made_;
    const TriangleMesh* mesh_ = nullptr;
};

/// Distances to the wall of a plane domain, less its voids, on a lattice of about `columns` along
/// its longer side, and a little beyond.
/// @param voids  null: none.
PlaneField planeField(const Domain<2>& domain, const StampedVoids<2>* voids, int columns);

}  // namespace vdbpack
