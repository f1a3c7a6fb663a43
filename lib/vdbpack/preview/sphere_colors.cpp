#include "vdbpack/preview/sphere_colors.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdbpack {

template <int Dim>
SphereColors sphereColors(const Pack<Dim>& pack, PreviewColor by) {
    const std::size_t n = pack.spheres.size();
    const auto require = [&](std::size_t have, const char* name) {
        if (have != n)
            throw ParameterError(
                fmt::format("`preview.color` {}: {} of {} {} have it; color by radius", name, have,
                            n, Measure<Dim>::kSpheres));
    };
    SphereColors colors;
    colors.color.resize(n);
    if (by == PreviewColor::region) {
        // As in files: a pack without regions is all cortical.
        if (!pack.region.empty()) require(pack.region.size(), "region");
        const Color cortical = fromSrgb(0x4a78a8), trabecular = fromSrgb(0xf0d9a0);
        for (std::size_t i = 0; i < n; ++i)
            colors.color[i] = pack.region.empty() || pack.region[i] == 0 ? cortical : trabecular;
        colors.words = "colored by region, cortical blue, trabecular sand";
        return colors;
    }
    const char* name = by == PreviewColor::radius  ? "radius"
                       : by == PreviewColor::depth ? "depth"
                                                   : "order";
    if (by == PreviewColor::depth) require(pack.depth.size(), name);
    if (by == PreviewColor::order) require(pack.order.size(), name);
    const auto value = [&](std::size_t i) {
        return by == PreviewColor::radius  ? pack.spheres[i].radius
               : by == PreviewColor::depth ? static_cast<double>(pack.depth[i])
                                           : static_cast<double>(pack.order[i]);
    };
    double lo = n > 0 ? value(0) : 0, hi = lo;
    for (std::size_t i = 1; i < n; ++i) {
        lo = std::min(lo, value(i));
        hi = std::max(hi, value(i));
    }
    // All values are equal up to rounding: the middle of the ramp.
    const bool one = !(hi - lo > 1e-9 * std::fabs(hi));
    for (std::size_t i = 0; i < n; ++i)
        colors.color[i] = rampColor(one ? 0.5 : (value(i) - lo) / (hi - lo));
    const char* unit = by == PreviewColor::order ? "" : " mm";
    colors.words = one ? fmt::format("colored by {}, {:.4g}{}", name, lo, unit)
                       : fmt::format("colored by {}, {:.4g} to {:.4g}{} from dark to light", name,
                                     lo, hi, unit);
    return colors;
}

template SphereColors sphereColors<2>(const Pack<2>&, PreviewColor);
template SphereColors sphereColors<3>(const Pack<3>&, PreviewColor);

Color boneColor() {
    static const Color color = fromSrgb(0xece2cf);
    return color;
}

Color boneCutColor() {
    static const Color color = fromSrgb(0xd3a078);
    return color;
}

Color inkColor() {
    static const Color color = fromSrgb(0x2b3440);
    return color;
}

}  // namespace vdbpack
