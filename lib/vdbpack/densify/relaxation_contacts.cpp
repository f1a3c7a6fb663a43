// Spheres that are apart are drawn together until they touch; spheres of a front are settled.
#include "vdbpack/densify/relaxation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

/// The gap that remains where two spheres touch, in radii of the smaller one, for the smallest and
/// the largest sphere; and the least share by which radii are enlarged for that, and the least
/// number of quanta: rounding must not matter.
constexpr double kRest = 7e-5, kLeastDelta = 1e-5, kLeastQuanta = 10;
/// Overlaps below this share of delta are none of the true radii, with a margin for rounding.
constexpr float kContactApart = 0.9f;
/// Most steps. Without a pull, the last overlaps take 3 to 20; a few among a million spheres take
/// 340. Where a front settles in thin bone, a few take long to find a place.
constexpr int kMostSteps = 600, kMostSettling = 900;
/// In kPatience steps, the worst overlap falls to less than this share of it, or else the spheres
/// that have it exchange positions with smaller ones, once pulls have ended for as long: not where
/// overlaps are as small as kLeftOver, unless it is for kLongPatience. Where a front settles, also
/// before, where overlaps are larger than kWhilePulled and so many times the pull.
constexpr int kPatience = 15, kLongPatience = 150;
constexpr float kPatient = 0.7f, kLeftOver = 1e-4f, kWhilePulled = 1e-3f, kByPull = 4;
/// In every so many steps, the smallest spheres of a front that two walls squeeze as much are sent
/// to where these are farther apart: walls that are almost parallel hardly push them there.
constexpr int kKickEvery = 5;
/// So many steps before the pull ends, and then, the exact wall is queried: the spheres are close
/// to where they will be.
constexpr int kWallBefore = 25;
/// A sphere gains this share of overlaps and gaps as velocity.
constexpr float kContactPush = 0.6f;
/// The share of its velocity that a sphere keeps in a step: rising without a pull, as in Nesterov's
/// method (1983), since what is left takes ever softer modes.
float inertiaAt(int step) {
    return 1 - 3.0f / static_cast<float>(15 + std::max(0, step));
}

/// The largest step, in smallest radii.
constexpr float kCap = 0.05f;

/// Where a front settles, radii are enlarged by this share, and overlaps removed, though not to the
/// last, in so many steps at this pace: then gaps are about twice as large everywhere.
constexpr double kSettleDelta = 0.02;
constexpr RelaxationPace kSettlePace{0.95, 0.1, 1, 0.01};
constexpr int kSettleSteps = 60;
/// How much more strongly walls pull then, for spheres of sizes that differ by more than kEqual and
/// for others: about as many spheres stay at walls as the front had.
template <int Dim>
constexpr float kSettleWall = Dim == 3 ? 1.8f : 1;
constexpr float kSettleWallOfEqual = 0, kEqual = 1.1f;

}  // namespace

/// How gaps pull.
template <int Dim>
struct Relaxation<Dim>::Drawing {
    /// Gaps below this share of the sum of the radii pull. More pulls compete with a larger one.
    float range;
    /// As strongly as an overlap of this share of the distance, in the first step and, by a
    /// constant factor less in each, in the last one: then overlaps are far smaller than delta.
    float first, last;
    int steps;  ///< with a pull
    /// The same range of walls, in radii, and how much more strongly these pull: a sphere has one
    /// wall, and several neighbors.
    float wallRange, wallMore;
};

template <int Dim>
typename Relaxation<Dim>::Outcome Relaxation<Dim>::drawTogether(
    bool loose, const Callbacks& callbacks, const std::function<void(double)>& onStep) {
    return loose ? draw({0.03f, 1e-2f, 2e-6f, 95, 0.03f, 0}, callbacks, onStep)
                 : draw({0.016f, 5e-3f, 2e-6f, 95, 0.03f, 0}, callbacks, onStep);
}

