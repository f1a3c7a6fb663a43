// Fills a domain with spheres.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/order.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/pack/species.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// fast takes places as they come along the sweep, normal first those where a sphere is stopped
/// from growing by a further body, dense the same with more pending radii.
enum class Effort { fast, normal, dense };

struct PackOptions {
    explicit PackOptions(SizeDistribution s) : sizes(std::move(s)) {}

    SizeDistribution sizes;  ///< radii, mm
    std::uint64_t seed = 1;  ///< another seed, another pack of the same kind
    int threads = 0;         ///< 0: all cores; the pack is the same for any number
    Effort effort = Effort::normal;
    Order order = Order::sweep;
    /// Radii that wait at a time for a place; 0: by the effort, 64 or more. They are never placed,
    /// and those that are come the larger the earlier: few spheres want few.
    std::size_t pending = 0;
    double gap = 0;             ///< least distance between spheres, and of spheres to the wall, mm
    std::int64_t maxCount = 0;  ///< stop at this many spheres; 0: when full
    double blockSide = 0;       ///< edge of a block, mm; 0: from radii, domain and order
    /// Further species beside `sizes`, drawn with their probability for each new sphere that lies
    /// deep enough for them. They go ahead of the front where they don't fit at it.
    std::vector<Species> species;
};

template <int Dim>
struct PackResult {
    Pack<Dim> pack;  ///< what was placed, with `order` set
    /// Of each sphere: 0 for PackOptions::sizes, s + 1 for `species[s]`; empty without such.
    std::vector<std::uint8_t> species;
    std::size_t blocks = 0;
    Box<Dim> firstBlock;           ///< all are as large and lie edge to edge, mm
    std::size_t longestChain = 0;  ///< blocks that have to wait for one another
    std::size_t fronts = 0;        ///< fresh fronts started
    double quantum = 0;            ///< positions are whole multiples of this power of two, mm
    bool interrupted = false;      ///< cancelled: what stood by then is there, and final
};

/// Fills `domain` with non-overlapping spheres until no place is left that could take a sphere
/// of the mean radius.
///
/// The radii follow `options.sizes` (all that is drawn gets placed, but for some tens pending at
/// the end); centers are whole multiples of `quantum`; no two spheres overlap and none crosses the
/// wall, decided in double on the values as returned. The result depends on the domain, the options
/// (but not on the threads) and the spheres that stand alone.
///
/// @param existing  spheres that stand already, anywhere and of any radius, mm; they may overlap
///                  one another and the wall. What is placed keeps off them.
/// @throws ParameterError for a gap that is negative or not finite, or probabilities of species
/// that are negative or add up to 1 or more. InputError if the smallest
/// radius fits nowhere (with the largest place), the domain is empty, or one of `existing` is no
/// usable number or lies in more than 2000 others that are no copies. ResourceError if the count
/// would be absurd. Source: front advancing after Feng, Han, Owen (2003), doi:10.1002/nme.583;
/// sites, pools and wavefront as described in assets/guides/how-it-works.md.
template <int Dim>
PackResult<Dim> packSpheres(const Domain<Dim>& domain, const PackOptions& options,
                            const Callbacks& callbacks = {},
                            const std::vector<Sphere<Dim>>& existing = {});

/// The factor on `options.sizes` for which about `count` spheres fill the domain: found from
/// trial packs with larger radii, since the share that walls cost grows with the radius.
/// @throws ParameterError if `count` < 1, or if not nearly as many can keep the gap.
template <int Dim>
double scaleForCount(const Domain<Dim>& domain, const PackOptions& options, double count,
                     const Callbacks& callbacks = {},
                     const std::vector<Sphere<Dim>>& existing = {});

/// The largest place of a domain: the center and radius (mm) of about the largest ball inside.
template <int Dim>
Sphere<Dim> largestPlace(const Domain<Dim>& domain);

extern template PackResult<2> packSpheres(const Domain<2>&, const PackOptions&, const Callbacks&,
                                          const std::vector<Sphere<2>>&);
extern template PackResult<3> packSpheres(const Domain<3>&, const PackOptions&, const Callbacks&,
                                          const std::vector<Sphere<3>>&);
extern template double scaleForCount(const Domain<2>&, const PackOptions&, double, const Callbacks&,
                                     const std::vector<Sphere<2>>&);
extern template double scaleForCount(const Domain<3>&, const PackOptions&, double, const Callbacks&,
                                     const std::vector<Sphere<3>>&);
extern template Sphere<2> largestPlace(const Domain<2>&);
extern template Sphere<3> largestPlace(const Domain<3>&);

}  // namespace vdbpack
