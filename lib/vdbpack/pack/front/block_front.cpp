#include "vdbpack/pack/front/block_front.h"

#include "vdbpack/pack/front/front.h"
#include "vdbpack/pack/front/handover.h"
#include "vdbpack/pack/front/placement.h"
#include "vdbpack/pack/front/vacancy_search.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbpack {

namespace {

/// Pending radii tried at a site, from the largest that seems to fit.
constexpr std::size_t kAttempts = 3;

/// Most sites to pass after one of the largest spheres found no room.
constexpr int kLongestPause = 256;

/// Height over a wall, in largest common radii, below which another wall makes a thin part. Radii 1
/// to 2, solid fractions of slabs of 9 and 12 mm and of tubes of radius 6 mm: 0.581, 0.600 and
/// 0.547 at 2; 0.590, 0.600 and 0.547 at 2.5; 0.591, 0.600 and 0.556 at 3; 0.591, 0.599 and 0.561
/// at 3.5.
constexpr double kBroad = 3;

/// Mean radius that spheres on broad walls are to have, in mean radii: small ones of the second
/// layer lie at the wall as well, and densifying pulls large ones off it.
constexpr double kMeanOnWalls = 1.01;

/// A fresh front that places more makes it worthwhile to start the search over.
constexpr std::size_t kManySpheres = 200;

/// Factors on radii that differ by no more than this share are the same.
constexpr double kSameFactor = 3e-4, kNearlySameFactor = 5e-4;

}  // namespace

template <int Dim>
class BlockFront<Dim>::Work {
public:
    explicit Work(const FrontSettings<Dim>& settings) : front_(settings), placement_(front_) {}

    void fill(const Place& place, const BlockSpheres<Dim>& around, std::vector<RadiusPool>& pools,
              SpeciesQueue* further, DomainSampler<Dim>& sampler,
              const std::function<bool()>& cancelled, BlockSpheres<Dim>& placed);

    std::size_t seeds_ = 0;

private:
    using Placer = Placement<Dim>;

    void addExisting(const BlockSpheres<Dim>& around);
    void searchVacancies();
    void collect(BlockSpheres<Dim>& placed);
    void runFront();
    void grow(std::uint32_t site);
    bool growAs(std::uint32_t site, const LocalSize& size);
    bool restLocally(std::uint32_t site, const LocalSize& size, double drawn, double& radius,
                     Vec<Dim>& center);
    bool isOnBroadWall(std::uint32_t site, double common);
    bool placeDrawn(std::uint32_t site, const LocalSize& size, const FrontLengths& lengths,
                    bool onWall);
    void countOnWall(double drawn, const RadiusPool& pool) {
        wallBalance_ += drawn - kMeanOnWalls * pool.mean();
    }
    bool placeWide(std::uint32_t site, const LocalSize& size);
    bool placeFurther(std::uint32_t site);
    void countElement(const Vec<Dim>& center);
    bool placePending(const Vec<Dim>& center, const LocalSize& size, std::size_t k);
    void fillVacancy(Vec<Dim> x);

    /// What is requested where the largest sphere at a site would be.
    LocalSize sizeAtSite(std::uint32_t site) const {
        return front_.block.local ? front_.block.sizeAt(front_.sites.center(site)) : LocalSize{};
    }
    /// A radius of a pool where it has this factor, mm.
    double radiusOf(const LocalSize& size, double drawn) const {
        if (!front_.block.local) return drawn;
        return static_cast<double>(static_cast<float>(drawn * size.factor)) +
               front_.block.local->layer();
    }
    /// The same of the `k`-th smallest that a group has pending.
    double pendingRadius(const LocalSize& size, std::size_t k) const {
        return radiusOf(size, (*pools_)[size.group][k]);
    }
    /// How many of the pending radii of a group are <= `r` (mm) where they have this factor.
    std::size_t fitting(const LocalSize& size, double r) const {
        if (const auto* local = front_.block.local)
            r = (std::min(r, front_.block.settings.maxRadius) - local->layer()) / size.factor;
        return (*pools_)[size.group].countUpTo(r);
    }

    /// Looks now and then whether the pack is to be stopped: a step takes microseconds, next to
    /// clusters of existing spheres milliseconds.
    void askToStop(std::size_t step) {
        if (step % 16 == 0 && *cancelled_ && (*cancelled_)()) stop_ = true;
    }

