#include "vdbpack/pack/front/block_front.h"

#include "vdbpack/core/lanes.h"
#include "vdbpack/pack/front/bucket_queue.h"
#include "vdbpack/pack/front/place_search.h"
#include "vdbpack/pack/front/resting.h"
#include "vdbpack/pack/front/touching.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

/// Body numbers at and above this are walls of the pivot, below it spheres of the block.
constexpr std::uint32_t kWallBody = 0x40000000u;
/// In place of a body where a sphere rests on the pivot alone.
constexpr std::uint32_t kNoBody = 0x7fffffffu;
constexpr std::uint32_t kNone = 0xffffffffu;
/// In place of a block to come.
constexpr std::uint32_t kDone = 0;

/// Tangent planes that one pivot may collect; corners need three, rough walls a few more.
constexpr int kMaxPlanes = 12;

/// Pending radii tried at a site, from the largest that seems to fit.
constexpr std::size_t kAttempts = 3;

/// Width of the queue's buckets in mean radii: sites whose keys differ by less are taken as they
/// come. Wider ones cost density (at `normal` 0.0005 at 0.05, 0.002 at 0.2).
constexpr double kBucket = 0.02;

/// Steps of a sphere that is moved ahead of the front until it is clear.
constexpr int kSetDownSteps = 20;

/// Sites to pass at most after one of the largest spheres found no room.
constexpr int kLongestPause = 256;

/// A fresh front that places more makes it worthwhile to start the search anew.
constexpr std::size_t kManySpheres = 200;

template <int Dim>
std::array<float, Dim> toFloat(const Vec<Dim>& v) {
    std::array<float, Dim> f;
    for (std::size_t d = 0; d < Dim; ++d) f[d] = static_cast<float>(v.c[d]);
    return f;
}

template <int Dim>
Vec<Dim> fromFloat(const std::array<float, Dim>& f) {
    Vec<Dim> v;
    for (std::size_t d = 0; d < Dim; ++d) v.c[d] = static_cast<double>(f[d]);
    return v;
}

}  // namespace

template <int Dim>
class BlockFront<Dim>::Work {
public:
    explicit Work(const FrontSettings<Dim>& settings) {
        state_.settings = settings;
        probe_ = static_cast<float>(settings.probe);
        least_ = static_cast<float>(settings.least);
        // No smaller than the largest radius: what nothing stops must take that one as well.
        largest_ = static_cast<float>(settings.maxRadius);
        if (static_cast<double>(largest_) < settings.maxRadius)
            largest_ = std::nextafter(largest_, std::numeric_limits<float>::infinity());
        common_ = static_cast<float>(settings.commonRadius);
    }

    void fill(const Box<Dim>& own, const Box<Dim>& search, const BlockSpheres<Dim>& around,
              RadiusPool& pool, SpeciesQueue* further, DomainSampler<Dim>& sampler,
              const std::function<bool()>& cancelled, BlockSpheres<Dim>& placed);

    std::size_t seeds_ = 0;

private:
    struct Plane {
        Vec<Dim> point, normal;      ///< on the wall; unit, into the domain
        std::uint32_t next = kNone;  ///< of the same sphere
    };
    /// A place of the front where a sphere could rest.
    struct FrontSite {
        Track<float, Dim> track;  ///< from the probe's radius on, from the pivot
        float base;               ///< along the sweep, at the probe's radius
        float side;
        std::array<std::uint32_t, Dim - 1> bodies;
        std::uint32_t pivot;
        std::uint32_t foreign;  ///< the block it lies in if that comes later; see towards()
    };
    /// What every new sphere asks of the sites around it: apart, since that is half the memory
    /// that a placement touches.
    struct SiteEnd {
        std::array<float, Dim> center;  ///< at radius `limit`
        float limit;                    ///< largest radius that fits, as far as is known
        std::uint32_t next;             ///< of the same pivot
        bool dead;
    };
    /// What is kept of each sphere.
    struct Lists {
        std::uint32_t site = kNone, plane = kNone;
    };
    /// What came of placing a sphere at a site.
    enum class Outcome { placed, blocked, foreign, wallLearned };
    using Site = typename Surroundings<Dim>::Site;

    std::uint32_t towards(const Vec<Dim>& x) const;
    void add(const Sphere<Dim>& sphere);
    void settle(std::uint32_t index);
    void findSites(std::uint32_t pivot, std::uint32_t only);
    void addLooseSites(std::uint32_t pivot);
    float baseOf(const Vec<Dim>& start);
    std::uint32_t addSite(std::uint32_t pivot, const Site& site);
    static bool reaches(const std::array<float, Dim>& center, float radius, const SiteEnd& end);
    void handOver(std::vector<HandedSite<Dim>>& handed) const;
    void takeOver(const BlockSpheres<Dim>& around);
    void keepOff(std::uint32_t intruder);
    void limitBy(std::uint32_t index, const Body<float, Dim>& body);
    Body<float, Dim> floatBody(std::uint32_t pivot, std::uint32_t body) const;
    void enqueue(std::uint32_t index);
    void runFront();
    void grow(std::uint32_t site);
    void giveUp(std::uint32_t index);
    bool setDown(std::uint32_t site, double radius, double depth, double beyond);
    bool placeFurther(std::uint32_t site);
    void countElement(const Vec<Dim>& center);
    bool centerAt(std::uint32_t site, double radius, Vec<Dim>& center) const;
    Outcome tryPlace(std::uint32_t index, double radius, Vec<Dim> center);
    bool polish(const FrontSite& site, double radius, Vec<Dim>& center);
    bool findPlane(const Vec<Dim>& pivot, const Vec<Dim>& x, double least, double reach,
                   Plane& plane, double& distance);
    bool overlaps(const Vec<Dim>& center, double radius) const;
    std::uint32_t keepPlane(std::uint32_t sphere, const Plane& plane);
    void learn(std::uint32_t pivot, const Plane& plane);
    int planesOf(std::uint32_t sphere) const;
    bool placeAt(const Vec<Dim>& center, double radius, double beyond);
    bool placePending(const Vec<Dim>& center, std::size_t k);
    void fillPlace(Vec<Dim> x);

