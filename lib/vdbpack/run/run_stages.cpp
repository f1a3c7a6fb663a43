#include "vdbpack/run/run_stages.h"

#include "vdbpack/core/error.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/run/void_stage.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <tbb/info.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// How far the final count may be from --target-count before the pack is made again.
constexpr double kCountTolerance = 0.018;
constexpr int kCountAttempts = 8;

/// Bins of the density profile, how deep it goes, and cells of the local fraction, in diameters
/// (mean, largest, mean).
constexpr double kProfileWidth = 0.125, kProfileDepth = 5, kLocalEdge = 4;
/// Bins of the pair correlation a mean diameter, and centers that give an error of about 1 %.
constexpr double kPairBins = 40;
constexpr std::uint64_t kManyReferences = 2000;

/// Distances of some spheres' radii to those asked for, by number and by volume.
template <int Dim>
struct SizeCheck {
    explicit SizeCheck(const SizeDistribution& sizes) : asked(sizes), volume(sizes, Dim) {}
    double byNumber(std::vector<double> radii) const {
        return ksDistance(
            std::move(radii), [&](double r) { return asked.cdf(r); },
            [&](double r) { return asked.cdfBelow(r); });
    }
    double byVolume(std::vector<double> radii) const {
        return ksDistance(
            std::move(radii), [&](double r) { return volume(asked.cdf(r)); },
            [&](double r) { return volume(asked.cdfBelow(r)); }, Dim);
    }

    const SizeDistribution& asked;
    VolumeShares volume;
};

template <int Dim>
void checkSizes(const Pack<Dim>& pack, const SizeDistribution& sizes, Report& report) {
    const SizeCheck<Dim> check(sizes);
    std::vector<double> radii, atWall;
    const double near = 2 * report.radius.max;
    for (std::size_t i = report.existing; i < pack.spheres.size(); ++i) {
        radii.push_back(pack.spheres[i].radius);
        if (!pack.depth.empty() && static_cast<double>(pack.depth[i]) <= near)
            atWall.push_back(radii.back());
    }
    if (radii.empty()) return;
    report.ks = check.byNumber(radii);
    report.ksByVolume = check.byVolume(std::move(radii));
    if (atWall.empty()) return;
    Report::WallSizes wall;
    wall.depth = near;
    wall.count = atWall.size();
    wall.ks = check.byNumber(atWall);
    wall.ksByVolume = check.byVolume(std::move(atWall));
    report.wallSizes = wall;
}

}  // namespace

