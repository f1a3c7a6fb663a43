// Packs made denser than a front can: spheres are added, and all are pushed apart.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/size_distribution.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdbpack {

struct DensifyOptions {
    /// Solid fraction to reach, of all spheres together; infinity: as dense as it gets. What the
    /// pack has already (or less): none is added, overlaps alone are removed.
    double fraction = 0;
    /// Radii of the spheres that are added, mm; none: those of the pack.
    std::optional<SizeDistribution> sizes;
    double gap = 0;          ///< least distance between spheres, and of spheres to the wall, mm
    std::uint64_t seed = 1;  ///< another seed, another pack of the same kind
    std::size_t fixed = 0;   ///< the first spheres, which stay where they are
    /// Regions of the spheres; empty: all are of one. Spheres change places within their region
    /// only, and those that are added are put beside spheres of theirs, as many as its share of
    /// the volume; without `sizes` their radii are those of the region.
    std::vector<std::int32_t> regions;
};

template <int Dim>
struct DensifyResult {
    /// The spheres given, in their order, then those added. No two overlap and none crosses the
    /// wall, but for the fixed ones among themselves, if `apart`.
    std::vector<Sphere<Dim>> spheres;
    std::vector<std::int32_t> regions;  ///< of all of them, if they were given
    bool apart = false;                 ///< false: not even the pack as given came apart
    bool reached = false;               ///< the fraction asked for
    bool interrupted = false;           ///< cancelled: what is given is the last that was apart
    double before = 0, after = 0;  ///< solid fractions (of spheres that may overlap: their sum)
    std::uint64_t steps = 0;       ///< of the relaxation, all stages together
    int stages = 0;                ///< insertions
};

/// Makes a pack denser: further spheres are added where there is most room, and all of them are
/// relaxed (`Relaxation`) until none overlap. Radii stay as they are.
///
/// Where what is asked for is not to be had, the densest that came apart is returned. The same
/// for any number of threads. Cost: 15 to 30 microseconds of processor a sphere for 0.01 to 0.03
/// more than the front's fraction, 400 for as dense as it gets.
/// @param spheres  mm; from any program. They may overlap and cross the wall by less than radii.
/// @throws ParameterError for a fraction or gap that cannot be; InputError for unusable spheres or
/// a domain without volume; ResourceError above 2^31 spheres.
template <int Dim>
DensifyResult<Dim> densify(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
                           const DensifyOptions& options, const Callbacks& callbacks = {});

extern template DensifyResult<2> densify(const Domain<2>&, const std::vector<Sphere<2>>&,
                                         const DensifyOptions&, const Callbacks&);
extern template DensifyResult<3> densify(const Domain<3>&, const std::vector<Sphere<3>>&,
                                         const DensifyOptions&, const Callbacks&);

}  // namespace vdbpack
