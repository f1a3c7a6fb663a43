#include "vdbpack/distributed/rank_measures.h"

#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/measure/joined_components.h"
#include "vdbpack/measure/space_shares.h"
#include "vdbpack/report/measured_pack.h"
#include "vdbpack/verify/worst.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>
#include <utility>

namespace vdbpack {

namespace {

/// Radii of all ranks in narrow classes, and their distance to a distribution.
template <int Dim>
class RadiusClasses {
public:
    /// Of `n` spheres of this rank.
    /// @param least, largest  of all, mm.
    /// @param radiusAt  radius of the i-th one, mm; 0: it does not count.
    template <class RadiusAt>
    RadiusClasses(Ranks& ranks, std::size_t n, double least, double largest,
                  const RadiusAt& radiusAt)
        : least_(least * (1 - kRounding)),
          width_((largest * (1 + kRounding) - least_) / kClasses),
          shares_(2 * kClasses) {
        for (std::size_t i = 0; i < n; ++i) {
            const double r = radiusAt(i);
            if (!(r > 0)) continue;
            const auto k = std::min(kClasses - 1, static_cast<std::size_t>((r - least_) / width_));
            ++shares_[k];
            shares_[kClasses + k] +=
                static_cast<std::uint64_t>(std::pow(r / largest, Dim) * kParts);
        }
        ranks.sum(shares_);
    }
    std::uint64_t count() const { return total(0); }
    /// Kolmogorov-Smirnov distance, as exact as the classes are narrow: to 2e-5 for radii that
    /// are spread evenly.
    /// @param upTo, below  share of radii <= r and < r, as for `ksDistance`.
    template <class Share, class ShareBelow>
    double distance(bool byVolume, const Share& upTo, const ShareBelow& below) const {
        const std::size_t first = byVolume ? kClasses : 0;
        const auto all = static_cast<double>(total(first));
        std::uint64_t sum = 0;
        double largest = 0;
        for (std::size_t k = 0; k < kClasses; ++k) {
            sum += shares_[first + k];
            const double edge = least_ + static_cast<double>(k + 1) * width_;
            const double share = static_cast<double>(sum) / all;
            // A radius of a discrete distribution may lie on an edge.
            largest = std::max({largest, below(edge * (1 - kRounding)) - share,
                                share - upTo(edge * (1 + kRounding))});
        }
        return largest;
    }

private:
    static constexpr std::size_t kClasses = 1 << 16;
    static constexpr double kRounding = 1e-6, kParts = 0x1p30;

    std::uint64_t total(std::size_t first) const {
        std::uint64_t sum = 0;
        for (std::size_t k = 0; k < kClasses; ++k) sum += shares_[first + k];
        return sum;
    }

