// Private to views: what the script of a view reads.
#pragma once

#include "vdbpack/view/view.h"

#include <nlohmann/json.hpp>

#include <vector>

namespace vdbpack {

/// What a view shows, as the script reads it; `words` states what is rounded and left out.
template <int Dim>
nlohmann::ordered_json viewData(const ViewScene<Dim>& scene, const ViewOptions& options);

/// Numbers for the script: each value is `lo` + `step` times a whole number. `data` holds these
/// numbers of 16 bits, or 32 if one needs them, lowest byte first, deflated, in base 64. Whole
/// values in a range of 32 bits are exact (`whole`); others have 65534 steps, and 65535 stands for
/// values that are not finite.
nlohmann::ordered_json packedNumbers(const std::vector<double>& values);

}  // namespace vdbpack
