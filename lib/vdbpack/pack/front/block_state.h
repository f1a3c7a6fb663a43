// What the front and the search for places share while one block is filled.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/front/cell_list.h"
#include "vdbpack/pack/order.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// What a block needs to know besides the spheres around it.
template <int Dim>
struct FrontSettings {
    Order order = Order::sweep;
    /// Unit direction in which the front sweeps: low values are filled first.
    Vec<Dim> sweep;
    Vec<Dim> middle;  ///< of the domain, where Order::center and fifo begin, mm
    /// How far a sphere that a fourth (2D: third) body stops from growing goes ahead of the sweep
    /// if it is as large as any, mm; smaller ones go ahead by less. 0: nothing does.
    double lead = 0;
    /// Radius for which resting places are sought, mm: what rests there may be larger.
    double probe = 0;
    /// Resting places where no sphere of this radius fits are not used, mm; 0: all are.
    double least = 0;
    /// Gap up to which bodies are asked whether they stop a sphere on the pivot from growing, mm,
    /// at least twice the probe. Those farther off hardly matter.
    double reach = 0;
    /// Centers are whole multiples of this, mm; a power of two. Contacts stay open by about as
    /// much, so that no rounding can turn them into overlaps.
    double quantum = 0x1p-24;
    double minRadius = 0;   ///< of the distribution, mm
    double meanRadius = 0;  ///< of the distribution, mm
    double maxRadius = 0;   ///< of the distribution, mm
    /// Radius up to which spheres are so many that neighbors are sought for them, mm: the largest
    /// one, but for distributions with a few that are far larger than most.
    double commonRadius = 0;
    /// Larger spheres find too few places between others: they are set down ahead of the front, mm.
    double wideRadius = 0;
    double meanBall = 0;    ///< mean volume (2D: area) of a sphere, mm^Dim
    double fieldError = 0;  ///< how far off the domain's signedDistance may be, mm
    double fieldDepth = 0;  ///< depth at which it is clamped, mm
};

/// A block being filled. Coordinates are relative to `origin`.
template <int Dim>
struct BlockState {
    FrontSettings<Dim> settings;
    Vec<Dim> origin;  ///< of the block, in the domain, mm
    Box<Dim> own;     ///< centers placed lie in [lo, hi), half-open
    Box<Dim> search;  ///< where no place may be left
    std::vector<Sphere<Dim>> spheres;
    CellList<Dim> cells;  ///< of all `spheres`
    DomainSampler<Dim>* sampler = nullptr;

    /// @param beyond  what counts as part of the block past its upper faces, mm.
    bool owns(const Vec<Dim>& x, double beyond = 0) const {
        for (int d = 0; d < Dim; ++d)
            if (!(own.lo[d] <= x[d] && x[d] < own.hi[d] + beyond)) return false;
        return true;
    }

    Vec<Dim> snapped(const Vec<Dim>& x) const {
        Vec<Dim> s;
        for (int d = 0; d < Dim; ++d)
            s[d] = std::nearbyint(x[d] / settings.quantum) * settings.quantum;
        return s;
    }

    /// Whether a sphere would overlap none.
    bool isFree(const Vec<Dim>& x, double radius) const {
        return cells.near(x, radius, [&](std::uint32_t i) {
            const double least = spheres[i].radius + radius;
            return squaredLength(spheres[i].center - x) >= least * least;
        });
    }

    /// Distance from `x` to the nearest sphere or wall, at most `reach`, mm; negative outside the
    /// domain and inside a sphere.
    double clearance(const Vec<Dim>& x, double reach) const;

    /// Moves `x` uphill to where its clearance `room` is largest, at most `reach`, mm.
    void climb(Vec<Dim>& x, double& room, double reach) const;
};

extern template struct BlockState<2>;
extern template struct BlockState<3>;

}  // namespace vdbpack
