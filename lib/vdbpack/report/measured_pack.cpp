#include "vdbpack/report/measured_pack.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/core_volume.h"
#include "vdbpack/domain/intersection_domain.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/voids/cull.h"

#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// Width of bins of the density profile (in mean diameters), its depth (in largest diameters), and
/// side of the cells of the local fraction (in mean diameters).
constexpr double kProfileWidth = 0.125, kProfileDepth = 5, kLocalEdge = 4;
/// Bins of the pair correlation per mean diameter, and number of centers for an error of about 1 %.
constexpr double kPairBins = 40;
constexpr std::uint64_t kManyReferences = 2000;

/// Kolmogorov-Smirnov distances of radii to the requested distribution, by number and by volume.
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
    const double near = 2 * report.radius.max;
    std::vector<double> radii, atWall;
    radii.reserve(pack.spheres.size() - report.existing);
    for (std::size_t i = report.existing; i < pack.spheres.size(); ++i) {
        radii.push_back(pack.spheres[i].radius);
        if (!pack.depth.empty() && static_cast<double>(pack.depth[i]) <= near)
            atWall.push_back(radii.back());
    }
    if (radii.empty()) return;
    // Once for both distances of each.
    tbb::parallel_sort(radii.begin(), radii.end());
    tbb::parallel_sort(atWall.begin(), atWall.end());
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

/// Each group of sizes, of radii divided by the local factor, and the worst of them.
template <int Dim>
void checkLocalSizes(const Pack<Dim>& pack, const SizeDistribution& sizes, const LocalSizes& local,
                     const Domain<Dim>& domain, Report& report) {
    const std::vector<LocalSize> requested = localSizesOf(pack.spheres, domain, local);
    for (auto g = static_cast<std::uint32_t>(local.groups()); g-- > 0;) {
        Report::LocalGroup group = localGroup(local, g, sizes);
        const SizeDistribution& own = local.sizesOf(g, sizes);
        std::vector<double> radii;
        for (std::size_t i = report.existing; i < pack.spheres.size(); ++i) {
            const LocalSize& here = requested[i];
            if (here.group != g) continue;
            const bool first = radii.empty();
            group.factorLeast = first ? here.factor : std::min(group.factorLeast, here.factor);
            group.factorMost = first ? here.factor : std::max(group.factorMost, here.factor);
            radii.push_back(pack.spheres[i].radius / here.factor);
        }
        group.count = radii.size();
        if (radii.empty()) continue;
        tbb::parallel_sort(radii.begin(), radii.end());
        const VolumeShares volume(own, Dim);
        const auto upTo = [&](double r) { return own.cdf(r * (1 + kFactorKnown)); };
        const auto below = [&](double r) { return own.cdfBelow(r * (1 - kFactorKnown)); };
        group.ks = ksDistance(radii, upTo, below);
        group.ksByVolume = ksDistance(
            std::move(radii), [&](double r) { return volume(upTo(r)); },
            [&](double r) { return volume(below(r)); }, Dim);
        addLocalGroup(std::move(group), report);
    }
}

/// The layer of a thickness along the wall, and the part that it encloses, if any.
template <int Dim>
std::vector<RegionFraction> regionsOf(const Pack<Dim>& pack, const Domain<Dim>& domain,
                                      double shell, double solidFraction, const SphereRows& rows) {
    const Domain<Dim>& envelope = domain.envelope();
    const double all = domain.volume(), core = coreVolume(domain, shell);
    // Spheres lie in the domain: those below the shell of the envelope are in the core.
    const auto inner = interiorFraction(pack.spheres, envelope, shell, rows);
    const double coreSolid = inner && core > 0 ? *inner * envelope.volumeDeeperThan(shell) : 0;
    RegionFraction outside, inside;
    outside.name = "cortical";
    outside.volume = all - core;
    outside.solidFraction = (solidFraction * all - coreSolid) / (all - core);
    inside.name = "trabecular";
    inside.volume = core;
    inside.solidFraction = core > 0 ? coreSolid / core : 0;
    const auto deep = deeperThan(pack.spheres, domain, shell);
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        RegionFraction& region = deep[i] ? inside : outside;
        ++region.count;
        region.meanRadius += pack.spheres[i].radius;
    }
    for (RegionFraction* region : {&outside, &inside}) {
        region->count = sumOver(rows.ranks, region->count);
        region->meanRadius = sumOver(rows.ranks, region->meanRadius);
        if (region->count > 0) region->meanRadius /= static_cast<double>(region->count);
    }
    if (!(core > 1e-9 * all)) return {outside};
    return {outside, inside};
}

}  // namespace

