#include "vdbpack/densify/further_spheres.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/ranks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace vdbpack {

namespace {

/// Equal shares (by number) of the size distribution in which spheres are counted.
constexpr std::size_t kBins = 512;

}  // namespace

template <int Dim>
FurtherSizes<Dim>::FurtherSizes(const std::vector<Sphere<Dim>>& spheres,
                                const DensifyOptions& options)
    : options_(options) {
    for (std::size_t i = options.fixed; i < spheres.size(); ++i) {
        radii_.push_back(spheres[i].radius);
        Region& region = regions_[options.regions.empty() ? 0 : options.regions[i]];
        region.radii.push_back(spheres[i].radius);
        region.volume += Measure<Dim>::ball(spheres[i].radius);
    }
    std::sort(radii_.begin(), radii_.end());
    for (auto& [id, region] : regions_) std::sort(region.radii.begin(), region.radii.end());
}

/// The radius below which the share `u` of the spheres lies.
/// @param own  sorted radii, the distribution where the options have none.
template <int Dim>
double FurtherSizes<Dim>::quantile(const std::vector<double>& own, double u) const {
    if (options_.sizes) return options_.sizes->quantile(u);
    const auto n = own.size();
    return own[std::min(n - 1, static_cast<std::size_t>(u * static_cast<double>(n)))];
}

/// Number of moving spheres in each of `kBins` bins of the size distribution; radii outside of it
/// are not counted.
template <int Dim>
std::vector<double> FurtherSizes<Dim>::counted() const {
    std::vector<std::uint64_t> whole(kBins);
    // Spheres of one radius spread over the share that this radius has.
    struct Atom {
        double radius;
        std::uint64_t count;
    };
    std::vector<Atom> atoms;
    for (std::size_t i = 0, n = 0; i < radii_.size(); i += n) {
        const double r = radii_[i];
        for (n = 1; i + n < radii_.size() && radii_[i + n] == r; ++n) {
        }
        if (r < options_.sizes->min() * (1 - 1e-6) || r > options_.sizes->max() * (1 + 1e-6))
            continue;
        const double low = options_.sizes->cdfBelow(r), high = options_.sizes->cdf(r);
        if (high > low)
            atoms.push_back({r, n});
        else
            whole[std::min<std::size_t>(kBins - 1, static_cast<std::size_t>(low * kBins))] += n;
    }
    std::map<double, std::uint64_t> all;
    for (const auto& list : gathered(options_.ranks, atoms))
        for (const Atom& atom : list) all[atom.radius] += atom.count;
    if (options_.ranks) options_.ranks->sum(whole);
    std::vector<double> have(whole.begin(), whole.end());
    for (const auto& [r, n] : all) {
        const double first = options_.sizes->cdfBelow(r) * kBins,
                     last = options_.sizes->cdf(r) * kBins;
        for (double at = first;;) {
            const auto bin = std::min<std::size_t>(kBins - 1, static_cast<std::size_t>(at));
            const double end = std::min(last, std::floor(at) + 1);
            have[bin] += (end - at) / (last - first) * static_cast<double>(n);
            if (!(end < last)) break;
            at = end;
        }
    }
    return have;
}

/// How many of `count` further spheres belong into each bin, so that all spheres together come as
/// close to the distribution as possible: sizes of which the front placed too few come first.
template <int Dim>
std::vector<double> FurtherSizes<Dim>::missing(double count) const {
    std::vector<double> want(kBins, count / kBins);
    if (!options_.sizes) return want;
    const std::vector<double> have = counted();
    double all = count;
    for (const double n : have) all += n;
    double sum = 0;
    for (std::size_t b = 0; b < kBins; ++b) {
        want[b] = std::max(0.0, all / kBins - have[b]);
        sum += want[b];
    }
    for (double& w : want) w *= count / sum;
    return want;
}

/// The same for spheres of a total volume.
template <int Dim>
std::vector<double> FurtherSizes<Dim>::missingWithVolume(double volume,
                                                         const std::vector<double>& own) const {
    const auto ballAt = [&](std::size_t bin) {
        return Measure<Dim>::ball(quantile(own, (static_cast<double>(bin) + 0.5) / kBins));
    };
    double mean = 0;
    for (std::size_t b = 0; b < kBins; ++b) mean += ballAt(b) / kBins;
    if (volume / mean > 2e9)
        throw ResourceError(fmt::format(
            "densify: about {:.3g} {} would be added, more than 2e9; choose larger sizes",
            volume / mean, Measure<Dim>::kSpheres));
    // The sizes that are missing depend on the number of spheres, and the number on the sizes.
    double count = volume / mean;
    std::vector<double> want;
    for (int turn = 0; turn < 4; ++turn) {
        want = missing(count);
        double have = 0;
        for (std::size_t b = 0; b < kBins; ++b) have += want[b] * ballAt(b);
        if (turn < 3) count *= volume / have;
    }
    return want;
}

/// Radii of a total volume, in random order. @param own  as for `quantile`.
template <int Dim>
std::vector<double> FurtherSizes<Dim>::drawRadii(double volume, const std::vector<double>& own,
                                                 RandomStream& random) const {
    if (!(volume > 0)) return {};
    const std::vector<double> want = missingWithVolume(volume, own);
    std::vector<double> radii;
    double due = random.uniform(), placed = 0;
    for (std::size_t b = 0; b < kBins; ++b)
        for (due += want[b]; due >= 1; due -= 1) {
            const double u = (static_cast<double>(b) + random.uniform()) / kBins;
            radii.push_back(quantile(own, u));
            placed += Measure<Dim>::ball(radii.back());
        }
    while (placed < volume) {
        radii.push_back(quantile(own, random.uniform()));
        placed += Measure<Dim>::ball(radii.back());
    }
    for (std::size_t k = radii.size(); k > 1; --k)
        std::swap(radii[k - 1], radii[random.bits() % k]);
    return radii;
}

template <int Dim>
FurtherSpheres FurtherSizes<Dim>::draw(double volume, RandomStream& random) const {
    FurtherSpheres all;
    if (options_.regions.empty()) {
        all.radii = drawRadii(volume, radii_, random);
        return all;
    }
    double sum = 0;
    for (const auto& [id, region] : regions_) sum += region.volume;
    if (options_.sizes) {
        all.radii = drawRadii(volume, radii_, random);
        for (std::size_t k = 0; k < all.radii.size(); ++k) {
            double rest = random.uniform() * sum;
            auto at = regions_.begin();
            while (rest >= at->second.volume && std::next(at) != regions_.end())
                rest -= (at++)->second.volume;
            all.regions.push_back(at->first);
        }
        return all;
    }
    for (const auto& [id, region] : regions_) {
        const auto radii = drawRadii(volume * region.volume / sum, region.radii, random);
        all.radii.insert(all.radii.end(), radii.begin(), radii.end());
        all.regions.resize(all.radii.size(), id);
    }
    return all;
}

template class FurtherSizes<2>;
template class FurtherSizes<3>;

}  // namespace vdbpack
