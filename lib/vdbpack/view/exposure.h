// Private to views: which spheres of a pack can be seen, from outside or where it is cut.
#pragma once

#include "vdbpack/core/sphere.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// How a sphere comes into sight.
enum class Exposure : std::uint8_t {
    outer,   ///< near the space around the pack, or a void open to it
    inner,   ///< near a closed void
    buried,  ///< only where a cut passes close by
};

/// The radius that sets how far one looks into a pack, mm: sum of cubes / sum of squares. The mean
/// free path of a line of sight between spheres is 4/3 of it times void fraction / solid fraction.
double opticalRadius(const std::vector<Sphere<3>>& spheres);

/// Depth in optical radii beyond which a pack of solid fraction 0.6 hides what lies deeper, but for
/// a share of about e^-5.
inline constexpr double kOpticalDepth = 4.5;

/// One value a sphere. A space counts as void where no sphere is within 0.8 optical radii.
///
/// Cost: 30 cells a sphere are marked; at most 16 million cells, a byte each.
std::vector<Exposure> exposureOf(const std::vector<Sphere<3>>& spheres);

}  // namespace vdbpack
