// Spheres of nearly the same size exchange positions where that relieves an overlap.
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// Where spheres with the worst overlaps exchange, the least squeezed of so many smaller ones is
/// taken.
constexpr std::uint32_t kLooser = 100, kFarLooser = 300;

}  // namespace

template <int Dim>
void Relaxation<Dim>::swapRun(Run& run, const std::vector<Squeezed>& squeezed) {
    std::vector<Body>& next = now_.before;  // where the step has put them
    const auto n = static_cast<std::uint32_t>(run.ranks.size());
    const std::uint64_t key = mix64(seed_ ^ mix64(clock_ * 0x9e3779b97f4a7c15ull + run.number));
    // Pairs without a common sphere: of every other block of `stride` ranks, and the next one.
    const auto stride = 1 + static_cast<std::uint32_t>(key % kExchangeRanks);
    const auto offset = static_cast<std::uint32_t>((key >> 32) % (2 * stride));
    for (std::uint32_t block = 0; block < n + offset; block += 2 * stride)
        for (std::uint32_t k = std::max(block, offset) - offset;
             k + offset < block + stride && k + stride < n; ++k) {
            const std::uint32_t a = run.ranks[k], b = run.ranks[k + stride];
            const float radius = next[a].radius;
            const float more = next[b].radius - radius;  // negative within a class of radii
            const Squeezed &small = squeezed[a - run.first], &big = squeezed[b - run.first];
            if (more > 0 && big.squeeze > 0 &&
                big.squeeze - small.squeeze > 0.5f * (small.touching + big.touching) * more &&
                more <= kAlike * radius && isAlike(a, b) &&
                !(settling_ && (run.isBetweenWalls(a) || run.isBetweenWalls(b)))) {
                exchange(run, k, k + stride, next);
                run.exchanged.emplace_back(a, b);
            }
        }
}

template <int Dim>
void Relaxation<Dim>::exchange(Run& run, std::uint32_t k, std::uint32_t l,
                               std::vector<Body>& bodies) {
    const std::uint32_t a = run.ranks[k], b = run.ranks[l];
    const float more = bodies[b].radius - bodies[a].radius;
    std::swap(bodies[a].radius, bodies[b].radius);
    std::swap(run.ranks[k], run.ranks[l]);
    now_.listed[a].radius -= more * listGrow_;
    now_.listed[b].radius += more * listGrow_;
    now_.vicinities[a].roam -= more;
    if (isBeyond(now_.listed[a], bodies[a])) run.expired = true;
}

template <int Dim>
void Relaxation<Dim>::exchangeLabels(std::uint32_t a, std::uint32_t b) {
    std::swap(now_.labels[a], now_.labels[b]);
}

template <int Dim>
typename Relaxation<Dim>::Strain Relaxation<Dim>::strainOf(const Run& run,
                                                           std::size_t member) const {
    const std::uint32_t slot = run.members[member];
    const Body& body = now_.bodies[slot];
    const float grow = 1 + delta_;
    Strain strain;
    const auto add = [&](float overlap, float reach) {
        strain.worst = std::max(strain.worst, overlap);
        strain.squeeze += std::max(overlap, 0.0f) * reach;
    };
    const std::size_t eight = member / kLanes;
    for (std::uint32_t e = eight > 0 ? run.ends[eight - 1] : 0; e < run.ends[eight]; e += kLanes) {
        const Body& other = now_.bodies[run.ids[e + member % kLanes]];
        const float dx = difference(other.x, body.x), dy = difference(other.y, body.y),
                    dz = difference(other.z, body.z);
        const float reach = (other.radius + body.radius) * grow;
        add(reach * inverseRoot(dx * dx + dy * dy + dz * dz) - 1, reach);
    }
    const std::uint32_t k = slot - run.first;
    for (std::uint32_t p = k > 0 ? run.planeEnds[k - 1] : 0; p < run.planeEnds[k]; ++p) {
        const float reach = body.radius * grow;
        add(run.planes[p].overlap(run.planes[p].distance(body), reach), reach);
        if (settling_) strain.squeeze += reach;  // a place between walls does not give way
    }
    return strain;
}

