// From the words of a command line to a domain: meshes, level sets, shapes, slices and clips.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/core/units.h"
#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/image/image_grid.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/repair/mesh_repair.h"
#include "vdbpack/verify/verify.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// The files that a domain is read from; a shape stands for itself.
std::vector<std::string> domainInputs(const DomainRecipe& recipe);

/// The mesh of a recipe's file, repaired, joined with its inner one and placed as the recipe says,
/// mm.
/// @param report  what the repair did; unchanged if none was requested.
/// @throws ParameterError, InputError, IoError, ResourceError
TriangleMesh readDomainMesh(const DomainRecipe& recipe, const Callbacks& callbacks,
                            std::shared_ptr<const RepairReport>& report);

/// How a recipe's mesh is repaired.
RepairOptions repairOptions(const DomainRecipe& recipe);

/// Warns of a size that is unlikely for a bone. @throws InputError if it is too small to compute
/// with.
void checkSize(const Box<3>& bounds, const DomainRecipe& recipe, const Callbacks& callbacks);

/// Warns of a mesh far from the origin whose file has lost digits of its shape.
void warnOfLostDigits(const TriangleMesh& mesh, const DomainRecipe& recipe,
                      const Callbacks& callbacks);

/// A field that would be made of a file, and of what.
struct FieldPlan {
    std::uint64_t triangles = 0, vertices = 0;  ///< 0: no field is made, the domain is a shape
    bool watertight = false;                    ///< so that it is a narrow band of our own
    double area = 0, volume = 0;                ///< of the mesh, mm² and mm³
    double voxelSize = 0, depth = 0;            ///< mm
    int fields = 1;                             ///< of about that size

    /// About the voxels in the leaves of its tree, which reach beyond the wall and the depth.
    double voxels() const;
};

struct NamedShape;

/// A shape or the content of a file, before radii are known.
class DomainSource {
public:
    /// Reads the file or parses the shape. @throws ParameterError, InputError, IoError
    explicit DomainSource(const DomainRecipe& recipe, const Callbacks& callbacks = {});

    /// A mesh that was made of what the recipe names, mm. @throws InputError
    DomainSource(const DomainRecipe& recipe, TriangleMesh mesh, const Callbacks& callbacks);

    /// A contour of the program's own, mm, whose field gets voxels of `voxelSize` mm.
    DomainSource(TriangleMesh mesh, const std::string& name, double voxelSize);

    /// Leaves the inside of another file's mesh to that one: from now on the domain is what it
    /// leaves. @throws ParameterError if either is no file without clips and slices
    void cutBy(const DomainSource& other);
    /// Whether neither clips nor `cutBy` take anything from a file or shape.
    bool isWhole() const { return clips_.empty() && outsides_.empty(); }

    int dim() const;        ///< 2 for rect, disc and slices
    double volume() const;  ///< of a whole file or of a shape, mm^dim
    bool isFile() const { return mesh_ != nullptr; }
    bool hasCavities() const;  ///< closed components of the surface inside others
    const SharedMesh& mesh() const { return mesh_; }  ///< null: a shape
    /// Whether each edge of `mesh()` joins two triangles.
    bool isWatertight() const;
    /// That `mesh()` is the contour of; null: it is none.
    const std::shared_ptr<const VdbGrid>& levelSet() const { return levelSet_; }
    const Box<3>& fileBounds() const { return fileBounds_; }
    /// Of the image that the domain comes from, mm; nothing: it is none.
    const std::optional<ImageGrid>& imageGrid() const { return imageGrid_; }
    /// @param spaced  whether that image states the distances of its voxels.
    /// @param sided  whether it says which sides of a patient its axes point to.
    void setImageGrid(const ImageGrid& grid, bool spaced, bool sided) {
        imageGrid_ = grid;
        spaced_ = spaced;
        sided_ = sided;
    }
    bool isSpaced() const { return spaced_; }  ///< whether that image does
    bool isSided() const { return sided_; }    ///< the same; false: it comes from no image
    /// Around a 3D domain; for a file, without its clips.
    Box<3> domainBounds() const { return space_ ? space_->bounds() : fileBounds_; }

    /// The domain, its field made for spheres down to `minRadius` and up to `maxRadius` (mm).
    /// One of the two is null, by dim().
    struct Built {
        std::shared_ptr<const Domain<3>> space;
        std::shared_ptr<const Domain<2>> plane;
        std::shared_ptr<const MeshDomain> mesh;  ///< what `space` was cut from, if a file
        double sliceHeight = 0;                  ///< mm
    };
    /// @param voxelSize  used for the field if it is close to the default, mm: a level set
    ///                   in such voxels then comes with it. 0: none.
    Built build(double minRadius, double maxRadius, const Callbacks& callbacks = {},
                double voxelSize = 0) const;
    /// The level set of a file's mesh, without clips; quicker than `build` where its triangles are
    /// not asked. @param sound  as `FieldOptions::sound`.
    std::shared_ptr<const MeshDomain> field(double voxelSize, bool sound,
                                            const Callbacks& callbacks) const;

