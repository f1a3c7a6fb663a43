// Axis-aligned boxes, and sides of planes.
#pragma once

#include "vdbpack/core/vec.h"

#include <algorithm>
#include <limits>

namespace vdbpack {

/// An axis-aligned box (2D: rectangle); empty until a point is added.
template <int Dim>
struct Box {
    Vec<Dim> lo = filled(std::numeric_limits<double>::infinity());
    Vec<Dim> hi = filled(-std::numeric_limits<double>::infinity());

    bool empty() const {
        for (int i = 0; i < Dim; ++i)
            if (!(lo[i] <= hi[i])) return true;
        return false;
    }
    void add(const Vec<Dim>& p) {
        for (int i = 0; i < Dim; ++i) {
            lo[i] = std::min(lo[i], p[i]);
            hi[i] = std::max(hi[i], p[i]);
        }
    }
    bool contains(const Vec<Dim>& p) const {
        for (int i = 0; i < Dim; ++i)
            if (!(lo[i] <= p[i] && p[i] <= hi[i])) return false;
        return true;
    }
    /// Squared distance from `p` to the box, mm²; 0 inside.
    double squaredDistance(const Vec<Dim>& p) const {
        double square = 0;
        for (int i = 0; i < Dim; ++i) {
            const double out = std::max({lo[i] - p[i], p[i] - hi[i], 0.0});
            square += out * out;
        }
        return square;
    }
    Vec<Dim> size() const { return hi - lo; }
    Vec<Dim> center() const { return (lo + hi) * 0.5; }
    /// The box grown by `margin` (mm) on every side.
    Box grown(double margin) const { return {lo - filled(margin), hi + filled(margin)}; }
    /// Volume (2D: area), mm^Dim; 0 if empty.
    double volume() const {
        if (empty()) return 0;
        double m = 1;
        for (int i = 0; i < Dim; ++i) m *= hi[i] - lo[i];
        return m;
    }

    static Vec<Dim> filled(double value) {
        Vec<Dim> v;
        v.c.fill(value);
        return v;
    }
};

/// The common part of two boxes; empty where they do not meet.
template <int Dim>
Box<Dim> intersection(const Box<Dim>& a, const Box<Dim>& b) {
    Box<Dim> r;
    for (int i = 0; i < Dim; ++i) {
        r.lo[i] = std::max(a.lo[i], b.lo[i]);
        r.hi[i] = std::min(a.hi[i], b.hi[i]);
    }
    return r;
}

/// The side n.x <= offset of a plane (2D: line); `normal` need not have length one.
template <int Dim>
struct HalfSpace {
    Vec<Dim> normal;
    double offset = 0;  ///< n.x on the plane
};

}  // namespace vdbpack
