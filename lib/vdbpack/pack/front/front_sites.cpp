#include "vdbpack/pack/front/front_sites.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

/// Width of the queue's buckets in mean radii: sites whose keys differ by less are taken as they
/// come. Wider ones cost density (at `normal` 0.0005 at 0.05, 0.002 at 0.2).
constexpr double kBucket = 0.02;

/// Where the number of near bodies matters, sites go ahead the lower a sphere sinks in between the
/// bodies that it rests on: by this share of its height above their mean.
constexpr float kSink = 0.8f;
/// Spheres that a wall counts as. More make rows along flat walls: equal spheres in box 60 have a
/// solid fraction of 0.594 and 6 % in crystalline order at 2, 0.587 and 0.5 % at 1.1.
constexpr float kWallCrowd = 1.1f;
/// Most bodies near a site.
constexpr double kMostNear = 14;

/// The smallest float that is not below `v`.
float floatUp(double v) {
    const auto f = static_cast<float>(v);
    return static_cast<double>(f) < v ? std::nextafter(f, std::numeric_limits<float>::infinity())
                                      : f;
}

}  // namespace

template <int Dim>
FrontSites<Dim>::PivotRadii::PivotRadii(const FrontLengths& lengths)
    : probe(static_cast<float>(lengths.probe)),
      least(static_cast<float>(lengths.least)),
      // No smaller than the largest radius: an unlimited site must take that one as well.
      largest(floatUp(lengths.maxRadius)),
      common(static_cast<float>(lengths.commonRadius)),
      crowdLead(static_cast<float>(lengths.crowdLead)),
      nearGap(static_cast<float>(lengths.nearGap)),
      lead(lengths.lead),
      wallLead(lengths.wallLead),
      seamLead(lengths.seamLead),
      reach(lengths.reach) {}

template <int Dim>
FrontSites<Dim>::FrontSites(const BlockState<Dim>& block, FrontWalls<Dim>& walls)
    : block_(block), walls_(walls), radii_{PivotRadii(block.settings)} {}

template <int Dim>
void FrontSites<Dim>::clear() {
    const FrontSettings<Dim>& settings = block_.settings;
    sites_.clear();
    ends_.clear();
    first_.clear();
    unused_ = kNone;
    arrived_ = 0;
    if (block_.local) radii_.clear();
    const double low = sweeps(settings.order) ? dot(block_.own.lo, settings.sweep) : 0.0;
    // The lengths are those of the finest spheres, but for the largest radius.
    const double coarse = block_.local ? settings.maxRadius / settings.commonRadius : 1;
    const double ahead =
        coarse * (settings.lead + settings.wallLead + kMostNear * settings.crowdLead);
    queue_.reset(static_cast<float>(low - settings.waves.most(ahead)),
                 static_cast<float>(kBucket * settings.meanRadius));
}

template <int Dim>
void FrontSites<Dim>::find(std::uint32_t pivot, std::uint32_t only, Surroundings<Dim>& around,
                           bool inOwnBlock) {
    typename Surroundings<Dim>::Region inBlock;
    const Vec<Dim>& center = sphere(pivot).center;
    if (inOwnBlock) {
        for (std::size_t d = 0; d < Dim; ++d) {
            inBlock.lo[d] = static_cast<float>(block_.own.lo.c[d] - center.c[d]);
            inBlock.hi[d] = static_cast<float>(block_.own.hi.c[d] - center.c[d]);
        }
    }
    walls_.forEach(pivot, [&](std::uint32_t wall, const TangentPlane<Dim>& plane) {
        const double above = dot(center - plane.point, plane.normal);
        around.addWall(toFloat(plane.normal), static_cast<float>(above), kWallBody + wall);
    });
    const PivotRadii& radii = radiiOf(pivot);
    around.findSites(static_cast<float>(sphere(pivot).radius),
                     {radii.probe, radii.least, radii.largest}, only,
                     inOwnBlock ? &inBlock : nullptr, found_);
    for (const auto& site : found_) add(pivot, site, &around);
    if (found_.empty() && only == Surroundings<Dim>::kAll && around.reached() <= Dim)
        addLoose(pivot, around);
}

