// Bond order: crystals are distinguished from random packs, however they are turned.
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/measure/bond_order.h"
#include "vdbpack/pack/packer.h"

namespace {

/// Spheres that touch in a face-centered cubic lattice, turned about (1, 2, 3).
std::vector<Sphere<3>> crystal(int cells, double angle) {
    const Vec<3> axis = normalized(Vec<3>{{1, 2, 3}});
    const double edge = 2 * std::sqrt(2.0), c = std::cos(angle), s = std::sin(angle);
    std::vector<Sphere<3>> spheres;
    for (int i = 0; i < 2 * cells; ++i)
        for (int j = 0; j < 2 * cells; ++j)
            for (int k = 0; k < 2 * cells; ++k) {
                if ((i + j + k) % 2 != 0) continue;
                const Vec<3> x = Vec<3>{{1.0 * i, 1.0 * j, 1.0 * k}} * (edge / 2);
                spheres.push_back(
                    {x * c + cross(axis, x) * s + axis * (dot(axis, x) * (1 - c)), 0.999});
            }
    return spheres;
}

std::vector<Sphere<2>> hexagons(int rows) {
    std::vector<Sphere<2>> circles;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < rows; ++i)
            circles.push_back({{{2.0 * i + j % 2, std::sqrt(3.0) * j}}, 0.999});
    return circles;
}

}  // namespace

TEST_CASE("a crystal is solid-like, whichever way it is turned") {
    const double angle = GENERATE(0.0, 0.3, 1.1);
    const auto spheres = crystal(6, angle);
    // All but some of those at the edges.
    CHECK(solidLikeShare(spheres) > 0.9);
    const auto order = bondOrder(spheres);
    std::size_t inner = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i)
        if (std::fabs(order.strength[i] - 0.57452f) < 1e-4f) ++inner;
    // Steinhardt's figure for fcc, of all 12 neighbors: the 11^3 of 12^3 places not at a face, / 2.
    CHECK(inner >= 10 * 10 * 10 / 2);
}

TEST_CASE("hexagons in the plane are solid-like, squares are not") {
    const auto circles = hexagons(20);
    CHECK(solidLikeShare(circles) > 0.9);  // all but those at the edges
    const auto order = bondOrder(circles);
    CHECK(order.strength[210] == Approx(1).margin(1e-5));
    std::vector<Sphere<2>> squares;
    for (int i = 0; i < 20; ++i)
        for (int j = 0; j < 20; ++j) squares.push_back({{{2.0 * i, 2.0 * j}}, 0.99});
    CHECK(bondOrder(squares).strength[210] == Approx(0).margin(1e-5));
}

TEST_CASE("a pair has one bond and full order, a lone sphere none") {
    const std::vector<Sphere<3>> spheres{
        {{{0, 0, 0}}, 1}, {{{1.1, 1.2, 1.3}}, 0.9}, {{{50, 0, 0}}, 1}};
    const auto order = bondOrder(spheres);
    CHECK(order.strength[0] == Approx(1));
    CHECK(order.strength[1] == Approx(1));
    CHECK(order.strength[2] == 0);
    CHECK(solidLikeShare(spheres) == 0);
    CHECK(solidLikeShare(std::vector<Sphere<3>>{}) == 0);
}

TEST_CASE("packs of spheres of many sizes are not solid-like") {
    const auto domain = boxDomain<3>({Box<3>::filled(-15), Box<3>::filled(15)});
    const auto sizes = SizeDistribution::parse("uniform:1,2", 3);
    CHECK(solidLikeShare(packSpheres(*domain, PackOptions(sizes)).pack.spheres) < 0.02);
}
