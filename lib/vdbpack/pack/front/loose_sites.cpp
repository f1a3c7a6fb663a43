// Sites where a sphere touches a pivot alone.
#include "vdbpack/pack/front/front_sites.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbpack {

namespace {

/// Directions a little off each body in reach, for the largest of the common spheres on the pivot:
/// smaller ones fit there as well.
template <class Bodies, class CapOf>
std::vector<Vec<3>> directionsBeside(const Bodies& around, double rolling, float common,
                                     const CapOf& capOf) {
    constexpr int kAround = 16;
    std::vector<Vec<3>> directions;
    for (std::size_t i = 0; i < around.count; ++i) {
        Vec<3> axis;
        for (int d = 0; d < 3; ++d)
            axis[d] = static_cast<double>(around.to[static_cast<std::size_t>(d)][i]);
        const Cap<float, 3> cap = capOf(around.index[i]);
        const double l = length(axis);
        const double level = static_cast<double>(cap.level + common * cap.slope);
        const double height = level / (l * rolling);
        if (height >= 1) continue;
        axis *= 1 / l;
        const Vec<3> other = std::fabs(axis[0]) < 0.6 ? Vec<3>{{1, 0, 0}} : Vec<3>{{0, 1, 0}};
        const Vec<3> e1 = normalized(cross(axis, other));
        const Vec<3> e2 = cross(axis, e1);
        const double up = height - 1e-5;
        const double out = std::sqrt(std::max(0.0, 1 - up * up));
        for (int a = 0; a < kAround; ++a) {
            const double angle = 2 * kPi * a / kAround;
            directions.push_back(axis * up + (e1 * std::cos(angle) + e2 * std::sin(angle)) * out);
        }
    }
    return directions;
}

}  // namespace

/// A front begins with too few bodies to touch: then a sphere may touch the pivot alone.
template <int Dim>
void FrontSites<Dim>::addLoose(std::uint32_t pivot, const Surroundings<Dim>& around) {
    const PivotRadii radii = radiiOf(pivot);
    std::vector<Vec<Dim>> directions;
    if constexpr (Dim == 3)
        directions = directionsBeside(
            around.spheres,
            sphere(pivot).radius +
                (block_.local ? static_cast<double>(radii.common) : block_.settings.commonRadius),
            radii.common, [&](std::uint32_t body) { return cap(pivot, body); });
    if (directions.empty()) directions.push_back(-block_.settings.sweep);
    const float rolling = static_cast<float>(sphere(pivot).radius) + radii.probe;
    for (const Vec<Dim>& n : directions) {
        typename Surroundings<Dim>::Site site;
        site.track.makeLoose(rolling, toFloat(n));
        const float most = radii.largest - radii.probe;
        const float t = around.growth(site.track, most);
        if (most > 0 && !(t > 0)) continue;
        site.track.at(0, site.start);
        site.track.at(t, site.end);
        site.limit = t >= most ? radii.largest : radii.probe + t;
        site.side = 1;
        site.bodies.fill(kNoBody);
        add(pivot, site);
    }
}

template void FrontSites<2>::addLoose(std::uint32_t, const Surroundings<2>&);
template void FrontSites<3>::addLoose(std::uint32_t, const Surroundings<3>&);

}  // namespace vdbpack
