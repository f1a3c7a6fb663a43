#include "vdbpack/pack/size_field.h"

#include "vdbpack/core/lanes.h"
#include "vdbpack/core/parallel.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {
/// Ratio of values that are nearly the same.
constexpr double kNearly = 1.03;
}  // namespace

SizeField::SizeField(const Box<3>& bounds, const Vec<3>& node, double step,
                     const std::function<double(const Vec<3>&)>& value, double mostNodes)
    : step_(step) {
    double nodes = 0;
    for (;; step_ *= 1.1) {
        nodes = 1;
        for (int d = 0; d < 3; ++d) {
            const auto at = static_cast<std::size_t>(d);
            count_[at] = 1;
            origin_[d] = bounds.lo[d];
            if (bounds.hi[d] > bounds.lo[d]) {
                const double first = std::floor((bounds.lo[d] - node[d]) / step_);
                origin_[d] = node[d] + first * step_;
                const double steps = std::ceil((bounds.hi[d] - origin_[d]) / step_ - 1e-9);
                nodes *= steps + 1;
                if (!(nodes <= mostNodes)) break;
                count_[at] = static_cast<int>(steps) + 1;
            }
        }
        if (nodes <= mostNodes) break;
    }
    inverse_ = 1 / step_;
    const auto all = static_cast<std::size_t>(nodes);
    values_.resize(all + kLanes);  // whole eights may be read
    parallelFor(0, count_[1] * count_[2], [&](int row) {
        const int j = row % count_[1], k = row / count_[1];
        for (int i = 0; i < count_[0]; ++i)
            values_[indexOf(i, j, k)] =
                static_cast<float>(value(origin_ + Vec<3>{{i * step_, j * step_, k * step_}}));
    });
    const auto [least, most] =
        std::minmax_element(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(all));
    all_ = {static_cast<double>(*least), static_cast<double>(*most)};
    addLevels();
}

void SizeField::addLevels() {
    Level first;
    first.cell = kFirst;
    std::size_t total = 1;
    for (std::size_t d = 0; d < 3; ++d) {
        first.count[d] = std::max(1, (count_[d] - 1 + kFirst - 1) / kFirst);
        total *= static_cast<std::size_t>(first.count[d]);
    }
    first.bounds.resize(total);
    parallelFor(std::size_t{0}, total, [&](std::size_t c) {
        Index from, to;
        std::size_t rest = c;
        for (std::size_t d = 0; d < 3; ++d) {
            const auto n = static_cast<std::size_t>(first.count[d]);
            from[d] = static_cast<int>(rest % n) * kFirst;
            to[d] = std::min(count_[d] - 1, from[d] + kFirst);
            rest /= n;
        }
        auto& [low, high] = first.bounds[c];
        low = high = values_[indexOf(from[0], from[1], from[2])];
        for (int k = from[2]; k <= to[2]; ++k)
            for (int j = from[1]; j <= to[1]; ++j)
                for (int i = from[0]; i <= to[0]; ++i) {
                    const float v = values_[indexOf(i, j, k)];
                    low = std::min(low, v);
                    high = std::max(high, v);
                }
    });
    levels_.push_back(std::move(first));
    while (*std::max_element(levels_.back().count.begin(), levels_.back().count.end()) > 1)
        levels_.push_back(coarser(levels_.back()));
}

SizeField::Level SizeField::coarser(const Level& fine) const {
    Level level;
    level.cell = 2 * fine.cell;
    std::size_t total = 1;
    for (std::size_t d = 0; d < 3; ++d) {
        level.count[d] = (fine.count[d] + 1) / 2;
        total *= static_cast<std::size_t>(level.count[d]);
    }
    level.bounds.assign(total, {static_cast<float>(all_.most), static_cast<float>(all_.least)});
    std::size_t at = 0;
    for (int k = 0; k < fine.count[2]; ++k)
        for (int j = 0; j < fine.count[1]; ++j)
            for (int i = 0; i < fine.count[0]; ++i, ++at) {
                auto& [low, high] = level.bounds[static_cast<std::size_t>(
                    ((k / 2) * level.count[1] + j / 2) * level.count[0] + i / 2)];
                low = std::min(low, fine.bounds[at].first);
                high = std::max(high, fine.bounds[at].second);
            }
    return level;
}

