#include "vdbpack/pack/front/block_front.h"

#include "vdbpack/pack/front/block_work.h"
#include "vdbpack/pack/front/handover.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbpack {

namespace {

/// A fresh front that places more makes it worthwhile to start the search over.
constexpr std::size_t kManySpheres = 200;

}  // namespace

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
    for (int step = 0; sweeps(settings.order) && step < 200; ++step) {
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
