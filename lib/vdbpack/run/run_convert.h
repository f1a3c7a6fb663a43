// Packs, level sets and meshes from one format to another.
#pragma once

#include "vdbpack/run/run.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// The whole of `vdb_pack convert`. Packs are neither judged nor changed; solids (a level set, a
/// mesh) become level sets, fog or surfaces, and a mesh as .stl stays the mesh that it is.
/// @throws ParameterError (no output, an output that is an input or that there is nothing for),
/// InputError, IoError, ResourceError
ConvertResult runConvert(const ConvertRecipe& recipe, const Callbacks& callbacks = {});

nlohmann::ordered_json toJson(const ConvertResult& result);
/// For people; ends with a newline.
std::string summary(const ConvertResult& result);

}  // namespace vdbpack
