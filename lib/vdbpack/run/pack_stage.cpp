#include "vdbpack/run/pack_stage.h"

#include "vdbpack/core/error.h"
#include "vdbpack/run/void_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

/// How far the final count may be from the target before the pack is made again.
constexpr double kCountTolerance = 0.018;
constexpr int kCountAttempts = 8;

}  // namespace

FieldRadii fieldRadii(const PackRecipe& recipe, const RequestedSizes& requested,
                      const DomainSource& source) {
    const SizeDistribution& sizes = requested.sizes;
    const int dim = source.dim();
    FieldRadii radii;
    if (requested.targetCount > 0) {
        // Half full is the lowest that is to be expected: the field is deep and fine enough.
        const double guess = source.volume() / (requested.targetCount * sizes.meanBall(dim));
        radii.scale = std::pow((dim == 3 ? 0.58 : 0.8) * guess, 1.0 / dim);
    }
    radii.detail = fieldDetail(sizes.min(), sizes.mean()) * radii.scale;
    radii.reach =
        std::max(sizes.max() * radii.scale * 1.05 + recipe.gap, depthForShell(recipe.voids) / 3);
    return radii;
}

template <int Dim>
PackResult<Dim> packToCount(const Domain<Dim>& domain, PackOptions& options, double target,
                            const Callbacks& callbacks, const std::vector<Sphere<Dim>>& existing) {
    const SizeDistribution sizes = options.sizes;
    PackResult<Dim> best;
    double bestOff = std::numeric_limits<double>::infinity(), bestScale = 1;
    double tooSmall = 0, tooLarge = std::numeric_limits<double>::infinity();
    double scale = scaleForCount(domain, options, target, callbacks, existing);
    double lastScale = 0, lastCount = 0;
    for (int attempt = 0; attempt < kCountAttempts; ++attempt) {
        options.sizes = scaledSizes(sizes, scale, Dim);
        PackResult<Dim> result;
        try {
            result = packSpheres(domain, options, callbacks, existing);
        } catch (const InputError&) {  // nothing fits
            if (attempt + 1 == kCountAttempts && best.pack.spheres.empty()) throw;
        }
        const auto count = static_cast<double>(result.pack.spheres.size());
        const bool interrupted = result.interrupted;
        // Where the last one was interrupted, the one that has more is kept.
        if (std::fabs(count - target) < bestOff || (interrupted && best.pack.spheres.empty())) {
            bestOff = std::fabs(count - target);
            bestScale = scale;
            best = std::move(result);
        }
        best.interrupted = interrupted;
        if (best.interrupted || options.maxCount > 0 || bestOff < 1.5 ||
            bestOff < kCountTolerance * target)
            break;
        (count > target ? tooSmall : tooLarge) = scale;
        double next = scale * std::pow(std::max(count, 0.5) / target, 1.0 / Dim);
        if (lastCount > 0 && count > 0 && lastCount != count && lastScale != scale)
            next = scale * std::exp(std::log(target / count) * std::log(lastScale / scale) /
                                    std::log(lastCount / count));
        // Between what was too few and too many, or not too far.
        if (!(next > tooSmall && next < tooLarge))
            next = tooSmall > 0 && tooLarge < std::numeric_limits<double>::infinity()
                       ? std::sqrt(tooSmall * tooLarge)
                       : std::clamp(next, 0.5 * scale, 2 * scale);
        lastScale = scale;
        lastCount = count;
        scale = next;
    }
    options.sizes = scaledSizes(sizes, bestScale, Dim);
    if (!best.interrupted && options.maxCount == 0 && bestOff >= 1.5 &&
        bestOff >= kCountTolerance * target)
        callbacks.warn(fmt::format("{} {} are as near to the {:.0f} asked for as it gets",
                                   best.pack.spheres.size(), Measure<Dim>::kSpheres, target));
    return best;
}

template PackResult<2> packToCount(const Domain<2>&, PackOptions&, double, const Callbacks&,
                                   const std::vector<Sphere<2>>&);
template PackResult<3> packToCount(const Domain<3>&, PackOptions&, double, const Callbacks&,
                                   const std::vector<Sphere<3>>&);

}  // namespace vdbpack