    /// Looks now and then whether the pack is to be stopped: a step takes microseconds, beside
    /// heaps of spheres that stand milliseconds.
    void askToStop(std::size_t step) {
        if (step % 16 == 0 && *cancelled_ && (*cancelled_)()) stop_ = true;
    }

    const Sphere<Dim>& sphere(std::uint32_t i) const { return state_.spheres[i]; }
    double reachOf(double radius) const { return radius + state_.settings.reach; }

    BlockState<Dim> state_;
    float probe_, least_, largest_, common_;
    RadiusPool* pool_ = nullptr;
    SpeciesQueue* further_ = nullptr;
    std::vector<std::uint8_t> species_;  ///< beside state_.spheres where there are several
    const std::function<bool()>* cancelled_ = nullptr;
    bool stop_ = false;
    int wideWait_ = 0, widePause_ = 1;  ///< sites to pass before the next of the largest
    std::uint64_t arrived_ = 0;         ///< sites so far
    std::size_t standing_ = 0;          ///< spheres that stood before the block
    std::vector<Lists> lists_;          ///< beside state_.spheres
    std::vector<Plane> planes_;
    std::vector<FrontSite> sites_;
    std::vector<SiteEnd> ends_;     ///< beside `sites_`
    std::uint32_t unused_ = kNone;  ///< list of sites to use again
    BucketQueue queue_;             ///< of sites
    Surroundings<Dim> around_;
    std::vector<Site> found_;
    Plane wall_;                        ///< nearest to the candidate
    std::vector<std::uint32_t> local_;  ///< place here of each sphere around the block
    bool hasWall_ = false;
    PlaceSearch<Dim> search_;
};

template <int Dim>
void BlockFront<Dim>::Work::fill(const Box<Dim>& own, const Box<Dim>& search,
                                 const BlockSpheres<Dim>& around, RadiusPool& pool,
                                 SpeciesQueue* further, DomainSampler<Dim>& sampler,
                                 const std::function<bool()>& cancelled,
                                 BlockSpheres<Dim>& placed) {
    const FrontSettings<Dim>& settings = state_.settings;
    state_.origin = own.lo;
    state_.search = {search.lo - own.lo, search.hi - own.lo};
    state_.own = {state_.search.lo, own.hi - own.lo};
    state_.sampler = &sampler;
    pool_ = &pool;
    further_ = further;
    species_.clear();
    cancelled_ = &cancelled;
    stop_ = false;
    state_.spheres.clear();
    lists_.clear();
    planes_.clear();
    sites_.clear();
    ends_.clear();
    unused_ = kNone;
    arrived_ = 0;
    wideWait_ = 0;
    widePause_ = 1;
    const double low = settings.order == Order::sweep ? dot(state_.own.lo, settings.sweep) : 0.0;
    queue_.reset(static_cast<float>(low - settings.lead),
                 static_cast<float>(kBucket * settings.meanRadius));
    const Box<Dim> reach = state_.own.grown(2 * settings.commonRadius);
    // About twelve spheres a cell: full chunks, and few cells in reach.
    const double ball =
        std::min(settings.meanBall, 0.6 * Measure<Dim>::ball(settings.commonRadius));
    state_.cells.reset(reach, std::pow(20 * ball, 1.0 / Dim), settings.commonRadius);
    local_.assign(around.spheres.size(), kNone);
    for (std::size_t i = 0; i < around.spheres.size(); ++i) {
        const Sphere<Dim> local{around.spheres[i].center - state_.origin, around.spheres[i].radius};
        const double far = local.radius + (further_ ? 2 : 1) * settings.maxRadius;
        if (state_.own.squaredDistance(local.center) >= far * far) continue;
        local_[i] = static_cast<std::uint32_t>(state_.spheres.size());
        add(local);
    }
    takeOver(around);
    standing_ = state_.spheres.size();
    pool.refill();
    for (std::size_t k = 0; k < around.unexplored.size() && !stop_; ++k) {
        askToStop(k);
        const std::uint32_t i = local_[around.unexplored[k]];
        if (i == kNone) continue;
        around_.collect(state_.cells, sphere(i).center, reachOf(sphere(i).radius), i);
        Plane plane;
        double distance;
        if (findPlane(sphere(i).center, sphere(i).center, sphere(i).radius,
                      reachOf(sphere(i).radius), plane, distance))
            keepPlane(i, plane);
        findSites(i, Surroundings<Dim>::kAll);
    }
    runFront();
    if ((settings.order == Order::center || settings.order == Order::fifo) &&
        state_.owns(settings.middle - state_.origin))
        fillPlace(settings.middle - state_.origin);
    for (const bool centersOnly : {true, false}) {
        if (stop_ || (centersOnly && !state_.spheres.empty())) continue;
        search_.start(state_, centersOnly);
        for (Vec<Dim> place; !stop_ && search_.next(place);) {
            const std::size_t before = state_.spheres.size();
            fillPlace(place);
            const std::size_t filled = state_.spheres.size() - before;
            if (filled == 0) search_.skip();
            if (filled <= kManySpheres) continue;
            if (centersOnly) break;
            search_.start(state_, centersOnly);  // most cells that were left are covered now
        }
    }

    placed.clear();
    placed.spheres.reserve(state_.spheres.size() - standing_);
    for (std::size_t i = standing_; i < state_.spheres.size(); ++i)
        placed.spheres.push_back(
            {state_.spheres[i].center + state_.origin, state_.spheres[i].radius});
    if (further_) {
        species_.resize(state_.spheres.size());
        placed.species.assign(species_.begin() + static_cast<std::ptrdiff_t>(standing_),
                              species_.end());
    }
    handOver(placed.sites);
}

