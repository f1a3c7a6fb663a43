// Pages that show a pack.
#pragma once

#include "vdbpack/run/run.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// `pack` is shown, and with `domain.source` the wall of that domain. `reportFile` is the page
/// (empty: NAME.view.html in the current folder, with the name of the pack's file);
/// `preview.cut`, `preview.color` and `preview.column` are those of the view at first. `outputs`,
/// `preview.file` and `radius` are not used.
struct ViewRecipe : InputPack {};

struct ViewResult {
    std::string kind;         ///< "spheres" or "circles"
    std::uint64_t count = 0;  ///< of the pack
    std::string file;         ///< the page
    std::uint64_t bytes = 0;  ///< of it
    std::vector<std::string> warnings;
};

/// The whole of `vdb_pack view` but for opening the page. The pack is neither judged nor measured.
/// @throws ParameterError, InputError, IoError, ResourceError
ViewResult runView(const ViewRecipe& recipe, const Callbacks& callbacks = {});

nlohmann::ordered_json toJson(const ViewResult& result);
/// For people; ends with a newline.
std::string summary(const ViewResult& result);

}  // namespace vdbpack
