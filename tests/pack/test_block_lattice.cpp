#include "support/test.h"

#include "vdbpack/pack/block_lattice.h"

DIM_TEST_CASE("blocks cover the domain and wait for lower neighbors only") {
    Box<Dim> bounds;
    bounds.lo = Box<Dim>::filled(-3.3);
    bounds.hi = Box<Dim>::filled(41.7);
    bounds.hi[0] = 70;
    const BlockLattice<Dim> lattice(bounds, 10, 2, 0x1p-20);
    std::vector<std::size_t> at(lattice.size());
    for (std::size_t i = 0; i < lattice.size(); ++i) at[lattice.order()[i]] = i;
    double own = 0, search = 0;
    for (std::uint32_t b = 0; b < lattice.size(); ++b) {
        own += lattice.own(b).volume();
        search += lattice.search(b).volume();
        for (const auto lower : lattice.lowerNeighbors(b)) CHECK(at[lower.block] < at[b]);
        for (const auto donor : lattice.poolDonors(b)) CHECK(at[donor] < at[b]);
    }
    // Both cover the lattice once: the searched parts lag behind but leave nothing out.
    CHECK(own == Approx(search));
    CHECK(own >= bounds.volume());
    CHECK(lattice.longestChain() <= lattice.size());
}

TEST_CASE("of two blocks side by side one always waits for the other") {
    const Box<3> bounds{Box<3>::filled(0), Box<3>::filled(50)};
    const BlockLattice<3> lattice(bounds, 10, 2, 0x1p-20);
    std::set<std::pair<std::uint32_t, std::uint32_t>> waits;
    for (std::uint32_t b = 0; b < lattice.size(); ++b)
        for (const auto lower : lattice.lowerNeighbors(b)) waits.insert({b, lower.block});
    for (std::uint32_t a = 0; a < lattice.size(); ++a)
        for (std::uint32_t b = 0; b < a; ++b) {
            const auto common = intersection(lattice.own(a).grown(1), lattice.own(b).grown(1));
            if (!common.empty()) CHECK(waits.count({a, b}) + waits.count({b, a}) == 1);
        }
}

TEST_CASE("every row but the last few hands its pool on") {
    const Box<3> bounds{Box<3>::filled(0), Box<3>::filled(80)};
    const BlockLattice<3> lattice(bounds, 10, 2, 0x1p-20);
    std::set<std::uint32_t> given;
    for (std::uint32_t b = 0; b < lattice.size(); ++b)
        for (const auto donor : lattice.poolDonors(b)) CHECK(given.insert(donor).second);
    // 64 rows of 8: at most those still open when the last row starts keep theirs.
    CHECK(lattice.size() - given.size() <= 16);
}

TEST_CASE("an absurd number of blocks is refused") {
    const Box<3> bounds{Box<3>::filled(0), Box<3>::filled(1e6)};
    CHECK_THROWS_AS(BlockLattice<3>(bounds, 1, 0.2, 0x1p-20), ResourceError);
}
