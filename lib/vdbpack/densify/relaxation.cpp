#include "vdbpack/densify/relaxation.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
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
/// Gap up to which neighbors are listed, in smallest radii: adapted so that a list lasts a while.
constexpr float kLeastSkin = 0.2f, kMostSkin = 0.7f;
constexpr int kShortList = 6, kLongList = 15;  // steps
/// Ranks apart up to which spheres change places, and how far their radii may differ.
constexpr std::uint64_t kRanks = 20;
constexpr float kAlike = 0.1f;
/// Way that a sphere goes along a wall before it asks for it anew, in its radii.
constexpr float kSlide = 0.1f;
/// Radii of one class of cells span this factor at most.
constexpr double kClass = 2.2;

constexpr std::size_t kGrain = 4096;

template <class Work>
void forAll(std::size_t n, const Work& work) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, kGrain),
                      [&](const tbb::blocked_range<std::size_t>& part) {
                          for (std::size_t i = part.begin(); i < part.end(); ++i) work(i);
                      });
}

/// The whole position of a body that was at `home` when its low bits were last taken.
std::array<std::int64_t, 3> whereIs(const std::array<std::int64_t, 3>& home, const Body& body) {
    const auto moved = [](std::int64_t was, std::uint32_t is) {
        return was + static_cast<std::int32_t>(
                         is - static_cast<std::uint32_t>(static_cast<std::uint64_t>(was)));
    };
    return {moved(home[0], body.x), moved(home[1], body.y), moved(home[2], body.z)};
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
    walls.resize(n);
    roams.resize(n);
}

template <int Dim>
Relaxation<Dim>::Relaxation(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
                            std::size_t fixed, const std::vector<std::uint8_t>& kinds,
                            std::uint64_t seed)
    : domain_(domain),
      given_(spheres),
      kinds_(kinds),
      fixed_(static_cast<std::uint32_t>(fixed)),
      seed_(seed) {
    const std::size_t n = spheres.size();
    if (n > 0x7fffffff)
        throw ResourceError(fmt::format("densify: {} {} are more than 2^31 - 1; pack in parts", n,
                                        Measure<Dim>::kSpheres));
    double sum = 0, least = std::numeric_limits<double>::infinity(), smallest = least, most = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double r = spheres[i].radius;
        sum += r;
        most = std::max(most, r);
        smallest = std::min(smallest, r);
        if (i >= fixed) least = std::min(least, r);
    }
    if (n == 0 || fixed == n) return;
    const double mean = sum / static_cast<double>(n);
    // As fine as that of the front, unless the largest spheres would not fit into 2^28 quanta.
    quantum_ = std::max(std::exp2(std::floor(std::log2(mean)) - 22),
                        std::exp2(std::ceil(std::log2(most)) - 27));
    least_ = static_cast<float>(least / quantum_);
    most_ = static_cast<float>(most / quantum_);
    smallest_ = static_cast<float>(smallest / quantum_);
    // Rounding to whole quanta must not matter.
    delta_ = static_cast<float>(std::max(kDelta, 100.0 / static_cast<double>(least_)));
    skin_ = 0.5f * least_;
    fieldError_ = domain.facts().voxelSize / quantum_;
    fieldDepth_ = domain.fieldDepth() / quantum_;

    now_.resize(n);
    sorted_.resize(n);
    next_.resize(n + 8);
    listedRadii_.resize(n);
    touching_.resize(n);
    cells_.resize(n);
    from_.resize(n);
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
        now_.walls[i] = kNone;
        now_.roams[i] = i < fixed ? std::numeric_limits<float>::infinity() : -1;
    });
    ready_ = true;
    rebuild();
}

template <int Dim>
Relaxation<Dim>::~Relaxation() = default;

template <int Dim>
DomainSampler<Dim>& Relaxation<Dim>::sampler() {
    auto& mine = samplers_.local();
    if (!mine) mine = domain_.sampler();
    return *mine;
}

template <int Dim>
Vec<Dim> Relaxation<Dim>::position(const Home& home) const {
    Vec<Dim> x;
    for (int d = 0; d < Dim; ++d)
        x[d] = static_cast<double>(home[static_cast<std::size_t>(d)]) * quantum_;
    return x;
}

