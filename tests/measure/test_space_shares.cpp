// Measures of packs that ranks share.
#include "support/sizes.h"
#include "support/test.h"
#include "support/thread_ranks.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/measure/joined_components.h"
#include "vdbpack/measure/pair_correlation.h"
#include "vdbpack/measure/radius_histogram.h"
#include "vdbpack/measure/space_shares.h"
#include "vdbpack/verify/overlap.h"

#include <mutex>

namespace {

/// Spheres that overlap, in clusters, of a mix of sizes.
template <int Dim>
std::vector<Sphere<Dim>> someSpheres(std::size_t count, double side) {
    RandomStream random(5, 1);
    std::vector<Sphere<Dim>> spheres;
    for (std::size_t i = 0; i < count; ++i) {
        Sphere<Dim> s;
        for (int d = 0; d < Dim; ++d) s.center[d] = side * random.uniform();
        s.radius = i % 100 == 0 ? 3 : 0.4 + 0.3 * random.uniform();
        spheres.push_back(s);
        if (i % 500 == 0) spheres.push_back(s);  // a copy
    }
    return spheres;
}

/// What a rank has of spheres that are dealt out as they come (neighbors are those of any rank),
/// and their rows.
template <int Dim>
std::pair<std::vector<Sphere<Dim>>, std::vector<std::int64_t>> dealt(
    const std::vector<Sphere<Dim>>& spheres, const Ranks& ranks) {
    std::pair<std::vector<Sphere<Dim>>, std::vector<std::int64_t>> own;
    for (std::size_t i = 0; i < spheres.size(); ++i)
        if (static_cast<int>(i % 7) % ranks.count() == ranks.rank()) {
            own.first.push_back(spheres[i]);
            own.second.push_back(static_cast<std::int64_t>(i));
        }
    return own;
}

/// Two of three spheres are deep.
std::vector<float> someDepths(std::size_t count) {
    std::vector<float> depths(count);
    for (std::size_t i = 0; i < count; ++i) depths[i] = i % 3 > 0 ? 100 : 0;
    return depths;
}

std::vector<float> ofRows(const std::vector<float>& depths, const std::vector<std::int64_t>& rows) {
    std::vector<float> own;
    for (const auto row : rows) own.push_back(depths[static_cast<std::size_t>(row)]);
    return own;
}

/// The network of contacts whose sums of all ranks are these, by `fabric` and what goes with it.
template <int Dim>
ContactNetwork networkOver(Ranks& ranks, const ContactSums& sums) {
    std::vector<std::uint64_t> numbers(sums.fabric.begin(), sums.fabric.end());
    numbers.insert(numbers.end(), sums.stiffness.begin(), sums.stiffness.end());
    numbers.push_back(sums.deepContacts);
    ranks.sum(numbers);
    ContactSums together;
    std::copy_n(numbers.begin(), 6, together.fabric.begin());
    std::copy_n(numbers.begin() + 6, 21, together.stiffness.begin());
    together.deepContacts = numbers.back();
    return networkOf(together, Dim);
}

/// @param rounding  of differences of images.
void checkDirections(const ContactNetwork& a, const ContactNetwork& b, double rounding) {
    for (std::size_t k = 0; k < 3; ++k) CHECK(length(a.fabric[k] - b.fabric[k]) <= rounding);
    CHECK(a.deepContacts > 1000);
    CHECK(a.deepContacts == b.deepContacts);
    CHECK(a.modulusRatio == Approx(b.modulusRatio).epsilon(rounding));
}

}  // namespace

