// Spheres of nearly the same size exchange positions where that relieves an overlap.
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/relaxation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// Largest difference of ranks of two spheres that exchange positions, and of their radii (as a
/// share of the smaller one).
constexpr std::uint64_t kRanks = 20;
constexpr float kAlike = 0.1f;
/// Where spheres with the worst overlaps exchange, the least squeezed of so many smaller ones is
/// taken.
constexpr std::uint32_t kLooser = 100;

}  // namespace

template <int Dim>
void Relaxation<Dim>::swapRun(Run& run) {
    const auto n = static_cast<std::uint32_t>(run.ranks.size());
    const std::uint64_t key = mix64(seed_ ^ mix64(clock_ * 0x9e3779b97f4a7c15ull + run.number));
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
    touching_[a] = touching_[b] = -1;  // once per step: their squeezes are outdated
    now_.vicinities[a].roam -= more;
    run.grown = std::max(run.grown, (small.radius - listedRadii_[a]) / unitOf(listedRadii_[a]));
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
    parallelFor(std::size_t(0), runs_.size(), [&](std::size_t k) {
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

template void Relaxation<2>::swapRun(Run&);
template void Relaxation<2>::loosen(float);
template void Relaxation<3>::swapRun(Run&);
template void Relaxation<3>::loosen(float);

}  // namespace vdbpack
