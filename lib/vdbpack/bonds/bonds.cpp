#include "vdbpack/bonds/bonds.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

void requireLaw(const BondLaw& law, std::size_t spheres) {
    const auto require = [](bool holds, const char* what, double value, const char* remedy) {
        if (!holds) throw ParameterError(fmt::format("{} {:g}: {}", what, value, remedy));
    };
    const auto positive = [](double v) { return v > 0 && std::isfinite(v); };
    require(positive(law.modulus), "`bond-modulus`", law.modulus, "give MPa above 0");
    require(positive(law.radiusFactor), "`bond-radius`", law.radiusFactor, "give one above 0");
    require(law.shearRatio >= 0 && std::isfinite(law.shearRatio), "`bond-shear`", law.shearRatio,
            "give 0 or more");
    const double strain = law.breakingStrain.value_or(0.1);
    require(strain > 0 && strain < 1, "`bond-strength`", strain,
            "give the strain at which bonds break, a share below 1, such as 0.0078 for 0.78 %: a "
            "strength divided by Young's modulus");
    require(positive(law.shearStrength), "`bond-shear-strength`", law.shearStrength,
            "give a share of the tensile strength above 0");
    if (!law.moduli.empty() && law.moduli.size() != spheres)
        throw ParameterError(fmt::format("bonds: {} moduli for {} spheres; give one each",
                                         law.moduli.size(), spheres));
    for (std::size_t i = 0; i < law.moduli.size(); ++i)
        if (!positive(law.moduli[i]))
            throw ParameterError(fmt::format(
                "bonds: sphere {} has a modulus of {} MPa; give moduli above 0", i, law.moduli[i]));
}

}  // namespace

double Bond::area() const {
    return kPi * radius * radius;
}

std::vector<Bond> bondsOf(const Pack<3>& pack, const std::vector<Contact>& contacts,
                          const BondLaw& law) {
    const std::size_t n = pack.spheres.size();
    requireLaw(law, n);
    for (const Contact& c : contacts)
        if (c.i >= n || c.j >= n || c.i == c.j)
            throw ParameterError(fmt::format(
                "bonds: a contact joins {} and {} of {} spheres; list the contacts of this pack",
                c.i, c.j, n));
    const auto modulusOf = [&](std::uint32_t i) {
        return law.moduli.empty() ? law.modulus : law.moduli[i];
    };
    std::vector<Bond> bonds(contacts.size());
    parallelFor(std::size_t(0), contacts.size(), [&](std::size_t k) {
        const Contact& c = contacts[k];
        const Sphere<3>&a = pack.spheres[c.i], &b = pack.spheres[c.j];
        const Vec<3> branch = pack.cell.nearest(b.center - a.center);
        Bond& bond = bonds[k];
        bond.i = c.i;
        bond.j = c.j;
        bond.length = length(branch);
        bond.direction = branch * (1 / bond.length);
        const double half = 0.5 * (bond.length - a.radius - b.radius);
        bond.armI = a.radius + half;
        bond.armJ = b.radius + half;
        bond.radius = law.radiusFactor * std::min(a.radius, b.radius);
        bond.modulus = bond.length / (bond.armI / modulusOf(c.i) + bond.armJ / modulusOf(c.j));
        bond.normal = bond.modulus * bond.area() / bond.length;
        bond.tangential = law.shearRatio * bond.normal;
        const double inertia = 0.25 * bond.area() * bond.radius * bond.radius;
        bond.bending = law.isHinged ? 0 : bond.modulus * inertia / bond.length;
        bond.torsion = 2 * law.shearRatio * bond.bending;
        bond.tensile = law.breakingStrain.value_or(0) * bond.modulus * bond.area();
        bond.shear = law.shearStrength * bond.tensile;
    });
    return bonds;
}

}  // namespace vdbpack
