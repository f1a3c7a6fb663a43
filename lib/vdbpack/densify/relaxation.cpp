#include "vdbpack/densify/relaxation.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

/// Radii are larger by this share while spheres are pushed apart: what is left of an overlap when
/// it is small beside this is none of the true radii. It costs three times as much of the density.
constexpr double kDelta = 4e-4;
/// Overlaps below this share of it are none: more than all rounding.
constexpr float kApart = 0.97f;
/// Share of an overlap that a sphere gains as velocity in a step.
constexpr float kPush = 0.3f;
/// Gap up to which neighbors are listed, in smallest radii: such that a list lasts about so many
/// steps of the fastest sphere. One that lists far more than that is made anew.
constexpr float kLeastSkin = 0.15f, kMostSkin = 0.7f, kListSteps = 10, kFarMore = 1.6f;
/// Ranks apart up to which spheres change places, and how far their radii may differ.
constexpr std::uint64_t kRanks = 20;
constexpr float kAlike = 0.1f;
/// Way that a sphere goes along a wall before it asks for it anew, in its radii: while overlaps
/// are large, and when they are small.
constexpr double kRough = 0.05;
constexpr float kRoughSlide = 0.3f, kFineSlide = 0.05f;
/// Where the worst overlap is small, and yet falls by less than this factor in half a memory, those
/// that have it change places with the least squeezed of so many smaller ones.
constexpr float kNearlyApart = 0.01f, kStays = 0.8f;
constexpr std::uint32_t kLooser = 100;

/// The whole position of a body that was at `home` when its low bits were last taken.
Home whereIs(const Home& home, const Body& body) {
    const auto moved = [](std::int64_t was, std::uint32_t is) {
        return was + static_cast<std::int32_t>(is - lowBits(was));
    };
    return {moved(home[0], body.x), moved(home[1], body.y), moved(home[2], body.z)};
}

/// As fine as that of the front, unless the largest spheres would not fit into 2^28 quanta; mm.
template <int Dim>
double quantumOf(const std::vector<Sphere<Dim>>& spheres) {
    double sum = 0, most = 0;
    for (const auto& s : spheres) {
        sum += s.radius;
        most = std::max(most, s.radius);
    }
    if (!(sum > 0)) return 1;
    const double mean = sum / static_cast<double>(spheres.size());
    return std::max(std::exp2(std::floor(std::log2(mean)) - 22),
                    std::exp2(std::ceil(std::log2(most)) - 27));
}

float square(float v) {
    return v * v;
}

}  // namespace

template <int Dim>
void Relaxation<Dim>::Slots::resize(std::size_t n) {
    bodies.resize(n + 8);  // whole eights may be read
    motions.resize(n);
    homes.resize(n);
    labels.resize(n);
    places.resize(n);
}

template <int Dim>
Relaxation<Dim>::Relaxation(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
                            std::size_t fixed, const std::vector<std::int32_t>& regions,
                            std::uint64_t seed)
    : quantum_(quantumOf(spheres)),
      given_(spheres),
      regions_(regions),
      fixed_(static_cast<std::uint32_t>(fixed)),
      seed_(seed),
      walls_(domain, quantum_) {
    const std::size_t n = spheres.size();
    if (n > 0x7fffffff)
        throw ResourceError(fmt::format("densify: {} {} are more than 2^31 - 1; pack in parts", n,
                                        Measure<Dim>::kSpheres));
    double least = std::numeric_limits<double>::infinity(), smallest = least, most = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double r = spheres[i].radius;
        most = std::max(most, r);
        smallest = std::min(smallest, r);
        if (i >= fixed) least = std::min(least, r);
    }
    if (n == 0 || fixed == n) return;
    least_ = static_cast<float>(least / quantum_);
    most_ = static_cast<float>(most / quantum_);
    smallest_ = static_cast<float>(smallest / quantum_);
    // Rounding to whole quanta must not matter.
    delta_ = static_cast<float>(std::max(kDelta, 100.0 / static_cast<double>(least_)));
    skin_ = 0.5f * least_;

    now_.resize(n);
    sorted_.resize(n);
    next_.resize(n + 8);
    listedRadii_.resize(n);
    touching_.resize(n);
    forAll(n, [&](std::size_t i) {
        Home& home = now_.homes[i];
        home = {};
        for (int d = 0; d < Dim; ++d)
            home[static_cast<std::size_t>(d)] =
                static_cast<std::int64_t>(std::nearbyint(spheres[i].center[d] / quantum_));
        now_.bodies[i] = {lowBits(home[0]), lowBits(home[1]), lowBits(home[2]),
                          static_cast<float>(spheres[i].radius / quantum_)};
        now_.motions[i] = {};
        now_.labels[i] = static_cast<std::uint32_t>(i);
        now_.places[i] = {};
        if (i < fixed) now_.places[i].roam = std::numeric_limits<float>::infinity();
    });
    ready_ = true;
    sort();
}

