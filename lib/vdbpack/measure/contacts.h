// Contacts between spheres, and the network that they form.
#pragma once

#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/sphere.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace vdbpack {

/// The network that contacts form.
struct ContactNetwork {
    /// Mean number of spheres that a sphere touches, and one more for walls: the coordination
    /// number; 0 if empty.
    double mean = 0;
    double meanOfSpheres = 0;        ///< the same without walls
    std::uint64_t pairs = 0;         ///< touching pairs of spheres
    std::uint64_t wallContacts = 0;  ///< spheres that touch the wall
    /// Smallest gap of the touching pairs, mm; infinity if there are none.
    double smallestGap = std::numeric_limits<double>::infinity();
    std::vector<std::uint64_t> histogram;  ///< spheres with 0, 1, 2, ... contacts
    /// Contacts below which a sphere is not held in place: 4 (2D: 3).
    int few = 4;
    double fewShare = 0;  ///< share of the spheres with fewer than `few` contacts
    /// Mean of n n^T over the touching pairs, n the unit vector from one center to the other
    /// (2D: in the upper left): trace 1; 0 without pairs. Oda (1982), second-order fabric tensor.
    std::array<Vec<3>, 3> fabric{};
    /// Largest / smallest Young's modulus over all directions, if each contact were a spring along
    /// n and all centers moved as one strain has it: of the contacts of spheres that lie deeper
    /// than three of their radii, one of two such spheres counting twice. 0: `deepContacts` are
    /// fewer than 1000, or do not resist every strain. Source: affine estimate of Digby (1981),
    /// J. Appl. Mech. 48; Walton (1987), J. Mech. Phys. Solids 35; here without tangential springs.
    double modulusRatio = 0;
    Vec<3> stiffest{};               ///< direction of the largest modulus, of length one
    std::uint64_t deepContacts = 0;  ///< contacts that count for these
    /// Share of the spheres in the largest connected component; 0 if empty.
    double largestComponent = 0;
    std::uint64_t components = 0;  ///< connected components, single spheres included
};

struct ContactCheck : ContactNetwork {
    std::vector<std::int32_t> counts;  ///< spheres and walls that each sphere touches
};

/// @throws ParameterError unless the tolerance is a share of a radius from 0 to 1.
void requireContactTolerance(double tolerance);

/// Counts contacts and measures their network. The same for any number of threads.
///
/// @param tolerance  two spheres touch if their gap is below this share of the smaller radius
///                   (overlapping ones do), a sphere and the wall if |depth - radius| is at most
///                   this share of its radius; 0 to 1.
/// @param depth      distance of each center to the wall, mm; empty: walls are not counted.
/// @param cell       in which the spheres repeat: contacts with images count.
/// @throws ParameterError for another tolerance or number of depths; InputError as `checkOverlap`.
template <int Dim>
ContactCheck countContacts(const std::vector<Sphere<Dim>>& spheres, double tolerance,
                           const std::vector<float>& depth = {},
                           const PeriodicCell<Dim>& cell = {});

/// What the contacts of a pack add up to, of which parts can be counted one by one.
struct ContactSums {
    std::uint64_t spheres = 0;
    std::uint64_t partners = 0;             ///< touching spheres of each sphere
    std::uint64_t wallContacts = 0;         ///< spheres that touch the wall
    std::uint64_t few = 0;                  ///< spheres with fewer contacts than hold them in place
    std::array<std::uint64_t, 6> fabric{};  ///< fixed-point sum of n n^T, modulo 2^64
    /// The same of m m^T, m the `mandelDyad` of n, over the contacts of deep spheres.
    std::array<std::uint64_t, 21> stiffness{};
    std::uint64_t deepContacts = 0;
    std::vector<std::uint64_t> histogram;  ///< spheres with 0, 1, 2, ... contacts
    double smallestGap = std::numeric_limits<double>::infinity();  ///< mm

