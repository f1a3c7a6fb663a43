// Waves across the direction in which a front sweeps: Order::waves.
#pragma once

#include "vdbpack/core/vec.h"

#include <cmath>

namespace vdbpack {

/// Where a point lies in the order of a front.
struct FrontOrder {
    double position = 0;  ///< low ones are filled first, mm
    double slope = 1;     ///< by how much that rises in a mm in the direction of the front there
};

/// Waves of parabolic arcs along each axis across the diagonal in which a front sweeps.
///
/// A sphere that a front places rests on spheres behind it, so its contacts gather around the
/// direction in which the front advances there. The slopes of the waves are spread evenly from
/// -kSteepest to kSteepest: the front still moves along the diagonal, but over a few waves its
/// directions are spread so that contacts have none in common.
template <int Dim>
struct SweepWaves {
    double length = 0;  ///< of a wave, mm; 0: there are none
    Vec<Dim> start;     ///< where waves begin, mm

    /// The order of a point at a position along the sweep.
    FrontOrder at(const Vec<Dim>& x, double position) const {
        FrontOrder order{position};
        double square = 1;
        forEachWave(x, [&](int, double height, double slope) {
            order.position += height;
            square += slope * slope;
        });
        order.slope = std::sqrt(square);
        return order;
    }

    /// The direction in which the front advances at a point; its length is the slope.
    /// @param sweep  unit direction of the sweep.
    Vec<Dim> direction(const Vec<Dim>& x, const Vec<Dim>& sweep) const {
        Vec<Dim> rise = sweep;
        forEachWave(x, [&](int d, double, double slope) {
            const double part = slope / std::sqrt(static_cast<double>(d * (d + 1)));
            for (int i = 0; i < d; ++i) rise[i] += part;
            rise[d] -= d * part;
        });
        return rise;
    }

    /// How far a site that goes ahead by some mm may come before its position along the sweep, mm.
    double most(double ahead) const {
        const double steepest = length > 0 ? std::sqrt(1 + (Dim - 1) * kSteepest * kSteepest) : 1;
        return (Dim - 1) * kSteepest * length / 8 + steepest * ahead;
    }

private:
    /// Calls `visit(d, height, slope)` for the wave along each of the unit vectors across the
    /// diagonal and one another: (1, -1, 0) / sqrt(2), (1, 1, -2) / sqrt(6). Heights in mm.
    template <class Visit>
    void forEachWave(const Vec<Dim>& x, const Visit& visit) const {
        if (length == 0) return;
        double before = x[0] - start[0];  // sum of the coordinates so far
        for (int d = 1; d < Dim; ++d) {
            const double next = x[d] - start[d];
            const double across = (before - d * next) / std::sqrt(static_cast<double>(d * (d + 1)));
            before += next;
            const double turn = across / length - std::floor(across / length);
            const double steep = turn < 0.5 ? kSteepest : -kSteepest;
            const double u = turn < 0.5 ? turn : turn - 0.5;
            visit(d, steep * length * u * (1 - 2 * u), steep * (1 - 4 * u));
        }
    }

    /// Box 120, radii 1 to 2, largest eigenvalue of the fabric tensor and estimated moduli, largest
    /// / smallest: 0.340 and 1.08 at 2, 0.335 and 1.03 at 2.5, 0.339 and 1.07 at 3.
    static constexpr double kSteepest = 2.5;
};

}  // namespace vdbpack