    double least_, width_;
    std::vector<std::uint64_t> shares_;  // by number, then by volume
};

template <int Dim>
RadiusStatistics radiiOver(Ranks& ranks, const std::vector<Sphere<Dim>>& spheres,
                           std::uint64_t total) {
    RadiusStatistics all;
    if (total == 0) return all;
    const RadiusStatistics own = radiusStatistics(spheres);
    const auto n = static_cast<double>(spheres.size()), count = static_cast<double>(total);
    all.min = minOver(&ranks, n > 0 ? own.min : std::numeric_limits<double>::infinity());
    all.max = maxOver(&ranks, own.max);
    all.mean = sumOver(&ranks, n * own.mean) / count;
    const double off = own.mean - all.mean;
    all.sd = std::sqrt(sumOver(&ranks, n * (own.sd * own.sd + off * off)) / count);
    return all;
}

/// A sphere that a check names, and its row.
template <int Dim>
struct Named {
    Sphere<Dim> sphere;
    std::int64_t row;
};

/// Finds the worst of all ranks; their spheres are added to `named`.
template <int Dim>
void mergeWorst(Ranks& ranks, std::vector<std::pair<double, std::array<Named<Dim>, 2>>> own,
                std::size_t each, Pack<Dim>& named,
                const std::function<void(double, std::size_t)>& keep) {
    struct Finding {
        double value;
        Named<Dim> a, b;
    };
    std::vector<Finding> found;
    for (const auto& [value, spheres] : own) found.push_back({value, spheres[0], spheres[1]});
    std::vector<Finding> all = joined(gathered(&ranks, found));
    std::sort(all.begin(), all.end(), [](const Finding& a, const Finding& b) {
        return std::make_tuple(-a.value, a.a.row, a.b.row) <
               std::make_tuple(-b.value, b.a.row, b.b.row);
    });
    for (std::size_t k = 0; k < std::min(all.size(), kWorstNamed); ++k) {
        const std::size_t first = named.spheres.size();
        for (const Named<Dim>* n : {&all[k].a, &all[k].b}) {
            if (named.spheres.size() - first == each) break;
            named.spheres.push_back(n->sphere);
            named.id.push_back(n->row);
        }
        keep(all[k].value, first);
    }
}

ContactSums sumOver(Ranks& ranks, const ContactSums& own) {
    std::size_t bins = 0;
    for (const auto& each : gathered(&ranks, std::vector<std::size_t>{own.histogram.size()}))
        bins = std::max(bins, each.front());
    std::vector<std::uint64_t> numbers{own.spheres, own.partners, own.wallContacts, own.few,
                                       own.deepContacts};
    numbers.insert(numbers.end(), own.fabric.begin(), own.fabric.end());
    numbers.insert(numbers.end(), own.stiffness.begin(), own.stiffness.end());
    const std::size_t first = numbers.size();
    numbers.insert(numbers.end(), own.histogram.begin(), own.histogram.end());
    numbers.resize(first + bins);
    ranks.sum(numbers);
    ContactSums all;
    auto next = numbers.begin();
    for (std::uint64_t* number :
         {&all.spheres, &all.partners, &all.wallContacts, &all.few, &all.deepContacts})
        *number = *next++;
    for (std::uint64_t& number : all.fabric) number = *next++;
    for (std::uint64_t& number : all.stiffness) number = *next++;
    all.histogram.assign(next, numbers.end());
    all.smallestGap = minOver(&ranks, own.smallestGap);
    return all;
}

/// The same as `checkLocalSizes` of one process.
template <int Dim>
void compareLocalSizes(const RankPack<Dim>& share, const SizeDistribution& sizes,
                       const LocalSizes& local, Report& report) {
    Ranks& ranks = *share.ranks;
    const Pack<Dim>& pack = share.pack;
    const std::vector<LocalSize> requested = localSizesOf(pack.spheres, share.domain, local);
    for (auto g = static_cast<std::uint32_t>(local.groups()); g-- > 0;) {
        const SizeDistribution& own = local.sizesOf(g, sizes);
        Report::LocalGroup group = localGroup(local, g, sizes);
        double least = std::numeric_limits<double>::infinity(), most = 0;
        double smallest = own.min() * (1 - kFactorKnown), largest = own.max() * (1 + kFactorKnown);
        const auto radiusAt = [&](std::size_t i) {
            const LocalSize& here = requested[i];
            return i < share.fixed || here.group != g ? 0.0 : pack.spheres[i].radius / here.factor;
        };
        for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
            const double radius = radiusAt(i);
            if (!(radius > 0)) continue;
            least = std::min(least, requested[i].factor);
            most = std::max(most, requested[i].factor);
            smallest = std::min(smallest, radius);
            largest = std::max(largest, radius);
        }
        const RadiusClasses<Dim> classes(ranks, pack.spheres.size(), minOver(&ranks, smallest),
                                         maxOver(&ranks, largest), radiusAt);
        group.factorLeast = minOver(&ranks, least);
        group.factorMost = maxOver(&ranks, most);
        group.count = classes.count();
        if (group.count == 0) continue;
        const VolumeShares volume(own, Dim);
        const auto upTo = [&](double r) { return own.cdf(r * (1 + kFactorKnown)); };
        const auto below = [&](double r) { return own.cdfBelow(r * (1 - kFactorKnown)); };
        group.ks = classes.distance(false, upTo, below);
        group.ksByVolume = classes.distance(
            true, [&](double r) { return volume(upTo(r)); },
            [&](double r) { return volume(below(r)); });
        addLocalGroup(std::move(group), report);
    }
}

/// Protrusion of the spheres of all ranks; the worst are added to `named`.
/// @param distances  set to those of the own spheres to the first wall.
template <int Dim>
ProtrusionCheck protrusionOver(Ranks& ranks, const std::vector<Sphere<Dim>>& spheres,
                               const std::vector<std::int64_t>& rows,
                               const std::vector<const DomainSource*>& walls,
                               std::vector<double>& distances, Pack<Dim>& named) {
    ProtrusionCheck protrusion = walls.front()->protrusion(spheres, &distances);
    for (std::size_t i = 1; i < walls.size(); ++i) {
        const ProtrusionCheck wall = walls[i]->protrusion(spheres);
        if (wall.max > protrusion.max) protrusion = wall;
    }
    std::vector<std::pair<double, std::array<Named<Dim>, 2>>> worst;
    for (const auto& w : protrusion.worst)
        worst.push_back({w.protrusion, {Named<Dim>{spheres[w.i], rows[w.i]}, {}}});
    protrusion.worst.clear();
    mergeWorst<Dim>(ranks, worst, 1, named, [&](double value, std::size_t first) {
        protrusion.worst.push_back({first, value});
    });
    protrusion.max = maxOver(&ranks, protrusion.max);
    protrusion.spheres = sumOver(&ranks, protrusion.spheres);
    protrusion.centersOutside = sumOver(&ranks, protrusion.centersOutside);
    return protrusion;
}

/// What it takes neighbors for, part by part: overlaps, of which the worst are added to `named`,
/// contacts and the smallest gap.
template <int Dim>
void measureNeighbors(Ranks& ranks, Pack<Dim>& pack, const std::vector<std::int64_t>& rows,
                      double tolerance, Report& report, Pack<Dim>& named) {
    const auto& spheres = pack.spheres;
    const double gap = report.requestedGap;
    const double slack = std::max(tolerance, report.count > 0 ? 1.01 * gap / report.radius.min : 0);
    SpaceShares<Dim> shares(ranks, spheres, rows, {slack, 0, pack.cell},
                            pack.cell.all() ? nullptr : &pack.depth);
    JoinedComponents components(ranks);
    ContactSums sums;
    OverlapCheck overlap;
    double smallest = std::numeric_limits<double>::infinity();
    std::vector<std::pair<double, std::array<Named<Dim>, 2>>> worst;
    pack.contacts.assign(spheres.size(), 0);
    for (std::size_t round = 0; round < shares.rounds(); ++round) {
        const auto part = shares.part(round);
        const OverlapCheck here = checkOverlap(part.spheres, part.own);
        overlap.max = std::max(overlap.max, here.max);
        overlap.pairs += here.pairs;
        overlap.complete = overlap.complete && here.complete;
        for (const auto& w : here.worst)
            worst.push_back({w.overlap,
                             {Named<Dim>{part.spheres[w.i], part.rows[w.i]},
                              Named<Dim>{part.spheres[w.j], part.rows[w.j]}}});
        const PartContacts contacts = contactsOfPart(part.spheres, part.own, tolerance, part.depth);
        sums.add(contacts.sums);
        components.add(part.own, contacts.component, part.rows, part.shared);
        shares.handBack(contacts.partners, pack.contacts);
        if (gap > 0) smallest = std::min(smallest, smallestGap(part.spheres).value_or(smallest));
    }
    mergeWorst<Dim>(ranks, worst, 2, named, [&](double value, std::size_t first) {
        overlap.worst.push_back({first, first + 1, value});
    });
    overlap.max = maxOver(&ranks, overlap.max);
    overlap.pairs = sumOver(&ranks, overlap.pairs);
    overlap.complete = !anyOver(&ranks, !overlap.complete);
    report.overlap = overlap;

    sums.add(spheres, tolerance, pack.depth, pack.contacts);
    ContactNetwork contacts = networkOf(sumOver(ranks, sums), Dim);
    const auto joint = components.join();
    contacts.components = joint.components;
    if (report.count > 0) {
        contacts.largestComponent =
            static_cast<double>(joint.largest) / static_cast<double>(report.count);
        report.contacts = contacts;
    }
    smallest = minOver(&ranks, std::min(smallest, contacts.smallestGap));
    if (std::isfinite(smallest) && report.existing == 0) report.smallestGap = smallest;
}

}  // namespace