template <int Dim>
std::uint32_t FrontSites<Dim>::add(std::uint32_t pivot,
                                   const typename Surroundings<Dim>::Site& site,
                                   const Surroundings<Dim>* around) {
    const PivotRadii& radii = radiiOf(pivot);
    if (site.limit < radii.least) return kNone;
    const Vec<Dim>& center = sphere(pivot).center;
    End end;
    end.limit = site.limit;
    Vec<Dim> start;
    for (int d = 0; d < Dim; ++d) {
        const auto at = static_cast<std::size_t>(d);
        start[d] = center[d] + static_cast<double>(site.start[at]);
        end.center[at] = static_cast<float>(center[d]) + site.end[at];
    }
    const bool own = block_.owns(start);
    const std::uint32_t foreign = own ? 0 : block_.neighborAt(start);
    if (!own && foreign == 0) return kNone;
    std::uint32_t index = unused_;
    if (index == kNone) {
        index = static_cast<std::uint32_t>(sites_.size());
        sites_.emplace_back();
        ends_.emplace_back();
    } else {
        unused_ = ends_[index].next;
    }
    Site& s = sites_[index];
    s.track = site.track;
    const FrontOrder order = orderOf(start);
    s.base = static_cast<float>(order.position);
    s.slope = static_cast<float>(order.slope);
    s.side = site.side;
    s.bodies = site.bodies;
    s.pivot = pivot;
    s.foreign = foreign;
    s.crowd = 0;
    if (radii.crowdLead > 0) {
        s.base += s.slope * kSink * heightAbove(pivot, site.bodies, start);
        s.crowd = around ? around->crowdAt(site.end, site.limit, radii.nearGap) : 0.0f;
        walls_.forEach(pivot, [&](std::uint32_t, const TangentPlane<Dim>& plane) {
            s.crowd += wallCrowd(end, plane, radii.nearGap);
        });
    }
    end.next = first_[pivot];
    first_[pivot] = index;
    ends_[index] = end;
    enqueue(index);
    return index;
}

/// How far along the sweep a sphere at a site lies above the mean of the bodies that it touches; of
/// a wall, a sphere as large behind it. mm
template <int Dim>
float FrontSites<Dim>::heightAbove(std::uint32_t pivot, const Bodies& bodies,
                                   const Vec<Dim>& start) const {
    if (bodies[0] == kNoBody) return 0;
    const Vec<Dim>& sweep = block_.settings.sweep;
    const auto probe = static_cast<double>(radiiOf(pivot).probe);
    double height = dot(start - sphere(pivot).center, sweep);
    for (const std::uint32_t body : bodies)
        height += body >= kWallBody ? 2 * probe * dot(walls_[body - kWallBody].normal, sweep)
                                    : dot(start - sphere(body).center, sweep);
    return static_cast<float>(height / Dim);
}

/// What a body at a gap from a sphere adds to `Site::crowd`.
template <int Dim>
float FrontSites<Dim>::nearness(float gap, float nearGap) {
    const float near = 1 - std::max(gap, 0.0f) / nearGap;
    return near > 0 ? near * near : 0;
}

/// What a wall adds to `Site::crowd`.
template <int Dim>
float FrontSites<Dim>::wallCrowd(const End& end, const TangentPlane<Dim>& plane, float nearGap) {
    const double above = dot(fromFloat<Dim>(end.center) - plane.point, plane.normal);
    return kWallCrowd * nearness(static_cast<float>(above) - end.limit, nearGap);
}

/// Counts a sphere whose center is at a squared distance from that of a site.
template <int Dim>
void FrontSites<Dim>::crowd(std::uint32_t index, float square, float radius) {
    const float nearGap = radiiOf(sites_[index].pivot).nearGap;
    const float least = radius + ends_[index].limit, most = least + nearGap;
    if (square >= most * most) return;
    sites_[index].crowd += nearness(std::sqrt(square) - least, nearGap);
    enqueue(index);
}

template <int Dim>
void FrontSites<Dim>::countNear(std::uint32_t index, std::uint32_t sphereNear) {
    const Sphere<Dim>& s = sphere(sphereNear);
    crowd(index, squaredDistance(toFloat(s.center), ends_[index]), static_cast<float>(s.radius));
}

template <int Dim>
FrontOrder FrontSites<Dim>::orderOf(const Vec<Dim>& start) {
    const FrontSettings<Dim>& settings = block_.settings;
    switch (settings.order) {
        case Order::sweep:
        case Order::waves:
            return settings.waves.at(start + block_.origin, dot(start, settings.sweep));
        case Order::wall:
            return {-block_.sampler->signedDistance(start + block_.origin)};
        case Order::center:
            return {length(start + block_.origin - settings.middle)};
        case Order::fifo:
            // Sixteen sites a bucket of the queue, which keeps their order.
            return {kBucket * settings.meanRadius * static_cast<double>(arrived_++ / 16)};
    }
    return {};
}

