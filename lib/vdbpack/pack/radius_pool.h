// Radii that were drawn but not placed yet.
#pragma once

#include "vdbpack/core/rng.h"
#include "vdbpack/pack/size_distribution.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace vdbpack {

/// Pending radii, sorted. Taking what fits biases a pack towards small spheres; a pool that is
/// refilled from the distribution keeps it exact: all that was drawn gets placed, but for what
/// is pending at the end.
///
/// Draws follow the additive golden-ratio sequence from a random start, so that any run of draws
/// is spread over the distribution far more evenly than independent ones.
class RadiusPool {
public:
    /// @param shell  added to every radius drawn, mm.
    RadiusPool(const SizeDistribution& sizes, std::uint64_t seed, std::uint64_t stream,
               std::size_t capacity, double shell = 0);

    std::size_t size() const { return radii_.size(); }
    /// How many radii may be pending; what is pending beyond that stays until it is placed.
    /// @param common  larger radii do not count, mm: where they fit nowhere the others go on.
    void setCapacity(std::size_t capacity,
                     double common = std::numeric_limits<double>::infinity()) {
        capacity_ = capacity;
        common_ = common;
    }
    /// The `k`-th smallest pending radius, mm.
    double operator[](std::size_t k) const { return radii_[k]; }
    double smallest() const { return radii_.front(); }
    double largest() const { return radii_.back(); }
    /// How many pending radii are <= `r`.
    std::size_t countUpTo(double r) const;

    /// Removes the `k`-th smallest and draws up to the capacity.
    void take(std::size_t k);
    /// Draws until the pool is full and holds a radius of at most the mean: every place that
    /// takes a mean sphere can then be filled. Not for every draw: what is drawn on the way and
    /// is too large would pend for ever.
    void refill();
    /// Moves the radii pending in `other` into this pool.
    void absorb(RadiusPool& other);

private:
    void fill();
    void draw();

    SizeDistribution sizes_;
    double shell_;
    std::uint64_t share_;
    std::size_t capacity_;
    double common_ = std::numeric_limits<double>::infinity();
    std::vector<double> radii_;
};

}  // namespace vdbpack
