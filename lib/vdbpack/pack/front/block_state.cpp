#include "vdbpack/pack/front/block_state.h"

namespace vdbpack {

template <int Dim>
double BlockState<Dim>::clearance(const Vec<Dim>& x, double reach) const {
    double least = reach;
    cells.near(x, reach, [&](std::uint32_t i) {
        least = std::min(least, length(spheres[i].center - x) - spheres[i].radius);
        return true;
    });
    if (least <= 0) return least;
    WallPoint<Dim> wall;
    const Vec<Dim> global = x + origin;
    if (sampler->nearestWall(global, least, wall)) least = wall.distance;
    return sampler->contains(global) ? least : -least;
}

template <int Dim>
void BlockState<Dim>::climb(Vec<Dim>& x, double& room, double reach) const {
    for (double step = 0.25 * settings.minRadius; step > 0.005 * settings.minRadius;) {
        Vec<Dim> best = x;
        double bestRoom = room;
        for (int d = 0; d < Dim; ++d)
            for (const double sign : {-1.0, 1.0}) {
                Vec<Dim> y = x;
                y[d] += sign * step;
                if (!owns(y)) continue;
                const double c = clearance(y, reach);
                if (c > bestRoom) bestRoom = c, best = y;
            }
        if (bestRoom > room) {
            x = best;
            room = bestRoom;
        } else {
            step *= 0.5;
        }
    }
}

template struct BlockState<2>;
template struct BlockState<3>;

}  // namespace vdbpack
