// The options of a pack.
#pragma once

#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/size_distribution.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace vdbpack {

class Ranks;
class SizeField;

/// How much time goes into the solid fraction. fast takes sites as they come along the sweep;
/// normal takes those first where a further body stops a sphere from growing; dense does the same
/// with more pending radii, in larger blocks.
enum class Effort { fast, normal, dense };

constexpr const char* nameOf(Effort effort) {
    return effort == Effort::fast ? "fast" : effort == Effort::normal ? "normal" : "dense";
}

/// waves: along a diagonal of the axes, with waves across it (`SweepWaves`), so that contacts
/// gather around no direction; in blocks and on all threads. sweep: the same without waves:
/// contacts gather around the diagonal. Nearly equal spheres, and further species, are always swept
/// without waves. The others are those of the literature, for comparison, and run as one block on
/// one thread: from the wall inwards, from the middle outwards, and first in, first out from the
/// middle.
enum class Order { waves, sweep, wall, center, fifo };

/// Whether a front of that order moves along the diagonal, in blocks.
constexpr bool sweeps(Order order) {
    return order == Order::sweep || order == Order::waves;
}

constexpr const char* nameOf(Order order) {
    return order == Order::sweep    ? "sweep"
           : order == Order::waves  ? "waves"
           : order == Order::wall   ? "wall"
           : order == Order::center ? "centre"
                                    : "fifo";
}

/// What differs by place in the sizes of a pack. The center of a sphere decides.
struct LocalSizes {
    /// Factor on the radii; null: 1 everywhere.
    std::shared_ptr<const SizeField> factor;
    /// Radii (times the factor) of spheres with centers in `shell`; none: the sizes of the others.
    std::optional<SizeDistribution> shellSizes;
    ShellThickness shell;

    bool any() const { return factor || shellSizes; }
    /// The largest radius anywhere, mm. @param sizes  of group 0.
    double largest(const SizeDistribution& sizes) const;
    struct Factors {
        double least = 1, most = 1;
    };
    Factors factors() const;  ///< bounds of `factor`
    std::size_t groups() const { return shellSizes ? 2 : 1; }
    /// The distribution of group 1, the shell, or 0, all others. @param sizes  of group 0.
    const SizeDistribution& sizesOf(std::size_t group, const SizeDistribution& sizes) const {
        return group == 1 ? *shellSizes : sizes;
    }
};

/// A kind of spheres beside the first one: each new sphere is of it with some probability.
struct Species {
    SizeDistribution sizes;  ///< radii, mm
    double probability = 0;  ///< that a sphere is of this species, 0 to below 1
    double depth = 0;        ///< its spheres lie wholly deeper than this below the wall, mm
};

/// Options of `packSpheres`, set by name:
///
///     PackOptions options(SizeDistribution::uniform(1, 2));
///     options.seed = 7;
///     options.gap = 0.05;
struct PackOptions {
    explicit PackOptions(SizeDistribution s) : sizes(std::move(s)) {}

    /// Radii, mm, as shares by number; the only option without a default.
    SizeDistribution sizes;
    /// What differs by place; by default nothing. Each part follows its sizes as a whole pack
    /// would.
    LocalSizes local;
    /// Start of all random draws: another seed gives another pack of the same kind.
    std::uint64_t seed = 1;
    /// Threads that work at a time; 0: all cores. The pack is the same for any number.
    int threads = 0;
    Effort effort = Effort::normal;
    Order order = Order::waves;  ///< in which sites are taken
    /// Whether sizes next to walls, and where the pack begins, are those requested. Otherwise they
    /// are larger where the front starts and smaller where it ends, and the front takes 5 % less
    /// time.
    bool evenSizes = true;
    /// Least distance between spheres, and between spheres and the wall, mm.
    double gap = 0;
    /// Keep the first spheres of the pack up to this number; 0: all. The domain is filled all the
    /// same: for a pack of about so many spheres scale the radii by `scaleForCount`.
    std::int64_t maxCount = 0;
    /// Radii drawn and not yet placed, from which a site takes the largest that fits; 0: from the
    /// domain and effort, 32 to 384. More give larger spheres to the first sites and leave as many
    /// radii unplaced at the end: packs of few spheres need few.
    std::size_t pending = 0;
    /// Edge of a block (each is filled by one thread), mm; 0: from radii, domain and order. Smaller
    /// blocks occupy more threads and cost some solid fraction; no smaller than 8 largest radii.
    double blockSide = 0;
    /// Further species beside `sizes`, each drawn with its probability for every new sphere that
    /// lies deep enough. Spheres of these that fit at no site are set down ahead of the front.
    std::vector<Species> species;
    /// Other ranks that fill the same domain with the same call; null: there are none. The pack is
    /// the same for any number of them; each gets the spheres of its own blocks.
    Ranks* ranks = nullptr;
};

}  // namespace vdbpack