template <int Dim>
typename Relaxation<Dim>::Outcome Relaxation<Dim>::settle(
    const Callbacks& callbacks, const std::function<void(double)>& onStep) {
    constexpr double kFirstShare = 0.35;  // of the time
    setDelta(kSettleDelta);
    settling_ = true;
    const Outcome loose = run(kSettlePace, kSettleSteps, callbacks, [&](int step, double) {
        if (onStep) onStep(kFirstShare * step / kSettleSteps);
        return true;
    });
    if (loose.interrupted) return loose;
    const float wall = most_ < kEqual * smallest_ ? kSettleWallOfEqual : kSettleWall<Dim>;
    Outcome outcome = draw({0.06f, 0.02f, 1e-5f, 120, 0.1f, wall}, callbacks, [&](double done) {
        if (onStep) onStep(kFirstShare + (1 - kFirstShare) * done);
    });
    outcome.steps += loose.steps;
    return outcome;
}

template <int Dim>
typename Relaxation<Dim>::Outcome Relaxation<Dim>::draw(const Drawing& drawing,
                                                        const Callbacks& callbacks,
                                                        const std::function<void(double)>& onStep) {
    Outcome outcome;
    if (!ready_) {
        outcome.apart = true;
        return outcome;
    }
    const auto least = static_cast<double>(least_), most = static_cast<double>(most_);
    const double delta = kRest * least / (least + most);
    delta_ = static_cast<float>(std::max({delta, kLeastDelta, kLeastQuanta / least}));
    listGrow_ = (1 + delta_) * (1 + drawing.range);
    const float fade =
        std::pow(drawing.last / drawing.first, 1 / static_cast<float>(drawing.steps));
    RelaxationStep step;
    step.cap = kCap * least_;
    step.push = kContactPush;
    step.pull = drawing.first;
    step.range = 1 + drawing.range;
    wallRange_ = step.wallRange = 1 + drawing.wallRange;
    rebuild(false);
    float before = 1e30f;  // the worst overlap kPatience steps ago
    for (;; ++outcome.steps) {
        const Extremes all = stateOfAll(callbacks);
        if (all.cancelled) {
            outcome.interrupted = true;
            return outcome;
        }
        if (onStep) onStep(std::min(1.0, static_cast<double>(outcome.steps) / drawing.steps));
        renewLists(all, 0);
        const int left = drawing.steps - outcome.steps;
        if (left == kWallBefore || left == 0) keepsWall();
        step.inertia = inertiaAt(-left);
        if (left == 0) step.pull = 0;
        step.wallPull = step.pull * drawing.wallMore;
        step.drifts = left > 0;
        const float worst = stepAll(step);
        outcome.worst = std::max(0.0, static_cast<double>(worst - delta_));
        if (left <= 0 && worst < kContactApart * delta_ && keepsWall()) {
            outcome.apart = true;
            return outcome;
        }
        if (outcome.steps == (settling_ ? kMostSettling : kMostSteps)) return outcome;
        advance();
        refreshNear();
        relieve(left, worst, before, step);
        step.pull *= fade;
        ++clock_;
    }
}

template <int Dim>
void Relaxation<Dim>::relieve(int left, float worst, float& before, const RelaxationStep& step) {
    const float whilePulled = kWhilePulled + kByPull * step.pull;
    const float kick = settling_ && worst > whilePulled ? step.cap : 0;
    if (left % kPatience != 0) {
        if (kick > 0 && left % kKickEvery == 0) loosen(worst, kick, false);
        return;
    }
    const float leftOver = left < -kLongPatience ? delta_
                           : left < -kPatience   ? kLeftOver
                           : settling_           ? whilePulled
                                                 : std::numeric_limits<float>::infinity();
    if (worst > kPatient * before && worst > leftOver) {
        loosen(worst, kick, mayExchange_);
        refreshNear();
    }
    before = worst;
}

template typename Relaxation<2>::Outcome Relaxation<2>::settle(const Callbacks&,
                                                               const std::function<void(double)>&);
template typename Relaxation<3>::Outcome Relaxation<3>::settle(const Callbacks&,
                                                               const std::function<void(double)>&);
template typename Relaxation<2>::Outcome Relaxation<2>::drawTogether(
    bool, const Callbacks&, const std::function<void(double)>&);
template typename Relaxation<3>::Outcome Relaxation<3>::drawTogether(
    bool, const Callbacks&, const std::function<void(double)>&);

}  // namespace vdbpack
