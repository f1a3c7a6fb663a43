// Where a file is placed in the world of a run.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/image/image_grid.h"

#include <array>

namespace vdbpack {

/// An affine map of space, mm.
struct AffineMap {
    std::array<Vec<3>, 3> rows{{{{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}}};
    Vec<3> shift;

    Vec<3> turned(const Vec<3>& v) const {
        return {{dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}};
    }
    Vec<3> operator()(const Vec<3>& x) const { return turned(x) + shift; }
    double determinant() const { return dot(rows[0], cross(rows[1], rows[2])); }
};

/// The map of a recipe's pose, in its world: `matrix` or `transform`, then `rotate`, then
/// `translate`.
///
/// Files of ITK map points of the fixed image to points of the moving one, in LPS; what is moved is
/// in the moving one, so that the inverse is applied, as 3D Slicer does with a model.
/// Source: https://slicer.readthedocs.io/en/latest/developer_guide/modules/transforms.html
/// Warns of a map that changes lengths, shears or mirrors.
/// @throws ParameterError, InputError for a map that flattens, or another kind of file; IoError
AffineMap poseMap(const DomainRecipe& recipe, const Callbacks& callbacks);

/// Places a mesh in mm, its triangles flipped by mirrors; an image; as they are without a pose.
/// @throws as `poseMap`
void place(TriangleMesh& mesh, const DomainRecipe& recipe, const Callbacks& callbacks);
void place(ImageGrid& grid, const DomainRecipe& recipe, const Callbacks& callbacks);

}  // namespace vdbpack
