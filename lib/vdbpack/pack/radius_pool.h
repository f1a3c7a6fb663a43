// Radii drawn and not yet placed.
#pragma once

#include "vdbpack/core/rng.h"
#include "vdbpack/pack/size_distribution.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace vdbpack {

/// 2^64 / golden ratio: the additive step that spreads draws most evenly over a distribution.
inline constexpr std::uint64_t kGoldenStep = 0x9e3779b97f4a7c15ull;

/// Pending radii, sorted. Drawing until a radius fits would bias a pack towards small spheres; a
/// pool keeps the distribution exact: all radii drawn are placed, except those pending at the end.
///
/// Draws follow the additive golden-ratio sequence from a random start, so that any run of draws
/// is spread over the distribution far more evenly than independent ones.
class RadiusPool {
public:
    /// @param shell  added to every radius drawn, mm.
    RadiusPool(const SizeDistribution& sizes, std::uint64_t seed, std::uint64_t stream,
               std::size_t capacity, double shell = 0);

    std::size_t size() const { return radii_.size(); }
    /// Mean radius of the distribution, mm.
    double mean() const { return mean_; }
    /// Sets how many radii may be pending; where that falls, the pool shrinks as they are placed.
    /// @param common  larger radii do not count, mm: where they fit nowhere, the others continue.
    void setCapacity(std::size_t capacity, double common) {
        capacity_ = capacity;
        limit_ = std::max(limit_, capacity);
        common_ = common;
    }
    /// The `k`-th smallest pending radius, mm.
    double operator[](std::size_t k) const { return radii_[k]; }
    double smallest() const { return radii_.front(); }
    double largest() const { return radii_.back(); }
    /// How many pending radii are <= `r`.
    std::size_t countUpTo(double r) const;

    /// Draws a radius that is not pending: it is to be placed at once, or given back.
    double draw();
    /// Makes a radius that was drawn pending instead.
    void giveBack(double r);
    /// Whether the mean of the radii that left the pool is more than a hundredth above the mean of
    /// the distribution. A pool whose largest radii are taken first comes to hold small ones; those
    /// that replaced them would all be placed where the pack begins.
    bool hasGivenLarge() const { return given_.excess > 0.01 * mean_ * given_.count; }
    /// Removes the `k`-th smallest and draws up to the capacity.
    void take(std::size_t k);
    /// Draws until the pool is full and has a radius of at most the mean: then every vacancy for a
    /// mean sphere can be filled. Not after every `take`: larger radii drawn on the way would pend
    /// for ever.
    void refill();

    /// Of the radii that left the pool.
    struct Given {
        double count = 0;
        double excess = 0;  ///< their sum, less the sum of as many mean radii, mm
    };
    /// What one rank tells another of a pool that moves there.
    struct State {
        std::uint64_t share = 0;  ///< the last draw
        Given given;
        std::uint64_t limit = 0;    ///< to which the pool is filled
        std::vector<double> radii;  ///< pending, sorted, mm
    };
    State state() const { return {share_, given_, limit_, radii_}; }
    void restore(State state) {
        share_ = state.share;
        given_ = state.given;
        limit_ = state.limit;
        radii_ = std::move(state.radii);
    }

private:
    void fill();
    double next();
    void add(double r);
    void count(double r, double times);

    SizeDistribution sizes_;
    double shell_;
    double mean_;  ///< of the radii with their shells, mm
    std::uint64_t share_;
    Given given_;
    std::size_t capacity_, limit_;
    double common_ = std::numeric_limits<double>::infinity();
    std::vector<double> radii_;
};

}  // namespace vdbpack