/// Lists the sites that lie in blocks to come.
template <int Dim>
void BlockFront<Dim>::Work::handOver(std::vector<HandedSite<Dim>>& handed) const {
    using Kind = typename HandedSite<Dim>::Support::Kind;
    for (std::size_t i = standing_; i < state_.spheres.size(); ++i)
        for (std::uint32_t s = lists_[i].site; s != kNone; s = ends_[s].next) {
            const FrontSite& site = sites_[s];
            if (ends_[s].dead || site.foreign == 0) continue;
            HandedSite<Dim>& to = handed.emplace_back();
            for (std::size_t b = 0; b < Dim - 1; ++b) {
                auto& support = to.supports[b];
                support = {Kind::none, {}, {}, 0.0};
                if (site.bodies[b] == kNoBody) continue;
                if (site.bodies[b] >= kWallBody) {
                    const Plane& plane = planes_[site.bodies[b] - kWallBody];
                    support = {Kind::wall, plane.point + state_.origin, plane.normal, 0.0};
                } else {
                    const Sphere<Dim>& other = sphere(site.bodies[b]);
                    support = {Kind::sphere, other.center + state_.origin, {}, other.radius};
                }
            }
            to.center = fromFloat<Dim>(ends_[s].center) + state_.origin;
            to.limit = ends_[s].limit;
            to.side = site.side;
            to.pivot = static_cast<std::uint32_t>(i - standing_);
            to.towards = site.foreign;
        }
}

/// Goes on with the sites that finished blocks have handed over, by what stands now.
template <int Dim>
void BlockFront<Dim>::Work::takeOver(const BlockSpheres<Dim>& around) {
    using Kind = typename HandedSite<Dim>::Support::Kind;
    for (const HandedSite<Dim>& handed : around.sites) {
        const std::uint32_t pivot = local_[handed.pivot];
        if (pivot == kNone) continue;
        Site site;
        site.limit = handed.limit;
        site.side = handed.side;
        std::array<Body<float, Dim>, Dim - 1> bodies{};
        for (std::size_t b = 0; b < Dim - 1; ++b) {
            const auto& support = handed.supports[b];
            site.bodies[b] = kNoBody;
            if (support.kind == Kind::none) continue;
            if (support.kind == Kind::wall) {
                site.bodies[b] = kWallBody + keepPlane(pivot, {support.at - state_.origin,
                                                               support.normal, kNone});
            } else {
                // Once more, for this site alone: not in the cells.
                site.bodies[b] = static_cast<std::uint32_t>(state_.spheres.size());
                state_.spheres.push_back({support.at - state_.origin, support.radius});
                lists_.emplace_back();
            }
            bodies[b] = floatBody(pivot, site.bodies[b]);
        }
        const Vec<Dim> center = handed.center - state_.origin;
        const auto from = toFloat(center - sphere(pivot).center);
        const float rolling = static_cast<float>(sphere(pivot).radius) + probe_;
        if (site.bodies[0] == kNoBody)
            site.track.makeLoose(rolling, toFloat(normalized(center - sphere(pivot).center)));
        else if (!site.track.make(rolling, probe_, bodies, site.side))
            continue;
        if (!site.track.at(0, site.start)) continue;
        site.end = from;
        const std::uint32_t index = addSite(pivot, site);
        if (index == kNone) continue;
        // What has been placed meanwhile.
        state_.cells.near(center, static_cast<double>(handed.limit), [&](std::uint32_t i) {
            if (i != pivot && reaches(toFloat(sphere(i).center),
                                      static_cast<float>(sphere(i).radius), ends_[index]))
                limitBy(index, floatBody(pivot, i));
            return !ends_[index].dead;
        });
    }
}

/// The neighbor block that holds a point outside this one, as HandedSite::towards names it; kDone
/// if all of that lies behind the front.
template <int Dim>
std::uint32_t BlockFront<Dim>::Work::towards(const Vec<Dim>& x) const {
    std::array<int, Dim> offset;
    bool ahead = false;
    for (int d = 0; d < Dim; ++d) {
        // The faces of the block itself: 0 and own.hi.
        offset[static_cast<std::size_t>(d)] = x[d] < 0 ? -1 : x[d] < state_.own.hi[d] ? 0 : 1;
        ahead = ahead || x[d] >= state_.own.hi[d];
    }
    return ahead ? BlockSpheres<Dim>::bit(offset) : kDone;
}

template <int Dim>
void BlockFront<Dim>::Work::add(const Sphere<Dim>& sphere) {
    state_.cells.add(sphere, static_cast<std::uint32_t>(state_.spheres.size()));
    state_.spheres.push_back(sphere);
    lists_.emplace_back();
}

/// Brings the front up to date with a sphere just added; `around_` and `wall_` are those of its
/// center.
template <int Dim>
void BlockFront<Dim>::Work::settle(std::uint32_t index) {
    if (hasWall_) keepPlane(index, wall_);
    keepOff(index);
    findSites(index, Surroundings<Dim>::kAll);
}

