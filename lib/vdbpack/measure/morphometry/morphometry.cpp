#include "vdbpack/measure/morphometry/morphometry.h"

#include "vdbpack/core/error.h"
#include "vdbpack/measure/morphometry/euler.h"
#include "vdbpack/measure/morphometry/local_thickness.h"
#include "vdbpack/measure/morphometry/mean_intercept.h"
#include "vdbpack/measure/morphometry/surface_distance.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kDirections = 500;
/// Along which lines from voxel to voxel are laid.
constexpr int kVoxelDirections = 100;

void check(const VoxelImage& image) {
    if (!(image.voxelSize > 0) || !std::isfinite(image.voxelSize))
        throw ParameterError(
            fmt::format("image: voxel size {} mm; give a positive one", image.voxelSize));
    std::uint64_t count = 1;
    for (const std::int64_t n : image.size) {
        if (n < 1 || static_cast<std::uint64_t>(n) > kLargestImage / count)
            throw ParameterError(fmt::format(
                "image: size {} x {} x {}; give at least one voxel each way and at most {} in all",
                image.size[0], image.size[1], image.size[2], kLargestImage));
        count *= static_cast<std::uint64_t>(n);
    }
    if (image.distance.size() != count)
        throw ParameterError(fmt::format("image: {} distances for {} x {} x {} voxels; give {}",
                                         image.distance.size(), image.size[0], image.size[1],
                                         image.size[2], count));
    if (!image.label.empty() && image.label.size() != count)
        throw ParameterError(fmt::format("image: {} labels for {} voxels; give {} or none",
                                         image.label.size(), count, count));
    const auto bad = std::find_if(image.distance.begin(), image.distance.end(),
                                  [](float d) { return !std::isfinite(d); });
    if (bad != image.distance.end()) {
        const auto at = static_cast<std::int64_t>(bad - image.distance.begin());
        throw InputError(fmt::format(
            "image: voxel ({}, {}, {}) has the distance {}; give finite distances, clamped far "
            "from the surface",
            at % image.size[0], at / image.size[0] % image.size[1],
            at / (image.size[0] * image.size[1]), *bad));
    }
}

/// Over the voxels of one phase of one label.
struct Tally {
    std::uint64_t voxels = 0;
    double sum = 0, squares = 0, max = 0;  // of the thickness, voxels

    void add(const Tally& other) {
        voxels += other.voxels;
        sum += other.sum;
        squares += other.squares;
        max = std::max(max, other.max);
    }
    std::optional<LengthStatistics> statistics(double voxelSize) const {
        if (voxels == 0 || !(max > 0)) return std::nullopt;
        const double n = static_cast<double>(voxels);
        const double mean = sum / n;
        return LengthStatistics{mean * voxelSize,
                                std::sqrt(std::max(squares / n - mean * mean, 0.0)) * voxelSize,
                                max * voxelSize};
    }
};

struct Phases {
    Tally solid, rest;
    std::uint64_t voxels() const { return solid.voxels + rest.voxels; }
};

/// By label; sums of slices, added in order.
std::vector<Phases> tally(const VoxelImage& image, const std::vector<float>& thickness) {
    const auto slices = static_cast<std::size_t>(image.size[2]);
    const std::size_t slice = image.voxels() / slices;
    std::size_t labels = 2;
    for (const std::uint8_t label : image.label) labels = std::max<std::size_t>(labels, label + 1u);
    std::vector<std::vector<Phases>> bySlice(slices);
    tbb::parallel_for(std::size_t{0}, slices, [&](std::size_t z) {
        auto& sums = bySlice[z];
        sums.resize(labels);
        for (std::size_t voxel = z * slice; voxel < (z + 1) * slice; ++voxel) {
            Phases& phases = sums[image.label.empty() ? 1 : image.label[voxel]];
            Tally& t = image.distance[voxel] < 0 ? phases.solid : phases.rest;
            ++t.voxels;
            if (thickness.empty()) continue;
            const double value = static_cast<double>(thickness[voxel]);
            t.sum += value;
            t.squares += value * value;
            t.max = std::max(t.max, value);
        }
    });
    std::vector<Phases> total(labels);
    for (const auto& sums : bySlice)
        for (std::size_t label = 1; label < labels; ++label) {
            total[label].solid.add(sums[label].solid);
            total[label].rest.add(sums[label].rest);
        }
    return total;
}

