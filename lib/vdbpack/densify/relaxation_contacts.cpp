// Spheres that are apart, drawn together until they touch.
#include "vdbpack/densify/relaxation.h"

#include <algorithm>

namespace vdbpack {

namespace {

/// The gap that remains where two spheres touch, in radii of the smaller one, for the smallest and
/// the largest sphere; and the least share by which radii are enlarged for that, and the least
/// number of quanta: rounding must not matter.
constexpr double kRest = 9e-5, kLeastDelta = 1e-5, kLeastQuanta = 10;
/// Overlaps below this share of delta are none of the true radii, with a margin for rounding.
constexpr float kContactApart = 0.9f;
/// Spheres are drawn together whose gap is below this share of the sum of their radii. With 0.02,
/// a sphere of a box at 0.645 touches 0.1 fewer: more pulls compete.
constexpr float kRange = 0.012f;
/// A gap pulls as strongly as an overlap of its size pushes, up to one of this share of the
/// distance: of kFirst in the first step, and kFade times as much in each further one. In the end,
/// the pull leaves overlaps far smaller than delta.
constexpr float kFirst = 5e-3f, kFade = 0.905f;
/// Steps with a pull, and most of all. Without a pull, the last overlaps take 3 to 20 steps; a few
/// among a million spheres take 340.
constexpr int kPulls = 85, kMostSteps = 600;
/// Before these steps, the exact wall is queried: the spheres are close to where they will be.
constexpr int kFirstWall = 60, kSecondWall = kPulls;
/// A sphere gains this share of overlaps and gaps as velocity.
constexpr float kContactPush = 0.6f;

/// The share of its velocity that a sphere keeps in a step: rising without a pull, as in Nesterov's
/// method (1983), since what is left takes ever softer modes.
float inertiaAt(int step) {
    return 1 - 3.0f / static_cast<float>(15 + std::max(0, step - kPulls));
}

/// Gap up to which neighbors are listed beyond those in range, and the largest step; in smallest
/// radii.
constexpr float kSkin = 0.15f, kCap = 0.05f;

}  // namespace

template <int Dim>
typename Relaxation<Dim>::Outcome Relaxation<Dim>::drawTogether(
    const Callbacks& callbacks, const std::function<void(double)>& onStep) {
    Outcome outcome;
    if (!ready_) {
        outcome.apart = true;
        return outcome;
    }
    const auto least = static_cast<double>(least_), most = static_cast<double>(most_);
    const double delta = kRest * least / (least + most);
    delta_ = static_cast<float>(std::max({delta, kLeastDelta, kLeastQuanta / least}));
    listGrow_ = (1 + delta_) * (1 + kRange);
    skin_ = kSkin * least_;
    Step step;
    step.cap = kCap * least_;
    step.push = kContactPush;
    step.pull = kFirst;
    step.range = 1 + kRange;
    rebuild(false);
    for (;; ++outcome.steps) {
        const Extremes all = stateOfAll(callbacks);
        if (all.cancelled) {
            outcome.interrupted = true;
            return outcome;
        }
        if (onStep) onStep(std::min(1.0, static_cast<double>(outcome.steps) / kPulls));
        if (listsExpired(all)) rebuild(false);
        if (outcome.steps == kFirstWall || outcome.steps == kSecondWall) keepsWall();
        step.inertia = inertiaAt(outcome.steps);
        if (outcome.steps == kPulls) step.pull = 0;
        step.drifts = outcome.steps < kPulls;
        float fastest = 0;
        const float worst = stepAll(step, fastest);
        outcome.worst = std::max(0.0, static_cast<double>(worst - delta_));
        if (outcome.steps >= kPulls && worst < kContactApart * delta_ && keepsWall()) {
            outcome.apart = true;
            return outcome;
        }
        if (outcome.steps == kMostSteps) return outcome;
        advance(fastest);
        refreshNear();
        step.pull *= kFade;
        ++clock_;
    }
}

template typename Relaxation<2>::Outcome Relaxation<2>::drawTogether(
    const Callbacks&, const std::function<void(double)>&);
template typename Relaxation<3>::Outcome Relaxation<3>::drawTogether(
    const Callbacks&, const std::function<void(double)>&);

}  // namespace vdbpack
