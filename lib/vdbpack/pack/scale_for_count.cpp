#include "vdbpack/core/ball_share.h"
#include "vdbpack/core/error.h"
#include "vdbpack/pack/kernel_settings.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/pack/packer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

/// Factor on the radii of a trial that do not fit, and the least part of those that are sought.
constexpr double kSmaller = 0.7, kSmallest = 0.5;

/// From so many spheres on a trial pack of 1/80 of them tells how thick the domain is for them: it
/// then fills this share of what such a trial of a large domain fills.
constexpr double kMany = 20000, kThick = 0.85;

/// Radii of a pack by their scale, and its solid fraction.
struct Trial {
    double scale = 0, fraction = 0;
};

/// Share of a domain that spheres fill.
template <int Dim>
constexpr double kGuess = Dim == 3 ? 0.58 : 0.8;

template <int Dim>
void checkCount(double count, double most, double gap) {
    if (!(count >= 1 && std::isfinite(count)))
        throw ParameterError(
            fmt::format("`targetCount` {}: must be a number of spheres, 1 or more", count));
    if (!(count < most))
        throw ParameterError(
            fmt::format("{:.0f} {} cannot keep a gap of {:g} mm in this domain, however small they "
                        "are: at most about {:.0f} can; give a smaller count or a smaller gap",
                        count, Measure<Dim>::kSpheres, gap, most));
}

/// Share of a domain that is left beside existing spheres.
template <int Dim>
double roomBeside(const std::vector<Sphere<Dim>>& existing, const Domain<Dim>& domain,
                  double shell) {
    double taken = 0;
    const auto sampler = domain.sampler();
    for (const auto& s : existing)
        if (sampler->signedDistance(s.center) < 0) taken += Measure<Dim>::ball(s.radius + shell);
    return std::max(0.05, 1 - taken / domain.volume());
}

/// The scale at which spheres with their shells have this mean volume (2D: area), mm^Dim.
template <int Dim>
double scaleWith(const LocalBalls<Dim>& balls, double ball, double shell) {
    double lo = 0, hi = std::pow(ball / balls.mean(), 1.0 / Dim);
    for (int i = 0; shell > 0 && i < 100; ++i) {
        const double middle = 0.5 * (lo + hi);
        (balls.mean(middle, shell) < ball ? lo : hi) = middle;
    }
    return hi;
}

}  // namespace

template <int Dim>
double scaleForCount(const Domain<Dim>& domain, const PackOptions& options, double count,
                     const Callbacks& callbacks, const std::vector<Sphere<Dim>>& existing) {
    const double shell = shellOf(options);
    const LocalBalls<Dim> balls(domain, options.sizes, options.local);
    checkCount<Dim>(count, kGuess<Dim> * domain.volume() / balls.mean(0, shell), options.gap);
    // Where `n` spheres with their shells fill that fraction of the domain.
    const auto scaleFor = [&](double fraction, double n) {
        return scaleWith(balls, fraction * domain.volume() / n, shell);
    };
    PackOptions trial = options;
    trial.maxCount = 0;
    const auto isCancelled = [&] { return anyOver(options.ranks, callbacks.isCancelled()); };
    Callbacks quiet = callbacks;
    quiet.progress = nullptr;
    const auto fractionAt = [&](double scale) {
        trial.sizes = options.sizes.scaled(scale);
        if (options.local.shellSizes)
            trial.local.shellSizes = options.local.shellSizes->scaled(scale);
        const auto result = packSpheres(domain, trial, quiet, existing);
        return ballShare(result.pack.spheres, domain.volume(), options.ranks, shell);
    };
    const double room = kGuess<Dim> * roomBeside(existing, domain, shell);
    // A domain may be too thin for the spheres of a trial, or for those that would fill it.
    const auto tryOut = [&](double& scale) {
        const double least = kSmallest * scaleFor(room, count);
        for (;;) {
            try {
                return fractionAt(scale);
            } catch (const InputError&) {
                if (!(kSmaller * scale > least) || isCancelled()) throw;
                scale *= kSmaller;
            }
        }
    };
    const auto trialOf = [&](double n, double largest) {
        Trial made;
        made.scale = std::min(scaleFor(room, n), largest);
        if (!isCancelled()) made.fraction = tryOut(made.scale);
        return made;
    };
    // Solid fraction f = a - b s at scale s, since a layer as thick as the radii is packed worse
    // along the wall. Two trials give a and b: with 1/80 and 1/10 of the spheres where the domain
    // is thick for these, with 1/20 and 1/5 where it is not.
    constexpr double kAny = std::numeric_limits<double>::infinity();
    Trial coarse;
    if (count >= kMany) coarse = trialOf(count / 80, kAny);
    const bool isThick = coarse.fraction > kThick * room;
    if (!isThick) coarse = trialOf(std::max(count / 20, 50.0), kAny);
    const Trial fine = trialOf(isThick ? count / 10 : std::max(count / 5, 100.0), coarse.scale);
    if (isCancelled()) return fine.scale;
    const double slope = coarse.scale > fine.scale
                             ? (fine.fraction - coarse.fraction) / (coarse.scale - fine.scale)
                             : 0.0;
    double scale = fine.scale;
    for (int i = 0; i < 20; ++i) {
        const double fraction = fine.fraction + slope * (fine.scale - scale);
        scale = scaleFor(std::clamp(fraction, 0.01, 0.9), count);
    }
    return scale;
}

template double scaleForCount(const Domain<2>&, const PackOptions&, double, const Callbacks&,
                              const std::vector<Sphere<2>>&);
template double scaleForCount(const Domain<3>&, const PackOptions&, double, const Callbacks&,
                              const std::vector<Sphere<3>>&);

}  // namespace vdbpack