template <int Dim>
Relaxation<Dim>::~Relaxation() = default;

template <int Dim>
std::vector<Sphere<Dim>> Relaxation<Dim>::spheres() const {
    std::vector<Sphere<Dim>> spheres = given_;
    if (!ready_) return spheres;
    forAll(now_.labels.size(), [&](std::size_t i) {
        const std::uint32_t label = now_.labels[i];
        if (!isFixed(label))
            spheres[label].center = walls_.position(whereIs(now_.homes[i], now_.bodies[i]));
    });
    return spheres;
}

template <int Dim>
void Relaxation<Dim>::sort() {
    const std::size_t n = now_.labels.size();
    forAll(n, [&](std::size_t i) {
        Home& home = now_.homes[i];
        const Home at = whereIs(home, now_.bodies[i]);
        float way = 0;
        for (std::size_t d = 0; d < 3; ++d) way += square(static_cast<float>(at[d] - home[d]));
        now_.places[i].roam -= std::sqrt(way);
        home = at;
    });
    wraps_ = cells_.sort(now_.homes, now_.bodies.data(), smallest_, most_,
                         {2 * (1 + static_cast<double>(delta_)), static_cast<double>(skin_)});
    forAll(n, [&](std::size_t to) {
        const std::uint32_t i = cells_.order()[to];
        sorted_.bodies[to] = now_.bodies[i];
        sorted_.motions[to] = now_.motions[i];
        sorted_.homes[to] = now_.homes[i];
        sorted_.labels[to] = now_.labels[i];
        sorted_.places[to] = now_.places[i];
        listedRadii_[to] = now_.bodies[i].radius;
    });
    std::swap(now_, sorted_);
}

template <int Dim>
void Relaxation<Dim>::rebuild() {
    sort();
    askWalls();
    listNeighbors();
    spent_ = 0;
    listed_ = 0;
}

template <int Dim>
void Relaxation<Dim>::askWalls() {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, now_.labels.size(), 256),
                      [&](const tbb::blocked_range<std::size_t>& part) {
                          for (std::size_t i = part.begin(); i < part.end(); ++i)
                              if (now_.places[i].roam < 0) askWall(i);
                      });
}

template <int Dim>
void Relaxation<Dim>::askWall(std::size_t slot) {
    const Body& body = now_.bodies[slot];
    auto& place = now_.places[slot];
    const float margin = body.radius * delta_ + skin_;
    if (walls_.isDue(body, place, margin))
        walls_.ask(whereIs(now_.homes[slot], body), body, margin, place);
}

