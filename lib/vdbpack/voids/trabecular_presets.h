// Published figures of trabecular bone.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// Means of three-dimensional morphometry of human bone; absent: the source does not state it.
struct TrabecularPreset {
    const char* name;
    const char* bone;  ///< what was measured, of how many
    std::optional<double> bvtv;
    std::optional<double> tbth, tbsp;  ///< mm, measured directly (balls)
    std::optional<double> da;          ///< 1 - (short / long)^2
    std::optional<double> connd;       ///< 1/mm³
    const char* source;
};

const std::vector<TrabecularPreset>& trabecularPresets();

/// @throws ParameterError with the known names
const TrabecularPreset& trabecularPreset(const std::string& name);

/// All of them as a table of lines of at most 100 columns.
std::string presetTable();

}  // namespace vdbpack