template <typename T>
Json orNull(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

Json json(const std::optional<LengthStatistics>& s) {
    if (!s) return nullptr;
    return {{"mean", s->mean}, {"sd", s->sd}, {"max", s->max}};
}

std::string text(const std::optional<LengthStatistics>& s) {
    if (!s) return "none";
    return fmt::format("mean {:.4g} mm, deviation {:.3g}, largest {:.4g}", s->mean, s->sd, s->max);
}

std::string text(const Vec<3>& v) {
    return fmt::format("({:.3f}, {:.3f}, {:.3f})", v[0], v[1], v[2]);
}

}  // namespace

Morphometry measureMorphometry(const VoxelImage& image) {
    check(image);
    Morphometry m;
    const double h = image.voxelSize;
    m.voxelSize = h;
    const EulerNumbers euler = eulerNumbers(image);
    std::vector<Phases> phases;
    double area = 0;
    {
        const SurfaceDistance surface = surfaceDistance(image);
        std::vector<float> thickness;
        if (!surface.points.empty()) thickness = localThickness(image, surface);
        phases = tally(image, thickness);
        std::uint64_t voxels = 0;
        for (const Phases& p : phases) voxels += p.voxels();
        if (voxels == 0)
            throw InputError(fmt::format(
                "image: all {} voxels have label 0, so that there is no total volume; label those "
                "that belong to it 1 or more, or give no labels",
                image.voxels()));
        for (const SurfacePoint& p : surface.points) area += static_cast<double>(p.area);
        const auto directions = halfSphereDirections(kDirections);
        m.anisotropy = fitAnisotropy(directions, crossingRates(surface, directions), h);
    }
    if (m.anisotropy) {
        const auto directions = halfSphereDirections(kVoxelDirections);
        m.voxelAnisotropy = fitAnisotropy(directions, voxelCrossingRates(image, directions), h);
    }
    Phases all;
    for (std::size_t label = 1; label < phases.size(); ++label) {
        const Phases& p = phases[label];
        all.solid.add(p.solid);
        all.rest.add(p.rest);
        if (image.label.empty() || p.voxels() == 0) continue;
        RegionMorphometry region;
        region.label = static_cast<int>(label);
        region.totalVolume = static_cast<double>(p.voxels()) * h * h * h;
        region.solidVolume = static_cast<double>(p.solid.voxels) * h * h * h;
        region.solidFraction =
            static_cast<double>(p.solid.voxels) / static_cast<double>(p.voxels());
        region.thickness = p.solid.statistics(h);
        region.separation = p.rest.statistics(h);
        m.regions.push_back(region);
    }
    m.voxels = all.voxels();
    m.totalVolume = static_cast<double>(all.voxels()) * h * h * h;
    m.solidVolume = static_cast<double>(all.solid.voxels) * h * h * h;
    m.solidFraction = static_cast<double>(all.solid.voxels) / static_cast<double>(all.voxels());
    m.solidSurface = area * h * h;
    m.thickness = all.solid.statistics(h);
    m.separation = all.rest.statistics(h);
    if (m.thickness) m.number = m.solidFraction / m.thickness->mean;
    m.eulerNumber = euler.whole;
    m.deltaEuler = euler.share;
    m.connectivity = 1 - euler.share;
    m.connectivityDensity = m.connectivity / m.totalVolume;
    return m;
}

