#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/symmetric.h"
#include "vdbpack/measure/stiffness.h"

#include <cmath>
#include <cstddef>

namespace vdbpack {

namespace {

/// Where xx yy zz yz xz xy stand in Mandel's notation of `mandelDyad`, and their factors.
constexpr std::array<std::size_t, 6> kMandel{0, 3, 5, 4, 2, 1};
double factorOf(std::size_t voigt) {
    return voigt < 3 ? 1 : std::sqrt(2.0);
}

/// The compliance, in Voigt's order, of a stiffness in Mandel's notation.
StiffnessMatrix complianceOf(const StiffnessMatrix& mandel) {
    const auto eigen = eigenSystem<6>(mandel);
    StiffnessMatrix inverse{};
    for (std::size_t a = 0; a < 6; ++a)
        for (std::size_t b = 0; b < 6; ++b)
            for (std::size_t k = 0; k < 6; ++k)
                inverse[a].c[b] += eigen.vectors[k].c[kMandel[a]] * eigen.vectors[k].c[kMandel[b]] *
                                   factorOf(a) * factorOf(b) / eigen.values.c[k];
    return inverse;
}

/// Sums over a tensor in Voigt's order that do not depend on the frame.
struct Invariants {
    double direct = 0, cross = 0, shear = 0;
    explicit Invariants(const StiffnessMatrix& m) {
        for (std::size_t a = 0; a < 3; ++a) {
            direct += m[a].c[a];
            cross += m[a].c[(a + 1) % 3];
            shear += m[a + 3].c[a + 3];
        }
    }
};

}  // namespace

std::optional<Elasticity> elasticityOf(const StiffnessMatrix& stiffness) {
    StiffnessMatrix mandel{};
    for (std::size_t a = 0; a < 6; ++a)
        for (std::size_t b = 0; b < 6; ++b)
            mandel[kMandel[a]].c[kMandel[b]] = stiffness[a].c[b] * factorOf(a) * factorOf(b);
    const auto ratio = modulusRatio<3>(mandel);
    if (!ratio) return std::nullopt;
    const StiffnessMatrix s = complianceOf(mandel);
    Elasticity e;
    for (std::size_t a = 0; a < 3; ++a) {
        e.modulus.c[a] = 1 / s[a].c[a];
        e.shear.c[a] = 1 / s[a + 3].c[a + 3];
    }
    e.poisson = {{-s[0].c[1] / s[0].c[0], -s[0].c[2] / s[0].c[0], -s[1].c[2] / s[1].c[1]}};
    e.stiffest = ratio->direction;
    const Vec<3>& d = e.stiffest;
    const std::array<double, 6> dyad{d[0] * d[0], d[1] * d[1], d[2] * d[2],
                                     d[1] * d[2], d[0] * d[2], d[0] * d[1]};
    double compliance = 0;
    for (std::size_t a = 0; a < 6; ++a)
        for (std::size_t b = 0; b < 6; ++b) compliance += dyad[a] * s[a].c[b] * dyad[b];
    e.largest = 1 / compliance;
    e.smallest = e.largest / ratio->ratio;
    const Invariants c(stiffness), i(s);
    const double bulk = 0.5 * ((c.direct + 2 * c.cross) / 9 + 1 / (i.direct + 2 * i.cross));
    const double shear = 0.5 * ((c.direct - c.cross + 3 * c.shear) / 15 +
                                15 / (4 * i.direct - 4 * i.cross + 3 * i.shear));
    e.isotropicModulus = 9 * bulk * shear / (3 * bulk + shear);
    e.isotropicPoisson = (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear));
    return e;
}

}  // namespace vdbpack
