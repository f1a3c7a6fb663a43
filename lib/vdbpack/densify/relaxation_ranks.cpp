// The relaxation over ranks: who has which slots, and what ranks tell one another.
//
// Slots are numbered over all ranks in the order that one rank would sort them into, and a run of
// 1024 of them stays on one rank. So each rank takes the same steps for its runs as one rank would:
// neighbors in the same order, exchanges within the same runs.
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/relaxation.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace vdbpack {

/// Layers of cells across the last axis: all slots of a layer are sorted on one rank.
template <int Dim>
struct Relaxation<Dim>::Layers {
    static constexpr std::size_t kAxis = Dim - 1;

    std::vector<std::size_t> first;        ///< layer of each level, and their number
    std::vector<std::uint64_t> firstSlot;  ///< of each layer, and the number of slots
    std::vector<int> owner;                ///< rank of each

    /// The rank that has the run of a slot: that of the layer in which the run begins.
    int ownerOf(std::uint64_t slot) const {
        const std::uint64_t begin = slot / kSlotsOfRun * kSlotsOfRun;
        const auto next = std::upper_bound(firstSlot.begin(), firstSlot.end(), begin);
        return owner[static_cast<std::size_t>(next - firstSlot.begin()) - 1];
    }
};

/// A slot on its way to another rank.
template <int Dim>
struct Relaxation<Dim>::Traveler {
    Body body, listed, before;
    Home home;
    std::uint32_t slot, label, place, hasWall;
    float roam;
    typename WallPlanes<Dim>::Wall wall;
};

template <int Dim>
typename Relaxation<Dim>::Extremes Relaxation<Dim>::agreed(const Extremes& own) const {
    Extremes all = own;
    if (!ranks_) return all;
    for (const auto& list : gathered(ranks_, std::vector<Extremes>{own})) {
        const Extremes& e = list.front();
        all.worst = std::max(all.worst, e.worst);
        all.fastest = std::max(all.fastest, e.fastest);
        all.coincides = std::max(all.coincides, e.coincides);
        all.expired = std::max(all.expired, e.expired);
        all.cancelled = std::max(all.cancelled, e.cancelled);
    }
    return all;
}

template <int Dim>
typename Relaxation<Dim>::Layers Relaxation<Dim>::layersOverRanks() const {
    Layers layers;
    std::vector<double> positions;  // of the middle of each layer, quanta
    for (const auto& level : cells_.levels()) {
        layers.first.push_back(positions.size());
        for (std::int64_t k = 0; k < level.count[Layers::kAxis]; ++k)
            positions.push_back((static_cast<double>(level.low[Layers::kAxis] + k) + 0.5) *
                                level.side);
    }
    layers.first.push_back(positions.size());
    std::vector<std::uint64_t> counts(positions.size());
    for (std::size_t i = 0; i < now_.labels.size(); ++i) {
        const std::size_t k = cells_.levelOf(now_.bodies[i].radius);
        const std::int64_t layer =
            cells_.layerAt(cells_.levels()[k], now_.homes[i][Layers::kAxis], Layers::kAxis);
        ++counts[layers.first[k] + static_cast<std::size_t>(layer)];
    }
    ranks_->sum(counts);
    layers.firstSlot.resize(counts.size() + 1);
    std::partial_sum(counts.begin(), counts.end(), layers.firstSlot.begin() + 1);
    // Equal shares along the axis, of all levels together.
    std::vector<std::size_t> order(counts.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return positions[a] < positions[b]; });
    layers.owner.resize(counts.size());
    const auto ranks = static_cast<std::uint64_t>(ranks_->count());
    const std::uint64_t total = std::max<std::uint64_t>(layers.firstSlot.back(), 1);
    std::uint64_t before = 0;
    for (const std::size_t layer : order) {
        const std::uint64_t middle = before + counts[layer] / 2;
        layers.owner[layer] = static_cast<int>(std::min(ranks - 1, middle * ranks / total));
        before += counts[layer];
    }
    return layers;
}

