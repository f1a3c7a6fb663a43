// Elastic bonds between the spheres of a pack, and the stiffness that they give it.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/measure/contacts.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// What the bonds of a pack are made of.
struct BondLaw {
    double modulus = 1000;  ///< Young's modulus of spheres without one of their own, MPa, > 0
    /// Of each sphere, MPa, > 0; empty: `modulus` for all.
    std::vector<double> moduli{};
    double radiusFactor = 1;  ///< radius of a bond / of its smaller sphere, > 0
    /// k_t / k_n, and torsion to twice the bending stiffness; 0.4 is the G / E of a beam whose
    /// Poisson's ratio is 0.25. At least 0.
    double shearRatio = 0.4;
    bool isHinged = false;  ///< whether bonds resist neither bending nor torsion
    /// Strain in tension at which bonds break, the same for all moduli, and so for all densities:
    /// yield strains of trabecular bone are uniform within an anatomic site (Morgan et al. 2004,
    /// J Biomech 37:1413-1420). Nothing: bonds have no strength.
    std::optional<double> breakingStrain{};
    double shearStrength = 0.51;  ///< divided by the tensile strength, > 0
};

/// How the spheres of a pack are bonded.
struct BondOptions {
    BondLaw law;              ///< a column modulus_MPa of the pack replaces its `moduli`
    double tolerance = 1e-3;  ///< largest gap of bonded spheres, in smaller radii
    /// The same between spheres of two parts, where it is larger; 0: `tolerance`.
    double interfaceTolerance = 0;
    /// Classes of bonds by k_n, of equal width in its logarithm; 0: one for each bond.
    std::uint32_t classes = 1;
};

/// A beam of circular cross-section from center to center, cut where the surfaces meet: there its
/// forces act on both spheres.
struct Bond {
    std::uint32_t i = 0, j = 0;  ///< indices of the spheres, i < j
    Vec<3> direction;            ///< from i to (the nearest image of) j, of length one
    double length = 0;           ///< between the centers, mm
    double armI = 0, armJ = 0;   ///< from the centers to the middle of the gap, mm
    double radius = 0;           ///< of the cross-section, mm
    double modulus = 0;          ///< of both spheres in series, each along its arm, MPa
    double normal = 0;           ///< k_n = E A / length, N/mm
    double tangential = 0;       ///< k_t, N/mm
    double bending = 0;          ///< E I / length, N mm per rad
    double torsion = 0;          ///< k_t / k_n * 2 E I / length, N mm per rad
    double tensile = 0;          ///< force in tension at which it breaks, N; 0: it does not
    double shear = 0;            ///< the same across
    std::uint32_t number = 1;    ///< of its class, from 1 on

    double area() const;  ///< mm²
};

/// Bonds of a law, one for each contact, in their order.
///
/// @param contacts  of the pack (`listContacts`), by the tolerance up to which spheres are bonded.
/// @throws ParameterError for a law out of its bounds, another number of moduli than spheres, or
/// contacts of other spheres.
/// Source: parallel bonds of Potyondy, Cundall (2004), doi:10.1016/j.ijrmms.2004.09.011,
/// section 2.2, with stiffnesses as in their equations for E and the ratio of stiffnesses.
std::vector<Bond> bondsOf(const Pack<3>& pack, const std::vector<Contact>& contacts,
                          const BondLaw& law);

/// Where two parts meet.
struct InterfaceReport {
    std::array<std::string, 2> parts;  ///< their names
    std::uint64_t pairs = 0;           ///< bonds across
    double area = 0;                   ///< of their common wall, mm²
    /// Bonds per mm² that a plane through each part cuts, on average over its directions.
    std::array<double, 2> bulk{};

    double perArea() const { return area > 0 ? static_cast<double>(pairs) / area : 0; }
};

/// A pack as an elastic body.
struct BondedBody {
    const Pack<3>* pack = nullptr;             ///< not null
    const std::vector<Bond>* bonds = nullptr;  ///< `bondsOf` that pack; not null
    /// Spheres that move as the strain has it, and do not turn: 1 each. Empty: none do, as in a
    /// cell that is periodic along all axes.
    std::vector<std::uint8_t> boundary{};
    double volume = 0;  ///< over which stresses are averaged, mm³, > 0
};

/// By rows, in Voigt's order xx yy zz yz xz xy, for engineering shear strains.
using StiffnessMatrix = std::array<Vec<6>, 6>;

struct ApparentStiffness {
    /// Stress (MPa) by unit strain.
    StiffnessMatrix stiffness{};
    int iterations = 0;      ///< of the solver, the most of the six load cases
    double residual = 0;     ///< the largest of them, as a share of the load
    std::uint64_t free = 0;  ///< spheres that the solver moved
};

/// Strains the body in six ways, lets all spheres off the boundary find their equilibrium, and
/// takes C from the energy of the bonds: linear, small strains, bonds neither break nor are
/// stressed at first.
///
/// The six systems of six unknowns per sphere are solved by the conjugate gradients of Eigen with
/// the inverse of each sphere's own stiffness as a preconditioner. Spheres without bonds do not
/// move.
/// @throws ParameterError for a volume or a boundary that does not fit, a pack without bonds, or
/// one that is neither held by a boundary nor periodic along all axes; ResourceError if the solver
/// does not converge; Interrupted.
///
/// Cost: about 0.4 µs per bond and iteration of all six cases on two threads; iterations grow with
/// the number of spheres across. 500 bytes per sphere and 115 per bond. Source: energy of a uniform
/// strain (Hill's condition) on the boundary, as Zysset (1992) and Pahr, Zysset (2008),
/// doi:10.1007/s10237-007-0109-7, use it for voxels of bone.
ApparentStiffness apparentStiffness(const BondedBody& body, const Callbacks& callbacks = {});

/// The elastic energy (N mm) of a body whose boundary spheres are moved without turning, when all
/// others have found their equilibrium: half of what the forces on the boundary have worked.
/// @param moves  of each sphere, mm; those off the boundary are not looked at.
/// @throws as `apparentStiffness`; ParameterError for another number of moves than spheres
double energyOf(const BondedBody& body, const std::vector<Vec<3>>& moves,
                const Callbacks& callbacks = {});

/// What a stiffness in Voigt's order (`ApparentStiffness`) means; moduli in its unit.
struct Elasticity {
    Vec<3> modulus{};  ///< Young's moduli along x, y and z
    Vec<3> shear{};    ///< shear moduli of yz, xz and xy
    /// Poisson's ratios xy, xz, yz: contraction along the second axis by tension along the first.
    Vec<3> poisson{};
    double largest = 0, smallest = 0;  ///< Young's modulus over all directions
    Vec<3> stiffest{};                 ///< direction of the largest, of length one
    /// Of the isotropic average (Voigt, Reuss, Hill).
    double isotropicModulus = 0, isotropicPoisson = 0;
};

/// @return nothing if some strain meets (almost) no resistance.
std::optional<Elasticity> elasticityOf(const StiffnessMatrix& stiffness);

}  // namespace vdbpack