    Front<Dim> front_;
    Placer placement_;
    VacancySearch<Dim> search_;
    std::vector<RadiusPool>* pools_ = nullptr;
    SpeciesQueue* further_ = nullptr;
    std::vector<std::uint8_t> species_;  ///< beside the block's spheres where there are several
    const std::function<bool()>* cancelled_ = nullptr;
    bool stop_ = false;
    double wallBalance_ = 0;            ///< sum of radii on broad walls, less what it is to be, mm
    int wideWait_ = 0, widePause_ = 1;  ///< sites to pass before the next of the largest
};

template <int Dim>
void BlockFront<Dim>::Work::fill(const Place& place, const BlockSpheres<Dim>& around,
                                 std::vector<RadiusPool>& pools, SpeciesQueue* further,
                                 DomainSampler<Dim>& sampler,
                                 const std::function<bool()>& cancelled,
                                 BlockSpheres<Dim>& placed) {
    BlockState<Dim>& block = front_.block;
    const FrontSettings<Dim>& settings = block.settings;
    block.origin = place.own.lo;
    block.search = {place.search.lo - block.origin, place.search.hi - block.origin};
    block.own = {block.search.lo, place.own.hi - block.origin};
    block.laterBehind = place.laterBehind;
    block.sampler = &sampler;
    block.local = place.local;
    if (place.lengths) static_cast<FrontLengths&>(block.settings) = *place.lengths;
    pools_ = &pools;
    further_ = further;
    species_.clear();
    cancelled_ = &cancelled;
    stop_ = false;
    wideWait_ = 0;
    widePause_ = 1;
    wallBalance_ = 0;
    front_.clear();
    addExisting(around);
    runFront();
    if ((settings.order == Order::center || settings.order == Order::fifo) &&
        block.owns(settings.middle - block.origin))
        fillVacancy(settings.middle - block.origin);
    searchVacancies();
    collect(placed);
}

/// Starts the front from the spheres around the block.
template <int Dim>
void BlockFront<Dim>::Work::addExisting(const BlockSpheres<Dim>& around) {
    BlockState<Dim>& block = front_.block;
    const FrontSettings<Dim>& settings = block.settings;
    // About twelve spheres a cell: full chunks, and few cells in reach.
    const double ball =
        std::min(settings.meanBall, 0.6 * Measure<Dim>::ball(settings.commonRadius));
    block.cells.reset(block.own.grown(2 * settings.commonRadius), std::pow(20 * ball, 1.0 / Dim),
                      settings.commonRadius, block.local != nullptr);
    std::vector<std::uint32_t> local(around.spheres.size(), FrontSites<Dim>::kNone);
    for (std::size_t i = 0; i < around.spheres.size(); ++i) {
        const Sphere<Dim> s{around.spheres[i].center - block.origin, around.spheres[i].radius};
        const double far = s.radius + (further_ ? 2 : 1) * settings.maxRadius;
        if (block.own.squaredDistance(s.center) >= far * far) continue;
        local[i] = front_.add(s);
    }
    takeOver(around, local, front_);
    front_.standing = block.spheres.size();
    for (RadiusPool& pool : *pools_) pool.refill();
    for (std::size_t k = 0; k < around.unexplored.size() && !stop_; ++k) {
        askToStop(k);
        const std::uint32_t i = local[around.unexplored[k]];
        if (i != FrontSites<Dim>::kNone) placement_.explore(i);
    }
}

/// Starts a fresh front from every vacancy that is left.
template <int Dim>
void BlockFront<Dim>::Work::searchVacancies() {
    const BlockState<Dim>& block = front_.block;
    for (const bool centersOnly : {true, false}) {
        if (stop_ || (centersOnly && !block.spheres.empty())) continue;
        search_.start(block, centersOnly);
        for (Vec<Dim> vacancy; !stop_ && search_.next(vacancy);) {
            const std::size_t before = block.spheres.size();
            fillVacancy(vacancy);
            const std::size_t filled = block.spheres.size() - before;
            if (filled == 0) search_.skip();
            if (filled <= kManySpheres) continue;
            if (centersOnly) break;
            search_.start(block, centersOnly);  // most cells that were left are covered now
        }
    }
}