template <int Dim>
void Relaxation<Dim>::send(const std::vector<int>& to) {
    std::vector<std::vector<Traveler>> travelers(static_cast<std::size_t>(ranks_->count()));
    const std::size_t n = now_.labels.size();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < n; ++i) {
        auto& vicinity = now_.vicinities[i];
        if (to[i] == ranks_->rank()) {
            now_.take(kept, now_, i);
            slots_[kept++] = slots_[i];
            continue;
        }
        Traveler t{now_.bodies[i], now_.listed[i],
                   now_.before[i], now_.homes[i],
                   slots_[i],      now_.labels[i],
                   now_.places[i], 0,
                   vicinity.roam,  {}};
        if (vicinity.wall != WallPlanes<Dim>::kNone) {
            t.hasWall = 1;
            t.wall = walls_[vicinity.wall];
        }
        travelers[static_cast<std::size_t>(to[i])].push_back(t);
    }
    const auto arrived = exchanged(*ranks_, std::move(travelers));
    std::size_t all = kept;
    for (const auto& list : arrived) all += list.size();
    now_.resize(all);
    slots_.resize(all);
    for (const auto& list : arrived)
        for (const Traveler& t : list) {
            now_.bodies[kept] = t.body;
            now_.before[kept] = t.before;
            now_.homes[kept] = t.home;
            now_.listed[kept] = t.listed;
            now_.labels[kept] = t.label;
            now_.places[kept] = t.place;
            now_.vicinities[kept] = {};
            now_.vicinities[kept].roam = t.roam;
            if (t.hasWall) now_.vicinities[kept].wall = walls_.add(t.wall);
            slots_[kept++] = t.slot;
        }
}

/// Sorts the slots by keys, which are all different.
template <int Dim>
void Relaxation<Dim>::sortLocally(std::vector<std::pair<std::uint64_t, std::uint64_t>>& keys) {
    // A key, and in the low bits of the second number the slot.
    tbb::parallel_sort(keys.begin(), keys.end());
    const std::size_t n = keys.size();
    const auto from = [&](std::size_t to) { return static_cast<std::uint32_t>(keys[to].second); };
    std::vector<std::uint32_t> slots(n);
    forAll(n, [&](std::size_t to) { slots[to] = slots_[from(to)]; });
    now_.sort(from);
    slots_ = std::move(slots);
}

template <int Dim>
void Relaxation<Dim>::sortOverRanks() {
    moveHomes();
    // Those of others come later.
    std::size_t own = 0;
    for (std::size_t i = 0; i < now_.labels.size(); ++i) {
        if (isNearSlot_[i]) continue;
        now_.take(own, now_, i);
        slots_[own++] = slots_[i];
    }
    now_.resize(own);
    slots_.resize(own);
    wraps_ = cells_.lay(now_.homes, now_.bodies.data(), smallest_, most_,
                        {2 * (1 + static_cast<double>(delta_)), static_cast<double>(listedGap())},
                        ranks_);
    const Layers layers = layersOverRanks();
    const auto layerOf = [&](std::size_t i) {
        const std::size_t k = cells_.levelOf(now_.bodies[i].radius);
        return layers.first[k] +
               static_cast<std::size_t>(
                   cells_.layerAt(cells_.levels()[k], now_.homes[i][Layers::kAxis], Layers::kAxis));
    };
    std::vector<int> to(own);
    for (std::size_t i = 0; i < own; ++i) to[i] = layers.owner[layerOf(i)];
    send(to);

    // By cell, and within a cell by the numbers before.
    own = now_.labels.size();
    std::vector<std::pair<std::uint64_t, std::uint64_t>> keys(own);
    forAll(own, [&](std::size_t i) {
        const auto& level = cells_.levels()[cells_.levelOf(now_.bodies[i].radius)];
        keys[i] = {cells_.cellAt(level, now_.homes[i]), std::uint64_t{slots_[i]} << 32 | i};
    });
    sortLocally(keys);
    std::size_t layer = layers.owner.size();
    std::uint64_t next = 0;
    for (std::size_t i = 0; i < own; ++i) {
        const std::size_t here = layerOf(i);
        if (here != layer) next = layers.firstSlot[layer = here];
        slots_[i] = static_cast<std::uint32_t>(next++);
    }
    // Runs that begin in a layer of another rank go there.
    to.resize(own);
    for (std::size_t i = 0; i < own; ++i) to[i] = layers.ownerOf(slots_[i]);
    send(to);
    addNear(layers);
}

