// Private to runs: the morphometry of solids, of files or of spheres.
#pragma once

#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/run/run.h"

#include <memory>
#include <vector>

namespace vdbpack {

/// The field of a mesh, of a file or made of an image. @param solid  how it was read
/// @param images  of as many voxels that are made of it. @param voxel  mm; if 0, set to 1/256 of
/// the longest side. @param sound  as `FieldOptions::sound`.
std::shared_ptr<const MeshDomain> fieldOfMesh(TriangleMesh mesh, DomainRecipe solid, double images,
                                              const RunSettings& settings, double& voxel,
                                              const Callbacks& callbacks, bool sound = false);

/// Whether `recipe.pack` is an image, and so a solid.
bool isImageSolid(const MeasureRecipe& recipe);

/// The morphometry of the solid that `recipe.pack` names. @throws as `runMeasure`
MeasureResult measureSolid(const MeasureRecipe& recipe, Report report, const Callbacks& callbacks);

/// The morphometry of the solid that voids leave, a level set named `kSolid` among those of a run,
/// deeper than a shell (mm). @throws ParameterError without such a level set, as `runMeasure`
SolidMeasures measureSolidIn(const std::vector<std::shared_ptr<const VdbGrid>>& levelSets,
                             const DomainRecipe& domain, double shell, const RunSettings& settings,
                             const Callbacks& callbacks);

/// The morphometry of the spheres of a pack as one solid, by `recipe.dilation` and `domain`; null:
/// in the box around them. @throws ParameterError, ResourceError, Interrupted
SphereMorphometry sphereMorphometry(const std::vector<Sphere<3>>& spheres, const Domain<3>* domain,
                                    double meanRadius, const MeasureRecipe& recipe,
                                    const Callbacks& callbacks);

}  // namespace vdbpack