template <int Dim>
std::vector<Sphere<Dim>> Relaxation<Dim>::spheres() const {
    std::vector<Sphere<Dim>> spheres = given_;
    if (!ready_) return spheres;
    forAll(now_.labels.size(), [&](std::size_t i) {
        const std::uint32_t label = now_.labels[i];
        if (!isFixed(label))
            spheres[label].center = position(whereIs(now_.homes[i], now_.bodies[i]));
    });
    return spheres;
}

template <int Dim>
void Relaxation<Dim>::layLevels() {
    struct Extent {
        Home lo, hi;
        float most = 0;
        std::size_t count = 0;
        Extent() {
            lo.fill(std::numeric_limits<std::int64_t>::max());
            hi.fill(std::numeric_limits<std::int64_t>::min());
        }
    };
    const std::size_t n = now_.labels.size();
    const double ratio = static_cast<double>(most_) / static_cast<double>(smallest_);
    const auto classes =
        static_cast<std::size_t>(std::max(1.0, std::ceil(std::log(ratio) / std::log(kClass))));
    const double factor = std::pow(ratio, 1 / static_cast<double>(classes)) * (1 + 1e-6);
    levels_.assign(classes, {});
    for (std::size_t k = 0; k < classes; ++k)
        levels_[k].largest =
            k + 1 == classes
                ? most_
                : static_cast<float>(static_cast<double>(smallest_) * std::pow(factor, k + 1));
    tbb::enumerable_thread_specific<std::vector<Extent>> parts(classes);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, kGrain),
                      [&](const tbb::blocked_range<std::size_t>& part) {
                          auto& mine = parts.local();
                          for (std::size_t i = part.begin(); i < part.end(); ++i) {
                              std::size_t k = 0;
                              while (now_.bodies[i].radius > levels_[k].largest) ++k;
                              Extent& e = mine[k];
                              ++e.count;
                              for (std::size_t d = 0; d < 3; ++d) {
                                  e.lo[d] = std::min(e.lo[d], now_.homes[i][d]);
                                  e.hi[d] = std::max(e.hi[d], now_.homes[i][d]);
                              }
                          }
                      });
    std::size_t cells = 0;
    Extent whole;
    for (std::size_t k = 0; k < classes; ++k) {
        Extent all;
        for (const auto& part : parts) {
            all.count += part[k].count;
            for (std::size_t d = 0; d < 3; ++d) {
                all.lo[d] = std::min(all.lo[d], part[k].lo[d]);
                all.hi[d] = std::max(all.hi[d], part[k].hi[d]);
            }
        }
        Level& level = levels_[k];
        level.firstCell = cells;
        level.count = {0, 0, 0};
        if (all.count == 0) continue;
        for (std::size_t d = 0; d < 3; ++d) {
            whole.lo[d] = std::min(whole.lo[d], all.lo[d]);
            whole.hi[d] = std::max(whole.hi[d], all.hi[d]);
        }
        level.side = 2.0 * static_cast<double>(level.largest) * (1 + static_cast<double>(delta_)) +
                     static_cast<double>(skin_);
        // Where spheres are far between, cells that stay empty would be all there is.
        for (;; level.side *= 1.25) {
            double total = 1;
            for (std::size_t d = 0; d < 3; ++d) {
                level.low[d] = static_cast<std::int64_t>(
                    std::floor(static_cast<double>(all.lo[d]) / level.side));
                level.count[d] = static_cast<std::int64_t>(
                                     std::floor(static_cast<double>(all.hi[d]) / level.side)) -
                                 level.low[d] + 1;
                total *= static_cast<double>(level.count[d]);
            }
            if (total <= 8 * static_cast<double>(all.count) + 1000) break;
        }
        cells += static_cast<std::size_t>(level.count[0] * level.count[1] * level.count[2]);
    }
    wraps_ = !isNear(whole.lo, whole.hi);
    if (cells >= kNone)
        throw ResourceError("densify: the spheres lie too far apart for their size");
    starts_.resize(cells + 1);
}

template <int Dim>
std::size_t Relaxation<Dim>::cellOf(const Level& level, const Home& home) const {
    std::int64_t cell = 0;
    for (std::size_t d = 3; d-- > 0;)
        cell = cell * level.count[d] +
               static_cast<std::int64_t>(std::floor(static_cast<double>(home[d]) / level.side)) -
               level.low[d];
    return level.firstCell + static_cast<std::size_t>(cell);
}

