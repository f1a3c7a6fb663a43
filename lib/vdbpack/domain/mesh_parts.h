// The parts of one mesh.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <string>
#include <vector>

namespace vdbpack {

struct NamedMesh {
    std::string name;
    TriangleMesh mesh;
};

/// The parts of the mesh that `domain` names, in mm: 2 to 100, by the names of triangles in its
/// file, or its connected components by decreasing volume (`domain.partsBy`).
/// @throws ParameterError for an image; InputError for another number of parts, for a component
///         inside another one, and as `readMesh`
std::vector<NamedMesh> meshParts(const DomainRecipe& domain, const Callbacks& callbacks);

}  // namespace vdbpack