template <int Dim>
void measurePack(Pack<Dim>& pack, const DomainSource* source, const Domain<Dim>* domain,
                 const SizeDistribution* sizes, double contactTolerance, Report& report,
                 const Callbacks& callbacks, const LocalSizes* local) {
    const auto goesOn = [&] {
        report.interrupted = report.interrupted || callbacks.isCancelled();
        return !report.interrupted;
    };
    report.dim = Dim;
    report.count = pack.spheres.size();
    report.hash = packHash(pack);
    report.radius = radiusStatistics(pack.spheres);
    if (domain) pack.cell = domain->cell();
    report.overlap = checkOverlap(pack.spheres, pack.cell);
    report.contactTolerance = contactTolerance;
    // Values from a file may refer to another wall.
    pack.depth.clear();
    pack.contacts.clear();
    if (domain) {
        report.domain = domain->facts();
        report.volume = domain->volume();
        report.area = domain->wallArea();
        std::vector<double> distances;
        report.protrusion = source->protrusion(pack.spheres, &distances);
        report.solidFractionTotal = solidFraction(pack.spheres, *domain);
        // Only the parts of spheres inside the domain count.
        if (report.protrusion->spheres > 0)
            report.solidFractionTotal = interiorFraction(pack.spheres, *domain, 0);
        const double interior = 3 * report.radius.max;
        if (interior <= domain->fieldDepth() && goesOn())
            report.solidFractionInterior = interiorFraction(pack.spheres, *domain, interior);
        if (goesOn()) measureMassOffset(pack.spheres, *domain, report);
        // Without walls there is no depth.
        if (!pack.cell.all() && goesOn())
            pack.depth = source->depths(pack.spheres, *domain, distances);
    }
    std::optional<ContactCheck> contacts;
    if (goesOn()) contacts = countContacts(pack.spheres, contactTolerance, pack.depth, pack.cell);
    if (!pack.spheres.empty()) report.contacts = contacts;
    if (sizes && goesOn()) measureSizes(pack, *sizes, report, local, domain);
    // Pairs that were not counted have larger gaps than the tolerance of the smallest spheres.
    if (contacts && report.existing == 0 &&
        contacts->smallestGap <= contactTolerance * report.radius.min)
        report.smallestGap = contacts->smallestGap;
    else if (report.requestedGap > 0 || goesOn())
        report.smallestGap = smallestGap(pack.spheres, report.existing, pack.cell);
    if (contacts) pack.contacts = std::move(contacts->counts);
}

template <int Dim>
void measureMassOffset(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                       Report& report, Ranks* ranks) {
    const bool removed = report.voids && (report.voids->culled > 0 || report.voids->reachedShare);
    if (!removed && report.protrusion->centersOutside == 0)
        report.massOffset = massOffset(spheres, domain, ranks);
}

template <int Dim>
void warnOfUnion(const std::string& file, const Pack<Dim>& pack, const Report& report,
                 const Callbacks& callbacks) {
    constexpr double kLeast = 1e-3;  // of the sum: less is in the digits that are printed
    if (!report.overlap || report.overlap->pairs == 0 || !report.overlap->complete) return;
    const double share = unionShare(pack.spheres, pack.cell);
    if (share > 1 - kLeast) return;
    const auto& fraction = report.solidFractionTotal;
    callbacks.warn(fmt::format(
        "{}: {} pairs overlap, and solid fractions count their overlaps twice. The union has "
        "{:.4f} "
        "of the sum of all {}{}",
        file, report.overlap->pairs, share, Dim == 3 ? "volumes" : "areas",
        fraction
            ? fmt::format(": a solid fraction of {:.4f} for {:.4f}", *fraction * share, *fraction)
            : std::string()));
}

double structureDepth(const RadiusStatistics& radius, double shell) {
    return std::max({3 * radius.max, 6.05 * radius.mean, 1.05 * shell});
}

Report::LocalGroup localGroup(const LocalSizes& local, std::uint32_t group,
                              const SizeDistribution& sizes) {
    Report::LocalGroup named;
    named.name = local.groups() == 1 ? "all" : group == 1 ? "shell" : "inside";
    named.requested = local.sizesOf(group, sizes).spec();
    return named;
}

void addLocalGroup(Report::LocalGroup group, Report& report) {
    report.ks = std::max(report.ks.value_or(0), group.ks);
    report.ksByVolume = std::max(report.ksByVolume.value_or(0), group.ksByVolume);
    report.localSizes.push_back(std::move(group));
}

template <int Dim>
void measureSizes(const Pack<Dim>& pack, const SizeDistribution& sizes, Report& report,
                  const LocalSizes* local, const Domain<Dim>* domain) {
    report.requested = sizes.spec();
    if (local && local->any()) return checkLocalSizes(pack, sizes, *local, *domain, report);
    checkSizes(pack, sizes, report);
}

