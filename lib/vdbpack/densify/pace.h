// Private to densify: which pace a gain in solid fraction needs, and when a relaxation has jammed.
#pragma once

#include "vdbpack/core/ranks.h"

#include <cstddef>
#include <vector>

namespace vdbpack {

/// How fast overlaps are removed: quick paces jam at lower solid fractions.
struct RelaxationPace {
    double inertia = 0.97;  ///< share of its velocity that a sphere keeps in a step
    double cap = 0.07;      ///< largest step, in smallest radii
    int exchangeEvery = 3;  ///< steps between exchanges of positions
    /// Once the worst overlap is below this, nothing jams any more, and what is left of the motion
    /// is damped: a sphere that overlaps push back keeps less of its velocity. (Sooner, packs jam.)
    double loose = 0.003;
    /// A relaxation that succeeds does so within this many spans of 1 / (1 - inertia) steps.
    int spans = 14;
    /// Whether it is too short to succeed, and tells from what is left how dense a pack can be.
    bool isProbe = false;
};

/// The paces to try for a set of spheres, from quick to thorough.
class Paces {
public:
    /// @param dim    2 or 3.
    /// @param radii  of the spheres that move, mm.
    /// @param ranks  of whose spheres these are a share; null: they are all.
    Paces(int dim, const std::vector<double>& radii, Ranks* ranks = nullptr);

    /// All of them.
    std::vector<RelaxationPace> all() const { return from(0, steps_->size()); }
    /// Those worth a try for a gain in solid fraction over the front's.
    std::vector<RelaxationPace> forGain(double gain) const {
        return from(firstFor(gain), steps_->size());
    }
    /// The same, but only those that leave the pack at random: nearly equal spheres crystallize
    /// where they are agitated much or for long.
    std::vector<RelaxationPace> randomForGain(double gain) const {
        return from(firstFor(gain), randomCount());
    }
    /// Whether spheres (circles) of different sizes are packed.
    bool differInSize() const { return steps_ == &kWide; }
    /// Whether nearly equal spheres are packed.
    bool areEqualSpheres() const { return steps_ == &kEqual; }
    /// Whether circles of nearly equal size are packed.
    bool areEqualCircles() const { return steps_ == &kCircles; }

private:
    struct Step {
        RelaxationPace pace;
        double gain;  // up to which it is worth a try
    };
    using Steps = std::vector<Step>;
    static const Steps kWide, kEqual, kCircles;

    std::size_t randomCount() const;
    std::size_t firstFor(double gain) const;
    std::vector<RelaxationPace> from(std::size_t first, std::size_t last) const;

    const Steps* steps_;
};

/// Most steps of a relaxation at a pace.
int mostSteps(const RelaxationPace& pace);

/// Whether a relaxation has jammed. One that will succeed reduces its worst overlap to a tenth in
/// three spans of 1 / (1 - inertia) steps, from the sixth on; in one that has jammed, the overlap
/// stays above 0.4 of its value.
class Jam {
public:
    explicit Jam(const RelaxationPace& pace) : span_(1 / (1 - pace.inertia)) {}

    /// Takes note of a step's worst overlap. @return whether the relaxation has jammed.
    bool add(int step, double worst);

private:
    /// By the spans that are complete.
    bool isJammed() const;

    double span_;
    std::vector<double> least_;  // smallest worst overlap in each span
};

}  // namespace vdbpack