DIM_TEST_CASE("parts of space find what one pass over all spheres finds") {
    const double side = Dim == 3 ? 48.0 : 198.0, tolerance = 0.01;
    const auto spheres = someSpheres<Dim>(15000, side);
    const int axes = GENERATE(0, 1, 2);  // none, all but y, all
    PeriodicCell<Dim> cell{{{}, Box<Dim>::filled(axes > 0 ? side : 0)}, {}};
    cell.wraps.fill(axes > 0);
    cell.wraps[1] = axes == 2;
    const auto depths = someDepths(spheres.size());
    const ContactCheck all = countContacts(spheres, tolerance, depths, cell);
    const OverlapCheck overlaps = checkOverlap(spheres, cell);
    REQUIRE(all.components > 100);
    REQUIRE(overlaps.pairs > 1000);
    // Differences of images round.
    const auto exactly = [&](double value) { return Approx(value).epsilon(cell.any() ? 1e-9 : 0); };
    const int count = GENERATE(1, 2, 3, 6);
    const auto perPart = GENERATE(100'000ull, 700ull);
    CAPTURE(count, perPart);
    RankOffice office(count);
    std::mutex checking;
    std::vector<std::int32_t> partners(spheres.size());
    onRanks(office, [&](Ranks& ranks) {
        const auto [own, rows] = dealt(spheres, ranks);
        const auto depth = ofRows(depths, rows);
        SpaceShares<Dim> shares(ranks, own, rows, {tolerance, 0, cell}, &depth, perPart);
        JoinedComponents components(ranks);
        ContactSums sums;
        std::vector<std::int32_t> counts(own.size());
        std::uint64_t pairs = 0, seen = 0;
        double largest = 0;
        for (std::size_t round = 0; round < shares.rounds(); ++round) {
            const auto part = shares.part(round);
            seen += part.own;
            const OverlapCheck here = checkOverlap(part.spheres, part.own);
            pairs += here.pairs;
            largest = std::max(largest, here.max);
            const auto contacts = contactsOfPart(part.spheres, part.own, tolerance, part.depth);
            sums.add(contacts.sums);
            components.add(part.own, contacts.component, part.rows, part.shared);
            shares.handBack(contacts.partners, counts);
        }
        pairs = sumOver(&ranks, pairs);
        seen = sumOver(&ranks, seen);
        largest = maxOver(&ranks, largest);
        const ContactNetwork network = networkOver<Dim>(ranks, sums);
        const double gap = minOver(&ranks, sums.smallestGap);
        const auto joined = components.join();
        const std::lock_guard<std::mutex> lock(checking);
        CHECK(seen == spheres.size());
        CHECK(pairs == overlaps.pairs);
        CHECK(largest == exactly(overlaps.max));
        CHECK(gap == exactly(all.smallestGap));
        CHECK(joined.components == all.components);
        CHECK(static_cast<double>(joined.largest) ==
              Approx(all.largestComponent * static_cast<double>(spheres.size())));
        checkDirections(network, all, cell.any() ? 1e-9 : 0);
        for (std::size_t i = 0; i < own.size(); ++i)
            partners[static_cast<std::size_t>(rows[i])] = counts[i];
    });
    CHECK(partners == all.counts);
}

DIM_TEST_CASE("ranks measure the structure that one does") {
    const double side = Dim == 3 ? 40 : 200;
    Box<Dim> box;
    box.lo = Box<Dim>::filled(0);
    box.hi = Box<Dim>::filled(side);
    const auto domain = boxDomain<Dim>(box);
    const auto spheres = someSpheres<Dim>(30000, side);
    std::vector<float> depth;
    const auto sampler = domain->sampler();
    for (const auto& s : spheres)
        depth.push_back(static_cast<float>(-sampler->signedDistance(s.center)));
    const double reach = 4, width = 0.5, edge = 5;
    const auto pairs = [&](const auto& of, const auto& depths, const SphereRows& rows) {
        return *pairCorrelation(of, depths, reach, std::pow(side - 2 * reach, Dim), 30, rows);
    };
    const auto g = pairs(spheres, depth, {});
    const auto profile = densityProfile(spheres, *domain, width, 5.0);
    const auto local = *localFraction(spheres, *domain, edge);
    const auto radii = radiusHistogram(radiiOf(spheres));
    const double interior = *interiorFraction(spheres, *domain, 3);
    RankOffice office(GENERATE(1, 2, 5));
    std::mutex checking;
    onRanks(office, [&](Ranks& ranks) {
        std::vector<Sphere<Dim>> own;
        std::vector<float> ownDepth;
        SphereRows rows{&ranks};
        // The last of five has none.
        for (std::size_t i = 0; i < spheres.size(); ++i)
            if (static_cast<int>(i % 4) % ranks.count() == ranks.rank()) {
                own.push_back(spheres[i]);
                ownDepth.push_back(depth[i]);
                rows.rows.push_back(static_cast<std::int64_t>(i));
            }
        const auto ownG = pairs(own, ownDepth, rows);
        const auto ownProfile = densityProfile(own, *domain, width, 5.0, rows);
        const auto ownLocal = *localFraction(own, *domain, edge, rows);
        const auto ownRadii = radiusHistogram(radiiOf(own), {}, {}, 40, &ranks);
        const double ownInterior = *interiorFraction(own, *domain, 3, rows);
        const std::lock_guard<std::mutex> lock(checking);
        CHECK(ownG.g == g.g);
        CHECK(ownG.references == g.references);
        CHECK(ownG.density == g.density);
        CHECK(ownLocal.mean == local.mean);
        CHECK(ownLocal.sd == local.sd);
        CHECK(ownRadii.counts == radii.counts);
        CHECK(ownInterior == Approx(interior).epsilon(1e-12));
        REQUIRE(ownProfile.fraction.size() == profile.fraction.size());
        for (std::size_t b = 0; b < profile.fraction.size(); ++b) {
            CHECK(ownProfile.fraction[b] == Approx(profile.fraction[b]).epsilon(1e-12));
            CHECK(ownProfile.error[b] == Approx(profile.error[b]).epsilon(1e-12));
        }
    });
}
