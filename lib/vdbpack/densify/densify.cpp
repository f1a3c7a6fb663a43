#include "vdbpack/densify/densify.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/relaxation.h"
#include "vdbpack/domain/inset_domain.h"
#include "vdbpack/measure/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

namespace vdbpack {

namespace {

/// Paces from quick to thorough, each with the gain in solid fraction over the front's up to which
/// it comes to its end (spheres of ratio 1:2 in a box).
struct Pace {
    RelaxationPace pace;
    double gain;
};
constexpr std::array<Pace, 4> kPaces{{{{0.97, 0.07, 3}, 0.015},
                                      {{0.98, 0.15, 3}, 0.03},
                                      {{0.99, 0.20, 3}, 0.04},
                                      {{0.995, 0.25, 3}, 1}}};
/// A pace that comes to its end does so within this many of its memories, 1 / (1 - inertia).
constexpr double kMemories = 14;
/// Stages when it is to be as dense as it gets, in solid fraction; the last one ends it.
constexpr std::array<double, 3> kStages{0.02, 0.01, 0.005};
/// Where what was asked for is not to be had, the search ends when it is known this well.
constexpr double kNear = 0.004;
/// Fractions that are no packs of spheres any more: all of the volume but for single crystals.
template <int Dim>
constexpr double kMostFraction = Dim == 3 ? 0.95 : 0.98;

int stepsOf(const RelaxationPace& pace) {
    return static_cast<int>(kMemories / (1 - pace.inertia));
}

template <int Dim>
class Densifier {
public:
    Densifier(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
              const DensifyOptions& options, const Callbacks& callbacks)
        : options_(options),
          callbacks_(callbacks),
          volume_(domain.measure()),
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
        result_.spheres = spheres;
        result_.before = fractionOf(result_.spheres);
        for (std::size_t i = options.fixed; i < spheres.size(); ++i)
            radii_.push_back(spheres[i].radius);
        std::sort(radii_.begin(), radii_.end());
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
                (attempt(middle, kPaces.size() - 1) ? low : high) = middle;
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
        const auto spheres = withShell(result_.spheres);
        if (checkOverlap(spheres).pairs > 0) return false;
        const auto sampler = domain_->sampler();
        return std::all_of(spheres.begin() + static_cast<std::ptrdiff_t>(options_.fixed),
                           spheres.end(), [&](const Sphere<Dim>& s) {
                               return !sampler->isWallCloser(s.center,
                                                             s.radius * (1 - kVerifyTolerance)) &&
                                      sampler->contains(s.center);
                           });
    }
    double reachedFraction() const { return fractionOf(result_.spheres); }

    static std::size_t paceFor(double gain) {
        std::size_t k = 0;
        while (k + 1 < kPaces.size() && gain > kPaces[k].gain) ++k;
        return k;
    }

    double quantile(double u) const {
        if (options_.sizes) return options_.sizes->quantile(u);
        const auto n = radii_.size();
        return radii_[std::min(n - 1, static_cast<std::size_t>(u * static_cast<double>(n)))];
    }

    /// Radii of spheres that bring the fraction from what it is to `fraction`:
    /// evenly spread over the distribution, in random order.
    std::vector<double> furtherRadii(double fraction) {
        const double missing = (fraction - reachedFraction()) * volume_;
        if (!(missing > 0)) return {};
        double mean = 0;
        constexpr int kSamples = 1024;
        for (int k = 0; k < kSamples; ++k)
            mean += Measure<Dim>::ball(quantile((k + 0.5) / kSamples)) / kSamples;
        const double count = missing / mean;
        if (count > 2e9)
            throw ResourceError(
                fmt::format("densify: about {:.3g} further {} are too many; ask for larger ones",
                            count, Measure<Dim>::kSpheres));
        RandomStream random(options_.seed ^ 0x64656e73696679ull,
                            static_cast<std::uint64_t>(result_.stages));
        // Rounded at random: a stage that asks for less than one gets one now and then.
        const auto n = static_cast<std::size_t>(std::ceil(count));
        std::vector<double> radii(n);
        const double start = random.uniform();
        for (std::size_t k = 0; k < n; ++k)
            radii[k] = quantile((static_cast<double>(k) + start) / static_cast<double>(n));
        for (std::size_t k = n; k > 1; --k) std::swap(radii[k - 1], radii[random.bits() % k]);
        return radii;
    }

    /// Adds what is missing to `fraction` and relaxes, from pace `first` on. What came apart is
    /// kept. @return whether it did.
    bool attempt(double fraction, std::size_t first) {
        std::vector<Sphere<Dim>> spheres = result_.spheres;
        if (auto radii = furtherRadii(fraction); !radii.empty()) {
            Relaxation<Dim> standing(*domain_, withShell(spheres), options_.fixed, {},
                                     options_.seed);
            const auto places =
                standing.roomiestPlaces(radii, static_cast<std::uint64_t>(result_.stages));
            spheres.insert(spheres.end(), places.begin(), places.end());
        }
        ++result_.stages;
        Relaxation<Dim> relaxation(*domain_, withShell(spheres), options_.fixed, {},
                                   options_.seed + static_cast<std::uint64_t>(result_.stages));
        for (std::size_t k = first; k < kPaces.size(); ++k) {
            const int steps = stepsOf(kPaces[k].pace);
            const auto tell = [&](int step, double worst) {
                if (step % 10 != 0 || !callbacks_.progress) return;
                callbacks_.progress(
                    {fmt::format("densify to {:.4f}, overlap {:.2g}", fraction, worst),
                     static_cast<double>(step) / steps, static_cast<double>(spheres.size())});
            };
            const auto outcome = relaxation.run(kPaces[k].pace, steps, callbacks_, tell);
            result_.steps += static_cast<std::uint64_t>(outcome.steps);
            if (outcome.interrupted) {
                result_.interrupted = true;
                return false;
            }
            if (outcome.apart) {
                const auto moved = relaxation.spheres();
                for (std::size_t i = 0; i < moved.size(); ++i) spheres[i].center = moved[i].center;
                result_.spheres = std::move(spheres);
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
    std::vector<double> radii_;  ///< of the spheres that move, sorted, mm
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
