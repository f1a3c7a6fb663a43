// Cells that repeat along some of their axes.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/sphere.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace vdbpack {

/// A box (2D: rectangle) that repeats along the axes that wrap: what leaves it through a face comes
/// back through the opposite one. By default no axis wraps, and the box means nothing.
template <int Dim>
struct PeriodicCell {
    Box<Dim> box;                       ///< mm; along an axis that does not wrap, between its walls
    std::array<bool, Dim> wraps{};      ///< axes along which it repeats
    using Laps = std::array<int, Dim>;  ///< whole cells along each axis

    bool isAlong(int d) const { return wraps[static_cast<std::size_t>(d)]; }
    bool any() const {
        for (const bool w : wraps)
            if (w) return true;
        return false;
    }
    bool all() const {
        for (const bool w : wraps)
            if (!w) return false;
        return true;
    }
    double length(int d) const { return box.hi[d] - box.lo[d]; }
    /// The shortest length along which it repeats, mm; infinity if there is none.
    double shortest() const {
        double least = std::numeric_limits<double>::infinity();
        for (int d = 0; d < Dim; ++d)
            if (isAlong(d)) least = std::min(least, length(d));
        return least;
    }

    /// By how much an image lies beside what it is one of, mm.
    Vec<Dim> shift(const Laps& laps) const {
        Vec<Dim> by{};
        for (int d = 0; d < Dim; ++d)
            if (isAlong(d)) by[d] = laps[static_cast<std::size_t>(d)] * length(d);
        return by;
    }

    /// The image of `x` in the cell: from the lower face on, below the upper one.
    Vec<Dim> wrapped(Vec<Dim> x) const {
        for (int d = 0; d < Dim; ++d) {
            if (!isAlong(d) || (box.lo[d] <= x[d] && x[d] < box.hi[d])) continue;
            x[d] -= std::floor((x[d] - box.lo[d]) / length(d)) * length(d);
            // Rounding may end at a face or beyond it.
            if (x[d] < box.lo[d] || x[d] >= box.hi[d]) x[d] = box.lo[d];
        }
        return x;
    }

    /// The shortest of the images of a difference of two points.
    Vec<Dim> nearest(Vec<Dim> difference) const {
        for (int d = 0; d < Dim; ++d)
            if (isAlong(d)) difference[d] -= std::nearbyint(difference[d] / length(d)) * length(d);
        return difference;
    }

    /// Calls `visit(shift)` for the images of a box that meet another box, itself included.
    /// @param part  its lower corner lies in the cell.
    template <class Visit>
    void forEachShift(const Box<Dim>& part, const Box<Dim>& met, const Visit& visit) const {
        Laps first{}, last{};
        for (int d = 0; d < Dim; ++d) {
            const auto at = static_cast<std::size_t>(d);
            if (!isAlong(d)) continue;
            first[at] = static_cast<int>(std::ceil((met.lo[d] - part.hi[d]) / length(d)));
            last[at] = static_cast<int>(std::floor((met.hi[d] - part.lo[d]) / length(d)));
            if (first[at] > last[at]) return;
        }
        for (Laps laps = first;;) {
            visit(shift(laps));
            std::size_t d = 0;
            while (d < Dim && ++laps[d] > last[d]) laps[d] = first[d], ++d;
            if (d == Dim) return;
        }
    }
};

/// Spheres of a cell, and the images of those that are near its faces.
template <int Dim>
struct SpheresWithImages {
    std::vector<Sphere<Dim>>
        spheres;          ///< first the spheres of the cell, wrapped into it, then images
    std::size_t own = 0;  ///< of the cell
    std::vector<std::uint32_t> source;  ///< of each sphere: itself, or that of which it is an image
};

/// @param reach  images are added whose surface is closer to the cell than this, mm: with the
///               largest radius and a gap, all that a sphere of the cell is near to.
template <int Dim>
SpheresWithImages<Dim> withImages(const std::vector<Sphere<Dim>>& spheres,
                                  const PeriodicCell<Dim>& cell, double reach);

/// Least length of a periodic cell in diameters of the largest sphere: in shorter ones, spheres
/// would come near their own images.
inline constexpr double kCellDiameters = 4;

/// The same for a pack that is given: in shorter ones, two spheres may touch more than once.
inline constexpr double kGivenCellDiameters = 2;

/// @param largest  radius, with half of the gap, mm.
/// @throws InputError if a cell is shorter than that.
template <int Dim>
void requireLongCell(const PeriodicCell<Dim>& cell, double largest,
                     double diameters = kCellDiameters);

}  // namespace vdbpack
