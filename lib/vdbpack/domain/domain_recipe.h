// What DOMAIN and the options about it say.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/units.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/repair/mesh_repair.h"

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

struct Callbacks;
struct Image;
class VdbGrid;

/// What the thickness of a shell is measured from: all walls of the domain, or the outer surface
/// alone, without the walls of cavities and clips.
enum class ShellFrom { walls, outer };

/// A part of space that is kept.
struct Clip {
    std::string text;                  ///< as `parseClip` reads it
    std::vector<HalfSpace<3>> planes;  ///< whose intersection it is, mm
};

/// What lies inside closed components of the surface that are inside others: nothing, the same as
/// around them (`fill`), or `outer` (empty: the mesh of the domain) without the inside of `inner`.
struct Cavities {
    bool fill = false;
    std::string outer, inner;  ///< files; empty: none

    bool any() const { return fill || !inner.empty(); }
};

/// How a file is moved into the world of a run, after its unit and scale: by a matrix or the file
/// of one, then turned, then shifted.
struct Pose {
    std::string file;            ///< text file of a transform of ITK (.tfm); empty: none
    std::vector<double> matrix;  ///< 3 or 4 rows of 4 numbers, the shift in mm; empty: none
    /// Direction of an axis, degrees (right-handed), and a point of the axis, mm; empty: none.
    std::vector<double> rotate;
    std::optional<Vec<3>> translate;  ///< mm

    bool any() const {
        return !file.empty() || !matrix.empty() || !rotate.empty() || translate.has_value();
    }
};

/// Whether there is one domain, or parts: of a mesh by names in its file, or its connected
/// components; or one pack over several labels of an image, the part of a sphere by its center.
enum class PartsBy { none, group, component, center };

/// From which value on an image is taken.
struct Threshold {
    std::optional<double> value;  ///< nothing: of Otsu's method, not found yet
    /// Otsu's of the values from this on, -infinity for all; nothing: it was given as a number.
    std::optional<double> otsuFrom;

    Threshold(double given) : value(given) {}
    static Threshold otsu(double from = -std::numeric_limits<double>::infinity());
    /// otsu or otsu:LEAST. @throws ParameterError
    static Threshold parse(const std::string& text);
    std::string text() const;  ///< as it was given

    /// With its value, found unless it is known. Warns of one that seems to part air from tissue in
    /// HU. @param path for messages. @throws InputError if the image has no two different values
    Threshold of(const Image& image, const std::string& path, const Callbacks& callbacks) const;

private:
    Threshold() = default;
};

/// What DOMAIN and the options about it say.
struct DomainRecipe {
    /// A file (.stl .obj .ply .off .gts .vtp .vtk .vdb), an image (`namesImage`) or a shape:
    /// box:LX,LY,LZ  box:x0,y0,z0,x1,y1,z1 ball:R cylinder:R,H  rect:W,H  rect:x0,y0,x1,y1  disc:R
    /// (mm, centered at the origin), periodic:LX,LY,LZ or periodic:LX,LY.
    std::string source;
    /// What a program has in memory, in place of the file that `source` names in messages; at most
    /// one of them, lengths in `unit`.
    std::shared_ptr<const TriangleMesh> mesh;
    std::shared_ptr<const Image> image;
    std::shared_ptr<const VdbGrid> levelSet;  ///< in mm whatever the unit
    Unit unit = Unit::millimeter;             ///< of the file
    double scale = 1;                         ///< further factor on the file's lengths
    Pose pose;
    std::string gridName;  ///< level set in a .vdb; empty: the first
    /// Value at the surface, of a fog volume in a .vdb or of an image.
    std::optional<Threshold> threshold;
    std::string label;  ///< of an image: a value or a name, or several joined by "+"
    /// LABEL=FILE: only the voxels of a label map whose centers lie in that label of another one.
    std::string mask;
    /// Distances of the voxels of an image that states none, else of label maps that are written,
    /// mm; nothing: the distances that the image states.
    std::optional<Vec<3>> voxelSpacing;
    ImageSpace space = ImageSpace::lps;  ///< of images, and of meshes that state theirs
    std::optional<double> slice;         ///< height z of a plane of the domain, mm; nothing: all
    std::vector<Clip> clips;             ///< only what lies in all of them is kept
    std::array<bool, 3> periodic{};      ///< axes along which a box or rectangle repeats
    double voxelSize = 0;                ///< mm; 0: chosen
    bool repair = false;                 ///< the mesh, by repair/mesh_repair.h
    double repairVoxel = 0;              ///< mm; 0: chosen
    RepairComponents repairComponents = RepairComponents::together;
    Cavities cavities;
    ShellFrom shellFrom = ShellFrom::walls;
    PartsBy partsBy = PartsBy::none;  ///< where a recipe may have several parts
};

/// Whether a domain comes from an image, a file or in memory.
bool isImage(const DomainRecipe& recipe);
/// Whether it is no file.
inline bool isInMemory(const DomainRecipe& recipe) {
    return recipe.mesh || recipe.image || recipe.levelSet;
}

/// The file, label or shape of a recipe, for people.
std::string describe(const DomainRecipe& recipe);

}  // namespace vdbpack