template <int Dim>
const TangentPlane<Dim>* FrontSites<Dim>::wall(std::uint32_t index) const {
    for (const std::uint32_t body : sites_[index].bodies)
        if (body >= kWallBody && body != kNoBody) return &walls_[body - kWallBody];
    return nullptr;
}

/// Whether a sphere lies beyond upper faces of the block alone: in a periodic cell the first blocks
/// stand there.
template <int Dim>
bool FrontSites<Dim>::isBeyond(std::uint32_t index) const {
    const Vec<Dim>& center = sphere(index).center;
    bool beyond = false;
    for (int d = 0; d < Dim; ++d) {
        if (center[d] < block_.own.lo[d]) return false;
        beyond = beyond || center[d] >= block_.own.hi[d];
    }
    return beyond;
}

/// How far a site goes ahead because of what the front is going to meet there, mm.
template <int Dim>
double FrontSites<Dim>::meetingLead(std::uint32_t index) const {
    const PivotRadii& radii = radiiOf(sites_[index].pivot);
    bool meets = isBeyond(sites_[index].pivot);
    for (const std::uint32_t body : sites_[index].bodies) {
        if (body < kWallBody)
            meets = meets || isBeyond(body);
        else if (body != kNoBody &&
                 dot(walls_[body - kWallBody].normal, block_.advance(center(index))) < 0)
            return radii.wallLead;
    }
    return meets ? radii.seamLead : 0;
}

/// How far a site goes ahead of its position along the sweep, mm.
template <int Dim>
float FrontSites<Dim>::leadOf(std::uint32_t index) const {
    const PivotRadii& radii = radiiOf(sites_[index].pivot);
    if (!(radii.common > radii.probe)) return 0;
    double lead = isOpen(index) ? 0 : radii.lead;
    if (radii.wallLead > 0) lead += meetingLead(index);
    const float limit = std::min(ends_[index].limit, radii.common);
    return static_cast<float>(lead) * (limit - radii.probe) / (radii.common - radii.probe);
}

/// Where a site comes in the order of the front, mm.
template <int Dim>
float FrontSites<Dim>::keyOf(std::uint32_t index) const {
    const Site& site = sites_[index];
    return site.base - site.slope * leadOf(index) -
           site.slope * radiiOf(site.pivot).crowdLead * site.crowd;
}

template <int Dim>
void FrontSites<Dim>::enqueue(std::uint32_t index) {
    if (sites_[index].foreign == 0) queue_.push(index, keyOf(index));
}

template <int Dim>
template <class T>
Cap<T, Dim> FrontSites<Dim>::capOf(std::uint32_t pivot, std::uint32_t body) const {
    const auto array = [](const Vec<Dim>& v) {
        std::array<T, Dim> a;
        for (std::size_t d = 0; d < Dim; ++d) a[d] = static_cast<T>(v.c[d]);
        return a;
    };
    const Sphere<Dim>& s = sphere(pivot);
    if (body >= kWallBody) {
        const TangentPlane<Dim>& plane = walls_[body - kWallBody];
        return Cap<T, Dim>::ofWall(array(plane.normal),
                                   static_cast<T>(dot(s.center - plane.point, plane.normal)));
    }
    return Cap<T, Dim>::ofSphere(array(sphere(body).center - s.center), static_cast<T>(s.radius),
                                 static_cast<T>(sphere(body).radius));
}

template <int Dim>
Cap<float, Dim> FrontSites<Dim>::cap(std::uint32_t pivot, std::uint32_t body) const {
    return capOf<float>(pivot, body);
}

