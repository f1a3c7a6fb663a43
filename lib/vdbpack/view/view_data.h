// Private to views: what the script of a view reads.
#pragma once

#include "vdbpack/view/view.h"

#include <nlohmann/json.hpp>

#include <string>

namespace vdbpack {

/// A view as facts and arrays.
struct ViewData {
    /// Facts for the script: `arrays` lists the zlib streams of `bytes` by name, length and
    /// numbers.
    nlohmann::ordered_json facts;
    std::string bytes;
};

template <int Dim>
ViewData viewData(const ViewScene<Dim>& scene, const ViewOptions& options);

}  // namespace vdbpack