    /// The field that `build` would make.
    FieldPlan plan(double minRadius, double maxRadius, double voxelSize = 0) const;
    struct Left {
        double volume = 0;  ///< mm³; of a slice its area, mm²
        double area = 0;    ///< of walls, with those that clips cut, of files only, mm²
    };
    /// The volume of a shape, or about what clips and slices leave of a file, by points spread over
    /// it.
    /// @param byParts  whether `cutBy` takes its share of the volume, too.
    Left left(bool byParts = true) const;

    /// How far spheres protrude from the domain's wall itself (triangles or formula), checked
    /// by code that is not used for the field.
    /// @param distances  as `checkProtrusion` has it; nothing where the wall is a formula.
    ProtrusionCheck protrusion(const std::vector<Sphere<3>>& spheres,
                               std::vector<double>* distances = nullptr) const;
    ProtrusionCheck protrusion(const std::vector<Sphere<2>>& circles,
                               std::vector<double>* distances = nullptr) const;

    /// Distance of each center to that wall, mm; `domain` as built from this source, `distances`
    /// as `protrusion` gave them.
    std::vector<float> depths(const std::vector<Sphere<3>>& spheres, const Domain<3>& domain,
                              const std::vector<double>& distances) const;
    std::vector<float> depths(const std::vector<Sphere<2>>& circles, const Domain<2>& domain,
                              const std::vector<double>& distances) const;

    /// Whether it repeats along some axis.
    bool isPeriodic() const {
        return (space_ && space_->cell().any()) || (plane_ && plane_->cell().any());
    }

    const DomainRecipe& recipe() const { return recipe_; }

private:
    DomainRecipe recipe_;
    SharedMesh mesh_;     ///< of a file, level sets contoured; null: a shape
    bool sound_ = false;  ///< `mesh_` needs no checks
    std::optional<ImageGrid> imageGrid_;
    bool spaced_ = false, sided_ = false;
    std::shared_ptr<const RepairReport> repair_;
    std::shared_ptr<const VdbGrid> levelSet_;  ///< what `mesh_` is the contour of; null: a mesh
    std::shared_ptr<const Domain<3>> space_;   ///< of a shape
    std::shared_ptr<const Domain<2>> plane_;
    std::optional<WallShape<3>> wall3_;  ///< the same for checks
    std::optional<WallShape<2>> wall2_;
    std::vector<HalfSpace<3>> clips_;
    std::vector<std::shared_ptr<const DomainSource>> outsides_;  ///< of what cuts the domain
    void takeCuts();
    void takeShape(const NamedShape& shape);
    void takeSurface(const Callbacks& callbacks);
    void takeMesh(const Callbacks& callbacks);
    FieldOptions fieldOptions(double minRadius, double maxRadius, double voxelSize) const;
    /// `mesh_` with its cavities filled.
    std::shared_ptr<const MeshDomain> meshEnvelope(FieldOptions options,
                                                   const Callbacks& callbacks) const;
    /// That of a domain which clips are to cut; null: what they leave.
    template <int Dim>
    std::shared_ptr<const Domain<Dim>> envelopeOf(
        const std::shared_ptr<const Domain<Dim>>& domain) const;

    Box<3> fileBounds_;
    std::shared_ptr<const MeshAnalysis> analysis_;  ///< of `mesh_`
    double fileVolume() const;                      ///< that `mesh_` encloses, mm³
};

/// The domain of that dimension. Null where it has another.
template <int Dim>
const std::shared_ptr<const Domain<Dim>>& ofDim(const DomainSource::Built& built) {
    if constexpr (Dim == 3)
        return built.space;
    else
        return built.plane;
}

/// Warns of settings that mean nothing to such a domain: units of shapes, grids of meshes.
void warnOfUnused(const DomainRecipe& recipe, const DomainSource& source,
                  const Callbacks& callbacks);

/// Warns of a `voxelSpacing` that nothing is made with, neither an image nor a label map.
/// @param isImage  the recipe names an image, whose file states the distances of its voxels.
void warnOfSpacing(const DomainRecipe& recipe, bool isImage, const Callbacks& callbacks);

/// Warns of a periodic cell that is not the one that the file of a pack states.
/// @param recipe  of `domain`.
template <int Dim>
void warnOfOtherCell(const std::string& pack, const PeriodicCell<Dim>& stated,
                     const DomainRecipe& recipe, const Domain<Dim>& domain,
                     const Callbacks& callbacks);

}  // namespace vdbpack