/// Lowers the limit of a site to where its track enters a cap on the same pivot.
template <int Dim>
void FrontSites<Dim>::limitBy(std::uint32_t index, const Cap<float, Dim>& cap) {
    const Site& site = sites_[index];
    End& end = ends_[index];
    const PivotRadii& radii = radiiOf(site.pivot);
    const float probe = radii.probe;
    const float rolling = static_cast<float>(sphere(site.pivot).radius) + probe;
    const float most = end.limit - probe;
    const float level = cap.level + probe * cap.slope;
    std::array<float, Dim> x;
    bool fits = site.track.at(0, x);
    float room = level;
    for (std::size_t d = 0; d < Dim; ++d) room -= x[d] * cap.to[d];
    fits = fits && room > -kSlack * rolling * rolling;
    if (!fits) return drop(index);  // not even the smallest
    if (!(most > 0)) return;
    const float t =
        firstHit<float, Dim>(site.track, cap.to, level, cap.slope, kTouching * rolling, most);
    if (t >= most) return;
    end.limit = probe + t;
    if (end.limit < radii.least) return drop(index);
    if (site.track.at(t, x))
        for (std::size_t d = 0; d < Dim; ++d)
            end.center[d] = static_cast<float>(sphere(site.pivot).center.c[d]) + x[d];
    enqueue(index);
}

template <int Dim>
float FrontSites<Dim>::squaredDistance(const std::array<float, Dim>& center, const End& end) {
    float square = 0;
    for (std::size_t d = 0; d < Dim; ++d)
        square += (end.center[d] - center[d]) * (end.center[d] - center[d]);
    return square;
}

/// Whether a sphere whose center is at a squared distance from that of a site reaches into the
/// largest one that the site would take.
template <int Dim>
bool FrontSites<Dim>::reaches(float square, float radius, const End& end) {
    const float least = radius + end.limit;
    return square < least * least * (1 - kSlack);
}

template <int Dim>
void FrontSites<Dim>::keepOff(std::uint32_t intruder, const Surroundings<Dim>& around) {
    const std::array<float, Dim> center = toFloat(sphere(intruder).center);
    const auto radius = static_cast<float>(sphere(intruder).radius);
    for (std::size_t i = 0; i < around.spheres.count; ++i) {
        const std::uint32_t pivot = around.spheres.index[i];
        std::uint32_t* link = &first_[pivot];
        while (*link != kNone) {
            End& end = ends_[*link];
            const float square = squaredDistance(center, end);
            if (!end.dead && reaches(square, radius, end)) limitBy(*link, cap(pivot, intruder));
            if (radiiOf(pivot).crowdLead > 0 && !end.dead) crowd(*link, square, radius);
            if (end.dead) {
                const std::uint32_t gone = *link;
                *link = end.next;
                end.next = unused_;
                unused_ = gone;
            } else {
                link = &end.next;
            }
        }
    }
}

template <int Dim>
void FrontSites<Dim>::keepOff(std::uint32_t index, std::uint32_t intruder) {
    if (reaches(squaredDistance(toFloat(sphere(intruder).center), ends_[index]),
                static_cast<float>(sphere(intruder).radius), ends_[index]))
        limitBy(index, cap(sites_[index].pivot, intruder));
}

template <int Dim>
void FrontSites<Dim>::keepOffWall(std::uint32_t pivot, std::uint32_t wall) {
    const Cap<float, Dim> forbidden = cap(pivot, kWallBody + wall);
    const PivotRadii& radii = radiiOf(pivot);
    for (std::uint32_t s = first_[pivot]; s != kNone; s = ends_[s].next) {
        if (!ends_[s].dead) limitBy(s, forbidden);
        if (!(radii.crowdLead > 0) || ends_[s].dead) continue;
        sites_[s].crowd += wallCrowd(ends_[s], walls_[wall], radii.nearGap);
        enqueue(s);
    }
}

template <int Dim>
bool FrontSites<Dim>::restingCenter(std::uint32_t index, double radius, Vec<Dim>& center) const {
    const Site& site = sites_[index];
    const Sphere<Dim>& pivot = sphere(site.pivot);
    const double open = radius + block_.settings.quantum;
    Track<double, Dim> track;
    if (site.bodies[0] == kNoBody) {
        const Vec<Dim> n = fromFloat<Dim>(ends_[index].center) - pivot.center;
        track.makeLoose(pivot.radius + open, normalized(n).c);
    } else {
        std::array<Cap<double, Dim>, Dim - 1> caps;
        for (std::size_t b = 0; b < Dim - 1; ++b)
            caps[b] = capOf<double>(site.pivot, site.bodies[b]);
        if (!track.make(pivot.radius + open, open, caps, static_cast<double>(site.side)))
            return false;
    }
    Vec<Dim> x;
    if (!track.at(0, x.c)) return false;
    center = pivot.center + x;
    return true;
}

template class FrontSites<2>;
template class FrontSites<3>;

}  // namespace vdbpack
