#include "vdbpack/formats/sphere_density.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

/// A positive number; 0 for any other text.
double positiveIn(std::string_view text) {
    double value = 0;
    return parseReal(text, value) && value > 0 && std::isfinite(value) ? value : 0;
}

/// "0=1900,1=1100"; nothing for any other text.
std::optional<std::map<std::int32_t, double>> densitiesByRegion(std::string_view text) {
    std::map<std::int32_t, double> densities;
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t end = std::min(text.find(',', at), text.size());
        const std::string_view entry = text.substr(at, end - at);
        at = end + 1;
        const std::size_t equals = std::min(entry.find('='), entry.size());
        std::int64_t region = 0;
        const double density = equals < entry.size() ? positiveIn(entry.substr(equals + 1)) : 0;
        if (!(density > 0) || !parseNumber(entry.substr(0, equals), region) ||
            region != static_cast<std::int32_t>(region) ||
            !densities.emplace(static_cast<std::int32_t>(region), density).second)
            return std::nullopt;
    }
    return densities;
}

}  // namespace

SphereDensity particleDensity(const std::string& text, std::optional<double> solidFraction) {
    if (text.empty()) return {};
    constexpr std::string_view kBulk = "bulk:";
    if (text.find('=') != std::string::npos)
        if (auto densities = densitiesByRegion(text)) return {0, *std::move(densities)};
    const bool isBulk = startsWith(text, kBulk);
    const double value = positiveIn(isBulk ? text.substr(kBulk.size()) : text);
    if (!(value > 0))
        throw ParameterError(fmt::format(
            "`density` '{}': write the density of the spheres in kg/m³ (1900), one for each region "
            "(0=1900,1=1100), or bulk:D with the mass of all spheres divided by the volume of the "
            "domain (bulk:1100)",
            text));
    if (!isBulk) return {value, {}};
    if (!solidFraction)
        throw ParameterError(fmt::format(
            "`density` {}: a bulk density is that of a domain; give one with `domain`", text));
    if (!(*solidFraction > 0))
        throw ParameterError(
            fmt::format("`density` {}: no sphere lies in the domain to carry its mass", text));
    return {value / *solidFraction, {}};
}

void checkDensity(const std::string& text) {
    particleDensity(text, 1.0);
}

void warnOfDensity(const std::string& text, const std::string& part, const Callbacks& callbacks) {
    // kg/m³: lighter than the emptiest bone, heavier than platinum
    constexpr double kLeast = 20, kMost = 22000;
    const SphereDensity density = particleDensity(text, 1.0);
    double least = density.all > 0 ? density.all : kLeast, most = density.all;
    for (const auto& [region, value] : density.ofRegions) {
        least = std::min(least, value);
        most = std::max(most, value);
    }
    const std::string of = part.empty() ? "" : part + ": ";
    const bool inTonnes = least < 1e-6;
    if (least < kLeast)
        callbacks.warn(fmt::format(
            "{}`density` {}: {:g} kg/m³ is lighter than any bone; if it is "
            "in {}, give {:g}",
            of, text, least, inTonnes ? "t/mm³" : "g/cm³", (inTonnes ? 1e12 : 1000) * least));
    if (most > kMost)
        callbacks.warn(
            fmt::format("{}`density` {}: {:g} kg/m³ is heavier than any metal; bone has some 1,000 "
                        "to 2,000, titanium 4,430. If it is in g/m³, give {:g}",
                        of, text, most, most / 1000));
}

void warnOfMissingDensities(const PackAttributes& pack,
                            const std::map<std::int32_t, double>& densities,
                            const Callbacks& callbacks) {
    if (densities.empty()) return;
    if (Materials(pack).hasParts()) return;
    std::set<std::int32_t> missing(pack.region.begin(), pack.region.end());
    if (missing.empty()) missing.insert(0);
    std::set<std::int32_t> unused;
    for (const auto& [region, density] : densities)
        if (missing.erase(region) == 0) unused.insert(region);
    if (!unused.empty())
        callbacks.warn(
            fmt::format("`density` of region {} has no effect: {}", fmt::join(unused, ", "),
                        pack.region.empty() ? "the spheres have no regions and count as region 0"
                                            : "no sphere is in it"));
    if (!missing.empty())
        callbacks.warn(fmt::format(
            "`density` has none for region {}: its spheres have {:g} kg/m³. Give one for each "
            "region, such as 0=1900,1=1100",
            fmt::join(missing, ", "), kDefaultDensity));
}

}  // namespace vdbpack
