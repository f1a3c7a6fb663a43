// The apparent stiffness of bonded spheres, against lattices whose stiffness is known.
#include "support/test.h"

#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/pack/packer.h"

#include <array>
#include <cmath>
#include <vector>

namespace {

/// Touching spheres of radius 0.5 mm at lattice points of a periodic cell.
/// @param basis  points of a cubic unit cell of side `side`, in halves of it.
Pack<3> latticeOf(const std::vector<std::array<int, 3>>& basis, double side, int cells) {
    Pack<3> pack;
    for (int x = 0; x < cells; ++x)
        for (int y = 0; y < cells; ++y)
            for (int z = 0; z < cells; ++z)
                for (const auto& b : basis)
                    pack.spheres.push_back({{{side * (x + 0.5 * b[0]), side * (y + 0.5 * b[1]),
                                              side * (z + 0.5 * b[2])}},
                                            0.5});
    pack.cell.box = {{{0, 0, 0}}, Vec<3>{{side * cells, side * cells, side * cells}}};
    pack.cell.wraps = {true, true, true};
    return pack;
}

Pack<3> simpleCubic(int cells = 4) {
    return latticeOf({{0, 0, 0}}, 1, cells);
}
Pack<3> faceCentered(int cells = 3) {
    return latticeOf({{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}}, std::sqrt(2.0), cells);
}

ApparentStiffness stiffnessOf(const Pack<3>& pack, const BondLaw& law, double volume = 0,
                              const std::vector<std::uint8_t>& boundary = {}) {
    const auto bonds = bondsOf(pack, listContacts(pack.spheres, 0.01, pack.cell), law);
    BondedBody body;
    body.pack = &pack;
    body.bonds = &bonds;
    body.boundary = boundary;
    body.volume = volume > 0 ? volume : pack.cell.box.volume();
    return apparentStiffness(body);
}

/// k_n of bonds of length 1 mm between spheres of 0.5 mm.
double normalOf(const BondLaw& law) {
    return law.modulus * kPi * 0.25 * law.radiusFactor * law.radiusFactor;
}

void requireCubic(const StiffnessMatrix& c, double direct, double across, double shear) {
    for (std::size_t a = 0; a < 6; ++a)
        for (std::size_t b = 0; b < 6; ++b) {
            CAPTURE(a, b);
            const double expected = a == b ? (a < 3 ? direct : shear) : a < 3 && b < 3 ? across : 0;
            CHECK(c[a].c[b] == Approx(expected).epsilon(1e-4).margin(1e-5 * direct));
        }
}

/// Spheres turned about an axis, in an aperiodic pack.
Pack<3> turned(Pack<3> pack, double angle) {
    for (auto& s : pack.spheres) {
        const Vec<3> x = s.center;
        s.center = {{std::cos(angle) * x[0] - std::sin(angle) * x[1],
                     std::sin(angle) * x[0] + std::cos(angle) * x[1], x[2]}};
    }
    return pack;
}

}  // namespace

TEST_CASE("springs between nearest neighbors of an fcc lattice have C11 : C12 : C44 as 2 : 1 : 1") {
    BondLaw law;
    law.shearRatio = 0;
    law.isHinged = true;
    const double k = normalOf(law);
    requireCubic(stiffnessOf(faceCentered(), law).stiffness, std::sqrt(2.0) * k, k / std::sqrt(2.0),
                 k / std::sqrt(2.0));
}

TEST_CASE("normal springs alone let a simple cubic lattice shear, tangential ones hold it") {
    BondLaw law;
    law.shearRatio = 0;
    law.isHinged = true;
    const auto hinged = stiffnessOf(simpleCubic(), law);
    requireCubic(hinged.stiffness, normalOf(law), 0, 0);
    CHECK_FALSE(elasticityOf(hinged.stiffness));
    law.shearRatio = 0.3;
    requireCubic(stiffnessOf(simpleCubic(), law).stiffness, normalOf(law), 0,
                 0.5 * 0.3 * normalOf(law));
}

