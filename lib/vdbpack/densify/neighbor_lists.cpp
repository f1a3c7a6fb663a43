// Which spheres are near which: the neighbor lists of the relaxation, and when they are renewed.
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/relaxation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// Gap up to which neighbors are listed, in smallest radii: such that a list lasts for about
/// kListSteps steps of the fastest sphere. A list with a gap kFarMore times too large is rebuilt.
constexpr float kLeastSkin = 0.15f, kMostSkin = 0.7f, kListSteps = 10, kFarMore = 1.6f;
/// Worst overlap above which walls are queried less often.
constexpr double kRough = 0.05;
/// Way that a sphere goes along a wall before the next query, in its radii: while overlaps are
/// large, and when they are small.
constexpr float kRoughSlide = 0.3f, kFineSlide = 0.05f;

float square(float v) {
    return v * v;
}

}  // namespace

template <int Dim>
void Relaxation<Dim>::moveHomes() {
    forAll(now_.labels.size(), [&](std::size_t i) {
        Home& home = now_.homes[i];
        const Home at = whereIs(home, now_.bodies[i]);
        float way = 0;
        for (std::size_t d = 0; d < 3; ++d) way += square(static_cast<float>(at[d] - home[d]));
        now_.vicinities[i].roam -= std::sqrt(way);
        home = at;
    });
}

template <int Dim>
void Relaxation<Dim>::sort() {
    if (ranks_) return sortOverRanks();
    moveHomes();
    if (cell_.any()) addImages();
    const std::size_t n = now_.labels.size();
    wraps_ = cells_.sort(
        now_.homes, now_.bodies.data(), smallest_, most_,
        {2 * (1 + static_cast<double>(delta_)) + 2 * static_cast<double>(listedGrow() - listGrow_),
         static_cast<double>(listedGap())});
    forAll(n, [&](std::size_t to) {
        const std::uint32_t i = cells_.order()[to];
        sorted_.take(to, now_, i);
        listedRadii_[to] = now_.bodies[i].radius;
    });
    std::swap(now_, sorted_);
    if (cell_.any()) findImages(cells_.order());
}

template <int Dim>
void Relaxation<Dim>::rebuild(bool rough) {
    walls_.setSlide(rough ? kRoughSlide : kFineSlide);
    sort();
    askWalls();
    listNeighbors();
    spent_ = 0;
    listed_ = 0;
}

template <int Dim>
void Relaxation<Dim>::renewLists(const Extremes& all, float fastest, float cap, double worst) {
    const float wanted = std::clamp(2 * kListSteps * std::sqrt(fastest), kLeastSkin * least_,
                                    std::max(kMostSkin * least_, 3 * cap));
    const bool tooLong = static_cast<float>(listed_) > kListSteps && skin_ > kFarMore * wanted;
    if (!listsExpired(all) && !tooLong) return;
    skin_ = wanted;
    rebuild(worst > kRough);
}

template <int Dim>
bool Relaxation<Dim>::listsExpired(const Extremes& all) {
    if (all.coincides && listed_ > 0) return true;
    const float most = 0.5f * skin_ * 0.999f;
    if (spent_ + all.grown <= most) return false;
    // No sphere has moved by more than the sum of the largest steps; most have moved by less.
    std::vector<float> moved(runs_.size());
    parallelFor(std::size_t(0), runs_.size(), [&](std::size_t k) {
        float way = 0;
        for (std::uint32_t i = runs_[k].first; i < runs_[k].last; ++i) {
            const Home& home = now_.homes[i];
            const Body& body = now_.bodies[i];
            const float own = square(difference(body.x, lowBits(home[0]))) +
                              square(difference(body.y, lowBits(home[1]))) +
                              square(difference(body.z, lowBits(home[2])));
            way = std::max(way, own / square(unitOf(listedRadii_[i])));
        }
        moved[k] = std::sqrt(way);
    });
    Extremes way;
    for (const float m : moved) way.moved = std::max(way.moved, m);
    spent_ = agreed(way).moved;
    return spent_ + all.grown > most;
}

template <int Dim>
void Relaxation<Dim>::listNeighbors() {
    const auto n = static_cast<std::uint32_t>(now_.labels.size());
    if (ranks_) {
        // Own slots of a run stand one after another.
        std::size_t runs = 0;
        for (std::uint32_t i = 0; i < n;) {
            std::uint32_t end = i + 1;
            if (!isNearSlot_[i]) {
                while (end < n && slots_[end] / kRun == slots_[i] / kRun) ++end;
                if (runs == runs_.size()) runs_.emplace_back();
                runs_[runs].first = i;
                runs_[runs].last = end;
                runs_[runs++].number = slots_[i];
            }
            i = end;
        }
        runs_.resize(runs);
    } else {
        runs_.resize((n + kRun - 1) / kRun);
        for (std::size_t k = 0; k < runs_.size(); ++k) {
            runs_[k].first = runs_[k].number = static_cast<std::uint32_t>(k) * kRun;
            runs_[k].last = std::min(n, runs_[k].first + kRun);
        }
    }
    parallelFor(std::size_t(0), runs_.size(), [&](std::size_t k) {
        Run& run = runs_[k];
        listRun(run);
        listPlanes(run);
    });
}

