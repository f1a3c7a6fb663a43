// Private to the fit of a structure: the foam of some knobs, and its measured numbers.
#pragma once

#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/voids/knob_search.h"
#include "vdbpack/voids/void_families.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// What is varied; BV/TV if no target says it. Logarithms but for spread, jitter and the share of
/// struts; the spread is the standard deviation of the logarithm of the radii, blend and width of
/// struts are in mean b.
enum KnobName : std::size_t {
    kScale,
    kSpread,
    kAspect,
    kJitter,
    kBlend,
    kStrutShare,
    kBvtv,
    kStrutWidth
};
using Knobs = std::vector<double>;

/// Voxels of a trabecula; of a small specimen, and of one that is measured for good.
inline constexpr double kCoarseVoxels = 4, kFineVoxels = 5;
/// Trabecular periods along a specimen.
inline constexpr double kCoarsePeriods = 5, kFinePeriods = 8, kLeastPeriods = 3.5;
/// The most voxels that a specimen is measured in.
inline constexpr double kMostVoxels = 1.2e8;
/// Distances from the distributions of a sample count from the first value on, and up to
/// the second the search goes on.
inline constexpr double kNearDistance = 0.08, kEnoughDistance = 0.11, kDistanceWeight = 0.6;

/// The numbers of a specimen.
enum class Number {
    thickness,
    spacing,
    anisotropy,
    connectivity,
    thicknessScatter,
    spacingScatter,
    crumbs,
    thicknessDistance,
    spacingDistance
};

inline bool isDistance(Number number) {
    return number == Number::thicknessDistance || number == Number::spacingDistance;
}

/// The distance of the distribution of a length from that of a sample: Kolmogorov and Smirnov's.
double distanceTo(const LengthStatistics& have, const std::vector<double>& sample);

/// What specimens are cut from, and their voxels, mm.
struct SpecimenStage {
    const Domain<3>* domain = nullptr;
    double voxel = 0;
    /// What the numbers would be in finer voxels, in what they are; none: the same.
    std::vector<double> correction;

    double voxels() const { return domain->volume() / std::pow(voxel, 3); }
};

/// A foam by its knobs, with the targets of a recipe.
class FoamModel {
protected:
    FoamModel(const VoidSetting<3>& setting, FoamPacks<3>& packs);

    static std::shared_ptr<const Domain<3>> boxAbout(const Vec<3>& size);
    /// Of the next specimens.
    void use(const SpecimenStage& stage);
    /// The foam of some knobs, in a box of its own.
    VoidRecipe recipeOf(const Knobs& x) const;
    /// @throws ParameterError where the dilation cannot reach BV/TV
    Morphometry specimen(const Knobs& x, std::uint64_t seed);
    std::vector<double> numbersOf(const Morphometry& m) const;
    /// The numbers at some knobs, corrected; nothing, and `unreachable_`, where there is no foam.
    std::optional<std::vector<double>> valuesAt(const Knobs& x);

    const VoidSetting<3>& s_;
    const VoidRecipe& r_;
    const FoamVoids& foam_;  ///< of that recipe
    FoamPacks<3>& packs_;
    std::vector<Knob> knobs_;
    std::vector<KnobTarget> targets_;  ///< strict ones first
    std::vector<Number> numbers_;      ///< of the targets
    std::vector<const char*> names_;   ///< of their parameters
    Knobs first_;
    bool spreadIsOpen_ = false;  ///< whether the spread of the radii is to be found
    double period_ = 0, thickness_ = 0;
    const SpecimenStage* stage_ = nullptr;
    /// Of the last specimen: its knobs, local thickness and spacing.
    std::pair<Knobs, std::array<LengthStatistics, 2>> lastOf_;
    std::string unreachable_;  ///< why the last knobs had no specimen

private:
    void aim(const char* name, Number number, const std::optional<double>& asked,
             KnobTarget target);
    SizeDistribution radii(const Knobs& x) const;
};

}  // namespace vdbpack