template <int Dim>
void Relaxation<Dim>::sortIntoCells() {
    const std::size_t n = now_.labels.size(), cells = starts_.size() - 1;
    std::vector<std::atomic<std::uint32_t>> fill(cells);
    forAll(n, [&](std::size_t i) {
        std::size_t k = 0;
        while (now_.bodies[i].radius > levels_[k].largest) ++k;
        cells_[i] = static_cast<std::uint32_t>(cellOf(levels_[k], now_.homes[i]));
        fill[cells_[i]].fetch_add(1, std::memory_order_relaxed);
    });
    std::uint32_t sum = 0;
    for (std::size_t c = 0; c < cells; ++c) {
        starts_[c] = sum;
        sum += fill[c].load(std::memory_order_relaxed);
        fill[c].store(starts_[c], std::memory_order_relaxed);
    }
    starts_[cells] = sum;
    forAll(n, [&](std::size_t i) {
        from_[fill[cells_[i]].fetch_add(1, std::memory_order_relaxed)] =
            static_cast<std::uint32_t>(i);
    });
    // The order within a cell does not depend on which thread was first.
    forAll(cells, [&](std::size_t c) {
        if (starts_[c + 1] - starts_[c] > 1)
            std::sort(from_.begin() + starts_[c], from_.begin() + starts_[c + 1]);
    });
    forAll(n, [&](std::size_t to) {
        const std::uint32_t i = from_[to];
        sorted_.bodies[to] = now_.bodies[i];
        sorted_.motions[to] = now_.motions[i];
        sorted_.homes[to] = now_.homes[i];
        sorted_.labels[to] = now_.labels[i];
        sorted_.walls[to] = now_.walls[i];
        sorted_.roams[to] = now_.roams[i];
        listedRadii_[to] = now_.bodies[i].radius;
    });
    std::swap(now_, sorted_);
}

template <int Dim>
void Relaxation<Dim>::rebuild() {
    const std::size_t n = now_.labels.size();
    forAll(n, [&](std::size_t i) {
        Home& home = now_.homes[i];
        const Home at = whereIs(home, now_.bodies[i]);
        float way = 0;
        for (std::size_t d = 0; d < 3; ++d) way += square(static_cast<float>(at[d] - home[d]));
        now_.roams[i] -= std::sqrt(way);
        home = at;
    });
    layLevels();
    sortIntoCells();
    askWalls();
    listNeighbors();
    spent_ = 0;
    listed_ = 0;
}

template <int Dim>
void Relaxation<Dim>::askWalls() {
    const std::size_t n = now_.labels.size();
    const auto isDue = [&](std::size_t i) { return now_.roams[i] < 0 && !isFixed(now_.labels[i]); };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, 256),
                      [&](const tbb::blocked_range<std::size_t>& part) {
                          DomainSampler<Dim>& sampler = this->sampler();
                          for (std::size_t i = part.begin(); i < part.end(); ++i)
                              if (isDue(i)) askWall(i, sampler);
                      });
}

