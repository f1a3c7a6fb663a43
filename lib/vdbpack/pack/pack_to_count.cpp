#include "vdbpack/core/error.h"
#include "vdbpack/core/ranks.h"
#include "vdbpack/pack/front_fraction.h"
#include "vdbpack/pack/kernel_settings.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/pack/packer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

/// How far the final count may be from the target before another pack is made: a share of it, and
/// spheres.
constexpr double kCountTolerance = 0.018, kCountsApart = 0.5;
constexpr int kCountAttempts = 8;
constexpr double kFar = std::numeric_limits<double>::max();

bool isNear(double count, double target) {
    const double off = std::fabs(count - target);
    return off < kCountsApart || off < kCountTolerance * target;
}

/// Whether a count is nearer than another one by its ratio to the target: where spheres a little
/// larger fit nowhere, twice as many as requested fill the domain, and a few leave it empty.
bool isNearer(double count, double other, double target) {
    const auto ratio = [&](double n) { return n > 0 ? std::fabs(std::log(n / target)) : kFar; };
    return ratio(count) < ratio(other);
}

/// Where not even the smallest of the spheres that are so few would fit.
[[noreturn]] void refuseCount(double target, const InputError& nothingFits) {
    throw InputError(
        fmt::format("`targetCount` {:.0f}: {}, or a larger number, which makes them smaller",
                    target, nothingFits.what()));
}

/// The scales tried so far, and the next one.
class ScaleSearch {
public:
    ScaleSearch(double target, int dim) : target_(target), dim_(dim) {}

    double next(double scale, double count) {
        (count > target_ ? tooSmall_ : tooLarge_) = scale;
        double next = scale * std::pow(std::max(count, 0.5) / target_, 1.0 / dim_);
        if (lastCount_ > 0 && count > 0 && lastCount_ != count && lastScale_ != scale)
            next = scale * std::exp(std::log(target_ / count) * std::log(lastScale_ / scale) /
                                    std::log(lastCount_ / count));
        // Between what was too few and too many, or at most a factor of two away.
        if (!(next > tooSmall_ && next < tooLarge_))
            next = tooSmall_ > 0 && tooLarge_ < std::numeric_limits<double>::infinity()
                       ? std::sqrt(tooSmall_ * tooLarge_)
                       : std::clamp(next, 0.5 * scale, 2 * scale);
        lastScale_ = scale;
        lastCount_ = count;
        return next;
    }

private:
    double target_;
    int dim_;
    double tooSmall_ = 0, tooLarge_ = std::numeric_limits<double>::infinity();
    double lastScale_ = 0, lastCount_ = 0;
};

}  // namespace

void scaleSizes(PackOptions& options, const PackOptions& from, double factor) {
    options.sizes = from.sizes.scaled(factor).rounded();
    if (from.local.shellSizes)
        options.local.shellSizes = from.local.shellSizes->scaled(factor).rounded();
}

template <int Dim>
PackResult<Dim> packToCount(const Domain<Dim>& domain, PackOptions& options, double target,
                            const Callbacks& callbacks, const std::vector<Sphere<Dim>>& existing,
                            const CountedSpheres<Dim>& counted) {
    const PackOptions asked = options;
    PackResult<Dim> best;
    double bestScale = 1, bestCount = 0;
    ScaleSearch search(target, Dim);
    const double front = std::max(1.0, target / counted.share);
    const auto firstScale = [&] {
        if (counted.fraction > 0)
            return std::pow(counted.fraction * domain.volume() /
                                (front * LocalBalls<Dim>(domain, asked.sizes, asked.local).mean()),
                            1.0 / Dim);
        try {
            return scaleForCount(domain, options, front, callbacks, existing);
        } catch (const InputError& nothingFits) {
            refuseCount(target, nothingFits);
        }
    };
    // No larger than what fits, which is looked for where a ball of that size is not soon found.
    std::optional<double> largest;
    const auto fitting = [&](double scale) {
        if (asked.local.any() || domain.cell().any()) return scale;
        if (!largest && holdsBall(domain, scale * asked.sizes.max() + asked.gap)) return scale;
        if (!largest) largest = largestScale(asked.sizes, largestBall(domain).radius - asked.gap);
        return std::min(scale, *largest);
    };
    double scale = fitting(firstScale());
    for (int attempt = 0; attempt < kCountAttempts; ++attempt) {
        scaleSizes(options, asked, scale);
        PackResult<Dim> result;
        try {
            result = packSpheres(domain, options, callbacks, existing);
        } catch (const InputError& nothingFits) {
            if (attempt + 1 == kCountAttempts && !(bestCount > 0)) refuseCount(target, nothingFits);
        }
        const auto& spheres = result.pack.spheres;
        const bool interrupted = result.interrupted;
        double count = static_cast<double>(sumOver(options.ranks, std::uint64_t{spheres.size()}));
        if (counted.count && !interrupted && count > 0)
            count = counted.count(spheres, options.local.largest(options.sizes));
        // Where the last one was interrupted, the one that has more is kept.
        if (isNearer(count, bestCount, target) || !(bestCount > 0)) {
            bestScale = scale;
            bestCount = count;
            best = std::move(result);
        }
        best.interrupted = interrupted;
        if (interrupted || options.maxCount > 0 || isNear(bestCount, target)) break;
        const double next = fitting(search.next(scale, count));
        if (next == scale) break;
        scale = next;
    }
    scaleSizes(options, asked, bestScale);
    if (counted.warns && !best.interrupted && options.maxCount == 0 && !isNear(bestCount, target))
        callbacks.warn(fmt::format(
            "{:.0f} {} were requested, and {:.0f} are nearest of {} packs; give another number or "
            "seed, or the radii themselves",
            target, Measure<Dim>::kSpheres, bestCount, kCountAttempts));
    return best;
}

template PackResult<2> packToCount(const Domain<2>&, PackOptions&, double, const Callbacks&,
                                   const std::vector<Sphere<2>>&, const CountedSpheres<2>&);
template PackResult<3> packToCount(const Domain<3>&, PackOptions&, double, const Callbacks&,
                                   const std::vector<Sphere<3>>&, const CountedSpheres<3>&);

}  // namespace vdbpack
