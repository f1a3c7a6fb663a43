// What `vdb_pack image` returns, and prints.
#pragma once

#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/image/image_surface.h"
#include "vdbpack/image/label_relations.h"
#include "vdbpack/image/value_histogram.h"
#include "vdbpack/image/voxel_axes.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

struct ImageResult {
    std::string source, format, type;
    ImageSpace space = ImageSpace::lps;
    bool isSided = true;  ///< whether it says which sides of a patient its axes point to
    ImageGrid grid;
    std::size_t layers = 1;
    double lowest = 0, highest = 0;                 ///< values, of those that are numbers
    std::optional<std::vector<LabelCount>> labels;  ///< nothing: a grey image
    LabelRelations relations;                       ///< of the labels
    std::vector<VoxelSolid> solids;                 ///< one a label
    ValueHistogram histogram;                       ///< of a grey image; else without bins
    /// What a threshold takes of the image: the requested one, and Otsu's of a grey image.
    struct Taken {
        Threshold threshold;
        VoxelSolid solid;
    };
    std::vector<Taken> taken;
    bool isRequested = false;  ///< whether the first of them was
    std::vector<std::string> warnings;
};

/// Lengths in mm: `format`, `type`, `size`, `spacing`, `orientation` (null: unknown), `space`,
/// `origin`, `directions` (one axis a row), `range`, `labels` (null for grey images), `contacts`,
/// `histogram` (null for label maps), `thresholds`.
nlohmann::json toJson(const ImageResult& result);
std::string summary(const ImageResult& result);

}  // namespace vdbpack