template <int Dim>
void BlockFront<Dim>::Work::collect(BlockSpheres<Dim>& placed) {
    const BlockState<Dim>& block = front_.block;
    placed.clear();
    placed.spheres.reserve(block.spheres.size() - front_.standing);
    for (std::size_t i = front_.standing; i < block.spheres.size(); ++i)
        placed.spheres.push_back({block.spheres[i].center + block.origin, block.spheres[i].radius});
    if (further_) {
        species_.resize(block.spheres.size());
        placed.species.assign(species_.begin() + static_cast<std::ptrdiff_t>(front_.standing),
                              species_.end());
    }
    handOver(front_, placed.sites);
}

template <int Dim>
void BlockFront<Dim>::Work::runFront() {
    for (std::size_t step = 0; !stop_; ++step) {
        const std::uint32_t site = front_.sites.pop();
        if (site == FrontSites<Dim>::kNone) return;
        grow(site);
        askToStop(step);
    }
}

/// Places the largest pending radius that fits at a site, or gives the site up.
template <int Dim>
void BlockFront<Dim>::Work::grow(std::uint32_t site) {
    const LocalSize size = sizeAtSite(site);
    if ((further_ && further_->isDue() && placeFurther(site)) || placeWide(site, size)) {
        if (!front_.sites.isRemoved(site)) front_.sites.enqueue(site);
        return;
    }
    if (growAs(site, size)) return;
    // Smaller spheres there may lie where other sizes are requested.
    Vec<Dim> start;
    if (front_.block.local &&
        front_.sites.restingCenter(
            site, static_cast<double>(front_.sites.probe(front_.sites.pivot(site))), start)) {
        const LocalSize other = front_.block.sizeAt(start);
        if (!LocalLengths<Dim>::areAlike(size, other) && growAs(site, other)) return;
    }
    front_.sites.giveUp(site);
}

/// Places the largest pending radius of the sizes requested nearby that fits at a site. @return
/// whether the site is settled: taken, left to another block, or queued again.
template <int Dim>
bool BlockFront<Dim>::Work::growAs(std::uint32_t site, const LocalSize& size) {
    using Outcome = typename Placer::Outcome;
    const BlockState<Dim>& block = front_.block;
    RadiusPool& pool = (*pools_)[size.group];
    const FrontLengths lengths = block.lengthsOf(size);
    const double common = lengths.commonRadius;
    const bool even = block.settings.evenSizes;
    const bool onWall = even && isOnBroadWall(site, common);
    if (even && (onWall || pool.hasGivenLarge()) && front_.sites.isOpen(site) &&
        placeDrawn(site, size, lengths, onWall))
        return true;
    const float limit = front_.sites.limit(site);
    std::size_t k = fitting(size, static_cast<double>(limit));
    for (std::size_t attempt = 0; attempt < kAttempts && k > 0; ++attempt) {
        const double drawn = pool[--k];
        double radius = radiusOf(size, drawn);
        Vec<Dim> center;
        if (!front_.sites.restingCenter(site, radius, center)) continue;
        if (block.local && !restLocally(site, size, drawn, radius, center)) continue;
        switch (placement_.placeAtSite(site, radius, center, size, lengths)) {
            case Outcome::placed:
                pool.take(k);
                countElement(center);
                if (onWall) countOnWall(drawn, pool);
                return true;
            case Outcome::wallLearned:
                // Queued again where the wall leaves it less room.
                if (front_.sites.isRemoved(site) || front_.sites.limit(site) < limit) return true;
                break;
            case Outcome::foreign:
                return true;
            case Outcome::blocked:
                // The limit for one far larger than most is an estimate without the bodies beyond
                // the reach.
                if (radius > common) k = fitting(size, std::max(common, 0.6 * radius));
                // So it is next to finer spheres.
                else if (block.local && placement_.tighten(site, radius, center))
                    return true;
                break;
        }
    }
    return false;
}