template <int Dim>
void Relaxation<Dim>::listRun(Run& run) {
    run.ids.clear();
    run.ends.clear();
    run.ranks.clear();
    run.grown = 0;
    run.coincides = false;
    Candidates around;
    for (std::uint32_t i = run.first; i < run.last;) {
        // All slots of a cell have the same candidates.
        const std::uint32_t cell = cells_.cellOf(i);
        std::uint32_t end = i + 1;
        while (end < run.last && cells_.cellOf(end) == cell) ++end;
        bool collected = false;
        for (std::uint32_t slot = i; slot < end; ++slot) {
            if (!isFixed(now_.labels[slot])) {
                if (!collected) collect(i, end, around);
                collected = true;
                run.ranks.push_back(slot);
                listSlot(run, slot, around);
            }
            run.ends.push_back(static_cast<std::uint32_t>(run.ids.size()));
        }
        i = end;
    }
    rankRun(run);
}

template <int Dim>
void Relaxation<Dim>::rankRun(Run& run) {
    // By region, radius and slot: bits of positive floats are in the order of their values.
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
    keys.reserve(run.ranks.size());
    for (const std::uint32_t slot : run.ranks) {
        const std::uint64_t region =
            regions_.empty() ? 0 : static_cast<std::uint32_t>(regions_[now_.labels[slot]]);
        keys.emplace_back(region << 32 | bitsAs<std::uint32_t>(now_.bodies[slot].radius), slot);
    }
    std::sort(keys.begin(), keys.end());
    for (std::size_t k = 0; k < keys.size(); ++k) run.ranks[k] = keys[k].second;
}

template <int Dim>
void Relaxation<Dim>::collect(std::uint32_t first, std::uint32_t last, Candidates& around) const {
    Home lo = now_.homes[first], hi = lo;
    float largest = 0;
    for (std::uint32_t i = first; i < last; ++i) {
        largest = std::max(largest, now_.bodies[i].radius);
        for (std::size_t d = 0; d < 3; ++d) {
            lo[d] = std::min(lo[d], now_.homes[i][d]);
            hi[d] = std::max(hi[d], now_.homes[i][d]);
        }
    }
    around.count = 0;
    for (const auto& level : cells_.levels()) {
        if (level.count[0] == 0) continue;
        const double reach = (static_cast<double>(largest) + static_cast<double>(level.largest)) *
                                 static_cast<double>(listedGrow()) * (1 + 1e-6) +
                             static_cast<double>(listedGap());
        cells_.forEachRow(level, lo, hi, reach, [&](std::uint32_t from, std::uint32_t to) {
            around.add(now_.bodies.data(), from, to);
        });
    }
}

template <int Dim>
void Relaxation<Dim>::listSlot(Run& run, std::uint32_t slot, Candidates& around) {
    const float grow = listedGrow(), gap = listedGap();
    const Body body = now_.bodies[slot];
    std::uint32_t* const found = around.found.data();
    std::uint32_t count = 0;
    int coinciding = 0;
    for (std::size_t j = 0; j < around.count; j += 8) {
        const Bodies8 other = around.bodies(j);
        const Float8 dx = difference(other.x, body.x);
        const Float8 dy = difference(other.y, body.y);
        const Float8 dz = difference(other.z, body.z);
        const Float8 d2 = dx * dx + dy * dy + dz * dz;
        const Float8 near = (other.radius + body.radius) * grow + gap;
        unsigned bits = bitsOf(d2 < near * near);
        if (around.count - j < 8) bits &= (1u << (around.count - j)) - 1;
        const unsigned same = bitsOf(d2 == 0) & bits;
        coinciding += __builtin_popcount(same);
        count += writeLanes(found + count, around.numbers(j), bits & ~same);
    }
    // The slot itself is one of them.
    if (coinciding > 1) partCoinciding(run, slot, around);
    // Low bits alone would list some spheres that are far away.
    if (wraps_)
        count = static_cast<std::uint32_t>(
            std::remove_if(
                found, found + count,
                [&](std::uint32_t k) { return !isNear(now_.homes[slot], now_.homes[k]); }) -
            found);
    while (count % 8 != 0) found[count++] = slot;
    run.ids.insert(run.ids.end(), found, found + count);
}

template <int Dim>
void Relaxation<Dim>::partCoinciding(Run& run, std::uint32_t slot, const Candidates& around) {
    const Body& body = now_.bodies[slot];
    for (std::size_t j = 0; j < around.count; ++j) {
        const std::uint32_t k = around.slots[j];
        const Body& met = now_.bodies[k];
        if (k == slot || met.x != body.x || met.y != body.y || met.z != body.z ||
            (wraps_ && !isNear(now_.homes[slot], now_.homes[k])))
            continue;
        part(slot, k);
        run.coincides = true;
    }
}

template <int Dim>
void Relaxation<Dim>::part(std::uint32_t slot, std::uint32_t other) {
    // Two centers at the same point define no direction: a random one is taken.
    RandomStream random(seed_ + clock_, now_.labels[slot]);
    Motion& motion = now_.motions[slot];
    const float by = 0.01f * now_.bodies[slot].radius * (slot < other ? 1.0f : -1.0f);
    motion.x += by * static_cast<float>(random.uniform() - 0.5);
    motion.y += by * static_cast<float>(random.uniform() - 0.5);
    if (Dim > 2) motion.z += by * static_cast<float>(random.uniform() - 0.5);
}

template void Relaxation<2>::sort();
template void Relaxation<2>::rebuild(bool);
template void Relaxation<2>::renewLists(const Extremes&, float, float, double);
template void Relaxation<3>::sort();
template void Relaxation<3>::rebuild(bool);
template void Relaxation<3>::renewLists(const Extremes&, float, float, double);
template void Relaxation<2>::moveHomes();
template void Relaxation<3>::moveHomes();

}  // namespace vdbpack
