#include "vdbpack/densify/relaxation.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace vdbpack {

namespace {

/// Radii are enlarged by this share while spheres are pushed apart: an overlap that is small
/// beside it is none of the true radii. It costs three times as much of the solid fraction.
constexpr double kDelta = 4e-4;
/// Share of an overlap that a sphere gains as velocity in a step.
constexpr float kPush = 0.3f;
/// Overlaps below this share of delta are none of the true radii, with a margin for rounding.
constexpr float kApart = 0.97f;
/// Share of its velocity that a sphere keeps besides where motion is damped.
constexpr float kTurning = 0.7f;
/// Where the worst overlap is small, and yet falls by less than the factor kStays in half a memory,
/// the spheres that have it exchange positions with smaller ones.
constexpr float kNearlyApart = 0.01f, kStays = 0.8f;

/// As fine as the front's quantum, unless the largest spheres would not fit into 2^28 quanta; mm.
template <int Dim>
double quantumOf(const std::vector<Sphere<Dim>>& spheres, Ranks* ranks) {
    double sum = 0, most = 0;
    for (const auto& s : spheres) {
        sum += s.radius;
        most = std::max(most, s.radius);
    }
    sum = sumOver(ranks, sum);
    most = maxOver(ranks, most);
    if (!(sum > 0)) return 1;
    const double mean = sum / static_cast<double>(sumOver(ranks, std::uint64_t{spheres.size()}));
    return std::max(std::exp2(std::floor(std::log2(mean)) - 22),
                    std::exp2(std::ceil(std::log2(most)) - 27));
}

/// Whether a relaxation is stuck with a few overlaps, asked in every step.
class Stuck {
public:
    explicit Stuck(const RelaxationPace& pace)
        : every_(static_cast<int>(0.5 / (1 - pace.inertia)) + 1) {}

    bool isStuck(float worst) {
        if (++steps_ < every_) return false;
        steps_ = 0;
        const bool stuck = worst < kNearlyApart && worst > kStays * before_;
        before_ = worst;
        return stuck;
    }

private:
    int every_;  // steps in half a memory
    int steps_ = 0;
    float before_ = 1;  // the worst overlap then
};

}  // namespace

template <int Dim>
void Relaxation<Dim>::Slots::resize(std::size_t n) {
    bodies.resize(n + 8);  // whole eights may be read
    before.resize(n + 8);
    homes.resize(n);
    listed.resize(n + 8);
    labels.resize(n);
    places.resize(n);
    vicinities.resize(n);
}

template <int Dim>
Relaxation<Dim>::Relaxation(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
                            std::size_t fixed, const std::vector<std::int32_t>& regions,
                            std::uint64_t seed, bool graded)
    : quantum_(quantumOf(spheres, nullptr)),
      cell_(domain.cell()),
      given_(spheres.size()),
      regions_(regions),
      fixed_(static_cast<std::uint32_t>(fixed)),
      seed_(seed),
      graded_(graded),
      walls_(domain, quantum_) {
    const std::size_t n = spheres.size();
    if (n > 0x7fffffff)
        throw ResourceError(fmt::format("densify: {} {} are more than 2^31 - 1; pack in parts", n,
                                        Measure<Dim>::kSpheres));
    if (n == 0 || fixed == n) return;
    for (int d = 0; d < Dim; ++d) {
        if (!cell_.isAlong(d)) continue;
        const auto at = static_cast<std::size_t>(d);
        cellLow_[at] = static_cast<std::int64_t>(std::ceil(cell_.box.lo[d] / quantum_));
        // Rounding to whole quanta does not matter, as for radii and positions.
        period_[at] = static_cast<std::int64_t>(std::nearbyint(cell_.length(d) / quantum_));
    }
    setRadii(spheres);
    placeSlots(spheres);
    ready_ = true;
    sort();
}

template <int Dim>
Relaxation<Dim>::Relaxation(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
                            Ranks& ranks, const std::vector<std::uint32_t>& labels, double further,
                            std::uint64_t seed)
    : quantum_(quantumOf(spheres, &ranks)),
      fixed_(0),
      seed_(seed),
      walls_(domain, quantum_),
      ranks_(&ranks),
      further_(static_cast<float>(further / quantum_)),
      slots_(labels) {
    const std::uint64_t all = sumOver(&ranks, std::uint64_t{spheres.size()});
    if (all > 0x7fffffff)
        throw ResourceError(fmt::format("densify: {} {} are more than 2^31 - 1; pack in parts", all,
                                        Measure<Dim>::kSpheres));
    if (all == 0) return;
    setRadii(spheres);
    placeSlots(spheres);
    now_.labels = now_.places = labels;
    isNearSlot_.assign(spheres.size(), 0);
    ready_ = true;
    sort();
}

template <int Dim>
void Relaxation<Dim>::setRadii(const std::vector<Sphere<Dim>>& spheres) {
    double least = std::numeric_limits<double>::infinity(), smallest = least, most = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const double r = spheres[i].radius;
        most = std::max(most, r);
        smallest = std::min(smallest, r);
        if (i >= fixed_) least = std::min(least, r);
    }
    least = minOver(ranks_, least);
    smallest = minOver(ranks_, smallest);
    most = maxOver(ranks_, most);
    least_ = static_cast<float>(least / quantum_);
    most_ = static_cast<float>(most / quantum_);
    smallest_ = static_cast<float>(smallest / quantum_);
    perLeast_ = 1 / least_;
    setDelta(kDelta);
    setMargins();
}

