// Further kinds of spheres that take part in the front, such as holes.
#pragma once

#include "vdbpack/core/rng.h"
#include "vdbpack/pack/pack_options.h"

#include <cstdint>
#include <deque>
#include <vector>

namespace vdbpack {

/// Spheres of further species that are due. After each sphere of the first species the species of
/// the next one is drawn; a sphere of another species is due until it finds room.
class SpeciesQueue {
public:
    /// A sphere that is due.
    struct Due {
        std::uint8_t species = 1;  ///< index in PackOptions::species + 1
        double radius = 0;         ///< mm
        double depth = 0;          ///< see Species::depth
    };

    /// @param shell  added to every radius drawn, mm.
    SpeciesQueue(const std::vector<Species>& species, std::uint64_t seed, std::uint64_t stream,
                 double shell);

    /// Draws the spheres that come between the one of the first species just placed and the next.
    void draw();
    bool isDue() const { return !due_.empty(); }
    const Due& next() const { return due_.front(); }
    /// The next one was placed.
    void take() { due_.pop_front(); }
    /// Depth beyond which some of these may lie, mm.
    double depth() const { return depth_; }

    /// What one rank tells another of a queue that moves there.
    struct State {
        std::vector<RandomStream> random;   ///< one
        std::vector<std::uint64_t> shares;  ///< the last draw of each species
        std::vector<Due> due;
    };
    State state() const { return {{random_}, shares_, {due_.begin(), due_.end()}}; }
    void restore(const State& state) {
        random_ = state.random.front();
        shares_ = state.shares;
        due_.assign(state.due.begin(), state.due.end());
    }

private:
    std::vector<Species> species_;
    double shell_;
    double depth_;
    RandomStream random_;
    std::vector<std::uint64_t> shares_;  ///< of each species, along the golden-ratio sequence
    std::deque<Due> due_;
};

}  // namespace vdbpack
