// Private to previews and views: the colors of spheres, bones and outlines.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/preview/color.h"
#include "vdbpack/preview/preview.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// The colors of the spheres of a pack.
struct SphereColors {
    std::vector<Color> color;  ///< one per sphere
    std::string words;         ///< "colored by radius, 1 to 2 mm from dark to light"
};
/// Columns of few whole numbers from 0, such as `part`, have colors that are easy to tell apart.
/// @param column  name of it, for PreviewColor::column.
/// @throws ParameterError if the pack lacks the attribute.
template <int Dim>
SphereColors sphereColors(const Pack<Dim>& pack, PreviewColor by, const std::string& column);

/// 0xRRGGBB of sRGB, for columns of few whole numbers from 0; and whether numbers are such.
const std::vector<std::uint32_t>& kindColors();
bool areKinds(const std::vector<double>& numbers);
/// 0xRRGGBB of sRGB: cortical, trabecular.
const std::vector<std::uint32_t>& regionColors();

/// The color of bone, and of bone on a cut face.
Color boneColor();
Color boneCutColor();
/// The color of outlines.
Color inkColor();

}  // namespace vdbpack
