// Bonds between spheres: their stiffness from radii and moduli.
#include "support/test.h"

#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/error.h"

#include <cmath>

namespace {

/// Two spheres of 2 and 1 mm on the x axis, 0.02 mm apart, and their contact.
Pack<3> pairOf() {
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 0}}, 2}, {{{3.02, 0, 0}}, 1}};
    return pack;
}

}  // namespace

TEST_CASE("a bond is a beam of the smaller sphere's radius, with both spheres in series") {
    BondLaw law;
    law.moduli = {1000, 500};
    law.radiusFactor = 0.5;
    law.shearRatio = 0.25;
    const auto bonds = bondsOf(pairOf(), {{0, 1, 0.02}}, law);
    REQUIRE(bonds.size() == 1);
    const Bond& b = bonds.front();
    CHECK(b.direction[0] == 1);
    CHECK(b.armI == Approx(2.01));
    CHECK(b.armJ == Approx(1.01));
    CHECK(b.radius == 0.5);
    CHECK(b.area() == Approx(kPi / 4));
    CHECK(1 / b.normal == Approx((2.01 / 1000 + 1.01 / 500) / b.area()));
    CHECK(b.tangential == Approx(0.25 * b.normal));
    CHECK(b.bending == Approx(b.normal * 0.25 * 0.5 * 0.5));  // I / A = r² / 4
    CHECK(b.torsion == Approx(0.5 * b.bending));              // 2 k_t / k_n
}

TEST_CASE("bonds of a law out of its bounds are refused") {
    const auto refused = [](const BondLaw& law) {
        CHECK_THROWS_AS(bondsOf(pairOf(), {{0, 1, 0.02}}, law), ParameterError);
    };
    BondLaw law;
    law.modulus = 0;
    refused(law);
    law = {};
    law.radiusFactor = -1;
    refused(law);
    law = {};
    law.shearRatio = std::nan("");
    refused(law);
    law = {};
    law.moduli = {1000};
    refused(law);
    law.moduli = {1000, 0};
    refused(law);
    CHECK_THROWS_AS(bondsOf(pairOf(), {{0, 2, 0}}, {}), ParameterError);
}
