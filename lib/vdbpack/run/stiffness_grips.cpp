#include "vdbpack/run/stiffness_grips.h"

#include "vdbpack/core/error.h"
#include "vdbpack/run/stiffness_warnings.h"
#include "vdbpack/verify/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace vdbpack {

namespace {

/// The area that spheres hide, seen along an axis, mm².
/// @param counts  whether a sphere is one of them.
template <class Counts>
double shadowOf(const Pack<3>& pack, int axis, double cell, const Counts& counts) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto at = [cell](double x) { return static_cast<std::int64_t>(std::floor(x / cell)); };
    const Box<3> box = boxAround(pack);
    const std::int64_t left = at(box.lo[u]), low = at(box.lo[v]), rows = at(box.hi[v]) - low + 1;
    std::vector<std::uint8_t> hidden(static_cast<std::size_t>((at(box.hi[u]) - left + 1) * rows));
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const Sphere<3>& s = pack.spheres[i];
        if (!counts(i)) continue;
        for (std::int64_t x = at(s.center[u] - s.radius); x <= at(s.center[u] + s.radius); ++x)
            for (std::int64_t y = at(s.center[v] - s.radius); y <= at(s.center[v] + s.radius);
                 ++y) {
                const double dx = (static_cast<double>(x) + 0.5) * cell - s.center[u],
                             dy = (static_cast<double>(y) + 0.5) * cell - s.center[v];
                if (dx * dx + dy * dy <= s.radius * s.radius)
                    hidden[static_cast<std::size_t>((x - left) * rows + y - low)] = 1;
            }
    }
    const auto cells = std::count(hidden.begin(), hidden.end(), std::uint8_t{1});
    return static_cast<double>(cells) * cell * cell;
}

}  // namespace

StiffnessResult::Pressed gripsOn(const StiffnessRecipe& recipe, const Pack<3>& pack, double volume,
                                 const Callbacks& callbacks) {
    constexpr double kCovers = 0.8, kLittle = 0.6, kMostShare = 0.25;
    StiffnessResult::Pressed pressed;
    const int axis = pressed.axis = *recipe.press;
    if (pack.cell.isAlong(axis))
        throw ParameterError(
            fmt::format("`press` {}: the pack is periodic along it, without ends", "xyz"[axis]));
    const Box<3> box = boxAround(pack);
    const double low = pressed.low = box.lo[axis], high = pressed.high = box.hi[axis];
    const double mean = radiusStatistics(pack.spheres).mean;
    pressed.area = volume / (high - low);
    const double whole =
        std::min(pressed.area, shadowOf(pack, axis, mean / 2, [](std::size_t) { return true; }));
    pressed.grip = recipe.grip.value_or(4 * mean);
    for (;; pressed.grip += mean / 2) {
        for (const int end : {0, 1})
            pressed.covers[end] =
                shadowOf(pack, axis, mean / 2,
                         [&](std::size_t i) {
                             return pressed.holds(end, pack.spheres[i].center[axis]);
                         }) /
                whole;
        const bool deepest = pressed.grip + mean / 2 > kMostShare * (high - low);
        if (recipe.grip || deepest || std::min(pressed.covers[0], pressed.covers[1]) >= kCovers)
            break;
    }
    if (const double least = std::min(pressed.covers[0], pressed.covers[1]); least < kLittle)
        callbacks.warn(fmt::format(
            "`press` {}: a grip of {:.4g} mm holds only {:.0f} % of the cross-section at one end, "
            "whose shape then decides the modulus; set a larger `grip`, or `clip` the ends",
            "xyz"[axis], pressed.grip, 100 * least));
    pressed.gauge = high - low - 2 * pressed.grip;
    if (!(pressed.gauge > 2 * mean))
        throw ParameterError(
            fmt::format("`press` {}: the pack is {:.4g} mm long, which leaves nothing between two "
                        "grips of {:.4g} mm; set a smaller `grip`",
                        "xyz"[axis], high - low, pressed.grip));
    return pressed;
}

}  // namespace vdbpack