template <int Dim>
void Relaxation<Dim>::setDelta(double delta) {
    // Rounding to whole quanta must not matter.
    delta_ = static_cast<float>(std::max(delta, 100.0 / static_cast<double>(least_)));
    listGrow_ = 1 + delta_;
}

template <int Dim>
void Relaxation<Dim>::placeSlots(const std::vector<Sphere<Dim>>& spheres) {
    const std::size_t n = spheres.size();
    now_.resize(n);
    forAll(n, [&](std::size_t i) {
        Home& home = now_.homes[i];
        home = {};
        for (int d = 0; d < Dim; ++d)
            home[static_cast<std::size_t>(d)] =
                static_cast<std::int64_t>(std::nearbyint(spheres[i].center[d] / quantum_));
        now_.bodies[i] = {lowBits(home[0]), lowBits(home[1]), lowBits(home[2]),
                          static_cast<float>(spheres[i].radius / quantum_)};
        now_.before[i] = now_.bodies[i];
        now_.labels[i] = now_.places[i] = static_cast<std::uint32_t>(i);
        now_.vicinities[i] = {};
        if (i < fixed_) now_.vicinities[i].roam = std::numeric_limits<float>::infinity();
    });
}

template <int Dim>
Relaxation<Dim>::~Relaxation() = default;

template <int Dim>
void Relaxation<Dim>::move(std::vector<Sphere<Dim>>& spheres) const {
    if (!ready_) return;
    forAll(now_.labels.size(), [&](std::size_t i) {
        const std::uint32_t label = now_.labels[i];
        if (!isFixed(label))
            spheres[label].center =
                walls_.position(wrapped(whereIs(now_.homes[i], now_.bodies[i])));
    });
}

template <int Dim>
std::vector<std::uint32_t> Relaxation<Dim>::places() const {
    std::vector<std::uint32_t> places(given_);
    std::iota(places.begin(), places.end(), 0u);
    if (ready_)
        for (std::size_t i = 0; i < now_.labels.size(); ++i)
            if (now_.labels[i] != kOfOthers) places[now_.labels[i]] = now_.places[i];
    return places;
}

template <int Dim>
void Relaxation<Dim>::stepRuns(const RelaxationStep& step) {
    parallelFor(std::size_t(0), runs_.size(), [&](std::size_t k) {
        if (step.range > 1)
            graded_ ? stepRun<true, true>(runs_[k], step) : stepRun<true, false>(runs_[k], step);
        else
            graded_ ? stepRun<false, true>(runs_[k], step) : stepRun<false, false>(runs_[k], step);
    });
}

template <int Dim>
float Relaxation<Dim>::stepAll(const RelaxationStep& step) {
    takeStep(step);
    Extremes all;
    for (const Run& run : runs_) {
        all.worst = std::max(all.worst, run.worst);
        all.fastest = std::max(all.fastest, run.fastest);
    }
    all = agreed(all);
    fastest_ = all.fastest;
    return all.worst;
}

template <int Dim>
typename Relaxation<Dim>::Extremes Relaxation<Dim>::stateOfAll(const Callbacks& callbacks) const {
    Extremes all;
    all.cancelled = callbacks.isCancelled();
    for (const Run& run : runs_) {
        all.coincides = std::max(all.coincides, std::uint32_t{run.coincides});
        all.expired = std::max(all.expired, std::uint32_t{run.expired});
    }
    return agreed(all);
}

template <int Dim>
void Relaxation<Dim>::advance() {
    ++listed_;
    if (onDevice_) {
        device_->advance(exchangesOnDevice_, runs_.size(), images_.size());
        exchangesOnDevice_ = false;
        return;
    }
    std::swap(now_.bodies, now_.before);
    parallelFor(std::size_t(0), runs_.size(), [&](std::size_t k) {
        for (const auto& [a, b] : runs_[k].exchanged) exchangeLabels(a, b);
    });
}

template <int Dim>
typename Relaxation<Dim>::Outcome Relaxation<Dim>::run(
    const RelaxationPace& pace, int steps, const Callbacks& callbacks,
    const std::function<bool(int, double)>& goOn) {
    Outcome outcome;
    if (!ready_) {
        outcome.apart = true;
        return outcome;
    }
    RelaxationStep step;
    step.inertia = static_cast<float>(pace.inertia);
    step.cap = static_cast<float>(pace.cap) * least_;
    step.push = kPush;
    rebuild(true);
    Stuck stuck(pace);
    for (;; ++outcome.steps) {
        const Extremes all = stateOfAll(callbacks);
        if (all.cancelled) {
            outcome.interrupted = true;
            return outcome;
        }
        renewLists(all, outcome.worst);
        step.exchanges =
            mayExchange_ && clock_ % static_cast<std::uint64_t>(pace.exchangeEvery) == 0;
        const float worst = stepAll(step);
        // Of the positions before this step, which is not taken if they are good.
        outcome.worst = std::max(0.0, static_cast<double>(worst - delta_));
        if (worst < kApart * delta_ && keepsWall()) {
            outcome.apart = true;
            return outcome;
        }
        if (outcome.steps == steps || (goOn && !goOn(outcome.steps, outcome.worst))) return outcome;
        if (static_cast<double>(worst) < pace.loose) step.turning = kTurning;
        advance();
        refreshNear();
        if (stuck.isStuck(worst)) {
            loosen(worst, 0, mayExchange_);
            refreshNear();
        }
        ++clock_;
    }
}

template class Relaxation<2>;
template class Relaxation<3>;

}  // namespace vdbpack