/// Layers of a level in a row, along the last axis.
template <int Dim>
struct Relaxation<Dim>::Interval {
    std::size_t level;
    double lo, hi;
};

/// Where each rank has slots.
template <int Dim>
auto Relaxation<Dim>::slotIntervals(const Layers& layers) const
    -> std::vector<std::vector<Interval>> {
    std::vector<std::vector<Interval>> intervals(static_cast<std::size_t>(ranks_->count()));
    for (std::size_t k = 0; k + 1 < layers.first.size(); ++k) {
        const auto& level = cells_.levels()[k];
        for (std::size_t l = layers.first[k]; l < layers.first[k + 1]; ++l) {
            const std::uint64_t first = layers.firstSlot[l], last = layers.firstSlot[l + 1];
            if (first == last) continue;
            const double lo = static_cast<double>(level.low[Layers::kAxis] +
                                                  static_cast<std::int64_t>(l - layers.first[k])) *
                              level.side;
            const auto add = [&](int rank) {
                auto& list = intervals[static_cast<std::size_t>(rank)];
                if (!list.empty() && list.back().level == k && list.back().hi >= lo)
                    list.back().hi = lo + level.side;
                else
                    list.push_back({k, lo, lo + level.side});
            };
            const int before = layers.ownerOf(first);
            add(before);
            if ((first / kSlotsOfRun + 1) * kSlotsOfRun < last && layers.owner[l] != before)
                add(layers.owner[l]);
        }
    }
    return intervals;
}

/// The own slots that each of the other ranks needs, since they are near its own.
template <int Dim>
std::vector<std::vector<std::uint32_t>> Relaxation<Dim>::slotsNear(const Layers& layers) const {
    const auto intervals = slotIntervals(layers);
    std::vector<std::vector<std::uint32_t>> near(intervals.size());
    const double grow = static_cast<double>(listGrow_) * (1 + 1e-6);
    const auto further = static_cast<double>(further_);
    for (std::size_t i = 0; i < now_.labels.size(); ++i) {
        const Body& body = now_.bodies[i];
        const auto& mine = cells_.levels()[cells_.levelOf(body.radius)];
        const auto at = static_cast<double>(now_.homes[i][Layers::kAxis]);
        const auto radius = static_cast<double>(body.radius);
        for (std::size_t r = 0; r < near.size(); ++r) {
            if (static_cast<int>(r) == ranks_->rank()) continue;
            const bool isNear =
                std::any_of(intervals[r].begin(), intervals[r].end(), [&](const Interval& in) {
                    const auto largest = static_cast<double>(cells_.levels()[in.level].largest);
                    double reach = (radius + largest) * grow + static_cast<double>(listedGap());
                    // Vacancies are sought among all bodies of the cells around a slot.
                    if (further > 0)
                        reach = std::max(reach, largest + 2.2 * further +
                                                    static_cast<double>(mine.largest) + mine.side);
                    return at >= in.lo - reach && at <= in.hi + reach;
                });
            if (isNear) near[r].push_back(static_cast<std::uint32_t>(i));
        }
    }
    return near;
}

