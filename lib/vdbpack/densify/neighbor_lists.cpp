// Which spheres are near which: the neighbor lists of the relaxation, and when they are renewed.
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/relaxation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// Margins: what the fastest sphere goes in kShare steps for all, in smallest radii at least
/// kLeastMargin, and for each sphere what it goes itself in kAhead steps, up to kMostMargin. Lists
/// kFarMore times too long are made again.
constexpr float kShare = 8, kAhead = 16, kLeastMargin = 0.1f, kMostMargin = 0.7f, kFarMore = 1.6f;
/// Worst overlap above which walls are queried less often.
constexpr double kRough = 0.05;
/// Way that a sphere goes along a wall before the next query, in its radii: while overlaps are
/// large, and when they are small.
constexpr float kRoughSlide = 0.3f, kFineSlide = 0.05f;

constexpr std::uint32_t kRadiusBits = 13;

float square(float v) {
    return v * v;
}

/// Numbers 0, 1, ... by their classes (below `classes`), and within a class by themselves.
template <class ClassOf>
void sortByClass(std::vector<std::uint32_t>& numbers, std::uint32_t classes,
                 const ClassOf& classOf) {
    std::vector<std::uint32_t> of(numbers.size()), next(classes + 1);
    for (std::uint32_t k = 0; k < numbers.size(); ++k) ++next[(of[k] = classOf(k)) + 1];
    for (std::uint32_t c = 0; c < classes; ++c) next[c + 1] += next[c];
    for (std::uint32_t k = 0; k < numbers.size(); ++k) numbers[next[of[k]]++] = k;
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
        now_.listed[i] = {now_.bodies[i].x, now_.bodies[i].y, now_.bodies[i].z,
                          marginOf(static_cast<std::uint32_t>(i))};
    });
}

template <int Dim>
void Relaxation<Dim>::sort() {
    setMargins();
    if (ranks_) return sortOverRanks();
    moveHomes();
    if (cell_.any()) addImages();
    wraps_ = cells_.sort(
        now_.homes, now_.bodies.data(), smallest_, most_,
        {2 * (1 + static_cast<double>(delta_)) + 2 * static_cast<double>(listedGrow() - listGrow_),
         static_cast<double>(listedGap())});
    now_.sort([&](std::size_t to) { return cells_.order()[to]; });
    if (cell_.any()) findImages(cells_.order());
}

template <int Dim>
void Relaxation<Dim>::rebuild(bool rough) {
    toHost();
    deviceTurn_ = device_ && device_->takesNext();
    walls_.setSlide(rough ? kRoughSlide : kFineSlide);
    sort();
    askWalls();
    listNeighbors();
    listed_ = 0;
}

template <int Dim>
void Relaxation<Dim>::setMargins() {
    const float speed = std::sqrt(fastest_);
    marginBase_ = std::clamp(kShare * speed, kLeastMargin * least_, kMostMargin * least_);
    marginMost_ = std::min(kMostMargin * least_, marginBase_ + kAhead * speed);
}

template <int Dim>
float Relaxation<Dim>::marginOf(std::uint32_t slot) const {
    if (isFixed(now_.labels[slot])) return 0;
    const Body &body = now_.bodies[slot], &before = now_.before[slot];
    const float speed =
        std::sqrt(square(difference(body.x, before.x)) + square(difference(body.y, before.y)) +
                  square(difference(body.z, before.z)));
    const float unit = unitOf(body.radius);
    return std::min(unit * marginMost_, unit * marginBase_ + kAhead * speed);
}

template <int Dim>
void Relaxation<Dim>::renewLists(const Extremes& all, double worst) {
    const float wanted = std::clamp((kShare + kAhead) * std::sqrt(fastest_), kLeastMargin * least_,
                                    kMostMargin * least_);
    const bool tooLong = static_cast<float>(listed_) > kAhead && marginMost_ > kFarMore * wanted;
    if (!all.expired && !(all.coincides && listed_ > 0) && !tooLong) return;
    rebuild(worst > kRough);
}

template <int Dim>
void Relaxation<Dim>::listNeighbors() {
    const auto n = static_cast<std::uint32_t>(now_.labels.size());
    now_.bodies[n] = now_.before[n] = {0, 0, 0, -1e30f};
    if (ranks_) {
        // Own slots of a run stand one after another.
        std::size_t runs = 0;
        for (std::uint32_t i = 0; i < n;) {
            std::uint32_t end = i + 1;
            if (!isNearSlot_[i]) {
                while (end < n && slots_[end] / kSlotsOfRun == slots_[i] / kSlotsOfRun) ++end;
                if (runs == runs_.size()) runs_.emplace_back();
                runs_[runs].first = i;
                runs_[runs].last = end;
                runs_[runs++].number = slots_[i];
            }
            i = end;
        }
        runs_.resize(runs);
    } else {
        runs_.resize((n + kSlotsOfRun - 1) / kSlotsOfRun);
        for (std::size_t k = 0; k < runs_.size(); ++k) {
            runs_[k].first = runs_[k].number = static_cast<std::uint32_t>(k) * kSlotsOfRun;
            runs_[k].last = std::min(n, runs_[k].first + kSlotsOfRun);
        }
    }
    parallelFor(std::size_t(0), runs_.size(), [&](std::size_t k) {
        Run& run = runs_[k];
        listPlanes(run);
        listRun(run);
    });
}

template <int Dim>
void Relaxation<Dim>::listRun(Run& run) {
    run.ends.clear();
    run.ranks.clear();
    run.expired = false;
    run.coincides = false;
    Candidates around;
    around.listed.clear();
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
            } else {
                now_.before[slot] = now_.bodies[slot];
            }
        }
        i = end;
    }
    const std::vector<std::uint32_t> listed = run.ranks;
    rankRun(run);
    run.members.clear();
    run.wallMembers = 0;
    if (!listed.empty()) interleave(run, listed, around);
}

