// The front inside one block of the domain.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/front/block_state.h"
#include "vdbpack/pack/radius_pool.h"
#include "vdbpack/pack/species.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace vdbpack {

/// A place of one block's front that lies in a block to come, which goes on from there.
template <int Dim>
struct HandedSite {
    /// What a sphere there rests on beside the pivot.
    struct Support {
        enum class Kind { sphere, wall, none } kind;
        Vec<Dim> at;      ///< center; of a wall, the point touched, mm
        Vec<Dim> normal;  ///< of a wall, into the domain
        double radius;    ///< of a sphere, mm
    };
    std::array<Support, Dim - 1> supports;
    Vec<Dim> center;        ///< at radius `limit`, mm
    float limit;            ///< largest radius that fits, as far as the block knew, mm
    float side;             ///< see Track::side
    std::uint32_t pivot;    ///< place in BlockSpheres::spheres
    std::uint32_t towards;  ///< the neighbor it lies in; see BlockSpheres::bit
};

/// Spheres of a block, or around one.
template <int Dim>
struct BlockSpheres {
    std::vector<Sphere<Dim>> spheres;
    /// Sites on them that lie in other blocks, by rising pivot.
    std::vector<HandedSite<Dim>> sites;
    /// Those that no block placed and others may rest on, rising: their sites are yet to be found.
    std::vector<std::uint32_t> unexplored;
    /// Species of each sphere, see PackOptions::species; empty where there is one.
    std::vector<std::uint8_t> species;

    /// The bit of the neighbor at `offset`, each -1, 0 or 1.
    static std::uint32_t bit(const std::array<int, Dim>& offset) {
        unsigned n = 0;
        for (const int o : offset) n = 3 * n + static_cast<unsigned>(o + 1);
        return std::uint32_t{1} << n;
    }

    void clear() {
        spheres.clear();
        sites.clear();
        unexplored.clear();
        species.clear();
    }
};

/// Fills one block: a pure function of its arguments.
///
/// The front is the set of sites where a sphere could rest on Dim bodies. It advances by the
/// lowest one along the sweep, but sites where a sphere is stopped by a further body before it
/// has grown to the largest radius go ahead of it, those with most room first: such a sphere
/// touches one body more, and later there would be less room for it. A site takes the largest
/// pending radius that fits. When the front has nowhere to go on, a search looks for places that
/// it has not reached and starts a fresh one from each, until none is left that could take a
/// sphere of the mean radius.
/// Keeps its memory from one block to the next; one object a thread.
template <int Dim>
class BlockFront {
public:
    explicit BlockFront(const FrontSettings<Dim>& settings);
    ~BlockFront();

    /// @param own       where the front of this block grows, mm; its faces are multiples of the
    ///                  quantum. Centers placed lie in [search.lo, own.hi), half-open; those of
    ///                  further species up to a largest radius past own.hi.
    /// @param search    where no place may be left at the end, mm. It lags behind `own` towards
    ///                  the finished blocks: what is left at a face that another block will
    ///                  grow across is better filled by that block's front.
    /// @param around    spheres that stand within a largest radius (with further species, two) of
    ///                  `own` or `search` (others do no harm), in an order fixed by the caller, and
    ///                  the sites on them in `own`.
    /// @param pool      pending radii; filled up and left for the next block.
    /// @param further   what is due of further species, left for the next block; null: none.
    /// @param sampler   of this thread, for the domain.
    /// @param cancelled asked now and then; when true the block is left unfinished.
    /// @param placed    is overwritten with the spheres of this block in the order of placement.
    void fill(const Box<Dim>& own, const Box<Dim>& search, const BlockSpheres<Dim>& around,
              RadiusPool& pool, SpeciesQueue* further, DomainSampler<Dim>& sampler,
              const std::function<bool()>& cancelled, BlockSpheres<Dim>& placed);

    /// Fresh fronts that `fill` had to start so far.
    std::size_t seeds() const;

private:
    class Work;
    std::unique_ptr<Work> work_;
};

extern template class BlockFront<2>;
extern template class BlockFront<3>;

}  // namespace vdbpack