template <int Dim>
void Relaxation<Dim>::addNear(const Layers& layers) {
    struct Near {
        Body body, listed;
        Home home;
        std::uint32_t slot;
    };
    const std::size_t own = now_.labels.size();
    tell_ = slotsNear(layers);
    std::vector<std::vector<Near>> toEach(tell_.size());
    for (std::size_t r = 0; r < tell_.size(); ++r)
        for (const std::uint32_t i : tell_[r])
            toEach[r].push_back({now_.bodies[i], now_.listed[i], now_.homes[i], slots_[i]});
    const auto arrived = exchanged(*ranks_, std::move(toEach));
    std::vector<std::size_t> heardFirst;  // slot behind the own ones
    std::size_t all = own;
    for (const auto& list : arrived) {
        heardFirst.push_back(all);
        all += list.size();
    }
    now_.resize(all);
    slots_.resize(all);
    for (std::size_t r = 0; r < arrived.size(); ++r) {
        std::size_t i = heardFirst[r];
        for (const Near& near : arrived[r]) {
            now_.bodies[i] = near.body;
            now_.before[i] = near.body;
            now_.homes[i] = near.home;
            now_.listed[i] = near.listed;
            now_.labels[i] = now_.places[i] = std::numeric_limits<std::uint32_t>::max();
            now_.vicinities[i] = {};
            now_.vicinities[i].roam = std::numeric_limits<float>::infinity();
            slots_[i++] = near.slot;
        }
    }
    heardFirst.push_back(all);
    const std::vector<std::uint32_t> now = sortWithNear(own);
    for (auto& list : tell_)
        for (std::uint32_t& i : list) i = now[i];
    heard_.assign(arrived.size(), {});
    for (std::size_t r = 0; r < arrived.size(); ++r)
        heard_[r].assign(now.begin() + static_cast<std::ptrdiff_t>(heardFirst[r]),
                         now.begin() + static_cast<std::ptrdiff_t>(heardFirst[r + 1]));
    now_.resize(all);
    cells_.take(now_.homes, now_.bodies.data(), Layers::kAxis);
}

/// Sorts the own slots and those behind them of other ranks. @return where each slot is by now.
template <int Dim>
std::vector<std::uint32_t> Relaxation<Dim>::sortWithNear(std::size_t own) {
    const std::size_t all = slots_.size();
    std::vector<std::pair<std::uint64_t, std::uint64_t>> keys(all);
    forAll(all, [&](std::size_t i) { keys[i] = {slots_[i], i}; });
    sortLocally(keys);
    std::vector<std::uint32_t> now(all);
    isNearSlot_.resize(all);
    for (std::size_t to = 0; to < all; ++to) {
        now[keys[to].second] = static_cast<std::uint32_t>(to);
        isNearSlot_[to] = keys[to].second >= own;
    }
    return now;
}

template <int Dim>
void Relaxation<Dim>::refreshNear() {
    if (!ranks_ && !onDevice_) refreshImages();
    if (!ranks_) return;
    std::vector<std::vector<Body>> toEach(tell_.size());
    for (std::size_t r = 0; r < tell_.size(); ++r) {
        toEach[r].reserve(tell_[r].size());
        for (const std::uint32_t i : tell_[r]) toEach[r].push_back(now_.bodies[i]);
    }
    const auto bodies = exchanged(*ranks_, std::move(toEach));
    for (std::size_t r = 0; r < bodies.size(); ++r)
        for (std::size_t k = 0; k < bodies[r].size(); ++k) now_.bodies[heard_[r][k]] = bodies[r][k];
}

template <int Dim>
std::vector<typename Relaxation<Dim>::Settled> Relaxation<Dim>::settled() const {
    std::vector<Settled> all;
    for (std::size_t i = 0; i < now_.labels.size(); ++i)
        if (!isNearSlot_[i])
            all.push_back({now_.labels[i], now_.places[i],
                           walls_.position(whereIs(now_.homes[i], now_.bodies[i]))});
    return all;
}

#define VDBPACK_INSTANTIATE(Dim)                                                                \
    template typename Relaxation<Dim>::Extremes Relaxation<Dim>::agreed(const Extremes&) const; \
    template void Relaxation<Dim>::sortOverRanks();                                             \
    template void Relaxation<Dim>::refreshNear();                                               \
    template std::vector<Relaxation<Dim>::Settled> Relaxation<Dim>::settled() const;
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
