// A closed triangle mesh as a domain: narrow-band level set for lookups, triangles for the truth.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <memory>
#include <string>

namespace vdbpack {

class VdbGrid;

struct FieldOptions {
    /// Edge of a voxel, mm; 0: chosen by `defaultVoxelSize`.
    double voxelSize = 0;
    /// Depth inside the wall up to which the field must know the distance, mm (three largest
    /// radii suffice for a packer and for the interior fraction).
    double depth = 0;
    /// Smallest feature to resolve, mm (the smallest radius); guides the default voxel size.
    double detail = 0;
    /// Name of the mesh in messages (its file).
    std::string name = "mesh";
};

/// A mesh domain keeps both; `grid` is what is written as `surface`.
class MeshDomain : public Domain<3> {
public:
    virtual std::shared_ptr<const VdbGrid> grid() const = 0;
    /// The wall itself: the triangles that distances are exact for, mm.
    virtual const TriangleMesh& wall() const = 0;
};

/// The inside of a closed mesh. Nested shells bound cavities, whichever way they face.
/// @throws InputError where the mesh is not closed and the field cannot be trusted, or where
/// the field's volume differs from the mesh's by more than 1 % (with both figures).
std::shared_ptr<const MeshDomain> meshDomain(TriangleMesh mesh, const FieldOptions& options,
                                             const Callbacks& callbacks = {});

/// The inside of a level set read from a .vdb file; its zero contour is the wall.
/// `gridName` may be empty: the first level set of the file.
/// @throws IoError, InputError
std::shared_ptr<const MeshDomain> levelSetDomain(const std::string& path,
                                                 const std::string& gridName, double scale,
                                                 const Callbacks& callbacks = {});

/// The voxel size that `meshDomain` takes by default, mm: near the detail asked for, but never
/// so fine that the field costs more than the pack.
double defaultVoxelSize(const TriangleMesh& mesh, double detail);

}  // namespace vdbpack
