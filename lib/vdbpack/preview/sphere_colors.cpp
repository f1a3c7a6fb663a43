#include "vdbpack/preview/sphere_colors.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

template <int Dim>
const Column& columnNamed(const Pack<Dim>& pack, const std::string& name) {
    const Column* const column = columnOfNumbers(pack, name.c_str());
    if (column && column->numbers.size() == pack.spheres.size()) return *column;
    std::string others;
    for (const Column& other : pack.columns)
        if (!other.numbers.empty()) others += ", " + other.name;
    throw ParameterError("`preview.color` " + name +
                         ": there is no such column of numbers; color by one of radius, region, "
                         "depth, order" +
                         others);
}

/// A color for each kind; the legend lists the kinds that occur.
/// @param kind  the kind of sphere i, from 0.
template <class Kind>
SphereColors colorsOfKinds(std::size_t n, const Kind& kind, const std::vector<std::uint32_t>& rgb,
                           const std::vector<std::string>& names) {
    std::vector<Legend::Kind> kinds;
    for (std::size_t k = 0; k < rgb.size(); ++k) kinds.push_back({names[k], fromSrgb(rgb[k])});
    std::vector<bool> occurs(rgb.size());
    SphereColors colors;
    colors.color.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
        occurs[kind(i)] = true;
        colors.color.push_back(kinds[kind(i)].color);
    }
    for (std::size_t k = 0; k < rgb.size(); ++k)
        if (occurs[k]) colors.legend.kinds.push_back(kinds[k]);
    return colors;
}

/// Where a color lies for the eye: Oklab, Ottosson (2020).
Vec<3> perceived(std::uint32_t rgb) {
    const Color c = fromSrgb(rgb);
    const double l = std::cbrt(0.4122214708 * c.r + 0.5363325363 * c.g + 0.0514459929 * c.b);
    const double m = std::cbrt(0.2119034982 * c.r + 0.6806995451 * c.g + 0.1073969566 * c.b);
    const double s = std::cbrt(0.0883024619 * c.r + 0.2817188376 * c.g + 0.6299787005 * c.b);
    return {{0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
             1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
             0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s}};
}

/// How many kinds the numbers of a column are; 0: they are no kinds.
std::size_t kindsIn(const Column& column) {
    if (areKinds(column.numbers)) return std::max(kFewKinds, column.names.size());
    return areKinds(column.numbers, std::min(kMostKinds, column.names.size())) ? column.names.size()
                                                                               : 0;
}

/// The name of a column with the unit in it set off: "density, kg/m3" of "density_kg_m3".
std::string titleOf(const std::string& column) {
    for (const auto& [end, unit] : {std::pair("_kg_m3", ", kg/m3"), std::pair("_MPa", ", MPa")})
        if (endsWith(column, end)) return column.substr(0, column.rfind(end)) + unit;
    return column;
}

/// Three digits, and all digits before the point.
std::string shortNumber(double value) {
    const double size = std::fabs(value);
    return fmt::format(size >= 100 && size < 1e7 ? "{:.0f}" : "{:.3g}", value);
}

/// Colors from dark to light.
/// @param value  of sphere i. @param unit  empty: it is a number, or part of the name.
template <class Value>
SphereColors colorsOfRamp(std::size_t n, const Value& value, const std::string& name,
                          const std::string& unit) {
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (std::size_t i = 0; i < n; ++i)
        if (std::isfinite(value(i))) {
            lo = std::min(lo, value(i));
            hi = std::max(hi, value(i));
        }
    if (!(lo <= hi)) lo = hi = 0;
    // All values are equal up to rounding: the middle of the ramp.
    const bool one = !(hi - lo > 1e-9 * std::fabs(hi));
    SphereColors colors;
    colors.color.resize(n);
    for (std::size_t i = 0; i < n; ++i)
        colors.color[i] = rampColor(one                       ? 0.5
                                    : std::isfinite(value(i)) ? (value(i) - lo) / (hi - lo)
                                                              : 0);
    const std::string after = unit.empty() ? "" : " " + unit;
    Legend& legend = colors.legend;
    if (one) {
        legend.kinds = {{name + " " + shortNumber(lo) + after, rampColor(0.5)}};
        legend.words = fmt::format("colored by {}, {:.4g}{}", name, lo, after);
    } else {
        legend.title = unit.empty() ? titleOf(name) : name + ", " + unit;
        legend.ends = {shortNumber(lo), shortNumber(hi)};
        legend.words = fmt::format("colored by {}, {:.4g} to {:.4g}{} from dark to light", name, lo,
                                   hi, after);
    }
    return colors;
}

}  // namespace

