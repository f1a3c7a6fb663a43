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

TEST_CASE("pools are handed from neighbor to neighbor, past blocks without spheres") {
    const Box<3> bounds{Box<3>::filled(0), Box<3>::filled(80)};
    const BlockLattice<3> lattice(bounds, 10, 2, 0x1p-20);
    // A shell: what is deeper holds no spheres.
    std::vector<double> spheres(lattice.size());
    std::size_t filled = 0;
    for (std::uint32_t b = 0; b < lattice.size(); ++b) {
        const auto own = lattice.own(b);
        const bool outer =
            std::any_of(own.lo.c.begin(), own.lo.c.end(), [](double x) { return x < 5 || x > 65; });
        spheres[b] = outer ? 100 : 0;
        filled += outer;
    }
    const auto donors = lattice.poolDonors(spheres);
    std::set<std::uint32_t> given;
    for (std::uint32_t b = 0; b < lattice.size(); ++b) {
        const std::uint32_t donor = donors[b];
        if (donor == BlockLattice<3>::kNone) continue;
        CHECK(spheres[donor] > 0);
        CHECK(given.insert(donor).second);
        const auto lower = lattice.lowerNeighbors(b);
        CHECK(std::any_of(lower.begin(), lower.end(),
                          [&](const auto& n) { return n.block == donor; }));
    }
    std::size_t received = 0;
    for (std::uint32_t b = 0; b < lattice.size(); ++b)
        received += spheres[b] > 0 && donors[b] != BlockLattice<3>::kNone;
    // Fewer chains than the shell has rows: 28 whole ones and 36 pairs of ends.
    CHECK(filled - received <= 28);
}

TEST_CASE("an absurd number of blocks is refused") {
    const Box<3> bounds{Box<3>::filled(0), Box<3>::filled(1e6)};
    CHECK_THROWS_AS(BlockLattice<3>(bounds, 1, 0.2, 0x1p-20), ResourceError);
}
