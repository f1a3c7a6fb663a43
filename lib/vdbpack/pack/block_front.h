// The front inside one block of the domain.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/radius_pool.h"

#include <functional>
#include <memory>
#include <vector>

namespace vdbpack {

/// What a block needs to know besides the spheres around it.
template <int Dim>
struct FrontSettings {
    /// Unit direction in which the front sweeps: low values are filled first.
    Vec<Dim> sweep;
    /// Radii tried at a pivot for each sphere placed there, at least 2: the smallest pending one
    /// and others from the largest down.
    int radiiTried = 3;
    /// Centers are whole multiples of this, mm; a power of two. Contacts stay open by about as
    /// much, so that no rounding can turn them into overlaps.
    double quantum = 0x1p-24;
    double minRadius = 0;   ///< of the distribution, mm
    double meanRadius = 0;  ///< of the distribution, mm
    double maxRadius = 0;   ///< of the distribution, mm
    double meanBall = 0;    ///< mean volume (2D: area) of a sphere, mm^Dim
    double fieldError = 0;  ///< how far off the domain's signedDistance may be, mm
    double fieldDepth = 0;  ///< depth at which it is clamped, mm
};

/// Fills one block: a pure function of its arguments.
///
/// A front starts from the spheres that stand around the block and from whatever place could
/// take a sphere of the mean radius, and goes on until no such place is left.
/// Keeps its memory from one block to the next; one object a thread.
template <int Dim>
class BlockFront {
public:
    explicit BlockFront(const FrontSettings<Dim>& settings);
    ~BlockFront();

    /// @param own       where the front of this block grows, mm; its faces are multiples of the
    ///                  quantum. Centers placed lie in [search.lo, own.hi), half-open.
    /// @param search    where no place may be left at the end, mm. It lags behind `own` towards
    ///                  the finished blocks: what is left at a face that another block will
    ///                  grow across is better filled by that block's front.
    /// @param around    spheres that stand with a center within two largest radii of `own` or
    ///                  `search` (others do no harm), in an order fixed by the caller.
    /// @param pool      pending radii; filled up and left for the next block.
    /// @param sampler   of this thread, for the domain.
    /// @param cancelled asked now and then; when true the block is left unfinished.
    /// @param placed    is overwritten with the spheres of this block in the order of placement.
    void fill(const Box<Dim>& own, const Box<Dim>& search, const std::vector<Sphere<Dim>>& around,
              RadiusPool& pool, DomainSampler<Dim>& sampler, const std::function<bool()>& cancelled,
              std::vector<Sphere<Dim>>& placed);

    /// Fresh fronts that `fill` had to start so far.
    std::size_t seeds() const;

private:
    class Work;
    std::unique_ptr<Work> work_;
};

extern template class BlockFront<2>;
extern template class BlockFront<3>;

}  // namespace vdbpack
