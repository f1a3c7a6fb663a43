#include "vdbpack/pack/kernel_settings.h"
#include "vdbpack/pack/packer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

/// Steps of the grid along the longest side of a domain.
template <int Dim>
constexpr int kGridSteps = Dim == 3 ? 48 : 256;

/// From this share of its depth on, a field says no more than that a point lies deep.
constexpr double kClamped = 0.9;

/// Calls `f` for the points of a grid in the bounds of a domain while it returns true.
template <int Dim, typename F>
void forGridPoints(const Box<Dim>& bounds, F&& f) {
    const Vec<Dim> size = bounds.size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    int n[3] = {1, 1, 1};
    for (int d = 0; d < Dim && longest > 0; ++d)
        n[d] = std::max(1, static_cast<int>(std::ceil(kGridSteps<Dim> * size[d] / longest)));
    for (int k = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i) {
                const int at[3] = {i, j, k};
                Vec<Dim> x;
                for (int d = 0; d < Dim; ++d) x[d] = bounds.lo[d] + (at[d] + 0.5) / n[d] * size[d];
                if (!f(x)) return;
            }
}

}  // namespace

template <int Dim>
bool holdsBall(const Domain<Dim>& domain, double radius) {
    const auto sampler = domain.sampler();
    bool holds = false;
    forGridPoints(domain.bounds(), [&](const Vec<Dim>& x) {
        const double field = -sampler->signedDistance(x);
        holds = field >= radius || (field > 0 && field > kClamped * domain.fieldDepth() &&
                                    !sampler->isWallCloser(x, radius));
        return !holds;
    });
    return holds;
}

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
    forGridPoints(bounds, [&](const Vec<Dim>& x) {
        const double field = -sampler->signedDistance(x);
        if (field <= std::min(best.radius, kClamped * domain.fieldDepth()) ||
            (field <= best.radius && sampler->isWallCloser(x, best.radius)))
            return true;
        const double depth = depthAt(x);
        if (depth > best.radius) best = {x, depth};
        return true;
    });
    // Uphill by steps away from the nearest wall (subgradients of the depth), which zigzag along
    // a ridge between walls to where it ends; steps halve, each length starting from the best.
    constexpr int kStepsOfALength = 32;
    for (double step = longest / kGridSteps<Dim>; best.radius > 0 && step > 1e-8 * best.radius;
         step *= 0.5) {
        Vec<Dim> x = best.center;
        // No step changes the depth by more than its length.
        const double reach = best.radius * (1 + 1e-6) + (kStepsOfALength + 1) * step;
        for (int k = 0; k <= kStepsOfALength; ++k) {
            WallPoint<Dim> wall;
            if (!sampler->nearestWall(x, reach, wall) || !(wall.distance > 0) ||
                (k > 0 && !(sampler->signedDistance(x) < 0)))
                break;
            if (wall.distance > best.radius) best = {x, wall.distance};
            x += (step / wall.distance) * (x - wall.point);
        }
    }
    return best;
}

template bool holdsBall(const Domain<2>&, double);
template bool holdsBall(const Domain<3>&, double);
template Sphere<2> largestBall(const Domain<2>&);
template Sphere<3> largestBall(const Domain<3>&);

}  // namespace vdbpack
