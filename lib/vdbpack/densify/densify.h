// Packs denser than a front can make them: spheres are added, and all are pushed apart.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/size_distribution.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// Where the steps of relaxations are taken; the pack is the same.
struct DeviceChoice {
    enum class Kind {
        automatic,  ///< a GPU where there is one that is quicker, in packs of many spheres
        processor,
        gpu  ///< any OpenCL device, also one that is slower
    };
    Kind kind = Kind::automatic;
    int number = 0;  ///< of a device of OpenCL, from 0, GPUs first

    bool operator==(const DeviceChoice& o) const { return kind == o.kind && number == o.number; }
};

/// What a device has done.
struct DeviceUse {
    std::string name, driver;  ///< empty: no device was used
    std::uint64_t steps = 0;   ///< of all relaxations
    double seconds = 0;        ///< of its kernels
};

struct LocalSizes;
class Ranks;

struct DensifyOptions {
    /// Solid fraction to reach, of all spheres together; infinity: as dense as possible (in space,
    /// nearly equal spheres: as far as they stay random; a higher request makes them crystallize).
    /// For the fraction of the input pack (or less), no sphere is added: overlaps are removed.
    double fraction = 0;
    /// Sizes of all spheres together, mm; none: the sizes of the input pack.
    std::optional<SizeDistribution> sizes;
    double gap = 0;          ///< least distance between spheres, and of spheres to the wall, mm
    std::uint64_t seed = 1;  ///< another seed, another pack of the same kind
    std::size_t fixed = 0;   ///< the first spheres, which stay where they are
    /// Regions of the spheres; empty: all are in one. Spheres exchange positions within their
    /// region only. Every region receives its share (by volume) of the added spheres, near its own
    /// spheres; without `sizes` they have radii of that region.
    std::vector<std::int32_t> regions;

    /// What differs by place in `sizes`, which are given; null: nothing. Spheres exchange positions
    /// with spheres of nearly the same request; `regions` are not used then.
    const LocalSizes* local = nullptr;

    /// Whether there is no pack to begin with: as many spheres of `sizes` as make `fraction` are
    /// put at random points and pushed apart. Nothing of a front is in such a pack. Not with
    /// spheres, regions, `local` and ranks.
    bool random = false;

    /// Whether the spheres of a region first exchange their radii at random in a periodic cell: for
    /// spheres of a front, which leaves large ones where it begins and small ones where it ends, at
    /// the faces of the cell. Not where `local` is given.
    bool mixSizes = false;

    /// Whether near spheres are drawn together until they touch, where spheres have moved.
    bool contacts = true;

    /// Whether the spheres of a front are settled, whatever `fraction` is: moved a little at
    /// random, pushed apart beyond their radii and drawn together, so that neither the directions
    /// of contacts nor the density tell where the front began. No sphere is added.
    bool settle = false;

    /// Where the steps of relaxations are taken; over ranks, the processor takes them.
    DeviceChoice device;

    /// Other ranks that densify the same pack with the same call; null: there are none. Each has
    /// the spheres that it placed, which do not overlap: no regions, none is fixed, and `sizes` are
    /// given. In a periodic cell, and with `local`, the first rank densifies all of them.
    Ranks* ranks = nullptr;
    std::vector<std::uint32_t>
        labels;  ///< of the spheres: their numbers among the spheres of all ranks, rising
    /// From one of these numbers to the next, all spheres belong to one rank; the last is the
    /// number of all.
    std::vector<std::int64_t> pieces;
};

template <int Dim>
struct DensifyResult {
    /// The input pack in its order, then the added spheres (`random`: these alone); near where they
    /// were, since it is the radii that spheres of nearly equal size exchange. If `apart`, no two
    /// overlap and none protrudes from the domain, except for the fixed ones.
    std::vector<Sphere<Dim>> spheres;
    std::vector<std::int32_t> regions;  ///< of all spheres, if the options have regions
    std::vector<std::uint32_t> labels;  ///< over ranks: of all spheres of this one
    std::vector<std::int64_t> pieces;   ///< over ranks: as in the options, with the added spheres
    bool apart = false;            ///< false: not even the overlaps of the input pack were removed
    bool reached = false;          ///< whether the requested fraction was reached
    bool interrupted = false;      ///< cancelled: `spheres` is the last pack without overlaps
    double before = 0, after = 0;  ///< solid fractions, overlaps counted twice
    std::uint64_t steps = 0;       ///< of the relaxation, all stages together
    int stages = 0;                ///< insertions
    DeviceUse device;              ///< what a device has done, if one was used
};

/// Makes a pack denser: further spheres are added where there is most room, and all of them are
/// relaxed (`Relaxation`) until none overlap. Then near spheres are drawn together until they
/// touch. The radii as a whole are kept.
///
/// Where the requested fraction is not reached, the densest pack without overlaps is returned. The
/// same for any number of threads. Cost: 8 to 15 µs of processor time per sphere for 0.01 to 0.03
/// more than the front's fraction, 100 to 260 µs for the densest pack, 20 from random points to a
/// front's fraction; 3 µs for contacts, 8 to 14 to settle.
/// @param spheres  mm; from any program. They may overlap and protrude by less than their radii.
/// @throws ParameterError for an impossible fraction or gap; InputError for unusable spheres or a
/// domain without volume, or a periodic cell shorter than four diameters; ResourceError above 2^31
/// spheres.
template <int Dim>
DensifyResult<Dim> densify(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
                           const DensifyOptions& options, const Callbacks& callbacks = {});

}  // namespace vdbpack
