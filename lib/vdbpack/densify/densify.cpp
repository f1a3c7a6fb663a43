#include "vdbpack/densify/densify.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/acceptance.h"
#include "vdbpack/densify/relaxation.h"
#include "vdbpack/domain/inset_domain.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <utility>

namespace vdbpack {

namespace {

/// Paces from quick to thorough, each with the gain in solid fraction over the front's up to which
/// it is worth a try (spheres of ratio 1:2 in a box).
struct Pace {
    RelaxationPace pace;
    double gain;
};
using Paces = std::array<Pace, 4>;
constexpr Paces kPaces{{{{0.97, 0.07, 3}, 0.018},
                        {{0.98, 0.15, 3}, 0.032},
                        {{0.99, 0.20, 3}, 0.045},
                        {{0.995, 0.25, 3}, 1}}};
/// The same for spheres that are all nearly as large: driven slowly, they crystallize.
constexpr Paces kNarrowPaces{{{{0.97, 0.07, 3}, 0.02},
                              {{0.98, 0.07, 3}, 0.045},
                              {{0.98, 0.15, 3}, 0.05},
                              {{0.99, 0.20, 3}, 1}}};
/// Standard deviation of the radii up to which they are, in mean radii.
constexpr double kNarrow = 0.06;
/// Way that such spheres are moved at random first, in radii along each axis. In a box of side 60
/// at 0.62, 3.8 to 4.7 % of equal ones then lie as in a crystal; of those not stirred, 5 to 8 %.
constexpr double kStir = 0.8;
constexpr std::uint64_t kStirring = 0x7374697272696e67ull;
/// A pace that comes to its end does so within this many of its memories, 1 / (1 - inertia).
constexpr double kMemories = 14;

/// Whether a relaxation has jammed. One that comes to its end takes its worst overlap down to a
/// tenth in three memories, from the sixth on; in one that does not, it stays where it is.
class Jam {
public:
    explicit Jam(const RelaxationPace& pace) : memory_(1 / (1 - pace.inertia)) {}

    bool seen(int step, double worst) {
        const auto window = static_cast<std::size_t>(step / memory_);
        if (window == least_.size()) {
            if (isJammed()) return true;
            least_.push_back(worst);
        }
        least_.back() = std::min(least_.back(), worst);
        return false;
    }

private:
    /// Of the windows that are complete.
    bool isJammed() const {
        const std::size_t n = least_.size();
        if (n < 7) return false;
        return least_[n - 1] > 0.4 * least_[n - 4] && std::min(least_[n - 1], least_[n - 2]) > 1e-3;
    }

