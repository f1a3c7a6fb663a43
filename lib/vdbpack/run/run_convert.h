// Packs, level sets and meshes from one format to another.
#pragma once

#include "vdbpack/run/run.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// `pack` is what is converted, `packGrid` the point grid or level set in a .vdb. With
/// `domain.source` level sets and surface of that domain can be written beside the spheres;
/// `domain.voxelSize` is also that of the level set made of a mesh. `outputs` or a picture are
/// required; `radius` and `reportFile` are not used.
struct ConvertRecipe : InputPack {};

struct ConvertResult {
    std::string kind;         ///< "spheres", "circles", "level set" or "mesh"
    std::uint64_t count = 0;  ///< spheres, circles or triangles; of a level set 0
    std::uint64_t hash = 0;   ///< of a pack, in mm
    std::vector<std::string> files, warnings;
};

/// The whole of `vdb_pack convert`. Packs are neither judged nor changed; solids (a level set, a
/// mesh) become level sets, fog or surfaces, and a mesh as .stl stays the mesh that it is.
/// @throws ParameterError (no output, an output that is an input or that there is nothing for),
/// InputError, IoError, ResourceError
ConvertResult runConvert(const ConvertRecipe& recipe, const Callbacks& callbacks = {});

nlohmann::ordered_json toJson(const ConvertResult& result);
/// For people; ends with a newline.
std::string summary(const ConvertResult& result);

}  // namespace vdbpack
