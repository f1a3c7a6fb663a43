// The wall in the relaxation: queries for the spheres near it, and the exact test at the end.
#include "vdbpack/core/parallel.h"
#include "vdbpack/densify/relaxation.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace vdbpack {

namespace {

/// Share of delta that the exact wall leaves between itself and a sphere: a little less than the
/// planes near it do, where rounding could part the two tests for ever.
constexpr double kRoom = 0.02;

}  // namespace

template <int Dim>
void Relaxation<Dim>::askWalls() {
    parallelFor(IndexRange(0, now_.labels.size(), 256), [&](const IndexRange& part) {
        for (std::size_t i = part.begin(); i < part.end(); ++i)
            if (now_.vicinities[i].roam < 0) askWall(i);
    });
}

template <int Dim>
void Relaxation<Dim>::askWall(std::size_t slot) {
    const Body& body = now_.bodies[slot];
    auto& vicinity = now_.vicinities[slot];
    const float margin = wallMargin(slot);
    if (walls_.isDue(body, vicinity, margin))
        walls_.ask(whereIs(now_.homes[slot], body), body, margin, vicinity);
}

template <int Dim>
void Relaxation<Dim>::listPlanes(Run& run) {
    run.planes.clear();
    run.planeEnds.clear();
    run.edges.clear();
    run.edgeEnds.clear();
    for (std::uint32_t i = run.first; i < run.last; ++i) {
        if (const std::uint32_t wall = now_.vicinities[i].wall; wall != WallPlanes<Dim>::kNone) {
            const Body& body = now_.bodies[i];
            for (const WallPlane& plane : walls_[wall])
                if (plane.distance(body) <
                    body.radius * std::max(listGrow_, wallRange_) + now_.listed[i].radius)
                    run.planes.push_back(plane);
        }
        run.planeEnds.push_back(static_cast<std::uint32_t>(run.planes.size()));
        if (!boundary_) continue;
        if (!isFixed(now_.labels[i])) listBoundary(run, i);
        run.edgeEnds.push_back(static_cast<std::uint32_t>(run.edges.size()));
    }
}

template <int Dim>
void Relaxation<Dim>::listBoundary(Run& run, std::uint32_t slot) {
    constexpr double kInside = 3;  // on the right side by more than what is accepted as none
    const Body& body = now_.bodies[slot];
    const double radius = static_cast<double>(body.radius);
    const double reach = static_cast<double>(now_.listed[slot].radius) * quantum_;
    const bool inside = (*isInside_)(regions_[now_.labels[slot]]);
    const auto edge =
        boundary_->edgeNear(walls_.position(whereIs(now_.homes[slot], body)), inside, reach);
    if (!edge) return;
    // A wall that the sphere touches when its center reaches the end of the shell, or a little
    // before; in the shell, no sooner than it touches the wall itself.
    const auto delta = static_cast<double>(delta_);
    double margin = kInside * delta * radius;
    if (!inside)
        margin = std::clamp(0.5 * (edge->thickness / quantum_ - radius * (1 + delta)), 0.0, margin);
    const Vec<Dim> toward = edge->inward * (inside ? 1.0 : -1.0);
    const double right = (inside ? 1 : -1) * (edge->depth - edge->thickness) / quantum_;
    const double away = right + radius - margin;
    std::array<std::uint32_t, 3> point{body.x, body.y, body.z};
    std::array<float, 3> normal{};
    for (std::size_t d = 0; d < Dim; ++d) {
        normal[d] = static_cast<float>(toward.c[d]);
        point[d] -=
            static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(toward.c[d] * away)));
    }
    run.edges.push_back({normal[0], normal[1], normal[2], point[0], point[1], point[2]});
}

template <int Dim>
bool Relaxation<Dim>::keepsSide(const Run& run, std::uint32_t slot) {
    const std::uint32_t k = slot - run.first;
    if (run.edgeEnds[k] == (k > 0 ? run.edgeEnds[k - 1] : 0)) return true;  // far from the end
    const Vec<Dim> x = walls_.position(whereIs(now_.homes[slot], now_.bodies[slot]));
    const bool inside = (*isInside_)(regions_[now_.labels[slot]]);
    if (boundary_->isDeeper(x) == inside) return true;
    // One as large as the shell is thick has no other place than at the wall.
    const double least = static_cast<double>(now_.bodies[slot].radius) * quantum_;
    return !inside && !boundary_->isDeeperThan(x, least * (1 + static_cast<double>(delta_)));
}

template <int Dim>
bool Relaxation<Dim>::keepsWall() {
    toHost();
    std::atomic<bool> keeps{true};
    const double grow = 1 + kRoom * static_cast<double>(delta_);
    parallelFor(std::size_t(0), runs_.size(), [&](std::size_t k) {
        Run& run = runs_[k];
        bool asked = false;
        for (std::uint32_t i = run.first; i < run.last; ++i) {
            if (isFixed(now_.labels[i])) continue;
            const Body& body = now_.bodies[i];
            const Home home = whereIs(now_.homes[i], body);
            if (boundary_ && !keepsSide(run, i)) keeps.store(false, std::memory_order_relaxed);
            if (walls_.allows(home, body, grow)) continue;
            walls_.ask(home, body, wallMargin(i), now_.vicinities[i]);
            asked = true;
        }
        if (!asked) return;
        keeps.store(false, std::memory_order_relaxed);
        listPlanes(run);
        run.wallMembers = run.members.size();
    });
    return !anyOver(ranks_, !keeps);
}

template void Relaxation<2>::askWalls();
template void Relaxation<2>::listPlanes(Run&);
template bool Relaxation<2>::keepsWall();
template void Relaxation<3>::askWalls();
template void Relaxation<3>::listPlanes(Run&);
template bool Relaxation<3>::keepsWall();

}  // namespace vdbpack