/// Adds the sites of a pivot: all, or those that rest on body `only`; of one that stood before the
/// block those in the block, since the others are known where they belong. `around_` holds its
/// spheres.
template <int Dim>
void BlockFront<Dim>::Work::findSites(std::uint32_t pivot, std::uint32_t only) {
    typename Surroundings<Dim>::Region inBlock;
    const typename Surroundings<Dim>::Region* region = nullptr;
    if (pivot < standing_) {
        for (std::size_t d = 0; d < Dim; ++d) {
            inBlock.lo[d] = static_cast<float>(state_.own.lo.c[d] - sphere(pivot).center.c[d]);
            inBlock.hi[d] = static_cast<float>(state_.own.hi.c[d] - sphere(pivot).center.c[d]);
        }
        region = &inBlock;
    }
    const Vec<Dim>& center = sphere(pivot).center;
    for (std::uint32_t p = lists_[pivot].plane; p != kNone; p = planes_[p].next) {
        const double above = dot(center - planes_[p].point, planes_[p].normal);
        around_.addPlane(toFloat(planes_[p].normal), static_cast<float>(above), kWallBody + p);
    }
    around_.findSites(static_cast<float>(sphere(pivot).radius), {probe_, least_, largest_}, only,
                      region, found_);
    for (const Site& site : found_) addSite(pivot, site);
    if (found_.empty() && only == Surroundings<Dim>::kAll && around_.reached() <= Dim)
        addLooseSites(pivot);
}

/// @return its place in `sites_`, or kNone if it is of no use.
template <int Dim>
std::uint32_t BlockFront<Dim>::Work::addSite(std::uint32_t pivot, const Site& site) {
    if (site.limit < least_) return kNone;
    const Vec<Dim>& center = sphere(pivot).center;
    SiteEnd end;
    Vec<Dim> start;
    for (int d = 0; d < Dim; ++d) {
        const auto at = static_cast<std::size_t>(d);
        start[d] = center[d] + static_cast<double>(site.start[at]);
        end.center[at] = static_cast<float>(center[d]) + site.end[at];
    }
    const bool own = state_.owns(start);
    const std::uint32_t foreign = own ? 0 : towards(start);
    if (!own && foreign == kDone) return kNone;
    std::uint32_t index = unused_;
    if (index == kNone) {
        index = static_cast<std::uint32_t>(sites_.size());
        sites_.emplace_back();
        ends_.emplace_back();
    } else {
        unused_ = ends_[index].next;
    }
    FrontSite& s = sites_[index];
    s.track = site.track;
    s.base = baseOf(start);
    s.side = site.side;
    s.bodies = site.bodies;
    s.pivot = pivot;
    s.foreign = foreign;
    end.limit = site.limit;
    end.dead = false;
    end.next = lists_[pivot].site;
    lists_[pivot].site = index;
    ends_[index] = end;
    enqueue(index);
    return index;
}

/// A front begins with too few bodies to rest on: then a sphere may rest on the pivot alone.
template <int Dim>
void BlockFront<Dim>::Work::addLooseSites(std::uint32_t pivot) {
    std::vector<Vec<Dim>> directions;
    if constexpr (Dim == 3) {
        constexpr int kAround = 16;
        const std::size_t count = around_.spheres.count;
        for (std::size_t i = 0; i < count; ++i) {
            // A little off each body that is in reach, for the largest of the common spheres:
            // smaller ones fit there as well.
            Vec<3> axis;
            for (int d = 0; d < 3; ++d)
                axis[d] = static_cast<double>(around_.spheres.to[static_cast<std::size_t>(d)][i]);
            const Body<float, 3> body = floatBody(pivot, around_.spheres.index[i]);
            const double l = length(axis);
            const double level = static_cast<double>(body.level + common_ * body.slope);
            const double height =
                level / (l * (sphere(pivot).radius + state_.settings.commonRadius));
            if (height >= 1) continue;
            axis *= 1 / l;
            const Vec<3> other = std::fabs(axis[0]) < 0.6 ? Vec<3>{{1, 0, 0}} : Vec<3>{{0, 1, 0}};
            const Vec<3> e1 = normalized(cross(axis, other));
            const Vec<3> e2 = cross(axis, e1);
            const double up = height - 1e-5;
            const double out = std::sqrt(std::max(0.0, 1 - up * up));
            for (int a = 0; a < kAround; ++a) {
                const double angle = 2 * kPi * a / kAround;
                directions.push_back(axis * up +
                                     (e1 * std::cos(angle) + e2 * std::sin(angle)) * out);
            }
        }
    }
    if (directions.empty()) directions.push_back(-state_.settings.sweep);
    const float rolling = static_cast<float>(sphere(pivot).radius) + probe_;
    for (const Vec<Dim>& n : directions) {
        Site site;
        site.track.makeLoose(rolling, toFloat(n));
        const float most = largest_ - probe_;
        const float t = around_.growth(site.track, most);
        if (most > 0 && !(t > 0)) continue;
        site.track.at(0, site.start);
        site.track.at(t, site.end);
        site.limit = t >= most ? largest_ : probe_ + t;
        site.side = 1;
        site.bodies.fill(kNoBody);
        addSite(pivot, site);
    }
}

/// Where a site stands in the order of the front, mm.
template <int Dim>
float BlockFront<Dim>::Work::baseOf(const Vec<Dim>& start) {
    const FrontSettings<Dim>& settings = state_.settings;
    switch (settings.order) {
        case Order::sweep:
            return static_cast<float>(dot(start, settings.sweep));
        case Order::wall:
            return static_cast<float>(-state_.sampler->signedDistance(start + state_.origin));
        case Order::center:
            return static_cast<float>(length(start + state_.origin - settings.middle));
        case Order::fifo:
            // Sixteen sites a bucket of the queue, which keeps their order.
            return static_cast<float>(kBucket * settings.meanRadius *
                                      static_cast<double>(arrived_++ / 16));
    }
    return 0;
}

