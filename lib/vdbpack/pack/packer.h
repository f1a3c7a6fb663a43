// Fills a domain with spheres.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/pack_options.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace vdbpack {

struct FieldOptions;
class MeshDomain;
struct TriangleMesh;

/// The field that the domain of a pack of these sizes needs, for `meshDomain`, `levelSetDomain` and
/// `implicitDomain`. Larger and smaller sizes can be packed, too, as `packSpheres` says.
FieldOptions fieldFor(const SizeDistribution& sizes);

/// The inside of a closed mesh as a domain for a pack of these sizes:
///
///     const auto sizes = SizeDistribution::uniform(0.5, 1);
///     const auto domain = meshDomain(mesh, sizes);
///     const Pack<3> pack = packSpheres(*domain, PackOptions(sizes)).pack;
///
/// @param mesh  mm. @throws as `meshDomain` with `fieldFor(sizes)`
std::shared_ptr<const MeshDomain> meshDomain(TriangleMesh mesh, const SizeDistribution& sizes,
                                             const Callbacks& callbacks = {});

template <int Dim>
struct PackResult {
    /// What was placed, with `order` set; over ranks the share of this one.
    Pack<Dim> pack;
    /// Of each sphere: 0 for PackOptions::sizes, s + 1 for `species[s]`; empty without such.
    std::vector<std::uint8_t> species;
    std::size_t blocks = 0;
    Box<Dim> firstBlock;           ///< the others are as large and fill the bounds face to face, mm
    std::size_t longestChain = 0;  ///< most blocks that have to be filled one after another
    std::size_t fronts = 0;        ///< fresh fronts started in vacancies
    double quantum = 0;            ///< centers are whole multiples of this power of two, mm
    bool interrupted = false;      ///< cancelled: the spheres placed until then are here, and final
    /// Over ranks: from one of these values of `order` to the next, all spheres are those of one
    /// rank; the last is their number.
    std::vector<std::int64_t> pieces;
};

/// Fills `domain` with non-overlapping spheres until no vacancy is left that could take a sphere of
/// the mean radius.
///
/// The radii follow `options.sizes`: all radii drawn are placed, except some tens that are pending
/// at the end. No two spheres overlap and none crosses the wall, decided in double on the values as
/// returned. The result depends on the domain, the options (but not on the threads) and `existing`
/// alone.
///
/// The distance field of the domain may be made for other radii. Smaller spheres are packed as
/// densely in a field that was made for larger ones, since triangles decide at the wall. Where the
/// field ends too near to the wall for a front to begin (`Domain::fieldDepth`), as it does if it
/// was made for radii twelve times smaller, the domain is refused.
///
/// @param existing  spheres to keep off, anywhere and of any radius, mm; they may overlap one
///                  another and the wall. They are not part of the result.
/// @throws ParameterError for a gap that is negative or not finite, or probabilities of species
/// that are negative or add up to 1 or more. InputError if the smallest radius fits nowhere (with
/// the largest ball that fits), the field of the domain is made for much smaller radii (with its
/// depth), the domain is empty, or one of `existing` is not a usable number or
/// lies in more than 2000 others that are no copies; if a periodic cell is shorter than four
/// diameters of the largest sphere. ResourceError if more than 1e9 spheres would be placed.
///
/// Source: front advancing after Feng, Han, Owen (2003), doi:10.1002/nme.583; sites, pools and
/// wavefront as described in assets/guides/how-it-works.md.
template <int Dim>
PackResult<Dim> packSpheres(const Domain<Dim>& domain, const PackOptions& options,
                            const Callbacks& callbacks = {},
                            const std::vector<Sphere<Dim>>& existing = {});

/// The factor on `options.sizes` for which about `count` spheres fill the domain.
///
/// Found from trial packs with larger radii, since the share of the domain that packs worse along
/// the wall grows with the radius: costs about a ninth of the pack itself, a quarter where the
/// domain is thin for its spheres or the spheres are few.
/// @param existing  as in `packSpheres`.
/// @throws ParameterError if `count` < 1, or if by far not as many can keep the gap.
template <int Dim>
double scaleForCount(const Domain<Dim>& domain, const PackOptions& options, double count,
                     const Callbacks& callbacks = {},
                     const std::vector<Sphere<Dim>>& existing = {});

/// Center and radius (mm) of about the largest ball inside a domain; a radius that is not positive
/// if no point inside was found.
///
/// Samples the domain on a grid and goes uphill from the deepest point; a larger ball in a part
/// that the grid misses is not found. Radius exact to 1e-8 of a local maximum.
template <int Dim>
Sphere<Dim> largestBall(const Domain<Dim>& domain);

/// The spheres of a pack that count toward a target, where later stages remove others.
template <int Dim>
struct CountedSpheres {
    /// How many of the spheres, in a pack whose largest radius is `largest` mm; empty: all. Over
    /// ranks: of the spheres of all ranks, from the spheres of one.
    std::function<double(const std::vector<Sphere<Dim>>& spheres, double largest)> count;
    double share = 1;     ///< of all spheres, estimated
    bool warns = true;    ///< whether a count that stays too far from the target gives a warning
    double fraction = 0;  ///< of the domain that spheres fill, about; 0: found by smaller packs
};

/// A pack of about `target` spheres: `options.sizes` are scaled until so many fill the domain.
///
/// The first scale is `scaleForCount`'s guess from smaller packs, the next scales follow the line
/// through the last two packs (logarithm of the count against logarithm of the scale), kept between
/// scales that gave too few and too many. Within 1.8 % of `target`, or the number itself where that
/// is less than a sphere; where eight packs come no nearer, the nearest is returned, and
/// `callbacks.warning` receives both numbers.
/// @param options   its sizes are left as they were packed.
/// @param existing  as for `packSpheres`; not counted.
/// @param counted   which spheres of a pack count.
/// @throws as `packSpheres` and `scaleForCount`.
template <int Dim>
PackResult<Dim> packToCount(const Domain<Dim>& domain, PackOptions& options, double target,
                            const Callbacks& callbacks = {},
                            const std::vector<Sphere<Dim>>& existing = {},
                            const CountedSpheres<Dim>& counted = {});

/// Sets the sizes of `options` (also of the shell) to the sizes of `from` times `factor`, rounded
/// as their texts state them.
void scaleSizes(PackOptions& options, const PackOptions& from, double factor);

}  // namespace vdbpack