template <int Dim>
Structure measureStructure(const Pack<Dim>& pack, const Domain<Dim>* domain, const Report& report,
                           double shell, const Callbacks& callbacks, const SphereRows& rows) {
    Structure result;
    if (report.count == 0) return result;
    result.dim = Dim;
    result.meanDiameter = 2 * report.radius.mean;
    const double known =
        domain ? std::min(domain->fieldDepth(), length(domain->bounds().size())) : 0;
    if (domain) {
        // To five largest diameters deep, or as deep as the field has distances.
        const double width = kProfileWidth * result.meanDiameter;
        const double deepest = std::min(known, kProfileDepth * 2 * report.radius.max);
        if (deepest >= width && !domain->cell().all())
            result.profile = densityProfile(pack.spheres, *domain, width, deepest, rows);
        callbacks.stopIfCancelled();
        const double edge = kLocalEdge * result.meanDiameter;
        if (domain->bounds().volume() < 1e8 * std::pow(edge, Dim))
            result.local = localFraction(pack.spheres, *domain, edge, rows);
    }
    callbacks.stopIfCancelled();
    // The largest range with enough centers at that depth. Without a domain the density is unknown.
    for (const double diameters : {3.0, 2.25, 1.5}) {
        const double reach = diameters * result.meanDiameter;
        if (!domain || reach > known || reach > 0.5 * domain->cell().shortest()) continue;
        result.pairCorrelation =
            pairCorrelation(pack.spheres, pack.depth, reach, domain->volumeDeeperThan(reach),
                            static_cast<int>(diameters * kPairBins), rows, domain->cell());
        if (result.pairCorrelation && result.pairCorrelation->references >= kManyReferences) break;
    }
    callbacks.stopIfCancelled();
    if (domain && shell > 0) {
        if (shell > known)
            throw ParameterError(fmt::format(
                "`shell` {} mm: the field has depths up to {:.4g} mm; give a thinner shell", shell,
                known));
        result.shell = shell;
        result.regions = regionsOf(pack, *domain, shell, *report.solidFractionTotal, rows);
    }
    return result;
}

#define VDBPACK_INSTANTIATE(Dim)                                                                  \
    template Structure measureStructure<Dim>(const Pack<Dim>&, const Domain<Dim>*, const Report&, \
                                             double, const Callbacks&, const SphereRows&);        \
    template void measureSizes(const Pack<Dim>&, const SizeDistribution&, Report&,                \
                               const LocalSizes*, const Domain<Dim>*);                            \
    template void measurePack<Dim>(Pack<Dim>&, const DomainSource*, const Domain<Dim>*,           \
                                   const SizeDistribution*, double, Report&, const Callbacks&,    \
                                   const LocalSizes*);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

template <int Dim>
RadiusHistogram radiiOf(const Pack<Dim>& pack, std::size_t existing, const SizeDistribution* sizes,
                        Ranks* ranks) {
    std::vector<double> radii;
    for (std::size_t i = existing; i < pack.spheres.size(); ++i)
        radii.push_back(pack.spheres[i].radius);
    if (!sizes) return radiusHistogram(radii);
    return radiusHistogram(
        radii, [&](double r) { return sizes->cdfBelow(r); }, {sizes->min(), sizes->max()}, 40,
        ranks);
}

template <int Dim>
PageDetails pageDetails(const Pack<Dim>& pack, std::size_t fixed, const DomainSource& source,
                        const DomainSource* around, const Domain<Dim>& domain,
                        const SizeDistribution& sizes, const Report& report,
                        const Callbacks& callbacks, const SphereRows& rows) {
    PageDetails details;
    // Radii by place have no distribution of their own.
    details.radii = radiiOf(pack, fixed, report.localSizes.empty() ? &sizes : nullptr, rows.ranks);
    // Its layers are those of one thickness.
    const double shell = report.voids && !report.voids->leastShell ? report.voids->shell : 0;
    const double depth = structureDepth(report.radius, shell);
    if (report.count == 0 || domain.fieldDepth() >= depth) {
        details.structure = measureStructure(pack, &domain, report, shell, callbacks, rows);
        return details;
    }
    const double detail = fieldDetail(report.radius.min, report.radius.mean);
    auto space = ofDim<Dim>(source.build(detail, depth / 3, callbacks));
    if constexpr (Dim == 3)
        if (around) space = partDomain(space, around->build(detail, depth / 3, callbacks).space);
    details.structure = measureStructure(pack, space.get(), report, shell, callbacks, rows);
    return details;
}

template PageDetails pageDetails<2>(const Pack<2>&, std::size_t, const DomainSource&,
                                    const DomainSource*, const Domain<2>&, const SizeDistribution&,
                                    const Report&, const Callbacks&, const SphereRows&);
template PageDetails pageDetails<3>(const Pack<3>&, std::size_t, const DomainSource&,
                                    const DomainSource*, const Domain<3>&, const SizeDistribution&,
                                    const Report&, const Callbacks&, const SphereRows&);

template RadiusHistogram radiiOf(const Pack<2>&, std::size_t, const SizeDistribution*, Ranks*);
template RadiusHistogram radiiOf(const Pack<3>&, std::size_t, const SizeDistribution*, Ranks*);

template void measureMassOffset(const std::vector<Sphere<2>>&, const Domain<2>&, Report&, Ranks*);
template void measureMassOffset(const std::vector<Sphere<3>>&, const Domain<3>&, Report&, Ranks*);

template void warnOfUnion(const std::string&, const Pack<2>&, const Report&, const Callbacks&);
template void warnOfUnion(const std::string&, const Pack<3>&, const Report&, const Callbacks&);

}  // namespace vdbpack