SizeField::Range SizeField::withinCells(const Level& level, const Index& from,
                                        const Index& to) const {
    Index first, last;
    for (std::size_t d = 0; d < 3; ++d) {
        first[d] = std::min(from[d] / level.cell, level.count[d] - 1);
        last[d] = std::clamp((to[d] - 1) / level.cell, first[d], level.count[d] - 1);
    }
    auto low = static_cast<float>(all_.most), high = static_cast<float>(all_.least);
    for (int k = first[2]; k <= last[2]; ++k)
        for (int j = first[1]; j <= last[1]; ++j)
            for (int i = first[0]; i <= last[0]; ++i) {
                const auto& [a, b] = level.bounds[static_cast<std::size_t>(
                    (k * level.count[1] + j) * level.count[0] + i)];
                low = std::min(low, a);
                high = std::max(high, b);
            }
    return {static_cast<double>(low), static_cast<double>(high)};
}

SizeField::Range SizeField::within(const Box<3>& box) const {
    constexpr int kFewNodes = 6;
    Index from, to;
    int longest = 0;
    for (std::size_t d = 0; d < 3; ++d) {
        const double most = count_[d] - 1;
        const double lo = (box.lo.c[d] - origin_.c[d]) * inverse_;
        const double hi = (box.hi.c[d] - origin_.c[d]) * inverse_;
        from[d] = static_cast<int>(std::clamp(lo, 0.0, most));
        to[d] = static_cast<int>(std::clamp(hi + 1, 0.0, most));
        longest = std::max(longest, to[d] - from[d]);
    }
    // A few cells are enough where all values are nearly the same.
    std::size_t l = 0;
    while (l + 1 < levels_.size() && levels_[l].cell < longest) ++l;
    const Range few = withinCells(levels_[l], from, to);
    if (few.most <= kNearly * few.least) return few;
    if (longest >= kFewNodes) {
        while (l > 0 && levels_[l - 1].cell * kFewNodes > longest) --l;
        return withinCells(levels_[l], from, to);
    }
    static_assert(kFewNodes < static_cast<int>(kLanes));
    Float8 low = everyLane(static_cast<float>(all_.most)),
           high = everyLane(static_cast<float>(all_.least));
    const Int8 used = Int8{0, 1, 2, 3, 4, 5, 6, 7} <= to[0] - from[0];
    for (int k = from[2]; k <= to[2]; ++k)
        for (int j = from[1]; j <= to[1]; ++j) {
            const Float8 row = load(&values_[indexOf(from[0], j, k)]);
            low = smaller(low, choose(used, row, low));
            high = larger(high, choose(used, row, high));
        }
    return {static_cast<double>(smallest(low)), static_cast<double>(largest(high))};
}

bool SizeField::isConstant(const Box<3>& box) const {
    Index from, to;
    for (std::size_t d = 0; d < 3; ++d) {
        const double most = count_[d] - 1;
        from[d] = static_cast<int>(std::clamp((box.lo.c[d] - origin_.c[d]) * inverse_, 0.0, most));
        to[d] =
            static_cast<int>(std::clamp((box.hi.c[d] - origin_.c[d]) * inverse_ + 1, 0.0, most));
    }
    const float first = values_[indexOf(from[0], from[1], from[2])];
    for (int k = from[2]; k <= to[2]; ++k)
        for (int j = from[1]; j <= to[1]; ++j) {
            const float* const row = &values_[indexOf(0, j, k)];
            for (int i = from[0]; i <= to[0]; ++i)
                if (row[i] != first) return false;
        }
    return true;
}

}  // namespace vdbpack
