#include "vdbpack/run_stages.h"

#include "vdbpack/core/error.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/recipe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// How far the final count may be from --target-count before the pack is made again.
constexpr double kCountTolerance = 0.018;
constexpr int kCountAttempts = 8;

template <int Dim>
double ksOf(const std::vector<Sphere<Dim>>& spheres, std::size_t from,
            const SizeDistribution& sizes) {
    std::vector<double> radii(spheres.size() - from);
    for (std::size_t i = 0; i < radii.size(); ++i) radii[i] = spheres[from + i].radius;
    return ksDistance(
        std::move(radii), [&](double r) { return sizes.cdf(r); },
        [&](double r) { return sizes.cdfBelow(r); });
}

}  // namespace

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
        if (std::fabs(count - target) < bestOff || result.interrupted) {
            bestOff = std::fabs(count - target);
            bestScale = scale;
            best = std::move(result);
        }
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

template <int Dim>
void measurePack(Pack<Dim>& pack, const DomainSource* source, const Domain<Dim>* domain,
                 const SizeDistribution* sizes, double contactTolerance, Report& report) {
    report.dim = Dim;
    report.count = pack.spheres.size();
    report.hash = packHash(pack);
    report.radius = radiusStatistics(pack.spheres);
    report.overlap = checkOverlap(pack.spheres);
    report.contactTolerance = contactTolerance;
    if (sizes) {
        report.requested = sizes->spec();
        report.ks = ksOf(pack.spheres, report.existing, *sizes);
    }
    if (domain) {
        report.domain = domain->facts();
        report.volume = domain->measure();
        report.area = domain->wallMeasure();
        report.protrusion = source->protrusion(pack.spheres);
        report.solidFractionTotal = solidFraction(pack.spheres, *domain);
        // Of those that stood already, only what stands inside.
        const auto sampler = domain->sampler();
        for (std::size_t i = 0; i < report.existing; ++i)
            if (!sampler->contains(pack.spheres[i].center))
                *report.solidFractionTotal -=
                    Measure<Dim>::ball(pack.spheres[i].radius) / domain->measure();
        const double interior = 3 * report.radius.max;
        if (interior <= domain->fieldDepth())
            report.solidFractionInterior = interiorFraction(pack.spheres, *domain, interior);
        pack.depth = source->depths(pack.spheres, *domain);
    }
    auto contacts = countContacts(pack.spheres, contactTolerance, pack.depth);
    report.contactsMean = contacts.mean;
    // No pair that was not counted is closer than the smallest spheres' tolerance.
    if (report.existing == 0 && contacts.smallestGap <= contactTolerance * report.radius.min)
        report.smallestGap = contacts.smallestGap;
    else
        report.smallestGap = smallestGap(pack.spheres, report.existing);
    pack.contacts = std::move(contacts.counts);
}

template PackResult<2> packToCount(const Domain<2>&, PackOptions&, double, const Callbacks&,
                                   const std::vector<Sphere<2>>&);
template PackResult<3> packToCount(const Domain<3>&, PackOptions&, double, const Callbacks&,
                                   const std::vector<Sphere<3>>&);
template void measurePack<2>(Pack<2>&, const DomainSource*, const Domain<2>*,
                             const SizeDistribution*, double, Report&);
template void measurePack<3>(Pack<3>&, const DomainSource*, const Domain<3>*,
                             const SizeDistribution*, double, Report&);

}  // namespace vdbpack