/// Puts a site into the queue by what is known of it.
template <int Dim>
void BlockFront<Dim>::Work::enqueue(std::uint32_t index) {
    const FrontSite& site = sites_[index];
    if (site.foreign != 0) return;
    float key = site.base;
    const float limit = ends_[index].limit;
    if (limit < 0.99f * largest_ && common_ > probe_)
        key -= static_cast<float>(state_.settings.lead) * (std::min(limit, common_) - probe_) /
               (common_ - probe_);
    queue_.push(index, key);
}

template <int Dim>
Body<float, Dim> BlockFront<Dim>::Work::floatBody(std::uint32_t pivot, std::uint32_t body) const {
    const Vec<Dim>& center = sphere(pivot).center;
    if (body >= kWallBody) {
        const Plane& plane = planes_[body - kWallBody];
        return Body<float, Dim>::plane(toFloat(plane.normal),
                                       static_cast<float>(dot(center - plane.point, plane.normal)));
    }
    return Body<float, Dim>::sphere(toFloat(sphere(body).center - center),
                                    static_cast<float>(sphere(pivot).radius),
                                    static_cast<float>(sphere(body).radius));
}

/// Takes off a site's limit what `body`, seen from the site's pivot, leaves of it.
template <int Dim>
void BlockFront<Dim>::Work::limitBy(std::uint32_t index, const Body<float, Dim>& body) {
    const FrontSite& site = sites_[index];
    SiteEnd& end = ends_[index];
    const float rolling = static_cast<float>(sphere(site.pivot).radius) + probe_;
    const float most = end.limit - probe_;
    const float level = body.level + probe_ * body.slope;
    std::array<float, Dim> x;
    bool fits = site.track.at(0, x);
    float room = level;
    for (std::size_t d = 0; d < Dim; ++d) room -= x[d] * body.to[d];
    fits = fits && room > -kSlack * rolling * rolling;
    if (!fits) {  // not even the smallest
        end.dead = true;
        queue_.remove(index);
        return;
    }
    if (!(most > 0)) return;
    const float t = firstHit<Dim>(site.track, body, level, kTouching * rolling, most);
    if (t >= most) return;
    end.limit = probe_ + t;
    if (end.limit < least_) {
        end.dead = true;
        queue_.remove(index);
        return;
    }
    if (site.track.at(t, x))
        for (std::size_t d = 0; d < Dim; ++d)
            end.center[d] = static_cast<float>(sphere(site.pivot).center.c[d]) + x[d];
    enqueue(index);
}

/// Whether a sphere reaches into the largest one that a site would take.
template <int Dim>
bool BlockFront<Dim>::Work::reaches(const std::array<float, Dim>& center, float radius,
                                    const SiteEnd& end) {
    float square = 0;
    for (std::size_t d = 0; d < Dim; ++d)
        square += (end.center[d] - center[d]) * (end.center[d] - center[d]);
    const float least = radius + end.limit;
    return square < least * least * (1 - kSlack);
}

