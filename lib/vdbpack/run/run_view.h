// Pages that show a pack.
#pragma once

#include "vdbpack/run/run.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// The whole of `vdb_pack view` but for opening the page. The pack is neither judged nor measured.
/// @throws ParameterError, InputError, IoError, ResourceError
ViewResult runView(const ViewRecipe& recipe, const Callbacks& callbacks = {});

nlohmann::ordered_json toJson(const ViewResult& result);
/// For people; ends with a newline.
std::string summary(const ViewResult& result);

}  // namespace vdbpack