TEST_CASE("stiffness grows with the modulus and does not depend on the scale of a pack") {
    BondLaw law;
    Pack<3> pack = faceCentered();
    const auto one = elasticityOf(stiffnessOf(pack, law).stiffness);
    law.modulus *= 7;
    for (auto& s : pack.spheres) s = {s.center * 1e-3, s.radius * 1e-3};
    pack.cell.box.hi = pack.cell.box.hi * 1e-3;
    const auto other = elasticityOf(stiffnessOf(pack, law).stiffness);
    CHECK(other->isotropicModulus == Approx(7 * one->isotropicModulus).epsilon(1e-4));
    CHECK(other->isotropicPoisson == Approx(one->isotropicPoisson).epsilon(1e-4));
}

TEST_CASE("a uniform strain on the boundary of a lattice is a uniform strain inside") {
    Pack<3> pack = faceCentered(4);
    pack.cell = {};
    std::vector<std::uint8_t> boundary;
    std::uint64_t inside = 0;
    for (const auto& s : pack.spheres) {
        bool edge = false;
        for (int d = 0; d < 3; ++d) edge |= s.center[d] < 0.6 || s.center[d] > 4.3;
        boundary.push_back(edge);
        inside += !edge;
    }
    REQUIRE(inside > 20);
    const auto found = stiffnessOf(pack, {}, 1, boundary);
    CHECK(found.free == inside);
    // Their forces are in balance at once.
    CHECK(found.iterations == 0);
}

TEST_CASE("a turned pack has the turned stiffness") {
    const auto domain = boxDomain<3>({{{-3, -3, -3}}, {{3, 3, 3}}});
    const Pack<3> pack =
        packSpheres(*domain, PackOptions(SizeDistribution::uniform(0.3, 0.5))).pack;
    std::vector<std::uint8_t> boundary;
    for (const auto& s : pack.spheres) {
        bool edge = false;
        for (int d = 0; d < 3; ++d) edge |= std::abs(s.center[d]) + s.radius > 2.9;
        boundary.push_back(edge);
    }
    const auto here = elasticityOf(stiffnessOf(pack, {}, 216, boundary).stiffness);
    const auto there = elasticityOf(stiffnessOf(turned(pack, 0.7), {}, 216, boundary).stiffness);
    REQUIRE(here);
    REQUIRE(there);
    CHECK(there->largest == Approx(here->largest).epsilon(1e-4));
    CHECK(there->smallest == Approx(here->smallest).epsilon(1e-4));
    CHECK(there->isotropicModulus == Approx(here->isotropicModulus).epsilon(1e-4));
    CHECK(there->isotropicPoisson == Approx(here->isotropicPoisson).margin(1e-4));
}

TEST_CASE("an isotropic stiffness has its two constants in every direction") {
    StiffnessMatrix c{};
    const double modulus = 700, poisson = 0.2;
    const double lame = modulus * poisson / ((1 + poisson) * (1 - 2 * poisson));
    const double shear = modulus / (2 * (1 + poisson));
    for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = 0; b < 3; ++b) c[a].c[b] = lame + (a == b ? 2 * shear : 0);
        c[a + 3].c[a + 3] = shear;
    }
    const auto e = elasticityOf(c);
    REQUIRE(e);
    for (int d = 0; d < 3; ++d) {
        CHECK(e->modulus[d] == Approx(modulus));
        CHECK(e->shear[d] == Approx(shear));
        CHECK(e->poisson[d] == Approx(poisson));
    }
    CHECK(e->largest == Approx(modulus));
    CHECK(e->smallest == Approx(modulus));
    CHECK(e->isotropicModulus == Approx(modulus));
    CHECK(e->isotropicPoisson == Approx(poisson));
}

TEST_CASE("a body that nothing holds, or without bonds, is refused") {
    Pack<3> pack = simpleCubic(2);
    pack.cell = {};
    CHECK_THROWS_AS(stiffnessOf(pack, {}, 8), ParameterError);
    CHECK_THROWS_AS(stiffnessOf(pack, {}, 8, {1, 0}), ParameterError);
    pack.spheres.resize(1);
    CHECK_THROWS_AS(stiffnessOf(pack, {}, 8, {1}), ParameterError);
}
