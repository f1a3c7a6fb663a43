#include "vdbpack/pack/front/handover.h"

namespace vdbpack {

template <int Dim>
void handOver(const Front<Dim>& front, std::vector<HandedSite<Dim>>& handed) {
    using Sites = FrontSites<Dim>;
    using Kind = typename HandedSite<Dim>::Support::Kind;
    const Vec<Dim>& origin = front.block.origin;
    for (std::size_t i = front.standing; i < front.block.spheres.size(); ++i)
        front.sites.forEachForeign(
            static_cast<std::uint32_t>(i), [&](std::uint32_t site, std::uint32_t neighbor) {
                HandedSite<Dim>& to = handed.emplace_back();
                const auto& bodies = front.sites.bodies(site);
                for (std::size_t b = 0; b < Dim - 1; ++b) {
                    auto& support = to.supports[b];
                    support = {Kind::none, {}, {}, 0.0};
                    if (bodies[b] == Sites::kNoBody) continue;
                    if (bodies[b] >= Sites::kWallBody) {
                        const TangentPlane<Dim>& plane = front.walls[bodies[b] - Sites::kWallBody];
                        support = {Kind::wall, plane.point + origin, plane.normal, 0.0};
                    } else {
                        const Sphere<Dim>& other = front.sphere(bodies[b]);
                        support = {Kind::sphere, other.center + origin, {}, other.radius};
                    }
                }
                to.center = front.sites.center(site) + origin;
                to.limit = front.sites.limit(site);
                to.side = front.sites.side(site);
                to.pivot = static_cast<std::uint32_t>(i - front.standing);
                to.neighbor = neighbor;
            });
}

template <int Dim>
void takeOver(const BlockSpheres<Dim>& around, const std::vector<std::uint32_t>& local,
              Front<Dim>& front) {
    using Sites = FrontSites<Dim>;
    using Kind = typename HandedSite<Dim>::Support::Kind;
    const Vec<Dim>& origin = front.block.origin;
    for (const HandedSite<Dim>& handed : around.sites) {
        const std::uint32_t pivot = local[handed.pivot];
        if (pivot == Sites::kNone) continue;
        const float probe = front.sites.probe(pivot);
        typename Surroundings<Dim>::Site site;
        site.limit = handed.limit;
        site.side = handed.side;
        std::array<Cap<float, Dim>, Dim - 1> caps{};
        for (std::size_t b = 0; b < Dim - 1; ++b) {
            const auto& support = handed.supports[b];
            site.bodies[b] = Sites::kNoBody;
            if (support.kind == Kind::none) continue;
            if (support.kind == Kind::wall)
                site.bodies[b] = Sites::kWallBody +
                                 front.walls.add(pivot, {support.at - origin, support.normal});
            else
                site.bodies[b] = front.addHidden({support.at - origin, support.radius});
            caps[b] = front.sites.cap(pivot, site.bodies[b]);
        }
        const Vec<Dim> center = handed.center - origin;
        const Vec<Dim> from = center - front.sphere(pivot).center;
        const float rolling = static_cast<float>(front.sphere(pivot).radius) + probe;
        if (site.bodies[0] == Sites::kNoBody)
            site.track.makeLoose(rolling, toFloat(normalized(from)));
        else if (!site.track.make(rolling, probe, caps, site.side))
            continue;
        if (!site.track.at(0, site.start)) continue;
        site.end = toFloat(from);
        const std::uint32_t index = front.sites.add(pivot, site);
        if (index == Sites::kNone) continue;
        if (front.sites.nearGap(pivot) > 0)
            front.block.cells.near(center,
                                   static_cast<double>(handed.limit + front.sites.nearGap(pivot)),
                                   [&](std::uint32_t i) {
                                       if (i != pivot) front.sites.countNear(index, i);
                                       return true;
                                   });
        // By what has been placed since.
        front.block.cells.near(center, static_cast<double>(handed.limit), [&](std::uint32_t i) {
            if (i != pivot) front.sites.keepOff(index, i);
            return !front.sites.isRemoved(index);
        });
    }
}

template void handOver(const Front<2>&, std::vector<HandedSite<2>>&);
template void handOver(const Front<3>&, std::vector<HandedSite<3>>&);
template void takeOver(const BlockSpheres<2>&, const std::vector<std::uint32_t>&, Front<2>&);
template void takeOver(const BlockSpheres<3>&, const std::vector<std::uint32_t>&, Front<3>&);

}  // namespace vdbpack
