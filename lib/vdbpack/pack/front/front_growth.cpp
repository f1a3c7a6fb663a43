// A front advances: which sphere is placed at a site.
#include "vdbpack/pack/front/block_work.h"

#include <algorithm>
#include <cmath>

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

/// Factors on radii that differ by no more than this share are the same.
constexpr double kSameFactor = 3e-4, kNearlySameFactor = 5e-4;

}  // namespace

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

template <int Dim>
void BlockFront<Dim>::Work::countOnWall(double drawn, const RadiusPool& pool) {
    wallBalance_ += drawn - kMeanOnWalls * pool.mean();
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

template class BlockFront<2>::Work;
template class BlockFront<3>::Work;

}  // namespace vdbpack
