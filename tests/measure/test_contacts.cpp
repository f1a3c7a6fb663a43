#include "measure/packs.h"
#include "support/test.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/core/symmetric.h"
#include "vdbpack/measure/contacts.h"

#include <numeric>
#include <tuple>

TEST_CASE("lattices have 6, 8 and 12 contacts") {
    const auto [lattice, expected] =
        GENERATE(std::make_tuple(Lattice::sc, 6), std::make_tuple(Lattice::bcc, 8),
                 std::make_tuple(Lattice::fcc, 12));
    double edge = 0;
    auto spheres = latticeSpheres(lattice, 8, edge);
    for (auto& s : spheres) s.center += Vec<3>{{900, -500, 333}};
    const auto check = countContacts(spheres, 1e-3);
    const double lo = 1.5 * edge, hi = 6 * edge;
    int inner = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const Vec<3> x = spheres[i].center - Vec<3>{{900, -500, 333}};
        if (*std::min_element(x.c.begin(), x.c.end()) < lo ||
            *std::max_element(x.c.begin(), x.c.end()) > hi)
            continue;
        ++inner;
        REQUIRE(check.counts[i] == expected);
    }
    REQUIRE(inner > 20);
    REQUIRE(check.mean ==
            Approx(2.0 * static_cast<double>(check.pairs) / static_cast<double>(spheres.size())));
}

DIM_TEST_CASE("contacts are those of an all-pairs search") {
    const double tolerance = GENERATE(1e-3, 0.05, 1.0);
    const double ratio = GENERATE(1.0, 20.0);
    CAPTURE(Dim, tolerance, ratio);
    const auto spheres = randomSpheres<Dim>(500, 40, 0.5, ratio, 12);
    std::vector<std::int32_t> expected(spheres.size());
    for (std::size_t i = 0; i < spheres.size(); ++i)
        for (std::size_t j = 0; j < spheres.size(); ++j)
            expected[i] += i != j && gap(spheres[i], spheres[j]) <
                                         tolerance * std::min(spheres[i].radius, spheres[j].radius);
    const auto check = countContacts(spheres, tolerance);
    REQUIRE(check.counts == expected);

    // What they form.
    Matrix<3> fabric{};
    double pairs = 0;
    std::vector<std::size_t> set(spheres.size());
    std::iota(set.begin(), set.end(), std::size_t{0});
    for (std::size_t i = 0; i < spheres.size(); ++i)
        for (std::size_t j = i + 1; j < spheres.size(); ++j) {
            if (!(gap(spheres[i], spheres[j]) <
                  tolerance * std::min(spheres[i].radius, spheres[j].radius)))
                continue;
            const auto n = normalized(spheres[j].center - spheres[i].center);
            for (int p = 0; p < Dim; ++p)
                for (int q = 0; q < Dim; ++q) fabric[static_cast<std::size_t>(p)][q] += n[p] * n[q];
            ++pairs;
            const std::size_t from = set[j], to = set[i];
            std::replace(set.begin(), set.end(), from, to);
        }
    for (std::size_t p = 0; p < 3; ++p)
        for (int q = 0; q < 3; ++q)
            CHECK(check.fabric[p][q] == Approx(fabric[p][q] / std::max(pairs, 1.0)).margin(1e-8));
    std::vector<std::size_t> members(spheres.size());
    for (const std::size_t s : set) ++members[s];
    const auto total = static_cast<double>(spheres.size());
    CHECK(check.largestComponent ==
          Approx(static_cast<double>(*std::max_element(members.begin(), members.end())) / total));
    CHECK(static_cast<double>(check.components) ==
          total - static_cast<double>(std::count(members.begin(), members.end(), 0u)));
    for (std::size_t n = 0; n < check.histogram.size(); ++n)
        CHECK(check.histogram[n] == static_cast<std::uint64_t>(std::count(
                                        expected.begin(), expected.end(), static_cast<int>(n))));
    CHECK(check.few == Dim + 1);
    CHECK(check.fewShare ==
          Approx(static_cast<double>(std::count_if(expected.begin(), expected.end(),
                                                   [](int n) { return n < Dim + 1; })) /
                 total));
}

TEST_CASE("the fabric of cubic lattices is isotropic and of one component") {
    const auto lattice = GENERATE(Lattice::sc, Lattice::bcc, Lattice::fcc);
    double edge = 0;
    auto spheres = latticeSpheres(lattice, 7, edge);
    // Six cells with all their faces: as symmetric as the lattice.
    spheres.erase(std::remove_if(spheres.begin(), spheres.end(),
                                 [&](const Sphere<3>& s) {
                                     return *std::max_element(s.center.c.begin(),
                                                              s.center.c.end()) > 6.1 * edge;
                                 }),
                  spheres.end());
    const auto check = countContacts(spheres, 1e-3);
    const auto eigen = eigenSystem<3>(check.fabric);
    for (int i = 0; i < 3; ++i) CHECK(eigen.values[i] == Approx(1.0 / 3).epsilon(1e-6));
    CHECK(check.components == 1);
    CHECK(check.largestComponent == 1);
    // Stretched along z, the layers of a simple cubic lattice part.
    if (lattice != Lattice::sc) return;
    auto layers = spheres;
    for (auto& s : layers) s.center[2] *= 1.1;
    const auto parted = countContacts(layers, 1e-3);
    CHECK(parted.components == 7);
    CHECK(eigenSystem<3>(parted.fabric).values[2] == Approx(0).margin(1e-9));
    CHECK(eigenSystem<3>(parted.fabric).values[0] == Approx(0.5).epsilon(1e-6));
}

