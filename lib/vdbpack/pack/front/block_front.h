// The front inside one block of the domain.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/front/block_spheres.h"
#include "vdbpack/pack/front/front_settings.h"
#include "vdbpack/pack/front/local_lengths.h"
#include "vdbpack/pack/radius_pool.h"
#include "vdbpack/pack/species.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace vdbpack {

/// Fills one block: a pure function of its arguments.
///
/// The front is the set of sites where a sphere could touch Dim bodies. It advances by the lowest
/// site along the sweep, but sites where a further body stops a sphere before it has grown to the
/// largest radius come ahead of it, those with most room first: such a sphere touches one body
/// more, and later there would be less room for it. A site takes the largest pending radius that
/// fits. When no site is left, a search looks for vacancies that the front has not reached and
/// starts a fresh front from each, until none is left that could take a sphere of the mean radius.
///
/// Keeps its memory from one block to the next; one object a thread.
/// Source: advancing front after Feng, Han, Owen (2003), doi:10.1002/nme.583, with the order of
/// sites and the pools of radii of our own.
template <int Dim>
class BlockFront {
public:
    explicit BlockFront(const FrontSettings<Dim>& settings);
    ~BlockFront();

    /// Where a block lies.
    struct Place {
        /// Where the front of this block grows, mm; its faces are multiples of the quantum. Centers
        /// placed lie in [search.lo, own.hi), half-open; centers of further species up to a largest
        /// radius past own.hi.
        Box<Dim> own;
        /// Where no vacancy may be left at the end, mm. It lags behind `own` towards the finished
        /// blocks: a vacancy at a face across which another block will grow is better filled by
        /// that block's front.
        Box<Dim> search;
        /// Neighbors behind the block that come later all the same, bits as of `neighborBit`: sites
        /// in them are handed over, too.
        std::uint32_t laterBehind = 0;
        /// Where sizes differ by place: the lengths of this block, and the lengths of its points.
        /// Null: those of the settings.
        const FrontLengths* lengths = nullptr;
        LocalLengths<Dim>* local = nullptr;
    };

    /// @param around    existing spheres within a largest radius (with further species, two) of
    ///                  `own` or `search` (others do no harm), in an order fixed by the caller, and
    ///                  the sites on them in `own`.
    /// @param pools     pending radii of each group of sizes, where these differ by place per
    ///                  factor; refilled, and left for the next block.
    /// @param further   due spheres of further species, left for the next block; null: none.
    /// @param sampler   of this thread, for the domain.
    /// @param cancelled asked now and then; when true the block is left unfinished.
    /// @param placed    is overwritten with the spheres of this block in the order of placement.
    void fill(const Place& place, const BlockSpheres<Dim>& around, std::vector<RadiusPool>& pools,
              SpeciesQueue* further, DomainSampler<Dim>& sampler,
              const std::function<bool()>& cancelled, BlockSpheres<Dim>& placed);

    /// Fresh fronts that `fill` had to start so far.
    std::size_t seeds() const;

private:
    class Work;
    std::unique_ptr<Work> work_;
};

}  // namespace vdbpack
