#include "vdbpack/pack/front/block_state.h"

#include "vdbpack/core/depth_range.h"

namespace vdbpack {

template <int Dim>
bool BlockState<Dim>::findWall(const Vec<Dim>& inside, const Vec<Dim>& x, double least,
                               double reach, TangentPlane<Dim>& plane, double& distance) const {
    const Vec<Dim> global = x + origin;
    const double depth = -sampler->signedDistance(global), error = settings.fieldError;
    if (settings.fieldDepth > reach + error &&
        (depth > reach + error ||
         (depth > reach - error && sampler->depthRange(global).least > reach))) {
        // The field may be off by more than its stated error: the triangles decide up to `least`.
        if (error == 0) return false;
        reach = least;
    }
    WallPoint<Dim> wall;
    if (!sampler->nearestWall(global, reach, wall)) return false;
    distance = wall.distance;
    plane.point = wall.point - origin;
    plane.normal = x - plane.point;
    double l = length(plane.normal);
    if (!(l > 1e-9 * reach)) {  // on the wall
        plane.normal = inside - plane.point;
        l = length(plane.normal);
        if (!(l > 0)) plane.normal = -settings.sweep, l = 1;
    }
    // Triangles do not tell which side is inside; `inside` does.
    const double side = dot(inside - plane.point, plane.normal);
    plane.normal *= (side < 0 ? -1.0 : 1.0) / l;
    return true;
}

template <int Dim>
double BlockState<Dim>::clearance(const Vec<Dim>& x, double reach, double enough) const {
    double least = reach;
    cells.near(x, reach, [&](std::uint32_t i) {
        least = std::min(least, length(spheres[i].center - x) - spheres[i].radius);
        return least > enough;
    });
    if (least <= std::max(enough, 0.0)) return least;
    WallPoint<Dim> wall;
    const Vec<Dim> global = x + origin;
    if (enough > 0 && sampler->depthRange(global).most <= enough) return enough;
    if (sampler->nearestWall(global, least, wall)) least = wall.distance;
    return sampler->contains(global) ? least : -least;
}

template <int Dim>
void BlockState<Dim>::climb(Vec<Dim>& x, double& room, double reach, double least) const {
    for (double step = 0.25 * least; step > 0.005 * least;) {
        Vec<Dim> best = x;
        double bestRoom = room;
        for (int d = 0; d < Dim; ++d)
            for (const double sign : {-1.0, 1.0}) {
                Vec<Dim> y = x;
                y[d] += sign * step;
                if (!owns(y)) continue;
                const double c = clearance(y, reach, bestRoom);
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