template <int Dim>
double Relaxation<Dim>::strain() {
    constexpr double kUnit = 1 << 20;  // whole sums: the same over any number of ranks
    toHost();
    std::vector<std::array<std::uint64_t, 2>> sums(runs_.size());
    parallelFor(std::size_t(0), runs_.size(), [&](std::size_t r) {
        const Run& run = runs_[r];
        for (std::size_t m = 0; m < run.ranks.size(); ++m) {
            const float radius = now_.bodies[run.members[m]].radius;
            sums[r][0] += static_cast<std::uint64_t>(
                kUnit * static_cast<double>(strainOf(run, m).squeeze / radius));
        }
        sums[r][1] = run.ranks.size();
    });
    std::uint64_t sum = 0, count = 0;
    for (const auto& [squeeze, spheres] : sums) {
        sum += squeeze;
        count += spheres;
    }
    sum = sumOver(ranks_, sum);
    count = sumOver(ranks_, count);
    return static_cast<double>(sum) / kUnit / static_cast<double>(count);
}

template <int Dim>
void Relaxation<Dim>::leaveWalls(const Run& run, std::uint32_t slot, float speed) {
    const std::uint32_t k = slot - run.first;
    const Body& body = now_.bodies[slot];
    std::array<float, 3> toward{};
    float most = 0;  // cosine of the angle of two walls, negative
    for (std::uint32_t p = k > 0 ? run.planeEnds[k - 1] : 0; p < run.planeEnds[k]; ++p)
        for (std::uint32_t q = p + 1; q < run.planeEnds[k]; ++q) {
            const WallPlane &a = run.planes[p], &b = run.planes[q];
            const float cosine = a.nx * b.nx + a.ny * b.ny + a.nz * b.nz;
            if (!(cosine < most) || !(a.distance(body) < body.radius) ||
                !(b.distance(body) < body.radius))
                continue;
            most = cosine;
            toward = {a.nx + b.nx, a.ny + b.ny, a.nz + b.nz};
        }
    const float square = toward[0] * toward[0] + toward[1] * toward[1] + toward[2] * toward[2];
    if (!(square > 0)) return;
    const float by = speed * inverseRoot(square);
    const auto quanta = [&](float v) {
        return static_cast<std::uint32_t>(static_cast<std::int32_t>(by * v));
    };
    now_.before[slot] = {body.x - quanta(toward[0]), body.y - quanta(toward[1]),
                         body.z - quanta(toward[2]), body.radius};
}

template <int Dim>
void Relaxation<Dim>::loosen(float worst, float kick, bool exchanges) {
    toHost();
    const float least = std::max(0.5f * worst, delta_);
    std::vector<std::vector<Strain>> all(runs_.size());  // by slots, before any are exchanged
    parallelFor(std::size_t(0), runs_.size(), [&](std::size_t r) {
        const Run& run = runs_[r];
        if (!(run.worst > least)) return;
        all[r].resize(run.last - run.first);
        for (std::size_t m = 0; m < run.ranks.size(); ++m)
            all[r][run.members[m] - run.first] = strainOf(run, m);
    });
    parallelFor(std::size_t(0), runs_.size(), [&](std::size_t r) {
        Run& run = runs_[r];
        const std::vector<Strain>& strains = all[r];
        if (strains.empty()) return;
        for (std::uint32_t rank = 0; rank < run.ranks.size(); ++rank) {
            const std::uint32_t big = run.ranks[rank];
            if (!(strains[big - run.first].worst > least)) continue;
            std::uint32_t best = rank;
            // So much smaller that the overlap is none, if there is one.
            const float fits = now_.bodies[big].radius * (1 - strains[big - run.first].worst);
            std::uint32_t l = rank;
            while (l > 0 && rank - l < kFarLooser && now_.bodies[run.ranks[l]].radius > fits) --l;
            for (const std::uint32_t first = ++l; l-- > 0 && first - l <= kLooser;) {
                const std::uint32_t small = run.ranks[l];
                if (now_.bodies[small].radius < now_.bodies[big].radius && isAlike(small, big) &&
                    !(kick > 0 && run.hasWall(small)) &&
                    strains[small - run.first].squeeze <
                        strains[run.ranks[best] - run.first].squeeze)
                    best = l;
            }
            if (best == rank) {
                if (kick > 0) leaveWalls(run, big, kick);
            } else if (exchanges) {
                exchangeLabels(run.ranks[best], big);
                exchange(run, best, rank, now_.bodies);
            }
        }
    });
}

template void Relaxation<2>::swapRun(Run&, const std::vector<Squeezed>&);
template void Relaxation<2>::exchangeLabels(std::uint32_t, std::uint32_t);
template double Relaxation<2>::strain();
template void Relaxation<2>::loosen(float, float, bool);
template void Relaxation<3>::swapRun(Run&, const std::vector<Squeezed>&);
template void Relaxation<3>::exchangeLabels(std::uint32_t, std::uint32_t);
template double Relaxation<3>::strain();
template void Relaxation<3>::loosen(float, float, bool);

}  // namespace vdbpack