std::uint64_t peakMemory() {
    // What getrusage tells goes back to before the program was started, by one that may hold more.
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (std::uint64_t kibibytes = 0; word == "VmHWM:" && status >> kibibytes)
            return kibibytes * 1024;
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

int effectiveThreads(int threads) {
    return threads > 0 ? threads : tbb::info::default_concurrency();
}

bool passed(const Report& report) {
    return (!report.overlap || report.overlap->pairs == report.givenOverlaps) &&
           (!report.protrusion || report.protrusion->spheres == report.givenProtrusions) &&
           keepsGap(report);
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

template <int Dim>
void measurePack(Pack<Dim>& pack, const DomainSource* source, const Domain<Dim>* domain,
                 const SizeDistribution* sizes, double contactTolerance, Report& report,
                 const Callbacks& callbacks) {
    const auto goesOn = [&] {
        report.interrupted = report.interrupted || callbacks.isCancelled();
        return !report.interrupted;
    };
    report.dim = Dim;
    report.count = pack.spheres.size();
    report.hash = packHash(pack);
    report.radius = radiusStatistics(pack.spheres);
    report.overlap = checkOverlap(pack.spheres);
    report.contactTolerance = contactTolerance;
    // Whoever wrote them: nothing is known of that wall.
    pack.depth.clear();
    pack.contacts.clear();
    if (domain) {
        report.domain = domain->facts();
        report.volume = domain->volume();
        report.area = domain->wallArea();
        report.protrusion = source->protrusion(pack.spheres);
        report.solidFractionTotal = solidFraction(pack.spheres, *domain);
        // Only what is inside counts.
        if (report.protrusion->spheres > 0)
            report.solidFractionTotal = interiorFraction(pack.spheres, *domain, 0);
        const double interior = 3 * report.radius.max;
        if (interior <= domain->fieldDepth() && goesOn())
            report.solidFractionInterior = interiorFraction(pack.spheres, *domain, interior);
        if (goesOn()) pack.depth = source->depths(pack.spheres, *domain);
    }
    std::optional<ContactCheck> contacts;
    if (goesOn()) contacts = countContacts(pack.spheres, contactTolerance, pack.depth);
    if (!pack.spheres.empty()) report.contacts = contacts;
    if (sizes && goesOn()) measureSizes(pack, *sizes, report);
    // No pair that was not counted is closer than the smallest spheres' tolerance.
    if (contacts && report.existing == 0 &&
        contacts->smallestGap <= contactTolerance * report.radius.min)
        report.smallestGap = contacts->smallestGap;
    else if (report.gapAsked > 0 || goesOn())
        report.smallestGap = smallestGap(pack.spheres, report.existing);
    if (contacts) pack.contacts = std::move(contacts->counts);
}

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

void requireShell(double shell, const DomainSource& source) {
    if (!(shell > 0) || !source.isFile()) return;  // a shape has no field to be made
    const Vec<3> size = source.fileBounds().size();
    const double thin = *std::min_element(size.c.begin(), size.c.begin() + source.dim());
    if (2 * shell < thin) return;
    throw InputError(fmt::format(
        "--shell {} mm: everything is cortical, the domain is {:.4g} mm thick at the most; give a "
        "thinner shell, or check the unit of the domain",
        shell, thin));
}

double structureDepth(const RadiusStatistics& radius, double shell) {
    return std::max({3 * radius.max, 6.05 * radius.mean, 1.05 * shell});
}

template <int Dim>
void measureSizes(const Pack<Dim>& pack, const SizeDistribution& sizes, Report& report) {
    report.requested = sizes.spec();
    checkSizes(pack, sizes, report);
}

template <int Dim>
Structure measureStructure(const Pack<Dim>& pack, const Domain<Dim>* domain, const Report& report,
                           double shell, const Callbacks& callbacks) {
    Structure result;
    if (pack.spheres.empty()) return result;
    result.dim = Dim;
    result.meanDiameter = 2 * report.radius.mean;
    const double known =
        domain ? std::min(domain->fieldDepth(), length(domain->bounds().size())) : 0;
    if (domain) {
        // Bins of an eighth of the mean diameter, to five largest diameters deep or as deep as the
        // field knows.
        const double width = kProfileWidth * result.meanDiameter;
        const double deepest = std::min(known, kProfileDepth * 2 * report.radius.max);
        if (deepest >= width)
            result.profile = densityProfile(pack.spheres, *domain, width, deepest);
        callbacks.stopIfCancelled();
        const double edge = kLocalEdge * result.meanDiameter;
        if (domain->bounds().measure() < 1e8 * std::pow(edge, Dim))
            result.local = localFraction(pack.spheres, *domain, edge);
    }
    callbacks.stopIfCancelled();
    // As far as there are enough centers that deep; without a domain the density is not known.
    for (const double diameters : {3.0, 2.25, 1.5}) {
        const double reach = diameters * result.meanDiameter;
        if (!domain || reach > known) continue;
        result.pairCorrelation =
            pairCorrelation(pack.spheres, pack.depth, reach, domain->volumeDeeperThan(reach),
                            static_cast<int>(diameters * kPairBins));
        if (result.pairCorrelation && result.pairCorrelation->references >= kManyReferences) break;
    }
    callbacks.stopIfCancelled();
    if (domain && shell > 0) {
        if (shell > known)
            throw ParameterError(fmt::format(
                "--shell {} mm: the field knows depths up to {:.4g} mm; give a thinner shell",
                shell, known));
        result.shell = shell;
        const double all = domain->volume(), core = domain->volumeDeeperThan(shell);
        const auto inner = interiorFraction(pack.spheres, *domain, shell);
        const double coreSolid = inner ? *inner * core : 0;
        result.regions.push_back({"cortical", all - core,
                                  (*report.solidFractionTotal * all - coreSolid) / (all - core)});
        if (inner) result.regions.push_back({"trabecular", core, *inner});
    }
    return result;
}

template PackResult<2> packToCount(const Domain<2>&, PackOptions&, double, const Callbacks&,
                                   const std::vector<Sphere<2>>&);
template PackResult<3> packToCount(const Domain<3>&, PackOptions&, double, const Callbacks&,
                                   const std::vector<Sphere<3>>&);
template Structure measureStructure<2>(const Pack<2>&, const Domain<2>*, const Report&, double,
                                       const Callbacks&);
template Structure measureStructure<3>(const Pack<3>&, const Domain<3>*, const Report&, double,
                                       const Callbacks&);
template void measureSizes(const Pack<2>&, const SizeDistribution&, Report&);
template void measureSizes(const Pack<3>&, const SizeDistribution&, Report&);
template void measurePack<2>(Pack<2>&, const DomainSource*, const Domain<2>*,
                             const SizeDistribution*, double, Report&, const Callbacks&);
template void measurePack<3>(Pack<3>&, const DomainSource*, const Domain<3>*,
                             const SizeDistribution*, double, Report&, const Callbacks&);

}  // namespace vdbpack
