// Bonds between spheres: their stiffness from radii and moduli.
#include "support/temporary_folder.h"
#include "support/test.h"
#include "support/text_file.h"

#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/error.h"
#include "vdbpack/formats/bonded_pack.h"
#include "vdbpack/formats/materials.h"

#include <fmt/format.h>

#include <algorithm>
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

TEST_CASE("bonds break at a strain, whatever their modulus") {
    BondLaw law;
    law.breakingStrain = 0.01;
    law.shearStrength = 0.5;
    for (const double modulus : {1000.0, 2000.0}) {
        law.modulus = modulus;
        const Bond b = bondsOf(pairOf(), {{0, 1, 0.02}}, law).front();
        CHECK(b.tensile == Approx(0.01 * b.length * b.normal));
        CHECK(b.shear == Approx(0.5 * b.tensile));
    }
    CHECK(bondsOf(pairOf(), {{0, 1, 0.02}}, {}).front().tensile == 0);
}

TEST_CASE("LAMMPS gets the stiffness of each bond, or the means of classes") {
    Pack<3> pack;
    for (int k = 0; k < 6; ++k) pack.spheres.push_back({{{2.0 * k, 0, 0}}, 1});
    pack.columns.push_back({kModulusColumn, {100, 100, 100, 800, 800, 800}, {}});
    BondOptions options;
    options.law.breakingStrain = 0.01;
    const auto commands = [&](std::uint32_t classes) {
        options.classes = classes;
        const TemporaryFolder folder;
        const std::string file = folder.file("bonds.lmp");
        writeBondCoefficients(bondsIn(pack, options), options, file, Unit::meter);
        return contentOf(file);
    };
    // E A / length, half of it: 25 pi N/mm; in series, 100 and 800 MPa make 177.8.
    const std::string each = commands(0);
    CHECK_THAT(each, Contains("bond_style harmonic\n"));
    CHECK_THAT(each, Contains("\nbond_coeff 1 78539.816339744"));
    CHECK(std::count(each.begin(), each.end(), '\n') == 2 + 5);
    const std::string few = commands(2);
    CHECK_THAT(few, Contains("bond_style bpm/rotational smooth no\n"));
    const double soft = (2 * 100 + 1600.0 / 9) / 3 * kPi / 2 * 1e3, hard = 800 * kPi / 2 * 1e3;
    CHECK_THAT(few, Contains(fmt::format("\nbond_coeff 1 {:.9g} {:.9g} ", soft, 0.4 * soft)));
    CHECK_THAT(few, Contains(fmt::format("\nbond_coeff 2 {:.9g} {:.9g} ", hard, 0.4 * hard)));
    CHECK_THAT(few, Contains(fmt::format(" {:.9g} {:.9g} 1e+30 1e+30 0 0 0 0\n", 0.01 * 800 * kPi,
                                         0.51 * 0.01 * 800 * kPi)));
    options.law.breakingStrain.reset();
    CHECK_THAT(commands(2), Contains("bpm/rotational smooth no break no\n"));
    CHECK_THROWS_AS(commands(1), ParameterError);
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
    law.breakingStrain = 0;
    refused(law);
    law = {};
    law.moduli = {1000};
    refused(law);
    law.moduli = {1000, 0};
    refused(law);
    CHECK_THROWS_AS(bondsOf(pairOf(), {{0, 2, 0}}, {}), ParameterError);
}
