#include "vdbpack/voids/knob_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// What a knob's width away from its usual value weighs, as a relative error.
constexpr double kPriorError = 0.02;
/// Weight of a target whose range is looked for.
constexpr double kPushingWeight = 0.1;
/// Steps shorter than this share of a difference end a search; shorter ones than the second teach
/// nothing.
constexpr double kLeastStep = 1e-3, kLeastLesson = 1e-2;

double square(double x) {
    return x * x;
}

/// Gauss's elimination of a positive definite system, the right side in the last column.
std::vector<double> solved(std::vector<std::vector<double>> a) {
    const std::size_t n = a.size();
    for (std::size_t k = 0; k < n; ++k)
        for (std::size_t i = k + 1; i < n; ++i) {
            const double f = a[i][k] / a[k][k];
            for (std::size_t j = k; j <= n; ++j) a[i][j] -= f * a[k][j];
        }
    std::vector<double> x(n);
    for (std::size_t k = n; k-- > 0;) {
        x[k] = a[k][n];
        for (std::size_t j = k + 1; j < n; ++j) x[k] -= a[k][j] * x[j];
        x[k] /= a[k][k];
    }
    return x;
}

double scaleOf(const KnobTarget& t) {
    return std::max(t.asked, t.floor);
}
double errorOf(const KnobTarget& t, double value) {
    return (value - t.asked) / scaleOf(t);
}

}  // namespace

KnobSearch::KnobSearch(std::vector<Knob> knobs, std::vector<KnobTarget> targets, Measure measure)
    : knobs_(std::move(knobs)),
      targets_(std::move(targets)),
      measure_(std::move(measure)),
      jacobian_(targets_.size(), std::vector<double>(knobs_.size())) {}

std::optional<KnobTrial> KnobSearch::measure(const std::vector<double>& x) const {
    auto values = measure_(x);
    if (!values) return std::nullopt;
    KnobTrial trial{x, std::move(*values), {}};
    for (std::size_t i = 0; i < targets_.size(); ++i)
        trial.errors.push_back(errorOf(targets_[i], trial.values[i]));
    return trial;
}

double KnobSearch::merit(const KnobTrial& trial) const {
    double sum = 0;
    for (std::size_t i = 0; i < targets_.size(); ++i)
        sum += square(targets_[i].weight * trial.errors[i]);
    for (std::size_t k = 0; k < knobs_.size(); ++k)
        if (knobs_[k].isFree)
            sum += square(kPriorError * (trial.knobs[k] - knobs_[k].usual) / knobs_[k].width);
    return sum;
}

void KnobSearch::offer(KnobTrial trial) {
    if (!best_ || merit(trial) < merit(*best_)) best_ = std::move(trial);
}

bool KnobSearch::begin(const std::vector<double>& x) {
    auto trial = measure(x);
    if (!trial) return false;
    best_ = std::move(trial);
    return true;
}

void KnobSearch::takeDifferences() {
    const KnobTrial from = *best_;
    std::vector<KnobTrial> tried;
    for (std::size_t k = 1; k < knobs_.size(); ++k) {
        for (auto& row : jacobian_) row[k] = 0;
        if (!knobs_[k].isFree) continue;
        std::vector<double> x = from.knobs;
        double step = knobs_[k].step;
        if (x[k] + step < knobs_[k].low || x[k] + step > knobs_[k].high) step = -step;
        x[k] += step;
        auto trial = measure(x);
        if (!trial) continue;  // the other knobs have to do
        for (std::size_t i = 0; i < targets_.size(); ++i)
            jacobian_[i][k] = (trial->errors[i] - from.errors[i]) / step;
        tried.push_back(std::move(*trial));
    }
    for (KnobTrial& trial : tried) offer(std::move(trial));
}

/// The step that the linear model says is best, within the limits of the knobs.
std::vector<double> KnobSearch::step(const KnobTrial& from, double trust) {
    for (std::size_t i = 0; i < targets_.size(); ++i)
        jacobian_[i][0] = targets_[i].power * from.values[i] / scaleOf(targets_[i]);
    std::vector<double> d(knobs_.size());
    std::vector<bool> held(knobs_.size());
    for (std::size_t round = 0; round <= knobs_.size(); ++round) {
        // Normal equations of the free knobs that are not held at a limit.
        std::vector<std::size_t> at;
        for (std::size_t k = 0; k < knobs_.size(); ++k)
            if (knobs_[k].isFree && !held[k]) at.push_back(k);
        const std::size_t n = at.size();
        std::vector<std::vector<double>> a(n, std::vector<double>(n + 1));
        for (std::size_t p = 0; p < n; ++p) {
            for (std::size_t i = 0; i < targets_.size(); ++i) {
                const double w = square(targets_[i].weight);
                double rest = from.errors[i];
                for (std::size_t k = 0; k < knobs_.size(); ++k)
                    if (held[k]) rest += jacobian_[i][k] * d[k];
                for (std::size_t q = 0; q < n; ++q)
                    a[p][q] += w * jacobian_[i][at[p]] * jacobian_[i][at[q]];
                a[p][n] -= w * jacobian_[i][at[p]] * rest;
            }
            const double prior = square(kPriorError / knobs_[at[p]].width);
            a[p][p] += prior;
            a[p][n] -= prior * (from.knobs[at[p]] - knobs_[at[p]].usual);
        }
        const std::vector<double> best = solved(std::move(a));
        // The knob that goes farthest beyond its limits is held there; the others are solved again.
        std::size_t farthest = n;
        double beyond = 1 + 1e-12;
        for (std::size_t p = 0; p < n; ++p) {
            const std::size_t k = at[p];
            const double low = std::max(knobs_[k].low - from.knobs[k], -trust * knobs_[k].limit);
            const double high = std::min(knobs_[k].high - from.knobs[k], trust * knobs_[k].limit);
            d[k] = std::clamp(best[p], std::min(low, 0.0), std::max(high, 0.0));
            const double share = best[p] == d[k] ? 0 : best[p] / (d[k] == 0 ? 1e-9 : d[k]);
            if (std::fabs(share) > beyond) {
                beyond = std::fabs(share);
                farthest = p;
            }
        }
        if (farthest == n) break;
        held[at[farthest]] = true;
    }
    return d;
}