/// Updates the sites that sphere `intruder` reaches into; `around_` holds its neighbors.
template <int Dim>
void BlockFront<Dim>::Work::keepOff(std::uint32_t intruder) {
    const std::array<float, Dim> center = toFloat(sphere(intruder).center);
    const auto radius = static_cast<float>(sphere(intruder).radius);
    for (std::size_t i = 0; i < around_.spheres.count; ++i) {
        const std::uint32_t pivot = around_.spheres.index[i];
        std::uint32_t* link = &lists_[pivot].site;
        while (*link != kNone) {
            SiteEnd& end = ends_[*link];
            if (!end.dead && reaches(center, radius, end))
                limitBy(*link, floatBody(pivot, intruder));
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
void BlockFront<Dim>::Work::runFront() {
    for (std::size_t step = 0; !stop_; ++step) {
        const std::uint32_t site = queue_.pop();
        if (site == BucketQueue::kNone) return;
        grow(site);
        askToStop(step);
    }
}

/// Leaves a site alone; a block whose search reaches back to it may have a radius for it.
template <int Dim>
void BlockFront<Dim>::Work::giveUp(std::uint32_t index) {
    FrontSite& site = sites_[index];
    std::array<float, Dim> x;
    std::array<int, Dim> offset{};
    bool ahead = false;
    if (site.track.at(0, x))
        for (int d = 0; d < Dim; ++d) {
            const auto at = static_cast<std::size_t>(d);
            const double start = sphere(site.pivot).center[d] + static_cast<double>(x[at]);
            offset[at] = start >= state_.search.hi[d] ? 1 : 0;
            ahead = ahead || offset[at] > 0;
        }
    site.foreign = ahead ? BlockSpheres<Dim>::bit(offset) : kDone;
    ends_[index].dead = !ahead;
}

/// Places the largest pending radius that fits at a site, or gives the site up.
template <int Dim>
void BlockFront<Dim>::Work::grow(std::uint32_t index) {
    const FrontSettings<Dim>& settings = state_.settings;
    if (further_ && further_->isDue() && placeFurther(index)) {
        if (!ends_[index].dead) enqueue(index);
        return;
    }
    if (pool_->largest() > settings.wideRadius) {
        if (wideWait_ > 0) {
            --wideWait_;
        } else if (setDown(index, pool_->largest(), 0, 0)) {
            pool_->take(pool_->size() - 1);
            widePause_ = 1;
            if (!ends_[index].dead) enqueue(index);
            return;
        } else {
            wideWait_ = widePause_;
            widePause_ = std::min(2 * widePause_, kLongestPause);
        }
    }
    const float limit = ends_[index].limit;
    std::size_t k = pool_->countUpTo(static_cast<double>(limit));
    for (std::size_t attempt = 0; attempt < kAttempts && k > 0; ++attempt) {
        const double radius = (*pool_)[--k];
        Vec<Dim> center;
        if (!centerAt(index, radius, center)) continue;
        switch (tryPlace(index, radius, center)) {
            case Outcome::placed:
                pool_->take(k);
                countElement(center);
                return;
            case Outcome::wallLearned:
                // Queued again where the wall leaves it less room.
                if (ends_[index].dead || ends_[index].limit < limit) return;
                break;
            case Outcome::foreign:
                return;
            case Outcome::blocked:
                // The limit of one far larger than most is a guess, made without what lies beyond
                // the reach.
                if (radius > settings.commonRadius)
                    k = pool_->countUpTo(std::max(settings.commonRadius, 0.6 * radius));
                break;
        }
    }
    giveUp(index);
}

/// Places what is due of a further species at a site or ahead of it.
template <int Dim>
bool BlockFront<Dim>::Work::placeFurther(std::uint32_t index) {
    const SpeciesQueue::Due due = further_->next();
    // Across the faces to blocks to come as well: once this one has filled up to them, no place as
    // large is left there.
    if (!setDown(index, due.radius, due.depth, state_.settings.maxRadius)) return false;
    species_.resize(state_.spheres.size());
    species_.back() = due.species;
    further_->take();
    return true;
}

/// Draws which species comes next after a sphere of the first one, where others may be.
template <int Dim>
void BlockFront<Dim>::Work::countElement(const Vec<Dim>& center) {
    if (further_ && -state_.sampler->signedDistance(center + state_.origin) > further_->depth())
        further_->draw();
}

/// Places a sphere ahead of the front, as near to a site as there is room: one far larger than the
/// others would hardly ever fit between three of them.
/// @param depth   that its surface keeps from the wall, mm.
/// @param beyond  how far its center may lie across the faces to blocks to come, mm.
template <int Dim>
bool BlockFront<Dim>::Work::setDown(std::uint32_t index, double radius, double depth,
                                    double beyond) {
    const FrontSettings<Dim>& settings = state_.settings;
    // What snapping takes off must not be missing from the depth.
    const double room = radius + (depth > 0 ? depth + settings.quantum : 0);
    Vec<Dim> x;
    for (std::size_t d = 0; d < Dim; ++d) x.c[d] = static_cast<double>(ends_[index].center[d]);
    const Vec<Dim> ahead = settings.order == Order::sweep
                               ? settings.sweep
                               : normalized(x - sphere(sites_[index].pivot).center);
    x += ahead * (radius - static_cast<double>(ends_[index].limit));
    Vec<Dim> resting;
    if (radius <= static_cast<double>(ends_[index].limit) && centerAt(index, radius, resting))
        x = resting;
    // Away until it is clear of all; every step leaves some sphere or the wall behind.
    for (int step = 0;; ++step) {
        double most = 0;
        state_.cells.near(x, radius + settings.quantum, [&](std::uint32_t i) {
            const Sphere<Dim>& s = sphere(i);
            const double least = s.radius + radius + 1.5 * settings.quantum;
            const Vec<Dim> from = x - s.center;
            const double along = dot(from, ahead);
            const double inside = least * least - squaredLength(from);
            if (inside > 0) most = std::max(most, std::sqrt(along * along + inside) - along);
            return true;
        });
        Vec<Dim> by = ahead * (most > 0 ? most + settings.quantum : 0.0);
        Plane plane;
        double distance = room;
        if (most == 0 &&
            findPlane(sphere(sites_[index].pivot).center, x, room, room, plane, distance)) {
            // All that the last layers ask for would lie side by side at the wall.
            if (beyond > 0 && dot(plane.normal, ahead) < 0) return false;
            by = plane.normal * (room + 2 * settings.quantum - dot(x - plane.point, plane.normal));
        } else if (most == 0) {
            break;
        }
        x += by;
        if (step == kSetDownSteps || !state_.owns(x, beyond)) return false;
    }
    return placeAt(state_.snapped(x), radius, beyond);
}

/// Where a sphere of `radius` rests at a site, in double.
template <int Dim>
bool BlockFront<Dim>::Work::centerAt(std::uint32_t index, double radius, Vec<Dim>& center) const {
    const FrontSite& site = sites_[index];
    const Sphere<Dim>& pivot = sphere(site.pivot);
    const double open = radius + state_.settings.quantum;
    Track<double, Dim> track;
    if (site.bodies[0] == kNoBody) {
        Vec<Dim> n;
        for (int d = 0; d < Dim; ++d)
            n[d] = static_cast<double>(ends_[index].center[static_cast<std::size_t>(d)]) -
                   pivot.center[d];
        track.makeLoose(pivot.radius + open, normalized(n).c);
    } else {
        std::array<Body<double, Dim>, Dim - 1> bodies;
        for (std::size_t b = 0; b < Dim - 1; ++b) {
            const std::uint32_t body = site.bodies[b];
            if (body >= kWallBody) {
                const Plane& plane = planes_[body - kWallBody];
                bodies[b] = Body<double, Dim>::plane(plane.normal.c,
                                                     dot(pivot.center - plane.point, plane.normal));
            } else {
                bodies[b] = Body<double, Dim>::sphere((sphere(body).center - pivot.center).c,
                                                      pivot.radius, sphere(body).radius);
            }
        }
        if (!track.make(pivot.radius + open, open, bodies, static_cast<double>(site.side)))
            return false;
    }
    Vec<Dim> x;
    if (!track.at(0, x.c)) return false;
    center = pivot.center + x;
    return true;
}

/// The tangent plane of the wall point nearest to `x`, if one is closer than `reach`; where the
/// field says that none is, at least all that are closer than `least`.
template <int Dim>
bool BlockFront<Dim>::Work::findPlane(const Vec<Dim>& pivot, const Vec<Dim>& x, double least,
                                      double reach, Plane& plane, double& distance) {
    const FrontSettings<Dim>& settings = state_.settings;
    const Vec<Dim> global = x + state_.origin;
    if (settings.fieldDepth > reach + settings.fieldError &&
        -state_.sampler->signedDistance(global) > reach + settings.fieldError) {
        // The field may be wrong by more than it is said to be: what decides is asked of the wall.
        if (settings.fieldError == 0) return false;
        reach = least;
    }
    WallPoint<Dim> wall;
    if (!state_.sampler->nearestWall(global, reach, wall)) return false;
    distance = wall.distance;
    plane.point = wall.point - state_.origin;
    plane.normal = x - plane.point;
    plane.next = kNone;
    double l = length(plane.normal);
    if (!(l > 1e-9 * reach)) {  // on the wall
        plane.normal = pivot - plane.point;
        l = length(plane.normal);
        if (!(l > 0)) plane.normal = -settings.sweep, l = 1;
    }
    // Triangles do not say which side is inside; the pivot does.
    const double side = dot(pivot - plane.point, plane.normal);
    plane.normal *= (side < 0 ? -1.0 : 1.0) / l;
    return true;
}

/// Adds a wall to those that a sphere knows. @return its place in `planes_`.
template <int Dim>
std::uint32_t BlockFront<Dim>::Work::keepPlane(std::uint32_t sphere, const Plane& plane) {
    const auto index = static_cast<std::uint32_t>(planes_.size());
    planes_.push_back(plane);
    planes_.back().next = lists_[sphere].plane;
    lists_[sphere].plane = index;
    return index;
}

template <int Dim>
int BlockFront<Dim>::Work::planesOf(std::uint32_t sphere) const {
    int count = 0;
    for (std::uint32_t p = lists_[sphere].plane; p != kNone; p = planes_[p].next) ++count;
    return count;
}

/// Decides in double whether a sphere at `center` overlaps one of `around_`.
template <int Dim>
bool BlockFront<Dim>::Work::overlaps(const Vec<Dim>& center, double radius) const {
    const auto r = static_cast<float>(radius * (1 + 1e-4));  // more than lanes are off by
    const auto& near = around_.spheres;
    for (std::size_t i = 0; i < near.count; i += kLanes) {
        Float8 square{};
        for (std::size_t d = 0; d < Dim; ++d) {
            const Float8 to = load(&near.to[d][i]);
            square += to * to;
        }
        const Float8 least = load(&near.radius[i]) * (1 + 1e-6f) + r;
        const Int8 close = square < least * least;
        if (noneOf(close)) continue;
        bool disjoint = true;
        forEachSet(close, [&](std::size_t l) {
            const Sphere<Dim>& s = sphere(near.index[i + l]);
            const double exact = s.radius + radius;
            disjoint = disjoint && squaredLength(center - s.center) >= exact * exact;
        });
        if (!disjoint) return true;
    }
    return false;
}

template <int Dim>
typename BlockFront<Dim>::Work::Outcome BlockFront<Dim>::Work::tryPlace(std::uint32_t index,
                                                                        double radius,
                                                                        Vec<Dim> center) {
    const FrontSite& site = sites_[index];
    const Vec<Dim> guess = center;
    const FrontSettings<Dim>& settings = state_.settings;
    // Better filled by the block that comes there.
    const auto leave = [&] {
        sites_[index].foreign = towards(center);
        ends_[index].dead = sites_[index].foreign == kDone;
        return Outcome::foreign;
    };
    if (!state_.own.grown(0.5 * radius).contains(center)) return leave();
    if (!polish(site, radius, center)) return Outcome::blocked;
    center = state_.snapped(center);
    if (!state_.owns(center)) return leave();
    // One far larger than most has many neighbors, and most places are too small for it.
    if (radius > settings.commonRadius && !state_.isFree(center, radius)) return Outcome::blocked;
    around_.collect(state_.cells, center, reachOf(radius), kNone);
    if (overlaps(center, radius)) return Outcome::blocked;
    double distance = 0;
    hasWall_ =
        findPlane(sphere(site.pivot).center, center, radius, reachOf(radius), wall_, distance);
    if (!hasWall_ || distance >= radius) {
        add({center, radius});
        ends_[index].dead = true;  // and may be used again from here on
        settle(static_cast<std::uint32_t>(state_.spheres.size() - 1));
        return Outcome::placed;
    }
    // A wall that the pivot did not know. Learn its plane, unless the plane leaves this site
    // as it is: then it would come up again and again.
    if (planesOf(site.pivot) < kMaxPlanes &&
        dot(guess - wall_.point, wall_.normal) < radius * (1 - 1e-4)) {
        learn(site.pivot, wall_);
        return Outcome::wallLearned;
    }
    return Outcome::blocked;
}

/// Gives a pivot a wall that it did not know of.
template <int Dim>
void BlockFront<Dim>::Work::learn(std::uint32_t pivot, const Plane& plane) {
    const std::uint32_t wall = kWallBody + keepPlane(pivot, plane);
    const Body<float, Dim> body = floatBody(pivot, wall);
    for (std::uint32_t s = lists_[pivot].site; s != kNone; s = ends_[s].next)
        if (!ends_[s].dead) limitBy(s, body);
    around_.collect(state_.cells, sphere(pivot).center, reachOf(sphere(pivot).radius), pivot);
    findSites(pivot, wall);
}

/// Follows the resting place to curved walls, where the plane was only a first guess.
template <int Dim>
bool BlockFront<Dim>::Work::polish(const FrontSite& site, double radius, Vec<Dim>& center) {
    const Sphere<Dim>& pivot = sphere(site.pivot);
    const double slack = state_.settings.quantum;
    const double rolling = pivot.radius + radius + slack;
    if (site.bodies[0] == kNoBody) return true;
    std::size_t wallBodies = 0, wallAt = 0;
    for (std::size_t b = 0; b < Dim - 1; ++b)
        if (site.bodies[b] >= kWallBody) ++wallBodies, wallAt = b;
    if (wallBodies == 0) return true;
    Plane tangent{};
    double distance = 0;
    // One curved wall is followed to its true nearest point; two (a corner) are taken as planes.
    const int rounds = wallBodies == 1 ? 4 : 1;
    for (int round = 0; round < rounds; ++round) {
        const Vec<Dim> before = center;
        if (wallBodies == 1) {
            if (!findPlane(pivot.center, center, 2 * radius, 2 * radius, tangent, distance))
                return false;
            // In a corner another wall may be nearer: that one is not what the sphere rests on.
            const Plane& known = planes_[site.bodies[wallAt] - kWallBody];
            if (dot(tangent.normal, known.normal) < 0.8) tangent = known;
            // A flat wall: the place is right as it is.
            const double above = dot(center - tangent.point, tangent.normal);
            if (round == 0 && std::fabs(above - radius - slack) < 0.01 * slack) return true;
        }
        std::array<Contact<Dim>, Dim> contacts;
        contacts[0] = {pivot.center, {}, rolling, false};
        for (std::size_t b = 0; b < Dim - 1; ++b) {
            const std::uint32_t body = site.bodies[b];
            if (body >= kWallBody) {
                const Plane& plane =
                    wallBodies == 1 && b == wallAt ? tangent : planes_[body - kWallBody];
                contacts[b + 1] = {plane.point, plane.normal, radius + slack, true};
            } else {
                const Sphere<Dim>& other = sphere(body);
                contacts[b + 1] = {other.center, {}, other.radius + radius + slack, false};
            }
        }
        if (!moveToTouch<Dim>(contacts, slack, radius, center)) return false;
        if (squaredLength(center - before) < 0.01 * slack * slack) break;
    }
    return true;
}

/// Places a sphere at `center` if it is free there.
template <int Dim>
bool BlockFront<Dim>::Work::placeAt(const Vec<Dim>& center, double radius, double beyond) {
    if (!state_.owns(center, beyond)) return false;
    around_.collect(state_.cells, center, reachOf(radius), kNone);
    double distance = 0;
    hasWall_ = findPlane(center, center, radius, reachOf(radius), wall_, distance);
    if (overlaps(center, radius) || (hasWall_ && distance < radius) ||
        !state_.sampler->contains(center + state_.origin))
        return false;
    add({center, radius});
    settle(static_cast<std::uint32_t>(state_.spheres.size() - 1));
    return true;
}

/// The same with the `k`-th pending radius.
template <int Dim>
bool BlockFront<Dim>::Work::placePending(const Vec<Dim>& center, std::size_t k) {
    if (!placeAt(center, (*pool_)[k], 0)) return false;
    pool_->take(k);
    countElement(center);
    return true;
}

/// Starts a fresh front at a place that none has reached.
template <int Dim>
void BlockFront<Dim>::Work::fillPlace(Vec<Dim> x) {
    const FrontSettings<Dim>& settings = state_.settings;
    double far = 1.5 * settings.commonRadius;
    double room = state_.clearance(x, far);
    if (room >= far) {
        far = 1.5 * settings.maxRadius;
        room = state_.clearance(x, far);
    }
    // To where there is most room, so that the largest pending radius that fits is taken.
    state_.climb(x, room, far);
    pool_->refill();
    const std::size_t fitting = pool_->countUpTo(room - 2 * settings.quantum);
    if (fitting == 0) return;
    // Down the sweep until it touches something.
    const double radius = (*pool_)[fitting - 1];
    Vec<Dim> low = x;
    for (int step = 0; settings.order == Order::sweep && step < 200; ++step) {
        const double free = state_.clearance(low, far) - radius - settings.quantum;
        if (free < 1e-6 * radius) break;
        const Vec<Dim> y = low - settings.sweep * free;
        if (!state_.owns(y)) break;
        low = y;
    }
    // Snapping moves the center by less than a quantum; step back where that was too much.
    Vec<Dim> center = state_.snapped(low);
    for (int step = 0; step < 8 && state_.clearance(center, far) < radius; ++step)
        center = state_.snapped(low + settings.sweep * (settings.quantum * (2 << step)));
    if (placePending(center, fitting - 1) || placePending(state_.snapped(x), fitting - 1) ||
        placePending(state_.snapped(x), 0)) {
        ++seeds_;
        runFront();
    }
}

template <int Dim>
BlockFront<Dim>::BlockFront(const FrontSettings<Dim>& settings)
    : work_(std::make_unique<Work>(settings)) {}

template <int Dim>
BlockFront<Dim>::~BlockFront() = default;

template <int Dim>
void BlockFront<Dim>::fill(const Box<Dim>& own, const Box<Dim>& search,
                           const BlockSpheres<Dim>& around, RadiusPool& pool, SpeciesQueue* further,
                           DomainSampler<Dim>& sampler, const std::function<bool()>& cancelled,
                           BlockSpheres<Dim>& placed) {
    work_->fill(own, search, around, pool, further, sampler, cancelled, placed);
}

template <int Dim>
std::size_t BlockFront<Dim>::seeds() const {
    return work_->seeds_;
}

template class BlockFront<2>;
template class BlockFront<3>;

}  // namespace vdbpack