template <int Dim>
void Relaxation<Dim>::listNeighbors() {
    const auto n = static_cast<std::uint32_t>(now_.labels.size());
    runs_.resize((n + kRun - 1) / kRun);
    tbb::parallel_for(std::size_t(0), runs_.size(), [&](std::size_t k) {
        Run& run = runs_[k];
        run.first = static_cast<std::uint32_t>(k) * kRun;
        run.last = std::min(n, run.first + kRun);
        listRun(run);
        listPlanes(run);
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
                                 static_cast<double>(1 + delta_) * (1 + 1e-6) +
                             static_cast<double>(skin_);
        cells_.forEachRow(level, lo, hi, reach, [&](std::uint32_t from, std::uint32_t to) {
            around.add(now_.bodies.data(), from, to);
        });
    }
}

template <int Dim>
void Relaxation<Dim>::listSlot(Run& run, std::uint32_t slot, Candidates& around) {
    const float grow = 1 + delta_;
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
        const Float8 near = (other.radius + body.radius) * grow + skin_;
        unsigned bits = bitsOf(d2 < near * near);
        if (around.count - j < 8) bits &= (1u << (around.count - j)) - 1;
        const unsigned same = bitsOf(d2 == 0) & bits;
        coinciding += __builtin_popcount(same);
        count += writeLanes(found + count, around.numbers(j), bits & ~same);
    }
    // One's own slot is one of them, and the others are too far away where low bits tell too
    // little.
    if (coinciding > 1)
        for (std::size_t j = 0; j < around.count; ++j) {
            const std::uint32_t k = around.slots[j];
            const Body& met = now_.bodies[k];
            if (k == slot || met.x != body.x || met.y != body.y || met.z != body.z ||
                (wraps_ && !isNear(now_.homes[slot], now_.homes[k])))
                continue;
            part(slot, k);
            run.coincides = true;
        }
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
void Relaxation<Dim>::listRun(Run& run) {
    run.ids.clear();
    run.ends.clear();
    run.ranks.clear();
    run.grown = 0;
    run.coincides = false;
    Candidates around;
    for (std::uint32_t i = run.first; i < run.last;) {
        // Those of one cell look at the same others.
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
void Relaxation<Dim>::listPlanes(Run& run) {
    run.planes.clear();
    run.planeEnds.clear();
    for (std::uint32_t i = run.first; i < run.last; ++i) {
        if (const std::uint32_t wall = now_.places[i].wall; wall != WallPlanes<Dim>::kNone) {
            const Body& body = now_.bodies[i];
            for (const WallPlane& plane : walls_[wall])
                if (plane.distance(body) < body.radius * (1 + delta_) + skin_)
                    run.planes.push_back(plane);
        }
        run.planeEnds.push_back(static_cast<std::uint32_t>(run.planes.size()));
    }
}

template <int Dim>
void Relaxation<Dim>::part(std::uint32_t slot, std::uint32_t other) {
    // On the very same spot nothing says which way to go.
    RandomStream random(seed_ + clock_, now_.labels[slot]);
    Motion& motion = now_.motions[slot];
    const float by = 0.01f * now_.bodies[slot].radius * (slot < other ? 1.0f : -1.0f);
    motion.x += by * static_cast<float>(random.uniform() - 0.5);
    motion.y += by * static_cast<float>(random.uniform() - 0.5);
    if (Dim > 2) motion.z += by * static_cast<float>(random.uniform() - 0.5);
}

template <int Dim>
template <bool kSqueeze>
void Relaxation<Dim>::stepRun(Run& run, float inertia, float cap, Body* next) {
    const Body* bodies = now_.bodies.data();
    const float grow = 1 + delta_;
    const std::uint32_t* ids = run.ids.data();
    Float8 worst = {};
    float worstWall = 0, fastest = 0;
    std::uint32_t plane = 0;
    const float capSquare = cap * cap;
    for (std::uint32_t i = run.first; i < run.last; ++i) {
        const Body body = bodies[i];
        const std::uint32_t* end = run.ids.data() + run.ends[i - run.first];
        Float8 fx = {}, fy = {}, fz = {}, squeeze = {};
        Int8 touching = {};
        for (; ids != end; ids += 8) {
            const Bodies8 other = gather(bodies, ids);
            const Float8 dx = difference(other.x, body.x);
            const Float8 dy = difference(other.y, body.y);
            const Float8 dz = difference(other.z, body.z);
            const Float8 d2 = dx * dx + dy * dy + dz * dz;
            const Float8 reach = (other.radius + body.radius) * grow;
            // One fills up with oneself, at distance 0.
            const Int8 near = (d2 < reach * reach) & (d2 > 0);
            const Float8 d = squareRoot(d2);
            const Float8 push = where8(near, reach / d - 1);
            fx -= push * dx;
            fy -= push * dy;
            fz -= push * dz;
            worst = larger(worst, push);
            if constexpr (kSqueeze) {
                squeeze += push * d;
                touching -= near;
            }
        }
        float x = sum(fx), y = sum(fy), z = sum(fz);
        float squeezed = 0, contacts = 0;
        if constexpr (kSqueeze) {
            squeezed = sum(squeeze);
            contacts = sum(__builtin_convertvector(touching, Float8));
        }
        if (const std::uint32_t last = run.planeEnds[i - run.first]; plane < last) {
            const float reach = body.radius * grow;
            for (; plane < last; ++plane) {
                const WallPlane& p = run.planes[plane];
                const float away = p.distance(body);
                const float over = reach - away;
                if (!(over > 0)) continue;
                x += over * p.nx;
                y += over * p.ny;
                z += over * p.nz;
                worstWall = std::max(worstWall, p.overlap(away, reach));
                squeezed += over;
                contacts += 1;
            }
        }
        Motion& motion = now_.motions[i];
        float vx = inertia * motion.x + kPush * x;
        float vy = inertia * motion.y + kPush * y;
        float vz = inertia * motion.z + kPush * z;
        float speed = vx * vx + vy * vy + vz * vz;
        if (speed > capSquare) {
            const float slower = cap / std::sqrt(speed);
            vx *= slower, vy *= slower, vz *= slower;
            speed = capSquare;
        }
        fastest = std::max(fastest, speed);
        motion.x = vx, motion.y = vy, motion.z = vz;
        if constexpr (kSqueeze) {
            motion.squeeze = squeezed;
            touching_[i] = contacts;
        }
        const auto moved = [](std::uint32_t at, float by) {
            return at + static_cast<std::uint32_t>(static_cast<std::int32_t>(std::rint(by)));
        };
        next[i] = {moved(body.x, vx), moved(body.y, vy), moved(body.z, vz), body.radius};
    }
    run.worst = std::max(largest(worst), worstWall);
    if (run.coincides) run.worst = std::max(run.worst, 1.0f);
    run.fastest = fastest;
}

template <int Dim>
void Relaxation<Dim>::swapRun(Run& run) {
    const auto n = static_cast<std::uint32_t>(run.ranks.size());
    const std::uint64_t key = mix64(seed_ ^ mix64(clock_ * 0x9e3779b97f4a7c15ull + run.first));
    for (std::uint32_t k = 0; k + 1 < n; ++k) {
        const auto l = k + 1 + static_cast<std::uint32_t>(mix64(key + k) % kRanks);
        if (l >= n) continue;
        const std::uint32_t a = run.ranks[k], b = run.ranks[l];
        const Body &small = now_.bodies[a], &big = now_.bodies[b];
        const float more = big.radius - small.radius;
        const float pSmall = now_.motions[a].squeeze, pBig = now_.motions[b].squeeze;
        if (!(more > 0 && pBig > 0 && touching_[a] >= 0 && touching_[b] >= 0 &&
              more <= kAlike * small.radius &&
              pBig - pSmall > 0.5f * (touching_[a] + touching_[b]) * more))
            continue;
        if (!isAlike(a, b)) continue;
        exchange(run, k, l);
    }
}

template <int Dim>
void Relaxation<Dim>::exchange(Run& run, std::uint32_t k, std::uint32_t l) {
    const std::uint32_t a = run.ranks[k], b = run.ranks[l];
    Body &small = now_.bodies[a], &big = now_.bodies[b];
    const float more = big.radius - small.radius;
    std::swap(small.radius, big.radius);
    std::swap(now_.labels[a], now_.labels[b]);
    std::swap(run.ranks[k], run.ranks[l]);
    touching_[a] = touching_[b] = -1;  // once in a step: what they push has changed
    now_.places[a].roam -= more;
    run.grown = std::max(run.grown, small.radius - listedRadii_[a]);
}

template <int Dim>
float Relaxation<Dim>::worstOf(const Run& run, std::uint32_t slot) const {
    const Body& body = now_.bodies[slot];
    const float grow = 1 + delta_;
    float worst = 0;
    const std::uint32_t k = slot - run.first;
    for (std::uint32_t e = k > 0 ? run.ends[k - 1] : 0; e < run.ends[k]; ++e) {
        if (run.ids[e] == slot) continue;
        const Body& other = now_.bodies[run.ids[e]];
        const float dx = difference(other.x, body.x), dy = difference(other.y, body.y),
                    dz = difference(other.z, body.z);
        const float reach = (other.radius + body.radius) * grow;
        worst = std::max(worst, reach / std::sqrt(dx * dx + dy * dy + dz * dz) - 1);
    }
    for (std::uint32_t p = k > 0 ? run.planeEnds[k - 1] : 0; p < run.planeEnds[k]; ++p) {
        const float reach = body.radius * grow;
        worst = std::max(worst, run.planes[p].overlap(run.planes[p].distance(body), reach));
    }
    return worst;
}

template <int Dim>
void Relaxation<Dim>::loosen(float worst) {
    const float least = std::max(0.5f * worst, delta_);
    std::vector<std::vector<std::uint32_t>> stuck(runs_.size());  // ranks in each run
    tbb::parallel_for(std::size_t(0), runs_.size(), [&](std::size_t k) {
        const Run& run = runs_[k];
        if (!(run.worst > least)) return;
        for (std::uint32_t rank = 0; rank < run.ranks.size(); ++rank)
            if (worstOf(run, run.ranks[rank]) > least) stuck[k].push_back(rank);
    });
    for (std::size_t k = 0; k < runs_.size(); ++k)
        for (const std::uint32_t rank : stuck[k]) {
            Run& run = runs_[k];
            const std::uint32_t big = run.ranks[rank];
            if (touching_[big] < 0) continue;
            std::uint32_t best = rank;
            for (std::uint32_t l = rank; l-- > 0 && rank - l <= kLooser;) {
                const std::uint32_t small = run.ranks[l];
                if (touching_[small] >= 0 && isAlike(small, big) &&
                    now_.motions[small].squeeze < now_.motions[run.ranks[best]].squeeze)
                    best = l;
            }
            if (best != rank) exchange(run, best, rank);
        }
}

template <int Dim>
bool Relaxation<Dim>::mustRebuild() {
    float grown = 0;
    for (const Run& run : runs_) {
        if (run.coincides && listed_ > 0) return true;
        grown = std::max(grown, run.grown);
    }
    const float most = 0.5f * skin_ * 0.999f;
    if (spent_ + grown <= most) return false;
    // The sum of the largest steps says more than what any one sphere has moved.
    std::vector<float> moved(runs_.size());
    tbb::parallel_for(std::size_t(0), runs_.size(), [&](std::size_t k) {
        float way = 0;
        for (std::uint32_t i = runs_[k].first; i < runs_[k].last; ++i) {
            const Home& home = now_.homes[i];
            const Body& body = now_.bodies[i];
            way = std::max(way, square(difference(body.x, lowBits(home[0]))) +
                                    square(difference(body.y, lowBits(home[1]))) +
                                    square(difference(body.z, lowBits(home[2]))));
        }
        moved[k] = std::sqrt(way);
    });
    spent_ = *std::max_element(moved.begin(), moved.end());
    return spent_ + grown > most;
}

template <int Dim>
bool Relaxation<Dim>::keepsWall() {
    std::atomic<bool> keeps{true};
    const double grow = 1 + 0.03 * static_cast<double>(delta_);
    tbb::parallel_for(std::size_t(0), runs_.size(), [&](std::size_t k) {
        Run& run = runs_[k];
        bool asked = false;
        for (std::uint32_t i = run.first; i < run.last; ++i) {
            if (isFixed(now_.labels[i])) continue;
            const Body& body = now_.bodies[i];
            const Home home = whereIs(now_.homes[i], body);
            if (walls_.allows(home, body, grow)) continue;
            walls_.ask(home, body, body.radius * delta_ + skin_, now_.places[i]);
            asked = true;
        }
        if (!asked) return;
        keeps.store(false, std::memory_order_relaxed);
        listPlanes(run);
    });
    return keeps;
}

template <int Dim>
typename Relaxation<Dim>::Outcome Relaxation<Dim>::run(
    const RelaxationPace& pace, int steps, const Callbacks& callbacks,
    const std::function<bool(int, double)>& goOn) {
    Outcome outcome;
    if (!ready_) {
        outcome.apart = true;
        return outcome;
    }
    const auto inertia = static_cast<float>(pace.inertia);
    const float cap = static_cast<float>(pace.cap) * least_;
    walls_.setSlide(kRoughSlide);
    rebuild();
    const int lookEvery =
        static_cast<int>(0.5 / (1 - pace.inertia) / std::max(1, pace.swapEvery)) + 1;
    int looks = 0;
    float fastest = square(cap);  // of the last step
    float before = 1;
    for (;; ++outcome.steps) {
        if (callbacks.isCancelled()) {
            outcome.interrupted = true;
            return outcome;
        }
        const float wanted = std::clamp(2 * kListSteps * std::sqrt(fastest), kLeastSkin * least_,
                                        std::max(kMostSkin * least_, 3 * cap));
        if (mustRebuild() ||
            (static_cast<float>(listed_) > kListSteps && skin_ > kFarMore * wanted)) {
            skin_ = wanted;
            walls_.setSlide(outcome.worst > kRough ? kRoughSlide : kFineSlide);
            rebuild();
        }
        const bool exchanges =
            pace.swapEvery > 0 && clock_ % static_cast<std::uint64_t>(pace.swapEvery) == 0;
        tbb::parallel_for(std::size_t(0), runs_.size(), [&](std::size_t k) {
            if (exchanges)
                stepRun<true>(runs_[k], inertia, cap, next_.data());
            else
                stepRun<false>(runs_[k], inertia, cap, next_.data());
        });
        float worst = 0;
        fastest = 0;
        for (const Run& run : runs_) {
            worst = std::max(worst, run.worst);
            fastest = std::max(fastest, run.fastest);
        }
        outcome.worst = std::max(0.0, static_cast<double>(worst - delta_));
        // Told of where they stand now, not of where the step would take them.
        if (worst < kApart * delta_ && keepsWall()) {
            outcome.apart = true;
            return outcome;
        }
        if (outcome.steps == steps || (goOn && !goOn(outcome.steps, outcome.worst))) return outcome;
        std::swap(now_.bodies, next_);
        spent_ += std::sqrt(fastest);
        ++listed_;
        if (exchanges)
            tbb::parallel_for(std::size_t(0), runs_.size(),
                              [&](std::size_t k) { swapRun(runs_[k]); });
        if (exchanges && ++looks >= lookEvery) {
            looks = 0;
            if (worst < kNearlyApart && worst > kStays * before) {
                loosen(worst);
            }
            before = worst;
        }
        ++clock_;
    }
}

template class Relaxation<2>;
template class Relaxation<3>;

}  // namespace vdbpack