template <int Dim>
void Relaxation<Dim>::askWall(std::size_t slot, DomainSampler<Dim>& sampler) {
    const Body& body = now_.bodies[slot];
    const Home home = whereIs(now_.homes[slot], body);
    const Vec<Dim> x = position(home);
    const double radius = static_cast<double>(body.radius);
    const double need = radius * (1 + static_cast<double>(delta_)) + static_cast<double>(skin_);
    const double slide = static_cast<double>(kSlide) * radius;
    const double inside = -sampler.signedDistance(x) / quantum_;
    const double least = std::min(inside, fieldDepth_) - fieldError_;
    std::uint32_t& index = now_.walls[slot];
    WallPoint<Dim> found;
    if (least > need + slide || !sampler.nearestWall(x, (need + 3 * slide) * quantum_, found)) {
        now_.roams[slot] = static_cast<float>(std::max(least - need, slide));
        // Nothing is near any more, but if the center left the domain altogether.
        if (inside > -fieldError_ && index != kNone) walls_[index].count = 0;
        return;
    }
    const double distance = found.distance / quantum_;
    now_.roams[slot] = static_cast<float>(std::max(distance - need, slide));
    if (index == kNone)
        index = static_cast<std::uint32_t>(walls_.push_back(Wall{}) - walls_.begin());
    Wall& wall = walls_[index];
    Vec<Dim> normal = normalized(x - found.point);
    if (inside < 2 * fieldError_ && !sampler.contains(x)) normal *= -1;
    Plane plane;
    plane.nx = static_cast<float>(normal[0]);
    plane.ny = static_cast<float>(normal[1]);
    std::array<std::uint32_t*, 3> to{&plane.x, &plane.y, &plane.z};
    for (int d = 0; d < Dim; ++d)
        *to[static_cast<std::size_t>(d)] =
            lowBits(static_cast<std::int64_t>(std::nearbyint(found.point[d] / quantum_)));
    if constexpr (Dim > 2) plane.nz = static_cast<float>(normal[2]);
    // Other walls that it met are kept while it is beside them.
    std::uint32_t kept = 0;
    for (std::uint32_t k = 0; k < wall.count; ++k) {
        const Plane& p = wall.planes[k];
        const float dx = difference(body.x, p.x), dy = difference(body.y, p.y),
                    dz = difference(body.z, p.z);
        const float away = p.nx * dx + p.ny * dy + p.nz * dz;
        const float aside = dx * dx + dy * dy + dz * dz - away * away;
        const float alike = p.nx * plane.nx + p.ny * plane.ny + p.nz * plane.nz;
        if (alike > 0.9f || aside > square(0.7f * body.radius) ||
            away > static_cast<float>(need + 3 * slide) || away < 0)
            continue;
        wall.planes[kept++] = p;
    }
    if (kept == kMostPlanes) {
        std::copy(wall.planes.begin() + 1, wall.planes.end(), wall.planes.begin());
        --kept;
    }
    wall.planes[kept++] = plane;
    wall.count = kept;
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
    });
}

template <int Dim>
void Relaxation<Dim>::listRun(Run& run) {
    run.ids.clear();
    run.ends.clear();
    run.ranks.clear();
    run.grown = 0;
    run.coincides = false;
    const float grow = 1 + delta_;
    for (std::uint32_t i = run.first; i < run.last; ++i) {
        if (isFixed(now_.labels[i])) {
            run.ends.push_back(static_cast<std::uint32_t>(run.ids.size()));
            continue;
        }
        run.ranks.push_back(i);
        const Body body = now_.bodies[i];
        const Home& home = now_.homes[i];
        for (const Level& level : levels_) {
            if (level.count[0] == 0) continue;
            const double reach =
                (static_cast<double>(body.radius) + static_cast<double>(level.largest)) *
                    static_cast<double>(grow) * (1 + 1e-6) +
                static_cast<double>(skin_);
            forEachRow(level, home, reach, [&](std::uint32_t first, std::uint32_t last) {
                for (std::uint32_t j = first; j < last; j += 8) {
                    const Bodies8 other = load(now_.bodies.data() + j);
                    const Float8 dx = difference(other.x, body.x);
                    const Float8 dy = difference(other.y, body.y);
                    const Float8 dz = difference(other.z, body.z);
                    const Float8 d2 = dx * dx + dy * dy + dz * dz;
                    const Float8 near = (other.radius + body.radius) * grow + skin_;
                    unsigned bits = bitsOf(d2 < near * near);
                    if (last - j < 8) bits &= (1u << (last - j)) - 1;
                    for (; bits != 0; bits &= bits - 1) {
                        const auto k = j + static_cast<std::uint32_t>(__builtin_ctz(bits));
                        if (k == i || (wraps_ && !isNear(home, now_.homes[k]))) continue;
                        const Body& met = now_.bodies[k];
                        if (met.x == body.x && met.y == body.y && met.z == body.z) {
                            part(i, k);
                            run.coincides = true;
                        }
                        run.ids.push_back(k);
                    }
                }
            });
        }
        while (run.ids.size() % 8 != 0) run.ids.push_back(i);
        run.ends.push_back(static_cast<std::uint32_t>(run.ids.size()));
    }
    // By kind, radius and slot: bits of positive floats are in the order of their values.
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
    keys.reserve(run.ranks.size());
    for (const std::uint32_t slot : run.ranks) {
        const std::uint64_t kind = kinds_.empty() ? 0 : kinds_[now_.labels[slot]];
        keys.emplace_back(kind << 32 | bitsAs<std::uint32_t>(now_.bodies[slot].radius), slot);
    }
    std::sort(keys.begin(), keys.end());
    for (std::size_t k = 0; k < keys.size(); ++k) run.ranks[k] = keys[k].second;
}