/// Finds the radius of one of a pool where its sphere rests at a site: its factor is that of its
/// center. @return false if other sizes are requested there, or it does not fit.
template <int Dim>
bool BlockFront<Dim>::Work::restLocally(std::uint32_t site, const LocalSize& size, double drawn,
                                        double& radius, Vec<Dim>& center) {
    constexpr int kTurns = 3;
    LocalSize used = size;
    for (int turn = 0; turn < kTurns; ++turn) {
        const LocalSize here = front_.block.sizeAt(center);
        if (!LocalLengths<Dim>::areAlike(size, here)) return false;
        if (std::fabs(here.factor - used.factor) <= kSameFactor * here.factor) return true;
        used = here;
        radius = radiusOf(here, drawn);
        if (radius > static_cast<double>(front_.sites.limit(site)) ||
            radius > front_.block.settings.maxRadius ||
            !front_.sites.restingCenter(site, radius, center))
            return false;
    }
    // Where the field is so steep that no radius was found, the site is left.
    const LocalSize here = front_.block.sizeAt(center);
    return here.group == used.group &&
           std::fabs(here.factor - used.factor) <= kNearlySameFactor * here.factor;
}

/// Whether a sphere at a site touches a wall that has no other wall in front of it. In thin parts,
/// where it has, only the largest spheres that fit leave no vacancies.
/// @param common  largest common radius there, mm.
template <int Dim>
bool BlockFront<Dim>::Work::isOnBroadWall(std::uint32_t site, double common) {
    const TangentPlane<Dim>* const wall = front_.sites.wall(site);
    if (!wall) return false;
    const BlockState<Dim>& block = front_.block;
    const Vec<Dim> center = front_.sites.center(site);
    const double above = dot(center - wall->point, wall->normal);
    const auto depthAt = [&](double height) {
        return -block.sampler->signedDistance(center + wall->normal * (height - above) +
                                              block.origin);
    };
    // Towards another wall the depth falls; beside one it stays.
    const double height = kBroad * common, step = 0.5 * common;
    return depthAt(height + step) > depthAt(height) - 0.5 * step;
}

/// Places the next radius drawn at an open site. On a wall, and where a pack begins, most sites are
/// open: the largest pending radius in each of them would gather the largest spheres there. Where a
/// further body limits the sphere, the wall gets smaller ones; to make up for these, the larger of
/// two radii drawn is placed as long as the mean of those on walls is too small.
/// @return false if the site is still open to pending radii
template <int Dim>
bool BlockFront<Dim>::Work::placeDrawn(std::uint32_t site, const LocalSize& size,
                                       const FrontLengths& lengths, bool onWall) {
    RadiusPool& pool = (*pools_)[size.group];
    double drawn = pool.draw();
    if (onWall && wallBalance_ < 0) {
        const double other = pool.draw();
        pool.giveBack(std::min(drawn, other));
        drawn = std::max(drawn, other);
    }
    using Outcome = typename Placer::Outcome;
    double radius = radiusOf(size, drawn);
    Vec<Dim> center;
    Outcome outcome = Outcome::blocked;
    if (front_.sites.restingCenter(site, radius, center) &&
        (!front_.block.local || restLocally(site, size, drawn, radius, center)))
        outcome = placement_.placeAtSite(site, radius, center, size, lengths);
    if (outcome == Outcome::placed) {
        countElement(center);
        if (onWall) countOnWall(drawn, pool);
        return true;
    }
    pool.giveBack(drawn);
    return outcome == Outcome::foreign || front_.sites.isRemoved(site) ||
           !front_.sites.isOpen(site);
}

/// Places the largest pending radius ahead of the front if it is one of the wide ones; after a
/// failure, passes ever more sites before the next attempt.
template <int Dim>
bool BlockFront<Dim>::Work::placeWide(std::uint32_t site, const LocalSize& size) {
    RadiusPool& pool = (*pools_)[size.group];
    const std::size_t last = pool.size() - 1;
    if (!(pendingRadius(size, last) > front_.block.lengthsOf(size).wideRadius)) return false;
    if (wideWait_ > 0) {
        --wideWait_;
        return false;
    }
    if (placement_.setDown(site, pendingRadius(size, last), 0, 0)) {
        pool.take(last);
        widePause_ = 1;
        return true;
    }
    wideWait_ = widePause_;
    widePause_ = std::min(2 * widePause_, kLongestPause);
    return false;
}