/// @param slots  of the lists in `lists`.
template <int Dim>
void Relaxation<Dim>::interleave(Run& run, const std::vector<std::uint32_t>& slots,
                                 const Candidates& lists) {
    const auto begin = [&](std::uint32_t k) { return k > 0 ? lists.ends[k - 1] : 0; };
    const auto hasWall = [&](std::uint32_t k) {
        const std::uint32_t s = slots[k] - run.first;
        return run.planeEnds[s] > (s > 0 ? run.planeEnds[s - 1] : 0) ||
               (!run.edgeEnds.empty() && run.edgeEnds[s] > (s > 0 ? run.edgeEnds[s - 1] : 0));
    };
    std::vector<std::uint32_t> order(slots.size());
    std::size_t walls = 0;
    std::uint32_t most = 0;
    for (std::uint32_t k = 0; k < slots.size(); ++k)
        most = std::max(most, lists.ends[k] - begin(k));
    sortByClass(order, 2 * (most + 1), [&](std::uint32_t k) {
        const bool wall = hasWall(k);
        walls += wall;
        return (wall ? 0 : most + 1) + most - (lists.ends[k] - begin(k));
    });
    order.resize(padded(order.size()), order.back());
    run.wallMembers = walls;
    run.members.resize(order.size());
    std::uint32_t end = 0;
    for (std::size_t m = 0; m < order.size(); m += 8) {
        std::uint32_t rows = 0;
        for (std::size_t l = 0; l < 8; ++l) {
            const std::uint32_t k = order[m + l];
            run.members[m + l] = slots[k];
            rows = std::max(rows, lists.ends[k] - begin(k));
        }
        run.ends.push_back(end += rows * 8);
    }
    run.ids.assign(end, nobody());
    for (std::size_t m = 0; m < order.size(); ++m) {
        const std::uint32_t k = order[m];
        std::uint32_t* to = run.ids.data() + (m < 8 ? 0 : run.ends[m / 8 - 1]) + m % 8;
        for (std::uint32_t e = begin(k); e < lists.ends[k]; ++e, to += 8) *to = lists.listed[e];
    }
}

template <int Dim>
void Relaxation<Dim>::rankRun(Run& run) {
    // By region, radius and slot: bits of positive floats are in the order of their values.
    // Classes of 0.1 % or less of the radii: bits of positive floats are in the order of their
    // values.
    const auto bits = [](float radius) { return bitsAs<std::uint32_t>(radius); };
    const std::uint32_t least = bits(smallest_) >> kRadiusBits;
    const std::vector<std::uint32_t> slots = run.ranks;
    sortByClass(run.ranks, (bits(most_) >> kRadiusBits) - least + 1, [&](std::uint32_t k) {
        return (bits(now_.bodies[slots[k]].radius) >> kRadiusBits) - least;
    });
    for (std::uint32_t& k : run.ranks) k = slots[k];
    if (regions_.empty()) return;
    std::stable_sort(run.ranks.begin(), run.ranks.end(), [&](std::uint32_t a, std::uint32_t b) {
        return regions_[now_.labels[a]] < regions_[now_.labels[b]];
    });
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
            around.add(now_.bodies.data(), now_.listed.data(), from, to);
        });
    }
}

template <int Dim>
void Relaxation<Dim>::listSlot(Run& run, std::uint32_t slot, Candidates& around) {
    const float grow = listGrow_;
    const Body body = now_.bodies[slot];
    const float gap = now_.listed[slot].radius;
    std::uint32_t* const found = around.found.data();
    std::uint32_t count = 0;
    int coinciding = 0;
    for (std::size_t j = 0; j < around.count; j += 8) {
        const Bodies8 other = around.bodies(j);
        const Float8 dx = difference(other.x, body.x);
        const Float8 dy = difference(other.y, body.y);
        const Float8 dz = difference(other.z, body.z);
        const Float8 d2 = dx * dx + dy * dy + dz * dz;
        const Float8 near = (other.radius + body.radius) * grow + (around.marginsAt(j) + gap);
        unsigned bits = bitsOf(d2 < near * near);
        if (around.count - j < 8) bits &= (1u << (around.count - j)) - 1;
        const unsigned same = bitsOf(d2 == 0) & bits;
        coinciding += __builtin_popcount(same);
        const LanePacking packed(bits & ~same);
        store(found + count, packed(around.numbers(j)));
        count += packed.count();
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
    around.listed.insert(around.listed.end(), found, found + count);
    around.ends.push_back(static_cast<std::uint32_t>(around.listed.size()));
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
    Body& before = now_.before[slot];
    const float by = 0.01f * now_.bodies[slot].radius * (slot < other ? 1.0f : -1.0f);
    for (std::uint32_t* at : {&before.x, &before.y, &before.z}) {
        if (Dim == 2 && at == &before.z) break;
        *at -= static_cast<std::uint32_t>(
            static_cast<std::int32_t>(by * static_cast<float>(random.uniform() - 0.5)));
    }
}

template void Relaxation<2>::sort();
template void Relaxation<2>::rebuild(bool);
template void Relaxation<2>::renewLists(const Extremes&, double);
template void Relaxation<2>::setMargins();
template void Relaxation<3>::sort();
template void Relaxation<3>::rebuild(bool);
template void Relaxation<3>::renewLists(const Extremes&, double);
template void Relaxation<3>::setMargins();
template void Relaxation<2>::moveHomes();
template void Relaxation<3>::moveHomes();

}  // namespace vdbpack