nlohmann::ordered_json toJson(const Morphometry& m) {
    Json out;
    out["voxelSize"] = m.voxelSize;
    out["voxels"] = m.voxels;
    out["TV"] = m.totalVolume;
    out["BV"] = m.solidVolume;
    out["BV/TV"] = m.solidFraction;
    out["BS"] = m.solidSurface;
    out["Tb.Th"] = json(m.thickness);
    out["Tb.Sp"] = json(m.separation);
    out["Tb.N"] = orNull(m.number);
    out["euler"] = {{"whole", m.eulerNumber}, {"delta", m.deltaEuler}};
    out["connectivity"] = m.connectivity;
    out["Conn.D"] = m.connectivityDensity;
    out["DA"] = nullptr;
    if (m.anisotropy) {
        const Anisotropy& a = *m.anisotropy;
        Json lengths = Json::array(), axes = Json::array();
        for (const auto& length : a.meanInterceptLengths) lengths.push_back(orNull(length));
        for (const auto& axis : a.axes) axes.push_back(axis.c);
        out["DA"] = {{"degree", a.degree},
                     {"ratio", orNull(a.ratio)},
                     {"eigenvalues", a.eigenvalues},
                     {"MIL", lengths},
                     {"axes", axes}};
    }
    out["DAvoxels"] = m.voxelAnisotropy ? Json({{"degree", m.voxelAnisotropy->degree},
                                                {"ratio", orNull(m.voxelAnisotropy->ratio)},
                                                {"axis", m.voxelAnisotropy->axes[0].c}})
                                        : Json();
    out["regions"] = Json::array();
    for (const RegionMorphometry& r : m.regions)
        out["regions"].push_back({{"label", r.label},
                                  {"TV", r.totalVolume},
                                  {"BV", r.solidVolume},
                                  {"BV/TV", r.solidFraction},
                                  {"Tb.Th", json(r.thickness)},
                                  {"Tb.Sp", json(r.separation)}});
    return out;
}

std::string summary(const Morphometry& m) {
    std::string out;
    const auto line = [&](const std::string& label, const std::string& value) {
        out += fmt::format("{:<11}{}\n", label, value);
    };
    line("BV/TV", fmt::format("{:.4f}: {:.6g} of {:.6g} mm³, voxels of {:.4g} mm", m.solidFraction,
                              m.solidVolume, m.totalVolume, m.voxelSize));
    line("BS", fmt::format("{:.6g} mm²", m.solidSurface));
    line("Tb.Th", text(m.thickness));
    line("Tb.Sp", text(m.separation));
    line("Tb.N", m.number ? fmt::format("{:.4g} /mm (BV/TV divided by Tb.Th)", *m.number) : "none");
    line("Conn.D", fmt::format("{:.5g} /mm³ (Euler number {:.8g}, {:.8g} corrected for cut faces)",
                               m.connectivityDensity, m.eulerNumber, m.deltaEuler));
    if (m.anisotropy) {
        const Anisotropy& a = *m.anisotropy;
        line("DA", fmt::format("{:.4f} as 1 - (short / long)², {} as long / short", a.degree,
                               a.ratio ? fmt::format("{:.4g}", *a.ratio) : "infinite"));
        if (m.voxelAnisotropy)
            line("", fmt::format("{:.4f} by lines from voxel to voxel, as in BoneJ",
                                 m.voxelAnisotropy->degree));
        std::string lengths;
        for (const auto& length : a.meanInterceptLengths)
            lengths += (lengths.empty() ? "" : ", ") +
                       (length ? fmt::format("{:.4g}", *length) : "infinite");
        line("MIL", lengths + " mm");
        line("", "the longest along " + text(a.axes[0]));
    } else {
        line("DA", "none");
    }
    for (const RegionMorphometry& r : m.regions) {
        line(fmt::format("region {}", r.label),
             fmt::format("BV/TV {:.4f}: {:.6g} of {:.6g} mm³", r.solidFraction, r.solidVolume,
                         r.totalVolume));
        line("  Tb.Th", text(r.thickness));
        line("  Tb.Sp", text(r.separation));
    }
    return out;
}

}  // namespace vdbpack
