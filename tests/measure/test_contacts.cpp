#include "measure/packs.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/measure/contacts.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

using namespace vdbpack;
using namespace vdbpack::test;

TEST_CASE("lattices have 6, 8 and 12 contacts", "[measure]") {
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

TEMPLATE_TEST_CASE_SIG("contacts are those of an all-pairs search", "[measure]", ((int Dim), Dim),
                       2, 3) {
    const double tolerance = GENERATE(1e-3, 0.05, 1.0);
    const double ratio = GENERATE(1.0, 20.0);
    CAPTURE(Dim, tolerance, ratio);
    const auto spheres = randomSpheres<Dim>(500, 40, 0.5, ratio, 12);
    std::vector<std::int32_t> expected(spheres.size());
    for (std::size_t i = 0; i < spheres.size(); ++i)
        for (std::size_t j = 0; j < spheres.size(); ++j)
            expected[i] += i != j && gap(spheres[i], spheres[j]) <
                                         tolerance * std::min(spheres[i].radius, spheres[j].radius);
    REQUIRE(countContacts(spheres, tolerance).counts == expected);
}

TEST_CASE("walls count as contacts where the depth is known", "[measure]") {
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

TEMPLATE_TEST_CASE_SIG("the smallest gap is that of all pairs", "[measure]", ((int Dim), Dim), 2,
                       3) {
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
