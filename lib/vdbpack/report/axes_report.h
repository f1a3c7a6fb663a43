// Principal axes in reports.
#pragma once

#include "vdbpack/core/principal_axes.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace vdbpack {

/// `center`, `axes` (unit vectors, one a row), `lengths`; mm.
nlohmann::json toJson(const PrincipalAxes<3>& axes);
/// For people: the center, then each axis with its length.
std::vector<std::string> linesOf(const PrincipalAxes<3>& axes);

}  // namespace vdbpack
