#include "vdbpack/densify/body_cells.h"

#include "vdbpack/core/count.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"

#include <fmt/format.h>

#include <atomic>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

/// Largest ratio of the radii within a level.
constexpr double kClass = 2.2;
/// Most cells of a level: per body, and in any case.
constexpr double kCellsEach = 8, kFewCells = 1000;
/// Bodies in cells that are searched for one another differ by less than 2^30 quanta up to this
/// side.
constexpr double kSideOfNear = 1 << 28;

/// Where the bodies of a level lie.
struct Extent {
    Home lo, hi;
    std::size_t count = 0;

    Extent() {
        lo.fill(std::numeric_limits<std::int64_t>::max());
        hi.fill(std::numeric_limits<std::int64_t>::min());
    }
    void add(const Extent& other) {
        count += other.count;
        add(other.lo, other.hi);
    }
    void add(const Home& low, const Home& high) {
        for (std::size_t d = 0; d < 3; ++d) {
            lo[d] = std::min(lo[d], low[d]);
            hi[d] = std::max(hi[d], high[d]);
        }
    }
};

}  // namespace

bool BodyCells::lay(const std::vector<Home>& homes, const Body* bodies, float least, float largest,
                    Side side, Ranks* ranks) {
    const double ratio = static_cast<double>(largest) / static_cast<double>(least);
    const auto classes =
        static_cast<std::size_t>(std::max(1.0, std::ceil(std::log(ratio) / std::log(kClass))));
    const double factor = std::pow(ratio, 1 / static_cast<double>(classes)) * (1 + 1e-6);
    levels_.assign(classes, {});
    for (std::size_t k = 0; k < classes; ++k)
        levels_[k].largest =
            k + 1 == classes
                ? largest
                : static_cast<float>(static_cast<double>(least) * std::pow(factor, k + 1));
    PerThread<std::vector<Extent>> parts([&] { return std::vector<Extent>(classes); });
    parallelFor(IndexRange(0, homes.size()), [&](const IndexRange& part) {
        auto& mine = parts.local();
        for (std::size_t i = part.begin(); i < part.end(); ++i) {
            Extent& e = mine[levelOf(bodies[i].radius)];
            ++e.count;
            e.add(homes[i], homes[i]);
        }
    });
    std::vector<Extent> own(classes);
    for (const auto& part : parts)
        for (std::size_t k = 0; k < classes; ++k) own[k].add(part[k]);
    std::vector<Extent> extents(classes);
    for (const auto& ofRank : gathered(ranks, own))
        for (std::size_t k = 0; k < classes; ++k) extents[k].add(ofRank[k]);
    std::uint64_t cells = 0;
    Extent whole;
    double widest = 0;
    for (std::size_t k = 0; k < classes; ++k) {
        const Extent& all = extents[k];
        Level& level = levels_[k];
        level.firstCell = cells;
        level.count = {0, 0, 0};
        if (all.count == 0) continue;
        whole.add(all.lo, all.hi);
        level.side = side.radii * static_cast<double>(level.largest) + side.more;
        // Where bodies are sparse, most cells would be empty.
        for (;; level.side *= 1.25) {
            double total = 1;
            for (std::size_t d = 0; d < 3; ++d) {
                const auto at = [&](std::int64_t x) {
                    return static_cast<std::int64_t>(
                        std::floor(static_cast<double>(x) / level.side));
                };
                level.low[d] = at(all.lo[d]);
                level.count[d] = at(all.hi[d]) - level.low[d] + 1;
                total *= static_cast<double>(level.count[d]);
            }
            if (total <= kCellsEach * static_cast<double>(all.count) + kFewCells) break;
        }
        widest = std::max(widest, level.side);
        cells += static_cast<std::uint64_t>(level.count[0] * level.count[1] * level.count[2]);
    }
    cells_.clear();
    return widest > kSideOfNear && !isNear(whole.lo, whole.hi);
}

void BodyCells::requireFewCells(std::uint64_t cells) const {
    if (cells >= std::numeric_limits<std::uint32_t>::max())
        throw ResourceError(fmt::format(
            "densify: the spheres lie so far apart that they would need {} cells; check for "
            "spheres far from the others, and densify in parts",
            cells));
}

void BodyCells::take(const std::vector<Home>& homes, const Body* bodies, std::size_t axis) {
    const std::size_t n = homes.size();
    std::vector<std::pair<std::int64_t, std::int64_t>> layers(
        levels_.size(), {std::numeric_limits<std::int64_t>::max(), -1});
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t k = levelOf(bodies[i].radius);
        const std::int64_t layer = layerAt(levels_[k], homes[i][axis], axis);
        layers[k] = {std::min(layers[k].first, layer), std::max(layers[k].second, layer)};
    }
    std::uint64_t cells = 0;
    for (std::size_t k = 0; k < levels_.size(); ++k) {
        Level& level = levels_[k];
        level.firstCell = cells;
        if (layers[k].second < 0) {
            level.count = {0, 0, 0};
            continue;
        }
        level.low[axis] += layers[k].first;
        level.count[axis] = layers[k].second - layers[k].first + 1;
        cells += static_cast<std::uint64_t>(level.count[0] * level.count[1] * level.count[2]);
    }
    requireFewCells(cells);
    cells_.resize(n);
    order_.resize(n);
    starts_.assign(cells + 1, 0);
    for (std::size_t i = 0; i < n; ++i) {
        const std::uint64_t cell = cellAt(levels_[levelOf(bodies[i].radius)], homes[i]);
        cells_[i] = static_cast<std::uint32_t>(cell);
        order_[i] = static_cast<std::uint32_t>(i);
        ++starts_[cell + 1];
    }
    for (std::size_t c = 0; c < cells; ++c) starts_[c + 1] += starts_[c];
}

bool BodyCells::sort(const std::vector<Home>& homes, const Body* bodies, float least, float largest,
                     Side side) {
    const std::size_t n = homes.size();
    const bool wraps = lay(homes, bodies, least, largest, side, nullptr);
    std::uint64_t cells = 0;
    for (const Level& level : levels_)
        cells += static_cast<std::uint64_t>(level.count[0] * level.count[1] * level.count[2]);
    requireFewCells(cells);
    starts_.resize(cells + 1);
    cells_.resize(n);
    order_.resize(n);
    std::vector<std::atomic<std::uint32_t>> fill(cells);
    forAll(n, [&](std::size_t i) {
        cells_[i] =
            static_cast<std::uint32_t>(cellAt(levels_[levelOf(bodies[i].radius)], homes[i]));
        fill[cells_[i]].fetch_add(1, std::memory_order_relaxed);
    });
    firstPositions(fill, starts_, "spheres", "densify fewer spheres");
    forAll(n, [&](std::size_t i) {
        order_[fill[cells_[i]].fetch_add(1, std::memory_order_relaxed)] =
            static_cast<std::uint32_t>(i);
    });
    // The order within a cell does not depend on which thread was first.
    forAll(cells, [&](std::size_t c) {
        if (starts_[c + 1] - starts_[c] > 1)
            std::sort(order_.begin() + starts_[c], order_.begin() + starts_[c + 1]);
    });
    return wraps;
}

}  // namespace vdbpack