    double memory_;
    std::vector<double> least_;  ///< smallest worst overlap in each memory
};

/// Stages when it is to be as dense as it gets, in solid fraction; the last one ends it.
constexpr std::array<double, 3> kStages{0.02, 0.01, 0.005};
/// Shares of the size distribution in which spheres are counted.
constexpr std::size_t kBins = 512;
/// Where what was asked for is not to be had, the search ends when it is known this well.
constexpr double kNear = 0.004;
/// Fractions that are no packs of spheres any more: all of the volume but for single crystals.
template <int Dim>
constexpr double kMostFraction = Dim == 3 ? 0.95 : 0.98;

template <int Dim>
class Densifier {
public:
    Densifier(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
              const DensifyOptions& options, const Callbacks& callbacks)
        : options_(options),
          callbacks_(callbacks),
          volume_(domain.volume()),
          shell_(0.5 * options.gap) {
        if (!(options.gap >= 0) || !std::isfinite(options.gap))
            throw ParameterError(fmt::format("gap {} mm: must be 0 or more", options.gap));
        if (std::isnan(options.fraction) || options.fraction < 0)
            throw ParameterError(fmt::format("densify: {} is no solid fraction", options.fraction));
        if (std::isfinite(options.fraction) && options.fraction > kMostFraction<Dim>)
            throw ParameterError(
                fmt::format("densify: no {} fill {} of anything; ask for less, or for max",
                            Measure<Dim>::kSpheres, options.fraction));
        if (options.fixed > spheres.size())
            throw ParameterError(fmt::format("densify: {} of {} {} cannot be fixed", options.fixed,
                                             spheres.size(), Measure<Dim>::kSpheres));
        if (!(volume_ > 0)) throw InputError("densify: the domain has no volume");
        if (shell_ > 0) inset_ = insetDomain(domain, shell_);
        domain_ = inset_ ? inset_.get() : &domain;
        if (!options.regions.empty() && options.regions.size() != spheres.size())
            throw ParameterError(fmt::format("densify: {} regions are given for {} {}",
                                             options.regions.size(), spheres.size(),
                                             Measure<Dim>::kSpheres));
        result_.spheres = spheres;
        result_.regions = options.regions;
        result_.before = fractionOf(result_.spheres);
        for (std::size_t i = options.fixed; i < spheres.size(); ++i) {
            radii_.push_back(spheres[i].radius);
            Region& region = regions_[options.regions.empty() ? 0 : options.regions[i]];
            region.radii.push_back(spheres[i].radius);
            region.volume += Measure<Dim>::ball(spheres[i].radius);
        }
        std::sort(radii_.begin(), radii_.end());
        for (auto& [id, region] : regions_) std::sort(region.radii.begin(), region.radii.end());
        double sum = 0, squares = 0;
        for (const double r : radii_) sum += r;
        const double mean = sum / static_cast<double>(radii_.size());
        for (const double r : radii_) squares += (r - mean) * (r - mean);
        if (squares <= kNarrow * kNarrow * mean * sum) paces_ = &kNarrowPaces;
    }

    DensifyResult<Dim> run() {
        if (radii_.empty()) {  // nothing may move
            result_.apart = true;
            return finished();
        }
        result_.apart = standsApart();
        const double wanted = options_.fraction;
        if (!(wanted > result_.before)) {
            // Overlaps alone: slow enough for any, and slower where that does not do.
            if (!result_.apart) attempt(result_.before, 0);
            return finished();
        }
        if (std::isfinite(wanted)) {
            if (attempt(wanted, paceFor(wanted - result_.before)) || result_.interrupted)
                return finished();
            // Less, then: halfway between what is had and what was not, some times.
            double low = reachedFraction(), high = wanted;
            while (high - low > kNear && !result_.interrupted) {
                const double middle = 0.5 * (low + high);
                (attempt(middle, paceFor(middle - result_.before)) ? low : high) = middle;
            }
            return finished();
        }
        for (const double stage : kStages)
            for (;;) {
                const double next = reachedFraction() + stage;
                if (next > kMostFraction<Dim> || !attempt(next, paceFor(next - result_.before)) ||
                    result_.interrupted)
                    break;
            }
        return finished();
    }

private:
    double fractionOf(const std::vector<Sphere<Dim>>& spheres) const {
        double sum = 0;
        for (const auto& s : spheres) sum += Measure<Dim>::ball(s.radius);
        return sum / volume_;
    }
    std::vector<Sphere<Dim>> withShell(std::vector<Sphere<Dim>> spheres) const {
        for (auto& s : spheres) s.radius += shell_;
        return spheres;
    }
    /// Whether the pack as given is what is asked for, but for its density.
    bool standsApart() const {
        return isAccepted(withShell(result_.spheres), options_.fixed, *domain_);
    }
    double reachedFraction() const { return fractionOf(result_.spheres); }

    std::size_t paceFor(double gain) const {
        std::size_t k = 0;
        while (k + 1 < paces_->size() && gain > (*paces_)[k].gain) ++k;
        return k;
    }

    /// @param radii  sorted; where no distribution is given, they are it.
    double quantile(const std::vector<double>& radii, double u) const {
        if (options_.sizes) return options_.sizes->quantile(u);
        const auto n = radii.size();
        return radii[std::min(n - 1, static_cast<std::size_t>(u * static_cast<double>(n)))];
    }

