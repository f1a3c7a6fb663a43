// Private to voids: a least-squares search in few dimensions with costly, noisy measurements.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace vdbpack {

/// A parameter that is varied.
struct Knob {
    double usual = 0;     ///< where it stays if no target asks for more
    double width = 1;     ///< how far from there weighs as much as 2 % of a target
    double low = -1e300;  ///< limits of its values
    double high = 1e300;
    double step = 0.1;   ///< of differences
    double limit = 1;    ///< of one step of the search
    bool isFree = true;  ///< else it stays where it is
};

/// A number that is to be reached.
struct KnobTarget {
    double asked = 0;  ///< not 0 without a floor
    double weight = 1;
    double power = 0;      ///< the number goes as exp(power * knob 0)
    double floor = 0;      ///< errors are relative to this at the least
    bool isStrict = true;  ///< else it is only to be approached
    /// Error up to which it is near enough, if it is not strict.
    double slack = std::numeric_limits<double>::infinity();
};

/// A measurement at some knobs, in the order of the targets.
struct KnobTrial {
    std::vector<double> knobs, values;
    std::vector<double> errors;  ///< relative to what was asked
};

/// Gauss-Newton steps towards all targets, with a Jacobian from differences that each further
/// measurement corrects: Broyden (1965), doi:10.1090/S0025-5718-1965-0198670-6. Knob 0 is the
/// logarithm of a scale, whose effect on each target is known.
class KnobSearch {
public:
    /// The numbers at some knobs, or nothing where there are none.
    using Measure = std::function<std::optional<std::vector<double>>(const std::vector<double>&)>;
    static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

    KnobSearch(std::vector<Knob> knobs, std::vector<KnobTarget> targets, Measure measure);

    std::vector<Knob>& knobs() { return knobs_; }
    std::vector<KnobTarget>& targets() { return targets_; }

    /// Forgets what was measured, and begins at `x`. @return whether there is something there
    bool begin(const std::vector<double>& x);
    /// The Jacobian at the best knobs, by a measurement a free knob.
    void takeDifferences();
    /// Steps until a trial is `isNear`, at most `rounds`.
    void search(int rounds, double enough, std::size_t left = kNone);

    /// What the search makes small: a weighted sum of squares of all errors.
    double merit(const KnobTrial& trial) const;
    const KnobTrial& best() const { return *best_; }
    void setBest(KnobTrial trial) { best_ = std::move(trial); }
    /// Whether all strict targets but `left` are within `enough`, and the others within their
    /// slack.
    bool isNear(const KnobTrial& trial, double enough, std::size_t left = kNone) const;
    /// Largest error of the strict targets but `left`.
    double worst(const KnobTrial& trial, std::size_t left = kNone) const;
    /// The strict target with that error.
    std::size_t worstTarget(const KnobTrial& trial) const;

    /// The least and the largest value of a target that are found while the others stay within
    /// `enough`, by some rounds in each direction from the best knobs, which stay.
    std::pair<double, double> rangeOf(std::size_t target, int rounds, double enough);

private:
    std::optional<KnobTrial> measure(const std::vector<double>& x) const;
    void offer(KnobTrial trial);
    std::vector<double> step(const KnobTrial& from, double trust);
    void learn(const std::vector<double>& d, const KnobTrial& from, const KnobTrial& to);

    std::vector<Knob> knobs_;
    std::vector<KnobTarget> targets_;
    Measure measure_;
    std::vector<std::vector<double>> jacobian_;  ///< of the errors, a row a target
    std::optional<KnobTrial> best_;
    std::vector<KnobTrial> seen_;
};

}  // namespace vdbpack
