// A block while it is filled.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/front/block_spheres.h"
#include "vdbpack/pack/front/cell_list.h"
#include "vdbpack/pack/front/front_settings.h"
#include "vdbpack/pack/front/local_lengths.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace vdbpack {

/// A plane tangent to the wall.
template <int Dim>
struct TangentPlane {
    Vec<Dim> point;   ///< on the wall, mm
    Vec<Dim> normal;  ///< unit, into the domain
};

/// A block while it is filled: its spheres and the domain. Coordinates are relative to `origin`.
template <int Dim>
struct BlockState {
    FrontSettings<Dim> settings;
    Vec<Dim> origin;                   ///< of the block, in the domain, mm
    Box<Dim> own;                      ///< centers placed lie in [lo, hi), half-open
    Box<Dim> search;                   ///< where no vacancy may be left
    std::uint32_t laterBehind = 0;     ///< see BlockFront::Place
    std::vector<Sphere<Dim>> spheres;  ///< around the block first, then those placed
    CellList<Dim> cells;               ///< of all `spheres`
    DomainSampler<Dim>* sampler = nullptr;
    LocalLengths<Dim>* local = nullptr;  ///< null: the same sizes everywhere
    /// Then, of each sphere: the least mean radius that is requested around it, mm.
    std::vector<double> leastMeans{};

    /// What is requested at a point.
    LocalSize sizeAt(const Vec<Dim>& x) const {
        return local ? local->at(x + origin) : LocalSize{};
    }
    /// Unit direction in which a swept front advances at a point.
    Vec<Dim> advance(const Vec<Dim>& x) const {
        if (settings.waves.length == 0) return settings.sweep;
        return normalized(settings.waves.direction(x + origin, settings.sweep));
    }
    FrontLengths lengthsOf(const LocalSize& size) const {
        if (local) return local->of(size);
        return settings;
    }
    /// The least mean radius that is requested within a distance of a point, mm.
    double leastMean(const Vec<Dim>& x, double distance) const {
        return local ? local->leastMean(x + origin, distance) : settings.meanRadius;
    }
    /// The mean radius that is requested at a point, mm.
    double meanAt(const Vec<Dim>& x) const {
        return local ? local->mean(x + origin) : settings.meanRadius;
    }
    /// Whether the same sizes are requested up to a distance from a point along each axis, mm.
    bool hasOneSize(const Vec<Dim>& x, double distance) const {
        return !local || local->isConstant(x + origin, distance);
    }

    /// Whether a center belongs to the block.
    /// @param beyond  how far past its upper faces it may lie, mm.
    bool owns(const Vec<Dim>& x, double beyond = 0) const {
        for (int d = 0; d < Dim; ++d)
            if (!(own.lo[d] <= x[d] && x[d] < own.hi[d] + beyond)) return false;
        return true;
    }

    /// The neighbor block (`neighborBit`) that holds a point outside this one; 0 if all of it lies
    /// behind the front.
    std::uint32_t neighborAt(const Vec<Dim>& x) const {
        std::array<int, Dim> offset;
        bool ahead = false;
        for (int d = 0; d < Dim; ++d) {
            // The faces of the block itself: 0 and own.hi.
            offset[static_cast<std::size_t>(d)] = x[d] < 0 ? -1 : x[d] < own.hi[d] ? 0 : 1;
            ahead = ahead || x[d] >= own.hi[d];
        }
        const std::uint32_t bit = neighborBit(offset);
        return ahead || (laterBehind & bit) != 0 ? bit : 0;
    }

    Vec<Dim> snapped(const Vec<Dim>& x) const {
        Vec<Dim> s;
        for (int d = 0; d < Dim; ++d)
            s[d] = std::nearbyint(x[d] / settings.quantum) * settings.quantum;
        return s;
    }

    /// Whether a sphere would overlap no other.
    bool isFree(const Vec<Dim>& x, double radius) const {
        return cells.near(x, radius, [&](std::uint32_t i) {
            const double least = spheres[i].radius + radius;
            return squaredLength(spheres[i].center - x) >= least * least;
        });
    }

    /// The plane tangent to the wall at its point nearest to `x`, if that is closer than `reach`,
    /// mm. Where the field reports more distance, the triangles are asked up to `least` only.
    /// @param inside  a point of the domain nearby: it decides the side where `x` lies on the wall.
    /// @return whether there is one; `distance` is then that of `x`, mm.
    bool findWall(const Vec<Dim>& inside, const Vec<Dim>& x, double least, double reach,
                  TangentPlane<Dim>& plane, double& distance) const;

    /// Distance from `x` to the nearest sphere or wall, at most `reach`, mm; negative outside the
    /// domain and inside a sphere. Where it is not above `enough`, any number that is not.
    double clearance(const Vec<Dim>& x, double reach,
                     double enough = -std::numeric_limits<double>::infinity()) const;

    /// Moves `x` uphill to where its clearance `room` is largest, at most `reach`, mm.
    /// @param least  radius of which a quarter is the first step, mm.
    void climb(Vec<Dim>& x, double& room, double reach, double least) const;
};

}  // namespace vdbpack
