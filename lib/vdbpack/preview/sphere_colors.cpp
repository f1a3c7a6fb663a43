#include "vdbpack/preview/sphere_colors.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace vdbpack {

namespace {

template <int Dim>
const std::vector<double>& numbersOf(const Pack<Dim>& pack, const std::string& name) {
    for (const Column& column : pack.columns)
        if (column.name == name && column.numbers.size() == pack.spheres.size())
            return column.numbers;
    throw ParameterError("`preview.color` " + name +
                         ": there is no such column of numbers; color by radius, region, depth, "
                         "order or a column of the pack");
}

}  // namespace

const std::vector<std::uint32_t>& kindColors() {
    // Colors that most people can tell apart: Okabe, Ito (2008), Color Universal Design.
    static const std::vector<std::uint32_t> colors{0x56b4e9, 0xe69f00, 0x009e73, 0xcc79a7,
                                                   0xf0e442, 0x0072b2, 0xd55e00, 0x999999};
    return colors;
}

bool areKinds(const std::vector<double>& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](double v) {
        return v >= 0 && v < static_cast<double>(kindColors().size()) && v == std::floor(v);
    });
}

const std::vector<std::uint32_t>& regionColors() {
    static const std::vector<std::uint32_t> colors{0x4a78a8, 0xf0d9a0};
    return colors;
}

template <int Dim>
SphereColors sphereColors(const Pack<Dim>& pack, PreviewColor by, const std::string& column) {
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
        const Color cortical = fromSrgb(regionColors()[0]),
                    trabecular = fromSrgb(regionColors()[1]);
        for (std::size_t i = 0; i < n; ++i)
            colors.color[i] = pack.region.empty() || pack.region[i] == 0 ? cortical : trabecular;
        colors.words = "colored by region, cortical blue, trabecular sand";
        return colors;
    }
    const std::vector<double>* numbers =
        by == PreviewColor::column ? &numbersOf(pack, column) : nullptr;
    if (numbers && areKinds(*numbers)) {
        for (std::size_t i = 0; i < n; ++i)
            colors.color[i] = fromSrgb(kindColors()[static_cast<std::size_t>((*numbers)[i])]);
        colors.words = "colored by " + column;
        return colors;
    }
    const char* name = by == PreviewColor::radius  ? "radius"
                       : by == PreviewColor::depth ? "depth"
                       : numbers                   ? column.c_str()
                                                   : "order";
    if (by == PreviewColor::depth) require(pack.depth.size(), name);
    if (by == PreviewColor::order) require(pack.order.size(), name);
    const auto value = [&](std::size_t i) {
        return numbers                      ? (*numbers)[i]
               : by == PreviewColor::radius ? pack.spheres[i].radius
               : by == PreviewColor::depth  ? static_cast<double>(pack.depth[i])
                                            : static_cast<double>(pack.order[i]);
    };
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (std::size_t i = 0; i < n; ++i)
        if (std::isfinite(value(i))) {
            lo = std::min(lo, value(i));
            hi = std::max(hi, value(i));
        }
    if (!(lo <= hi)) lo = hi = 0;
    // All values are equal up to rounding: the middle of the ramp.
    const bool one = !(hi - lo > 1e-9 * std::fabs(hi));
    for (std::size_t i = 0; i < n; ++i)
        colors.color[i] = rampColor(one                       ? 0.5
                                    : std::isfinite(value(i)) ? (value(i) - lo) / (hi - lo)
                                                              : 0);
    const char* unit = by == PreviewColor::order || numbers ? "" : " mm";
    colors.words = one ? fmt::format("colored by {}, {:.4g}{}", name, lo, unit)
                       : fmt::format("colored by {}, {:.4g} to {:.4g}{} from dark to light", name,
                                     lo, hi, unit);
    return colors;
}

template SphereColors sphereColors<2>(const Pack<2>&, PreviewColor, const std::string&);
template SphereColors sphereColors<3>(const Pack<3>&, PreviewColor, const std::string&);

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