/// Places the sphere that is due of a further species at a site or ahead of it.
template <int Dim>
bool BlockFront<Dim>::Work::placeFurther(std::uint32_t site) {
    const SpeciesQueue::Due due = further_->next();
    // Across the faces to later blocks as well: once this block has filled up to them, no vacancy
    // as large is left there.
    if (!placement_.setDown(site, due.radius, due.depth, front_.block.settings.maxRadius))
        return false;
    species_.resize(front_.block.spheres.size());
    species_.back() = due.species;
    further_->take();
    return true;
}

/// Draws which species comes next after a sphere of the first one, where others may be.
template <int Dim>
void BlockFront<Dim>::Work::countElement(const Vec<Dim>& center) {
    if (!further_) return;
    const BlockState<Dim>& block = front_.block;
    if (-block.sampler->signedDistance(center + block.origin) > further_->depth()) further_->draw();
}

/// Places the `k`-th pending radius of a group at `center` if it is free there.
template <int Dim>
bool BlockFront<Dim>::Work::placePending(const Vec<Dim>& center, const LocalSize& size,
                                         std::size_t k) {
    const BlockState<Dim>& block = front_.block;
    const LocalSize here = block.sizeAt(center);
    if (here.group != size.group) return false;
    const double radius = pendingRadius(here, k);
    if (block.local && radius > block.settings.maxRadius) return false;
    if (!placement_.placeAt(center, radius, 0)) return false;
    (*pools_)[size.group].take(k);
    countElement(center);
    return true;
}

/// Starts a fresh front at a vacancy.
template <int Dim>
void BlockFront<Dim>::Work::fillVacancy(Vec<Dim> x) {
    const BlockState<Dim>& block = front_.block;
    const FrontSettings<Dim>& settings = block.settings;
    const Vec<Dim> found = x;
    LocalSize size = block.sizeAt(x);
    double far = 1.5 * block.lengthsOf(size).commonRadius;
    double room = block.clearance(x, far);
    if (room >= far) {
        far = 1.5 * block.lengthsOf(size).maxRadius;
        room = block.clearance(x, far);
    }
    // To where there is most room, so that the largest pending radius that fits is taken.
    block.climb(x, room, far, block.lengthsOf(size).minRadius);
    for (RadiusPool& pool : *pools_) pool.refill();
    if (block.local) {
        const LocalSize there = block.sizeAt(x);
        if (fitting(there, room - 2 * settings.quantum) > 0) {
            size = there;
        } else {  // larger ones are requested there
            x = found;
            room = block.clearance(x, far);
        }
    }
    const std::size_t k = fitting(size, room - 2 * settings.quantum);
    if (k == 0) return;
    // Down the sweep until it touches something.
    const double radius = pendingRadius(size, k - 1);
    Vec<Dim> low = x;
    for (int step = 0; settings.order == Order::sweep && step < 200; ++step) {
        const double free = block.clearance(low, far) - radius - settings.quantum;
        if (free < 1e-6 * radius) break;
        const Vec<Dim> y = low - settings.sweep * free;
        if (!block.owns(y)) break;
        if (block.local && !LocalLengths<Dim>::areAlike(size, block.sizeAt(y))) break;
        low = y;
    }
    // Snapping moves the center by less than a quantum; step back where that was too much.
    Vec<Dim> center = block.snapped(low);
    for (int step = 0; step < 8 && block.clearance(center, far) < radius; ++step)
        center = block.snapped(low + settings.sweep * (settings.quantum * (2 << step)));
    if (placePending(center, size, k - 1) || placePending(block.snapped(x), size, k - 1) ||
        placePending(block.snapped(x), size, 0)) {
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
void BlockFront<Dim>::fill(const Place& place, const BlockSpheres<Dim>& around,
                           std::vector<RadiusPool>& pools, SpeciesQueue* further,
                           DomainSampler<Dim>& sampler, const std::function<bool()>& cancelled,
                           BlockSpheres<Dim>& placed) {
    work_->fill(place, around, pools, further, sampler, cancelled, placed);
}

template <int Dim>
std::size_t BlockFront<Dim>::seeds() const {
    return work_->seeds_;
}

template class BlockFront<2>;
template class BlockFront<3>;

}  // namespace vdbpack
