// A factor on radii that varies in space.
#pragma once

#include "vdbpack/core/box.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

namespace vdbpack {

/// Numbers at the nodes of a lattice, linear in between; beyond it, the numbers of the nearest
/// nodes. Immutable and thread-safe. A lookup takes some 10 ns.
class SizeField {
public:
    /// Tabulates a function.
    /// @param bounds  where it is known, mm; without extent along z for a field of the plane.
    /// @param node    where one of the nodes is to lie, mm.
    /// @param step    between the nodes along each axis, mm, > 0; longer where the lattice would
    ///                have more than `mostNodes`.
    /// @param value   thread-safe; positive.
    SizeField(const Box<3>& bounds, const Vec<3>& node, double step,
              const std::function<double(const Vec<3>&)>& value, double mostNodes = 3.2e7);

    double at(const Vec<3>& x) const;
    /// In the plane of the field.
    double at(const Vec<2>& x) const { return at({{x[0], x[1], origin_[2]}}); }

    struct Range {
        double least, most;
    };
    /// Bounds of the values within a box, mm: no wider than those a few nodes beyond it.
    Range within(const Box<3>& box) const;
    Range within(const Box<2>& box) const {
        return within(
            Box<3>{{{box.lo[0], box.lo[1], origin_[2]}}, {{box.hi[0], box.hi[1], origin_[2]}}});
    }
    /// Whether all values within a box are the same. Takes about as long as two lookups, where the
    /// box is not larger than a few steps.
    bool isConstant(const Box<3>& box) const;
    bool isConstant(const Box<2>& box) const {
        return isConstant(
            Box<3>{{{box.lo[0], box.lo[1], origin_[2]}}, {{box.hi[0], box.hi[1], origin_[2]}}});
    }
    Range all() const { return all_; }
    double step() const { return step_; }

private:
    using Index = std::array<int, 3>;
    /// Least and largest values in cells of `kFirst` steps, and of twice as many on each level.
    struct Level {
        int cell = 1;  ///< steps
        Index count{};
        std::vector<std::pair<float, float>> bounds;
    };
    static constexpr int kFirst = 4;
    void addLevels();
    Level coarser(const Level& fine) const;
    /// Bounds of the values at the nodes from `from` to `to`, or those of the cells that hold them.
    Range withinCells(const Level& level, const Index& from, const Index& to) const;
    std::size_t indexOf(int i, int j, int k) const {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(count_[1]) +
                static_cast<std::size_t>(j)) *
                   static_cast<std::size_t>(count_[0]) +
               static_cast<std::size_t>(i);
    }

    Vec<3> origin_;
    double step_ = 1, inverse_ = 1;
    Index count_{};
    std::vector<float> values_;
    std::vector<Level> levels_;
    Range all_{};
};

inline double SizeField::at(const Vec<3>& x) const {
    std::array<std::size_t, 3> up{};
    std::array<double, 3> share{};
    const float* low = values_.data();
    std::size_t stride = 1;
    for (std::size_t d = 0; d < 3; ++d) {
        const int last = count_[d] - 1;
        const double place =
            std::clamp((x.c[d] - origin_.c[d]) * inverse_, 0.0, static_cast<double>(last));
        const int node = static_cast<int>(place);
        share[d] = place - node;
        up[d] = node < last ? stride : 0;
        low += static_cast<std::size_t>(node) * stride;
        stride *= static_cast<std::size_t>(count_[d]);
    }
    const auto row = [&](const float* from) {
        const auto a = static_cast<double>(from[0]);
        return a + share[0] * (static_cast<double>(from[up[0]]) - a);
    };
    const auto layer = [&](const float* from) {
        const double a = row(from);
        return a + share[1] * (row(from + up[1]) - a);
    };
    const double a = layer(low);
    return a + share[2] * (layer(low + up[2]) - a);
}

}  // namespace vdbpack
