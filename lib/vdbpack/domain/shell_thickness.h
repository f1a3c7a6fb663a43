// How thick the shell along the wall of a domain is, by place.
#pragma once

#include "vdbpack/core/vec.h"

#include <functional>
#include <utility>

namespace vdbpack {

/// The thickness of the layer along the wall of a domain's envelope, mm. A point belongs to the
/// shell if its depth below that wall is not larger than the thickness at the point itself.
class ShellThickness {
public:
    /// The same everywhere; 0: there is no shell. Converts from a thickness in mm.
    ShellThickness(double uniform = 0) : least_(uniform), most_(uniform) {}
    /// @param at           thickness by place, from `least` to `most`; thread-safe.
    /// @param sliceHeight  2D: height of the plane, mm.
    ShellThickness(std::function<double(const Vec<3>&)> at, double least, double most,
                   double sliceHeight = 0)
        : at_(std::move(at)), least_(least), most_(most), sliceHeight_(sliceHeight) {}

    /// Whether there is a shell anywhere.
    bool any() const { return most_ > 0; }
    bool isUniform() const { return !at_; }
    double least() const { return least_; }
    double most() const { return most_; }
    double at(const Vec<3>& x) const { return at_ ? at_(x) : most_; }
    double at(const Vec<2>& x) const { return at({{x[0], x[1], sliceHeight_}}); }
    /// Whether a point at a depth (mm) lies deeper; seeks the thickness only where that matters.
    template <int Dim>
    bool isDeeper(const Vec<Dim>& x, double depth) const {
        return depth > most_ || (depth > least_ && depth > at(x));
    }

private:
    std::function<double(const Vec<3>&)> at_;
    double least_ = 0, most_ = 0, sliceHeight_ = 0;
};

}  // namespace vdbpack
