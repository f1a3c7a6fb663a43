// The options of a pack.
#pragma once

#include "vdbpack/core/ranks.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/pack/order.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/pack/species.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace vdbpack {

/// How much time goes into the solid fraction. fast takes sites as they come along the sweep;
/// normal takes those first where a further body stops a sphere from growing; dense does the same
/// with more pending radii.
enum class Effort { fast, normal, dense };

constexpr const char* nameOf(Effort effort) {
    return effort == Effort::fast ? "fast" : effort == Effort::normal ? "normal" : "dense";
}

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
    /// Order in which sites are taken. All but `sweep` run as one block on one thread.
    Order order = Order::sweep;
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
    /// effort, 64 or more. More give larger spheres to the first sites and leave as many radii
    /// unplaced at the end: packs of few spheres need few.
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
