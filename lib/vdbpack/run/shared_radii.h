// Private to runs: radii that several parts share.
#pragma once

#include "vdbpack/run/run_parts.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// Gives the parts that share the sizes of the whole run the radii that one of them was given, and
/// scales these for another round if by far not as many spheres were packed as requested.
class SharedRadii {
public:
    /// Gives the largest of these parts its share of the target count.
    SharedRadii(const PackRecipe& recipe, Parts& parts);
    /// Warns of a target count if no parts share radii.
    void warnOfUnused(const PackRecipe& recipe, const Callbacks& callbacks) const;

    /// Of the spheres of the parts that share radii; 0: none is requested.
    double target() const { return target_; }
    /// The order in which parts are packed.
    std::vector<std::size_t> order() const;
    /// Whether all parts take the radii that this part was packed with.
    bool leads(std::size_t k) const { return target_ > 0 && shared_[k] && k == first_; }
    /// Called before each part is packed, in that order.
    void prepare(PackRecipe& part, std::size_t k) const;
    /// Called after it, with its radii.
    void take(const SizeDistribution& sizes, std::size_t k);
    /// Spheres of the parts that share radii.
    double count(const std::vector<std::unique_ptr<Run<3>>>& runs) const;
    /// For the next round, after one that has left `count` spheres.
    void scaleFor(double count);
    /// What was chosen after the first round.
    std::string chosen() const;

private:
    std::vector<std::uint8_t> shared_;
    std::vector<SizeRequest> shells_;  ///< as requested
    std::size_t first_ = 0;
    double target_ = 0, asked_ = 1;  ///< asked_: mean radius as requested, mm
    std::optional<SizeDistribution> found_;
};

}  // namespace vdbpack