std::vector<std::uint32_t> kindColors(std::size_t count) {
    // Colors that most people can tell apart: Okabe, Ito (2008), Color Universal Design.
    std::vector<std::uint32_t> colors{0x56b4e9, 0xe69f00, 0x009e73, 0xcc79a7,
                                      0xf0e442, 0x0072b2, 0xd55e00, 0x999999};
    // Then each is the candidate farthest from all before, and from white paper and black lines.
    constexpr std::uint32_t kLevels = 9, kStep = 0x1e;
    constexpr double kDarkest = 0.35;  // in the shade of a sphere the hue is still seen
    std::vector<std::pair<std::uint32_t, double>> candidates;
    for (std::uint32_t n = 0; n < kLevels * kLevels * kLevels && count > colors.size(); ++n) {
        const std::uint32_t rgb = n % kLevels * kStep << 16 | n / kLevels % kLevels * kStep << 8 |
                                  n / kLevels / kLevels * kStep;
        if (perceived(rgb)[0] > kDarkest)
            candidates.emplace_back(rgb, std::numeric_limits<double>::infinity());
    }
    const auto add = [&](std::uint32_t color) {
        for (auto& [rgb, away] : candidates)
            away = std::min(away, length(perceived(rgb) - perceived(color)));
    };
    for (const std::uint32_t color : {0xffffffu, 0x000000u}) add(color);
    for (const std::uint32_t color : colors) add(color);
    while (colors.size() < std::min(count, kMostKinds)) {
        colors.push_back(
            std::max_element(candidates.begin(), candidates.end(),
                             [](const auto& x, const auto& y) { return x.second < y.second; })
                ->first);
        add(colors.back());
    }
    const std::size_t different = colors.size();
    colors.resize(count);
    for (std::size_t k = different; k < count; ++k) colors[k] = colors[k % different];
    return colors;
}

bool areKinds(const std::vector<double>& numbers, std::size_t most) {
    return std::all_of(numbers.begin(), numbers.end(), [&](double v) {
        return v >= 0 && v < static_cast<double>(most) && v == std::floor(v);
    });
}

const std::vector<std::uint32_t>& regionColors() {
    static const std::vector<std::uint32_t> colors{0x4a78a8, 0xf0d9a0};
    return colors;
}

PreviewOptions withColor(PreviewOptions options, const PackAttributes& pack) {
    if (options.color != PreviewColor::chosen) return options;
    options.color = PreviewColor::radius;
    const Column* part = columnOfNumbers(pack, kPartColumn);
    if (!part || part->numbers.empty() || kindsIn(*part) == 0) return options;
    const auto [least, most] = std::minmax_element(part->numbers.begin(), part->numbers.end());
    if (*least == *most) return options;
    options.color = PreviewColor::column;
    options.column = kPartColumn;
    return options;
}

template <int Dim>
SphereColors sphereColors(const Pack<Dim>& pack, const PreviewOptions& asked) {
    const PreviewOptions options = withColor(asked, pack);
    const std::size_t n = pack.spheres.size();
    const PreviewColor by = options.color;
    const auto require = [&](std::size_t have, const char* name) {
        if (have != n)
            throw ParameterError(
                fmt::format("`preview.color` {}: {} of {} {} have it; color by radius", name, have,
                            n, Measure<Dim>::kSpheres));
    };
    if (by == PreviewColor::region) {
        // As in files: a pack without regions is all cortical.
        if (!pack.region.empty()) require(pack.region.size(), "region");
        SphereColors colors = colorsOfKinds(
            n, [&](std::size_t i) { return pack.region.empty() || pack.region[i] == 0 ? 0u : 1u; },
            regionColors(), {"cortical", "trabecular"});
        colors.legend.words = "colored by region, cortical blue, trabecular sand";
        return colors;
    }
    if (by == PreviewColor::column) {
        const Column& column = columnNamed(pack, options.column);
        const auto& numbers = column.numbers;
        const auto value = [&](std::size_t i) { return numbers[i]; };
        const std::size_t kinds = kindsIn(column);
        if (kinds == 0) return colorsOfRamp(n, value, options.column, "");
        std::vector<std::string> names = column.names;
        for (std::size_t k = names.size(); k < kinds; ++k) names.push_back(std::to_string(k));
        SphereColors colors = colorsOfKinds(
            n, [&](std::size_t i) { return static_cast<std::size_t>(numbers[i]); },
            kindColors(kinds), names);
        colors.legend.title = options.column;
        colors.legend.words = "colored by " + options.column;
        for (std::size_t k = 0; k < colors.legend.kinds.size(); ++k)
            colors.legend.words += (k == 0 ? ": " : ", ") + colors.legend.kinds[k].name;
        return colors;
    }
    if (by == PreviewColor::depth) {
        require(pack.depth.size(), "depth");
        const auto depth = [&](std::size_t i) { return static_cast<double>(pack.depth[i]); };
        return colorsOfRamp(n, depth, "depth", "mm");
    }
    if (by == PreviewColor::order) {
        require(pack.order.size(), "order");
        const auto order = [&](std::size_t i) { return static_cast<double>(pack.order[i]); };
        return colorsOfRamp(n, order, "order", "");
    }
    const auto radius = [&](std::size_t i) { return pack.spheres[i].radius; };
    return colorsOfRamp(n, radius, "radius", "mm");
}

template SphereColors sphereColors<2>(const Pack<2>&, const PreviewOptions&);
template SphereColors sphereColors<3>(const Pack<3>&, const PreviewOptions&);

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