    /// Where the radii of the spheres that move lie in the distribution, each 0 to 1 and counted in
    /// `kBins` bins; those of another distribution count in none.
    std::vector<double> standing() const {
        std::vector<double> have(kBins, 0.0);
        for (std::size_t i = 0, n = 0; i < radii_.size(); i += n) {
            const double r = radii_[i];
            for (n = 1; i + n < radii_.size() && radii_[i + n] == r; ++n) {
            }
            const double low = options_.sizes->cdfBelow(r), high = options_.sizes->cdf(r);
            if (r < options_.sizes->min() * (1 - 1e-6) || r > options_.sizes->max() * (1 + 1e-6))
                continue;
            // Those of one radius spread over the share that it has.
            const double first = low * kBins, last = std::max(first, high * kBins);
            for (double at = first;;) {
                const auto bin = std::min<std::size_t>(kBins - 1, static_cast<std::size_t>(at));
                const double end = std::min(last, std::floor(at) + 1);
                const double share = last > first ? (end - at) / (last - first) : 1;
                have[bin] += share * static_cast<double>(n);
                if (!(end < last)) break;
                at = end;
            }
        }
        return have;
    }

    /// How many of `count` further spheres belong into each bin, so that all together come as near
    /// to the distribution as they can: those that a front has placed too few of come first.
    std::vector<double> missing(double count) const {
        std::vector<double> want(kBins, count / kBins);
        if (!options_.sizes) return want;
        const std::vector<double> have = standing();
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

    /// Spheres to be added.
    struct Further {
        std::vector<double> radii;
        std::vector<std::int32_t> regions;  ///< empty: all are of one
    };

    /// What brings the fraction from what it is to `fraction`, in random order.
    Further further(double fraction) const {
        const double volume = (fraction - reachedFraction()) * volume_;
        RandomStream random(options_.seed ^ 0x64656e73696679ull,
                            static_cast<std::uint64_t>(result_.stages));
        Further all;
        if (options_.regions.empty()) {
            all.radii = furtherRadii(volume, radii_, random);
            return all;
        }
        double sum = 0;
        for (const auto& [id, region] : regions_) sum += region.volume;
        if (options_.sizes) {
            all.radii = furtherRadii(volume, radii_, random);
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
            const auto radii = furtherRadii(volume * region.volume / sum, region.radii, random);
            all.radii.insert(all.radii.end(), radii.begin(), radii.end());
            all.regions.resize(all.radii.size(), id);
        }
        return all;
    }

    /// Radii that sum up to a volume, in random order. @param own  as for `quantile`.
    std::vector<double> furtherRadii(double volume, const std::vector<double>& own,
                                     RandomStream& random) const {
        if (!(volume > 0)) return {};
        const auto ballAt = [&](std::size_t bin) {
            return Measure<Dim>::ball(quantile(own, (static_cast<double>(bin) + 0.5) / kBins));
        };
        double mean = 0;
        for (std::size_t b = 0; b < kBins; ++b) mean += ballAt(b) / kBins;
        if (volume / mean > 2e9)
            throw ResourceError(
                fmt::format("densify: about {:.3g} further {} are too many; ask for larger ones",
                            volume / mean, Measure<Dim>::kSpheres));
        // Which sizes are missing depends on how many there will be, and the other way round.
        double count = volume / mean;
        std::vector<double> want;
        for (int turn = 0; turn < 4; ++turn) {
            want = missing(count);
            double have = 0;
            for (std::size_t b = 0; b < kBins; ++b) have += want[b] * ballAt(b);
            if (turn < 3) count *= volume / have;
        }
        std::vector<double> radii;
        radii.reserve(static_cast<std::size_t>(count) + 2);
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
    /// Moves spheres at random, within the domain: what a front of equal ones laid in rows along
    /// the wall is disordered again.
    void stir(std::vector<Sphere<Dim>>& spheres) const {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(options_.fixed, spheres.size(), 1024),
                          [&](const tbb::blocked_range<std::size_t>& part) {
                              const auto sampler = domain_->sampler();
                              for (std::size_t i = part.begin(); i < part.end(); ++i) {
                                  RandomStream random(options_.seed ^ kStirring, i);
                                  Sphere<Dim>& s = spheres[i];
                                  Vec<Dim> to = s.center;
                                  for (int d = 0; d < Dim; ++d)
                                      to[d] += kStir * s.radius * (2 * random.uniform() - 1);
                                  if (sampler->signedDistance(to) < -0.5 * s.radius) s.center = to;
                              }
                          });
    }

    /// Adds what is missing to `fraction` and relaxes, from pace `first` on. What came apart is
    /// kept. @return whether it did.
    bool attempt(double fraction, std::size_t first) {
        std::vector<Sphere<Dim>> spheres = result_.spheres;
        std::vector<std::int32_t> regions = result_.regions;
        if (const Further added = further(fraction); !added.radii.empty()) {
            Relaxation<Dim> standing(*domain_, withShell(spheres), options_.fixed, regions,
                                     options_.seed);
            const auto places = standing.roomiestPlaces(added.radii, added.regions,
                                                        static_cast<std::uint64_t>(result_.stages));
            spheres.insert(spheres.end(), places.begin(), places.end());
            regions.insert(regions.end(), added.regions.begin(), added.regions.end());
            if (paces_ == &kNarrowPaces) stir(spheres);
        }
        ++result_.stages;
        for (std::size_t k = first; k < paces_->size(); ++k) {
            const RelaxationPace& pace = (*paces_)[k].pace;
            // From the beginning each time: what has jammed does not come loose any more.
            Relaxation<Dim> relaxation(*domain_, withShell(spheres), options_.fixed, regions,
                                       options_.seed + static_cast<std::uint64_t>(result_.stages));
            const int steps = static_cast<int>(kMemories / (1 - pace.inertia));
            Jam jam(pace);
            const auto goOn = [&](int step, double worst) {
                if (step % 10 == 0 && callbacks_.progress)
                    callbacks_.progress(
                        {fmt::format("densify to {:.4f}, overlap {:.2g}", fraction, worst),
                         static_cast<double>(step) / steps, static_cast<double>(spheres.size())});
                return !jam.seen(step, worst);
            };
            const auto outcome = relaxation.run(pace, steps, callbacks_, goOn);
            result_.steps += static_cast<std::uint64_t>(outcome.steps);
            if (outcome.interrupted) {
                result_.interrupted = true;
                return false;
            }
            if (outcome.apart) {
                const auto moved = relaxation.spheres();
                for (std::size_t i = 0; i < moved.size(); ++i) spheres[i].center = moved[i].center;
                result_.spheres = std::move(spheres);
                result_.regions = std::move(regions);
                return result_.apart = true;
            }
        }
        return false;
    }

    DensifyResult<Dim> finished() {
        result_.after = reachedFraction();
        result_.reached = result_.apart && result_.after >= options_.fraction - 1e-9;
        return std::move(result_);
    }

    const DensifyOptions& options_;
    const Callbacks& callbacks_;
    double volume_;
    double shell_;
    std::unique_ptr<Domain<Dim>> inset_;
    const Domain<Dim>* domain_ = nullptr;
    /// What moves of a region: radii, sorted, mm; and their volume, mm^Dim.
    struct Region {
        std::vector<double> radii;
        double volume = 0;
    };
    std::vector<double> radii_;  ///< of the spheres that move, sorted, mm
    std::map<std::int32_t, Region> regions_;
    const Paces* paces_ = &kPaces;
    DensifyResult<Dim> result_;
};

}  // namespace

template <int Dim>
DensifyResult<Dim> densify(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
                           const DensifyOptions& options, const Callbacks& callbacks) {
    return Densifier<Dim>(domain, spheres, options, callbacks).run();
}

template DensifyResult<2> densify(const Domain<2>&, const std::vector<Sphere<2>>&,
                                  const DensifyOptions&, const Callbacks&);
template DensifyResult<3> densify(const Domain<3>&, const std::vector<Sphere<3>>&,
                                  const DensifyOptions&, const Callbacks&);

}  // namespace vdbpack
