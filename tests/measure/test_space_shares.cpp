// Measures of packs that ranks share.
#include "support/thread_ranks.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/joined_components.h"
#include "vdbpack/measure/space_shares.h"
#include "vdbpack/verify/overlap.h"

#include <catch2/catch.hpp>

#include <mutex>

using namespace vdbpack;

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

}  // namespace

TEMPLATE_TEST_CASE_SIG("parts of space find what one pass over all spheres finds",
                       "[measure][ranks]", ((int Dim), Dim), 2, 3) {
    const auto spheres = someSpheres<Dim>(30000, Dim == 3 ? 60.0 : 280.0);
    const double tolerance = 0.01;
    const ContactCheck all = countContacts(spheres, tolerance);
    const OverlapCheck overlaps = checkOverlap(spheres);
    REQUIRE(all.components > 100);
    REQUIRE(overlaps.pairs > 1000);
    const int count = GENERATE(1, 2, 3, 6);
    const auto perPart = GENERATE(100'000ull, 700ull);
    CAPTURE(count, perPart);
    RankOffice office(count);
    std::mutex checking;
    std::vector<std::int32_t> partners(spheres.size());
    onRanks(office, [&](Ranks& ranks) {
        // Dealt out as they come: neighbors are those of any rank.
        std::vector<Sphere<Dim>> own;
        std::vector<std::int64_t> rows;
        for (std::size_t i = 0; i < spheres.size(); ++i)
            if (static_cast<int>(i % 7) % ranks.count() == ranks.rank()) {
                own.push_back(spheres[i]);
                rows.push_back(static_cast<std::int64_t>(i));
            }
        SpaceShares<Dim> shares(ranks, own, rows, tolerance, perPart);
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
            const PartContacts contacts = contactsOfPart(part.spheres, part.own, tolerance);
            sums.add(contacts.sums);
            components.add(part.own, contacts.component, part.rows, part.shared);
            shares.handBack(contacts.partners, counts);
        }
        pairs = sumOver(&ranks, pairs);
        seen = sumOver(&ranks, seen);
        largest = maxOver(&ranks, largest);
        std::vector<std::uint64_t> fabric(sums.fabric.begin(), sums.fabric.end());
        ranks.sum(fabric);
        const double gap = minOver(&ranks, sums.smallestGap);
        const auto joined = components.join();
        const std::lock_guard<std::mutex> lock(checking);
        CHECK(seen == spheres.size());
        CHECK(pairs == overlaps.pairs);
        CHECK(largest == overlaps.max);
        CHECK(gap == all.smallestGap);
        CHECK(joined.components == all.components);
        CHECK(static_cast<double>(joined.largest) ==
              Approx(all.largestComponent * static_cast<double>(spheres.size())));
        ContactSums together;
        std::copy(fabric.begin(), fabric.end(), together.fabric.begin());
        CHECK(networkOf(together, Dim).fabric == all.fabric);
        for (std::size_t i = 0; i < own.size(); ++i)
            partners[static_cast<std::size_t>(rows[i])] = counts[i];
    });
    CHECK(partners == all.counts);
}