template <int Dim>
void compareSizes(const RankPack<Dim>& share, const SizeDistribution& sizes,
                  const LocalSizes* local, Report& report) {
    Ranks& ranks = *share.ranks;
    const Pack<Dim>& pack = share.pack;
    report.requested = sizes.spec();
    if (local) return compareLocalSizes(share, sizes, *local, report);
    const VolumeShares volume(sizes, Dim);
    const auto compare = [&](const auto& counts, std::uint64_t& count, double& ks,
                             double& ksByVolume) {
        const RadiusClasses<Dim> classes(
            ranks, pack.spheres.size(), sizes.min(), sizes.max(),
            [&](std::size_t i) { return counts(i) ? pack.spheres[i].radius : 0.0; });
        count = classes.count();
        if (count == 0) return false;
        ks = classes.distance(
            false, [&](double r) { return sizes.cdf(r); },
            [&](double r) { return sizes.cdfBelow(r); });
        ksByVolume = classes.distance(
            true, [&](double r) { return volume(sizes.cdf(r)); },
            [&](double r) { return volume(sizes.cdfBelow(r)); });
        return true;
    };
    Report::WallSizes all, wall;
    if (compare([&](std::size_t i) { return i >= share.fixed; }, all.count, all.ks,
                all.ksByVolume)) {
        report.ks = all.ks;
        report.ksByVolume = all.ksByVolume;
    }
    if (!anyOver(&ranks, !pack.depth.empty())) return;
    wall.depth = 2 * report.radius.max;
    const auto isNear = [&](std::size_t i) {
        return i >= share.fixed && static_cast<double>(pack.depth[i]) <= wall.depth;
    };
    if (compare(isNear, wall.count, wall.ks, wall.ksByVolume)) report.wallSizes = wall;
}

