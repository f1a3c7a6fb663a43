// Private to previews and views: the colors of spheres, bones and outlines.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/preview/color.h"
#include "vdbpack/preview/preview.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// What colors mean.
struct Legend {
    struct Kind {
        std::string name;
        Color color;
    };
    std::string title;                ///< "part" or "radius, mm"; empty: none, and no ramp
    std::vector<Kind> kinds;          ///< each with a color of its own; empty: a ramp or nothing
    std::size_t more = 0;             ///< further kinds, for which there is no room
    std::array<std::string, 2> ends;  ///< numbers at the dark and the light end of the ramp
    std::string words;                ///< "colored by radius, 1 to 2 mm from dark to light"
};
/// The colors of the spheres of a pack.
struct SphereColors {
    std::vector<Color> color;  ///< one per sphere
    Legend legend;
};
/// The same with the attribute for `PreviewColor::chosen`.
PreviewOptions withColor(PreviewOptions options, const PackAttributes& pack);

/// Columns of few whole numbers from 0, or with names, such as `part`, have colors that are easy
/// to tell apart.
/// @throws ParameterError if the pack lacks the attribute that `options` names.
template <int Dim>
SphereColors sphereColors(const Pack<Dim>& pack, const PreviewOptions& options);

/// 0xRRGGBB of sRGB, as different as so many colors can be; the first eight are always the same.
std::vector<std::uint32_t> kindColors(std::size_t count);
/// Whether numbers are whole, from 0, and below `most`.
inline constexpr std::size_t kFewKinds = 8, kMostKinds = 256;
bool areKinds(const std::vector<double>& numbers, std::size_t most = kFewKinds);
/// 0xRRGGBB of sRGB: cortical, trabecular.
const std::vector<std::uint32_t>& regionColors();

/// The color of bone, and of bone on a cut face.
Color boneColor();
Color boneCutColor();
/// The color of outlines.
Color inkColor();

}  // namespace vdbpack