template <int Dim>
bool Relaxation<Dim>::isNear(const Home& a, const Home& b) const {
    for (std::size_t d = 0; d < 3; ++d)
        if (a[d] - b[d] > (std::int64_t(1) << 30) || b[d] - a[d] > (std::int64_t(1) << 30))
            return false;
    return true;
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
        if (const std::uint32_t index = now_.walls[i]; index != kNone) {
            const Wall& wall = walls_[index];
            const float reach = body.radius * grow;
            for (std::uint32_t k = 0; k < wall.count; ++k) {
                const Plane& p = wall.planes[k];
                const float away = p.nx * difference(body.x, p.x) + p.ny * difference(body.y, p.y) +
                                   p.nz * difference(body.z, p.z);
                const float over = reach - away;
                if (!(over > 0)) continue;
                x += over * p.nx;
                y += over * p.ny;
                z += over * p.nz;
                worstWall = std::max(worstWall, over / std::max(away, 0.1f * reach));
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
        Body &small = now_.bodies[a], &big = now_.bodies[b];
        const float more = big.radius - small.radius;
        float &pSmall = now_.motions[a].squeeze, &pBig = now_.motions[b].squeeze;
        if (!(more > 0 && pBig > 0 && touching_[a] >= 0 && touching_[b] >= 0 &&
              more <= kAlike * small.radius &&
              pBig - pSmall > 0.5f * (touching_[a] + touching_[b]) * more))
            continue;
        if (!kinds_.empty() && kinds_[now_.labels[a]] != kinds_[now_.labels[b]]) continue;
        std::swap(small.radius, big.radius);
        std::swap(now_.labels[a], now_.labels[b]);
        std::swap(run.ranks[k], run.ranks[l]);
        touching_[a] = touching_[b] = -1;  // once in a step: what they push has changed
        now_.roams[a] -= more;
        run.grown = std::max(run.grown, small.radius - listedRadii_[a]);
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
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, now_.labels.size(), 256),
                      [&](const tbb::blocked_range<std::size_t>& part) {
                          DomainSampler<Dim>& sampler = this->sampler();
                          for (std::size_t i = part.begin(); i < part.end(); ++i) {
                              if (isFixed(now_.labels[i])) continue;
                              const Vec<Dim> x = position(whereIs(now_.homes[i], now_.bodies[i]));
                              const double radius =
                                  static_cast<double>(now_.bodies[i].radius) * grow;
                              const double inside = -sampler.signedDistance(x) / quantum_;
                              if (std::min(inside, fieldDepth_) - fieldError_ > radius) continue;
                              if (!sampler.isWallCloser(x, radius * quantum_) &&
                                  (inside > fieldError_ || sampler.contains(x)))
                                  continue;
                              keeps.store(false, std::memory_order_relaxed);
                              askWall(i, sampler);
                          }
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
    for (;; ++outcome.steps) {
        if (callbacks.isCancelled()) {
            outcome.interrupted = true;
            return outcome;
        }
        if (mustRebuild()) {
            const float wanted = listed_ < kShortList ? 1.15f : listed_ > kLongList ? 0.87f : 1.0f;
            skin_ = std::clamp(skin_ * wanted, std::max(kLeastSkin * least_, 2.5f * cap),
                               std::max(kMostSkin * least_, 3 * cap));
            rebuild();
        }
        const bool exchange =
            pace.swapEvery > 0 && clock_ % static_cast<std::uint64_t>(pace.swapEvery) == 0;
        tbb::parallel_for(std::size_t(0), runs_.size(), [&](std::size_t k) {
            if (exchange)
                stepRun<true>(runs_[k], inertia, cap, next_.data());
            else
                stepRun<false>(runs_[k], inertia, cap, next_.data());
        });
        float worst = 0, fastest = 0;
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
        if (exchange)
            tbb::parallel_for(std::size_t(0), runs_.size(),
                              [&](std::size_t k) { swapRun(runs_[k]); });
        ++clock_;
    }
}

template class Relaxation<2>;
template class Relaxation<3>;

}  // namespace vdbpack
