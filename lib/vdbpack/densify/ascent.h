// Private to densify: which solid fractions are tried on the way to the requested one.
#pragma once

#include "vdbpack/densify/pace.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A solid fraction is reached but for this.
inline constexpr double kFractionRounding = 1e-9;

/// A pack that is made denser in stages.
class Stages {
public:
    virtual ~Stages() = default;

    /// Adds spheres up to `fraction` and relaxes, at one pace after the other until a pack has no
    /// overlaps, which is kept. @return whether there is one.
    virtual bool attempt(double fraction, const std::vector<RelaxationPace>& paces) = 0;
    /// Where the last attempt ended with overlaps: their sum for a sphere, in radii, on average.
    virtual double strain() const = 0;
    virtual double reached() const = 0;  ///< solid fraction by now
    virtual bool isInterrupted() const = 0;

    /// Insertions on the way to the pack by now: part of the seed.
    std::uint64_t stage = 0;
};

/// The way of a pack to a solid fraction.
class Ascent {
public:
    struct Setting {
        double before;   ///< solid fraction of the front, or what it would be
        double limit;    ///< no solid fraction above this is tried
        bool isInCell;   ///< spheres in a cell that is periodic along an axis
        bool hasWalls;   ///< not periodic along all axes
        bool isInSpace;  ///< 3D
    };
    Ascent(Stages& stages, const Paces& paces, const Setting& setting)
        : stages_(stages), paces_(paces), setting_(setting) {}

    /// Tries the fraction at once, or else goes towards it as towards the densest pack: what is out
    /// of reach ends no less dense than that.
    void reach(double wanted);
    /// Goes to the densest pack; of equal spheres to the densest random one.
    void reachMost();

private:
    void climbInCell(double most);
    void climbAtRandom(double most);
    bool climbOnceAtRandom(double most);
    void climb(double most);
    bool climbByStrain(double most);
    bool attemptGain(double fraction);
    void fallBack();
    bool isEnded(double most) const;
    double from() const { return std::max(stages_.reached(), setting_.before); }

    Stages& stages_;
    const Paces& paces_;
    const Setting setting_;
};

}  // namespace vdbpack
