// What `vdb_pack image` returns, and prints.
#pragma once

#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/image/image_surface.h"
#include "vdbpack/image/label_relations.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

struct ImageResult {
    std::string source, format, type;
    ImageSpace space = ImageSpace::lps;
    ImageGrid grid;
    std::size_t layers = 1;
    double lowest = 0, highest = 0;                 ///< values, of those that are numbers
    std::optional<std::vector<LabelCount>> labels;  ///< nothing: a grey image
    LabelRelations relations;                       ///< of the labels
    std::vector<std::string> warnings;
};

/// Lengths in mm: `format`, `type`, `size`, `spacing`, `orientation`, `space`, `origin`,
/// `directions` (one axis a row), `range`, `labels` (null for grey images), `contacts`.
nlohmann::json toJson(const ImageResult& result);
std::string summary(const ImageResult& result);

}  // namespace vdbpack
