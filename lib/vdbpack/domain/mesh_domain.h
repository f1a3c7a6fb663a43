// A closed triangle mesh as a domain: narrow-band level set for lookups, triangles for exactness.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <algorithm>
#include <memory>
#include <string>

namespace vdbpack {

/// Radius that the field is made for, mm: in wide distributions the smallest spheres follow the
/// triangles anyway, and a field as fine as them would cost more than the pack.
inline double fieldDetail(double smallest, double mean) {
    return std::max(smallest, 0.5 * mean);
}

/// Default voxel of a field, in details: at this size the center of a sphere of that radius is
/// inside by the field wherever the sphere fits (the corners of its voxel are 0.87 voxels away on
/// average).
inline constexpr double kVoxelPerDetail = 1.1;

struct MeshAnalysis;
class MeshDomain;

struct FieldOptions {
    /// Edge of a voxel, mm; 0: chosen by `defaultVoxelSize`.
    double voxelSize = 0;
    /// Depth inside the wall up to which the field must have the distance, mm (three largest radii
    /// suffice for a packer and for the interior fraction).
    double depth = 0;
    /// Smallest feature to resolve, mm (the smallest radius); guides the default voxel size.
    double detail = 0;
    /// Name of the mesh in messages (its file).
    std::string name = "mesh";
    /// Whether the mesh is known to be sound, such as a contour of our own: its thickness and the
    /// volume of its field are not checked.
    bool sound = false;
    /// Whether the level set is all that will be asked for: what distances to the triangles take is
    /// then made at the first question.
    bool fieldFirst = false;
    /// Of this mesh, if the caller has it already; null: made.
    std::shared_ptr<const MeshAnalysis> analysis;
    /// What `Domain::envelope` is to be; null: the domain itself.
    std::shared_ptr<const MeshDomain> envelope;
    /// What was done to the mesh before, for `facts`.
    std::shared_ptr<const RepairReport> repair;

    /// What a pack of such radii (mm) needs of the field.
    /// @param mean  0: halfway between the two.
    static FieldOptions forRadii(double smallest, double largest, double mean = 0) {
        FieldOptions options;
        options.detail = fieldDetail(smallest, mean > 0 ? mean : 0.5 * (smallest + largest));
        options.depth = 3 * largest;
        return options;
    }
};

/// A domain that has both a level set and the triangles of its wall.
class MeshDomain : public Domain<3> {
public:
    /// The level set that is written as `surface`.
    virtual std::shared_ptr<const VdbGrid> grid() const = 0;
    /// The same in voxels of another size (mm), rebuilt unless the size is that of `grid`.
    /// @throws as `meshDomain` for impossible sizes.
    virtual std::shared_ptr<const VdbGrid> gridOf(double voxelSize) const = 0;
    /// The wall itself: the triangles that distances are exact for, mm.
    virtual const TriangleMesh& wall() const = 0;
};

/// The inside of a closed mesh. Nested shells bound cavities, for any orientation.
///
/// The volume of the field must agree with the volume of the mesh within 1 %; where it does not,
/// voxels of half the size are tried before the mesh is refused. A mesh with flaws that leave the
/// volumes alike, such as holes smaller than the voxels, is used with a warning that names them.
///
/// @throws InputError for a mesh that is empty or far thinner than the voxels, or where the volumes
/// differ (with both figures).
/// @throws ParameterError for negative options, ResourceError if memory does not suffice.
std::shared_ptr<const MeshDomain> meshDomain(TriangleMesh mesh, const FieldOptions& options,
                                             const Callbacks& callbacks = {});
std::shared_ptr<const MeshDomain> meshDomain(SharedMesh mesh, const FieldOptions& options,
                                             const Callbacks& callbacks = {});

/// The inside of a level set; its zero contour `mesh` (of `levelSetMesh`) is the wall. The level
/// set itself is the field where its voxels have about the requested size and lie along x, y, z;
/// else a field is built as by `meshDomain`. @throws as `meshDomain`
std::shared_ptr<const MeshDomain> levelSetDomain(std::shared_ptr<const VdbGrid> grid,
                                                 SharedMesh mesh, const FieldOptions& options,
                                                 const Callbacks& callbacks = {});

/// The same, read from a .vdb file. @throws as `meshDomain` and `levelSetMesh`.
std::shared_ptr<const MeshDomain> levelSetDomain(const std::string& path,
                                                 const std::string& gridName, double scale,
                                                 const FieldOptions& options,
                                                 const Callbacks& callbacks = {});

/// The default voxel size of `meshDomain`, mm: `kVoxelPerDetail` times the detail; coarser where
/// there would be more than some 40 million voxels, finer where the bone is thinner than two such
/// voxels.
double defaultVoxelSize(const TriangleMesh& mesh, double detail);

}  // namespace vdbpack