template <int Dim>
Pack<Dim> measureOverRanks(const RankPack<Dim>& share, SphereRows mine,
                           const std::vector<const DomainSource*>& walls, double tolerance,
                           Report& report) {
    Ranks& ranks = *share.ranks;
    Pack<Dim>& pack = share.pack;
    const auto& spheres = pack.spheres;
    const Domain<Dim>& domain = share.domain;
    Pack<Dim> named;

    report.dim = Dim;
    report.ranks = ranks.count();
    report.count = sumOver(&ranks, std::uint64_t{spheres.size()});
    report.hash = sumOver(&ranks, packHash(pack));
    report.radius = radiiOver(ranks, spheres, report.count);
    report.contactTolerance = tolerance;
    report.domain = domain.facts();
    report.volume = domain.volume();
    report.area = domain.wallArea();

    std::vector<double> distances;
    report.protrusion = protrusionOver(ranks, spheres, mine.rows, walls, distances, named);
    if (!pack.cell.all()) pack.depth = walls.front()->depths(spheres, domain, distances);
    distances = {};
    report.solidFractionTotal = report.protrusion->spheres > 0
                                    ? interiorFraction(spheres, domain, 0, mine)
                                    : solidFraction(spheres, domain, &ranks);
    if (!report.interrupted) measureMassOffset(spheres, domain, report, &ranks);
    if (const double interior = 3 * report.radius.max; interior <= domain.fieldDepth())
        report.solidFractionInterior = interiorFraction(spheres, domain, interior, mine);
    measureNeighbors(ranks, pack, mine.rows, tolerance, report, named);
    // The index among all names a sphere.
    if (pack.id.empty()) pack.id = std::move(mine.rows);
    return named;
}

template void compareSizes(const RankPack<2>&, const SizeDistribution&, const LocalSizes*, Report&);
template Pack<2> measureOverRanks(const RankPack<2>&, SphereRows,
                                  const std::vector<const DomainSource*>&, double, Report&);
template void compareSizes(const RankPack<3>&, const SizeDistribution&, const LocalSizes*, Report&);
template Pack<3> measureOverRanks(const RankPack<3>&, SphereRows,
                                  const std::vector<const DomainSource*>&, double, Report&);

}  // namespace vdbpack