TEST_CASE("contacts are the same for any number of threads") {
    const auto spheres = randomSpheres<3>(20000, 60, 0.5, 3, 5);
    std::vector<ContactCheck> checks;
    for (const int threads : {1, 2, 8})
        withThreads(threads, [&] { checks.push_back(countContacts(spheres, 1e-2)); });
    for (const auto& check : checks) {
        CHECK(check.counts == checks[0].counts);
        CHECK(check.fabric == checks[0].fabric);
        CHECK(check.components == checks[0].components);
        CHECK(check.largestComponent == checks[0].largestComponent);
    }
}

DIM_TEST_CASE("the list of contacts is that of an all-pairs search") {
    const double tolerance = GENERATE(0.0, 1e-3, 0.05, 1.0);
    const double ratio = GENERATE(1.0, 20.0);
    const auto seed = GENERATE(range(1u, 6u));
    CAPTURE(Dim, tolerance, ratio, seed);
    const auto spheres = randomSpheres<Dim>(500, 40, 0.5, ratio, seed);
    std::vector<std::tuple<std::uint32_t, std::uint32_t, double>> expected;
    for (std::uint32_t i = 0; i < spheres.size(); ++i)
        for (std::uint32_t j = i + 1; j < spheres.size(); ++j)
            if (gap(spheres[i], spheres[j]) <
                tolerance * std::min(spheres[i].radius, spheres[j].radius))
                expected.emplace_back(i, j, gap(spheres[i], spheres[j]));
    const auto found = [&](int threads) {
        std::vector<std::tuple<std::uint32_t, std::uint32_t, double>> list;
        for (const auto& c : withThreads(threads, [&] { return listContacts(spheres, tolerance); }))
            list.emplace_back(c.i, c.j, c.gap);
        return list;
    };
    REQUIRE(found(1) == expected);
    REQUIRE(found(8) == expected);
    REQUIRE(countContacts(spheres, tolerance).pairs == expected.size());
}

TEST_CASE("contacts are listed for usable spheres and tolerances only") {
    const std::vector<Sphere<3>> spheres{{{{0, 0, 1}}, 1}, {{{0, 0, 3}}, -1}};
    REQUIRE(listContacts(std::vector<Sphere<2>>{}, 1e-3).empty());
    REQUIRE_THROWS_AS(listContacts(spheres, 1e-3), InputError);
    REQUIRE_THROWS_AS(listContacts(spheres, 1.5), ParameterError);
    REQUIRE_THROWS_AS(listContacts(spheres, std::nan("")), ParameterError);
}

TEST_CASE("walls count as contacts where the depth is known") {
    const std::vector<Sphere<3>> spheres{{{{0, 0, 1}}, 1}, {{{0, 0, 3}}, 1}};
    const auto check = countContacts(spheres, 1e-3, {1.0005f, 3.0f});
    REQUIRE(check.counts == std::vector<std::int32_t>{2, 1});
    REQUIRE(check.pairs == 1);
    REQUIRE(check.wallContacts == 1);
    REQUIRE(check.mean == Approx(1.5));
    REQUIRE_THROWS_AS(countContacts(spheres, 1e-3, {1.0f}), ParameterError);
    REQUIRE_THROWS_AS(countContacts(spheres, -1), ParameterError);
    REQUIRE(countContacts(std::vector<Sphere<2>>{}, 1e-3).mean == 0);
}

DIM_TEST_CASE("the smallest gap is that of all pairs") {
    RandomStream random(21, Dim);
    for (int round = 0; round < 60; ++round) {
        // From crowded and overlapping to a few that are far apart, of very different sizes.
        const double spread = std::pow(10.0, 4 * random.uniform());
        std::vector<Sphere<Dim>> spheres;
        for (int i = 0; i < 2 + round; ++i) {
            Sphere<Dim> s;
            for (int d = 0; d < Dim; ++d) s.center[d] = spread * random.uniform();
            s.radius = 0.01 * std::pow(1000.0, random.uniform());
            spheres.push_back(s);
        }
        for (const std::size_t standing : {std::size_t{0}, spheres.size() / 2}) {
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < spheres.size(); ++i)
                for (std::size_t j = std::max(i + 1, standing); j < spheres.size(); ++j)
                    least = std::min(least, gap(spheres[i], spheres[j]));
            const auto found = smallestGap(spheres, standing);
            REQUIRE(found);
            CHECK(*found == Approx(least).margin(1e-9));
            if (standing > 0) continue;
            // Of the pairs that touch, if any do.
            const double touching = countContacts(spheres, 0.5).smallestGap;
            CHECK(touching >= least - 1e-9);
            double smallest = spheres[0].radius;
            for (const auto& s : spheres) smallest = std::min(smallest, s.radius);
            if (least < 0.5 * smallest) CHECK(touching == Approx(least).margin(1e-9));
        }
    }
    const std::vector<Sphere<Dim>> one(1, Sphere<Dim>{{}, 1});
    CHECK_FALSE(smallestGap(one));
    CHECK_FALSE(smallestGap(std::vector<Sphere<Dim>>{}));
}