/// What one measurement more says of the Jacobian, but for the scale.
void KnobSearch::learn(const std::vector<double>& d, const KnobTrial& from, const KnobTrial& to) {
    double moved = 0;
    for (std::size_t k = 1; k < knobs_.size(); ++k) moved += square(d[k] / knobs_[k].step);
    if (!(moved > square(kLeastLesson))) return;
    for (std::size_t i = 0; i < targets_.size(); ++i) {
        double miss = (to.values[i] - from.values[i] * std::exp(targets_[i].power * d[0])) /
                      scaleOf(targets_[i]);
        for (std::size_t k = 1; k < knobs_.size(); ++k) miss -= jacobian_[i][k] * d[k];
        for (std::size_t k = 1; k < knobs_.size(); ++k)
            jacobian_[i][k] += miss * d[k] / square(knobs_[k].step) / moved;
    }
}

void KnobSearch::search(int rounds, double enough, std::size_t left) {
    double trust = 1;
    for (int round = 0; round < rounds && !isNear(*best_, enough, left); ++round) {
        const KnobTrial from = *best_;
        const std::vector<double> d = step(from, trust);
        std::vector<double> x = from.knobs;
        double moved = 0;
        for (std::size_t k = 0; k < x.size(); ++k) {
            x[k] += d[k];
            moved = std::max(moved, std::fabs(d[k] / knobs_[k].step));
        }
        if (moved < kLeastStep) return;
        const auto trial = measure(x);
        if (!trial) {
            trust *= 0.4;
            continue;
        }
        learn(d, from, *trial);
        seen_.push_back(*trial);
        offer(*trial);
        trust = best_->knobs == x ? std::min(1.0, 2 * trust) : 0.5 * trust;
    }
}

bool KnobSearch::isNear(const KnobTrial& trial, double enough, std::size_t left) const {
    for (std::size_t i = 0; i < targets_.size(); ++i)
        if (!targets_[i].isStrict && !(std::fabs(trial.errors[i]) <= targets_[i].slack))
            return false;
    return worst(trial, left) <= enough;
}

double KnobSearch::worst(const KnobTrial& trial, std::size_t left) const {
    double worst = 0;
    for (std::size_t i = 0; i < targets_.size(); ++i)
        if (targets_[i].isStrict && i != left) worst = std::max(worst, std::fabs(trial.errors[i]));
    return worst;
}

std::size_t KnobSearch::worstTarget(const KnobTrial& trial) const {
    std::size_t at = 0;
    for (std::size_t i = 0; i < targets_.size(); ++i)
        if (targets_[i].isStrict && std::fabs(trial.errors[i]) > std::fabs(trial.errors[at]))
            at = i;
    return at;
}

std::pair<double, double> KnobSearch::rangeOf(std::size_t target, int rounds, double enough) {
    const KnobTrial kept = *best_;
    const KnobTarget asked = targets_[target];
    const auto jacobian = jacobian_;
    double low = kept.values[target], high = low;
    if (!(low > 0)) return {low, high};
    for (const double factor : {0.5, 2.0}) {
        best_ = kept;
        jacobian_ = jacobian;
        targets_[target].asked = factor * kept.values[target];
        targets_[target].weight = kPushingWeight;
        best_->errors[target] = errorOf(targets_[target], kept.values[target]);
        for (double& slope : jacobian_[target]) slope *= scaleOf(asked) / scaleOf(targets_[target]);
        seen_.clear();
        search(rounds, 0);
        for (const KnobTrial& trial : seen_) {
            if (worst(trial, target) > enough) continue;
            low = std::min(low, trial.values[target]);
            high = std::max(high, trial.values[target]);
        }
        targets_[target] = asked;
    }
    best_ = kept;
    jacobian_ = jacobian;
    return {low, high};
}

}  // namespace vdbpack