    void add(const ContactSums& other);
    /// Adds spheres, all but the pairs that they form.
    /// @param depth   of each, or empty.
    /// @param counts  touching spheres of each; becomes touching spheres and walls.
    template <int Dim>
    void add(const std::vector<Sphere<Dim>>& spheres, double tolerance,
             const std::vector<float>& depth, std::vector<std::int32_t>& counts);
};

/// The pairs that touch in a part of a pack.
struct PartContacts {
    ContactSums sums;                    ///< of pairs alone: `fabric` to `smallestGap`
    std::vector<std::int32_t> partners;  ///< touching spheres of each own sphere
    /// Of each sphere: an index into the spheres, the same for those that contacts connect.
    std::vector<std::uint32_t> component;
};

/// Finds the contacts of the first `own` spheres. The others are those of other parts that they
/// may touch; a pair of two parts adds to the sums of one of them.
/// @param depth   distance of each own center to the wall, mm; empty: there is none.
/// @param source  where the others are images of own spheres: of which (`SpheresWithImages`);
///                null: they are not. The two images of a pair add to the sums once.
template <int Dim>
PartContacts contactsOfPart(const std::vector<Sphere<Dim>>& spheres, std::size_t own,
                            double tolerance, const std::vector<float>& depth = {},
                            const std::vector<std::uint32_t>* source = nullptr);

/// The spheres with all images that they may touch.
/// @throws as `countContacts`.
template <int Dim>
SpheresWithImages<Dim> withPartners(const std::vector<Sphere<Dim>>& spheres, double tolerance,
                                    const PeriodicCell<Dim>& cell);

/// How many spheres the first `own` spheres touch, all together, at each tolerance: a pair of them
/// counts twice. The others are as of `contactsOfPart`.
/// @param tolerances  as of `countContacts`, rising.
template <int Dim>
std::array<std::uint64_t, 3> partnersOfPart(const std::vector<Sphere<Dim>>& spheres,
                                            std::size_t own,
                                            const std::array<double, 3>& tolerances);

/// The network of all parts, without its components.
ContactNetwork networkOf(const ContactSums& sums, int dim);

/// Two touching spheres.
struct Contact {
    std::uint32_t i = 0, j = 0;  ///< indices of the spheres, i < j
    double gap = 0;              ///< mm; negative where they overlap
};

/// Lists the pairs of spheres that `countContacts` counts, sorted by i, then j: the same list for
/// any number of threads. 16 bytes a contact, twice that while the list is made.
///
/// @param tolerance, cell  as of `countContacts`.
/// @throws as `countContacts`.
template <int Dim>
std::vector<Contact> listContacts(const std::vector<Sphere<Dim>>& spheres, double tolerance,
                                  const PeriodicCell<Dim>& cell = {});

/// The smallest distance between the surfaces of two spheres, mm; negative if they overlap.
/// Exact at any distance.
///
/// @param standing  pairs among the first `standing` spheres do not count.
/// @param cell      in which the spheres repeat: images count.
/// @return nothing if there is no pair. @throws InputError as `checkOverlap`.
template <int Dim>
std::optional<double> smallestGap(const std::vector<Sphere<Dim>>& spheres, std::size_t standing = 0,
                                  const PeriodicCell<Dim>& cell = {});

/// 1 for each sphere in a connected component (by contacts) with a sphere of region 0 (the shell)
/// that has at least a thousandth as many spheres as the largest: smaller ones are loose clusters
/// of the shell. Without regions, for each sphere of the largest connected component.
/// @param tolerance  as of `countContacts`.
/// @param cell       in which the spheres repeat, and touch across its faces.
/// @throws as `countContacts`.
template <int Dim>
std::vector<std::uint8_t> attachedSpheres(const std::vector<Sphere<Dim>>& spheres,
                                          const std::vector<std::int32_t>& region, double tolerance,
                                          const PeriodicCell<Dim>& cell = {});

}  // namespace vdbpack
