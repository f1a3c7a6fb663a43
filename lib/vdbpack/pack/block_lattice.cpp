#include "vdbpack/pack/block_lattice.h"

#include "vdbpack/core/error.h"
#include "vdbpack/pack/front/block_spheres.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace vdbpack {

template <int Dim>
BlockLattice<Dim>::BlockLattice(const Box<Dim>& bounds, double side, double lag, double quantum,
                                const PeriodicCell<Dim>& cell)
    : wraps_(cell.wraps) {
    lag_ = std::ceil(lag / quantum) * quantum;
    double total = 1;
    for (int d = 0; d < Dim; ++d) {
        lo_[d] = std::floor(bounds.lo[d] / quantum) * quantum;
        if (cell.isAlong(d)) {  // all centers lie in the cell
            lo_[d] = std::ceil(bounds.lo[d] / quantum) * quantum;
            hi_[d] = std::floor(bounds.hi[d] / quantum) * quantum;
        }
        const double extent = bounds.hi[d] - lo_[d];
        // Up to half as long again as wanted: a short block costs more than it saves.
        const double blocks = std::max(cell.isAlong(d) ? 2.0 : 1.0, std::ceil(extent / side - 0.5));
        total *= blocks;
        if (!(total < 5e7))
            throw ResourceError(fmt::format(
                "the domain would need more than {:.2g} blocks of {:.3g} mm; give larger "
                "radii or clip the domain",
                5e7, side));
        side_[d] = std::ceil(extent / blocks / quantum) * quantum;
        count_[static_cast<std::size_t>(d)] = static_cast<int>(blocks);
    }
    // Weight 1 to the axis with most blocks.
    auto& axes = axes_;
    std::iota(axes.begin(), axes.end(), std::size_t{0});
    std::stable_sort(axes.begin(), axes.end(),
                     [&](std::size_t a, std::size_t b) { return count_[a] > count_[b]; });
    for (std::size_t k = 0; k < Dim; ++k) weight_[axes[k]] = 1 << k;
    order_.resize(static_cast<std::size_t>(total));
    orderBlocks();
    findChain();
}

template <int Dim>
void BlockLattice<Dim>::orderBlocks() {
    std::iota(order_.begin(), order_.end(), 0u);
    std::vector<int> ranks(order_.size());
    for (const std::uint32_t b : order_) ranks[b] = rank(indexOf(b));
    std::stable_sort(order_.begin(), order_.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return ranks[a] < ranks[b]; });
    place_.resize(order_.size());
    for (std::uint32_t k = 0; k < order_.size(); ++k) place_[order_[k]] = k;
}

template <int Dim>
std::vector<std::uint32_t> BlockLattice<Dim>::poolDonors(const std::vector<double>& share) const {
    std::vector<std::uint32_t> donors(size(), kNone);
    std::vector<bool> given(size());
    for (const bool turn : {true, false})
        for (const std::uint32_t b : order_) {
            if ((share[b] > 0) != turn) continue;
            std::uint32_t& donor = donors[b];
            // The earliest has fewest others left to hand its pool to.
            for (const Neighbor& n : lowerNeighbors(b))
                if (share[n.block] > 0 && !given[n.block] &&
                    (donor == kNone || place_[n.block] < place_[donor]))
                    donor = n.block;
            if (donor != kNone) given[donor] = true;
        }
    return donors;
}

template <int Dim>
void BlockLattice<Dim>::findChain() {
    chain_ = 1;
    for (std::size_t k = 0; k < Dim; ++k)
        chain_ += static_cast<std::size_t>(count_[axes_[k]] - 1) << k;
    if (std::none_of(wraps_.begin(), wraps_.end(), [](bool w) { return w; })) return;
    std::vector<std::size_t> chains(order_.size(), 1);  // up to each block
    for (const std::uint32_t b : order_) {
        for (const Neighbor& n : lowerNeighbors(b))
            chains[b] = std::max(chains[b], chains[n.block] + 1);
        chain_ = std::max(chain_, chains[b]);
    }
}

template <int Dim>
typename BlockLattice<Dim>::Index BlockLattice<Dim>::indexOf(std::uint32_t b) const {
    Index i;
    std::size_t rest = b;
    for (std::size_t d = 0; d < Dim; ++d) {
        i[d] = static_cast<int>(rest % static_cast<std::size_t>(count_[d]));
        rest /= static_cast<std::size_t>(count_[d]);
    }
    return i;
}

template <int Dim>
std::uint32_t BlockLattice<Dim>::blockAt(const Index& i) const {
    std::size_t b = 0;
    for (std::size_t d = Dim; d-- > 0;) {
        if (i[d] < 0 || i[d] >= count_[d]) return kNone;
        b = b * static_cast<std::size_t>(count_[d]) + static_cast<std::size_t>(i[d]);
    }
    return static_cast<std::uint32_t>(b);
}

