#include "vdbpack/pack/packer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

template <int Dim>
Sphere<Dim> largestBall(const Domain<Dim>& domain) {
    const auto sampler = domain.sampler();
    const Box<Dim> bounds = domain.bounds();
    Sphere<Dim> best{bounds.center(), -std::numeric_limits<double>::infinity()};
    const Vec<Dim> size = bounds.size();
    const double longest = std::max(0.0, *std::max_element(size.c.begin(), size.c.end()));
    // The field is clamped where it is deep: there the exact distance decides.
    const auto depthAt = [&](const Vec<Dim>& x) {
        const double field = -sampler->signedDistance(x);
        if (field < 0) return field;
        WallPoint<Dim> wall;
        return sampler->nearestWall(x, longest, wall) ? wall.distance : field;
    };
    constexpr int kSteps = Dim == 3 ? 48 : 256;
    int n[3] = {1, 1, 1};
    for (int d = 0; d < Dim && longest > 0; ++d)
        n[d] = std::max(1, static_cast<int>(std::ceil(kSteps * size[d] / longest)));
    for (int k = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i) {
                const int at[3] = {i, j, k};
                Vec<Dim> x;
                for (int d = 0; d < Dim; ++d) x[d] = bounds.lo[d] + (at[d] + 0.5) / n[d] * size[d];
                if (-sampler->signedDistance(x) <= std::min(best.radius, domain.fieldDepth() * 0.9))
                    continue;
                const double depth = depthAt(x);
                if (depth > best.radius) best = {x, depth};
            }
    // Uphill by steps away from the nearest wall (subgradients of the depth), which zigzag along
    // a ridge between walls to where it ends; steps halve, each length starting from the best.
    constexpr int kStepsOfALength = 32;
    for (double step = longest / kSteps; best.radius > 0 && step > 1e-8 * best.radius;
         step *= 0.5) {
        Vec<Dim> x = best.center;
        for (int k = 0; k < kStepsOfALength; ++k) {
            WallPoint<Dim> wall;
            if (!sampler->nearestWall(x, longest, wall) || !(wall.distance > 0)) break;
            x += (step / wall.distance) * (x - wall.point);
            const double depth = depthAt(x);
            if (!(depth > 0)) break;
            if (depth > best.radius) best = {x, depth};
        }
    }
    return best;
}

template Sphere<2> largestBall(const Domain<2>&);
template Sphere<3> largestBall(const Domain<3>&);

}  // namespace vdbpack