template <int Dim>
int BlockLattice<Dim>::rank(const Index& i) const {
    int r = 0;
    for (std::size_t d = 0; d < Dim; ++d) r += weight_[d] * i[d];
    return r;
}

template <int Dim>
Box<Dim> BlockLattice<Dim>::own(std::uint32_t b) const {
    const Index i = indexOf(b);
    Box<Dim> box;
    for (int d = 0; d < Dim; ++d) {
        box.lo[d] = lo_[d] + side_[d] * i[static_cast<std::size_t>(d)];
        box.hi[d] = std::min(box.lo[d] + side_[d], hi_[d]);
    }
    return box;
}

template <int Dim>
Box<Dim> BlockLattice<Dim>::search(std::uint32_t b) const {
    const Index i = indexOf(b);
    Box<Dim> box = own(b);
    for (int d = 0; d < Dim; ++d) {
        const auto at = static_cast<std::size_t>(d);
        if (i[at] > 0) box.lo[d] -= lag_;
        if (i[at] + 1 < count_[at]) box.hi[d] -= lag_;
    }
    return box;
}

template <int Dim>
std::vector<std::uint32_t> BlockLattice<Dim>::blocksIn(const Box<Dim>& box) const {
    Index from{}, to{};
    for (int d = 0; d < Dim; ++d) {
        const auto at = static_cast<std::size_t>(d);
        const double last = count_[at] - 1;
        // A search lags behind its block.
        const double lo = (box.lo[d] - lo_[d]) / side_[d];
        const double hi = (box.hi[d] + lag_ - lo_[d]) / side_[d];
        if (!(hi >= 0 && lo <= last + 1)) return {};
        from[at] = static_cast<int>(std::clamp(std::floor(lo), 0.0, last));
        to[at] = static_cast<int>(std::clamp(std::floor(hi), 0.0, last));
    }
    std::vector<std::uint32_t> blocks;
    for (Index i = from;;) {
        blocks.push_back(blockAt(i));
        std::size_t d = 0;
        while (d < Dim && ++i[d] > to[d]) i[d] = from[d], ++d;
        if (d == Dim) return blocks;
    }
}

template <int Dim>
template <class Visit>
void BlockLattice<Dim>::forEachNeighbor(std::uint32_t b, const Visit& visit) const {
    const Index i = indexOf(b);
    const int neighbors = Dim == 3 ? 27 : 9;
    for (int n = 0; n < neighbors; ++n) {
        Index j = i;
        Neighbor found{};
        int rest = n;
        for (std::size_t d = 0; d < Dim; ++d, rest /= 3) {
            found.offset[d] = 1 - rest % 3;
            j[d] -= found.offset[d];
            if (!wraps_[d]) continue;
            found.laps[d] = j[d] < 0 ? -1 : j[d] >= count_[d] ? 1 : 0;
            j[d] -= found.laps[d] * count_[d];
        }
        found.block = blockAt(j);
        if (found.block != kNone && found.block != b) visit(found);
    }
}

template <int Dim>
std::vector<typename BlockLattice<Dim>::Neighbor> BlockLattice<Dim>::lowerNeighbors(
    std::uint32_t b) const {
    std::vector<Neighbor> lower;
    forEachNeighbor(b, [&](const Neighbor& n) {
        if (place_[n.block] < place_[b]) lower.push_back(n);
    });
    return lower;
}

template <int Dim>
std::uint32_t BlockLattice<Dim>::laterBehind(std::uint32_t b) const {
    std::uint32_t bits = 0;
    forEachNeighbor(b, [&](const Neighbor& n) {
        std::array<int, Dim> seen = n.offset;  // from `b`
        for (int& o : seen) o = -o;
        const bool behind = std::all_of(seen.begin(), seen.end(), [](int o) { return o <= 0; });
        if (behind && place_[n.block] > place_[b]) bits |= neighborBit(seen);
    });
    return bits;
}

template <int Dim>
int BlockLattice<Dim>::owner(std::uint32_t b, int ranks) const {
    const Index i = indexOf(b);
    if constexpr (Dim == 2) {
        return i[axes_[1]] % ranks;
    } else {
        // The factors of `ranks` that leave fewest without a row, the nearest to a square.
        int across = 1, used = 0;
        for (int k = 1; k * k <= ranks; ++k) {
            if (ranks % k != 0) continue;
            const int rows = std::min(ranks / k, count_[axes_[1]]) * std::min(k, count_[axes_[2]]);
            if (rows < used) continue;
            used = rows;
            across = k;
        }
        const int along = ranks / across;
        return i[axes_[1]] % along + along * (i[axes_[2]] % across);
    }
}

template class BlockLattice<2>;
template class BlockLattice<3>;

}  // namespace vdbpack
