// Void families: the list of voids of each method, as a function of their amount.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/core/ranks.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/voids/dilated_pack.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/void_field.h"
#include "vdbpack/voids/void_recipe.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace vdbpack {

/// Dense packs that several foams are made from, and what was found for the last of them.
template <int Dim>
struct FoamPacks {
    struct Entry {
        std::string sizes;
        std::uint64_t seed;
        FoamPack<Dim> pack;
    };
    std::vector<std::shared_ptr<const Entry>> entries;
    double dilation = 0;  ///< of the last foam; 0: unknown

    /// The stored dense pack for these arguments, or a new one, which is then stored. @throws as
    /// `foamPack`
    std::shared_ptr<const Entry> get(const SizeDistribution& sizes, const Vec<Dim>& half,
                                     const std::array<bool, Dim>& wraps, std::uint64_t seed,
                                     const Callbacks& callbacks);
};

/// The domain that voids are cut into, and the spheres around them.
template <int Dim>
struct VoidSetting {
    const VoidRecipe& recipe;
    const Domain<Dim>& domain;
    double sliceHeight = 0;  ///< mm
    std::uint64_t seed = 1;
    double largestRadius = 0;  ///< of the spheres of the run, mm; 0: none
    const Callbacks& callbacks;
    Ranks* ranks = nullptr;  ///< that share the spheres; null: none do
    /// BV/TV by place, from 0 to 1; empty: it is the same everywhere.
    std::function<double(const Vec<Dim>&)> bvtv{};
    /// Thickness by place, where the recipe has a field of it; uniform: thickness of the recipe.
    ShellThickness localShell{};
    FoamPacks<Dim>* packs = nullptr;  ///< kept for further foams; null: they are not
};

/// The same with another recipe, which must outlive it.
template <int Dim>
VoidSetting<Dim> withRecipe(const VoidSetting<Dim>& s, const VoidRecipe& recipe) {
    return {recipe,      s.domain, s.sliceHeight, s.seed,       s.largestRadius,
            s.callbacks, s.ranks,  s.bvtv,        s.localShell, s.packs};
}

/// The shell that no void is cut into.
template <int Dim>
ShellThickness shellOf(const VoidSetting<Dim>& s) {
    return s.localShell.isUniform() ? ShellThickness(s.recipe.shell) : s.localShell;
}

/// The part of the domain that voids are cut into: deeper than the shell.
template <int Dim>
VoidRegion<Dim> regionOf(const VoidSetting<Dim>& setting);

/// Holes of 1.5 to 2.5 largest spheres (radius in mm), to six digits.
SizeDistribution defaultVoidRadius(double largestSphere);

/// The shorter half-axis b without the factor of the recipe: as requested, or holes of 1.5 to 2.5
/// largest spheres.
/// @param chosen  receives a sentence on each default; may be null.
template <int Dim>
SizeDistribution voidRadii(const VoidSetting<Dim>& setting,
                           std::vector<std::string>* chosen = nullptr);

/// Sizes and directions of the voids. @param chosen  as for `voidRadii`.
template <int Dim>
VoidShape<Dim> voidShapeOf(const VoidSetting<Dim>& setting,
                           std::vector<std::string>* chosen = nullptr);

/// The mean of `setting.bvtv` over the part that voids are cut into.
template <int Dim>
double meanBvtv(const VoidSetting<Dim>& setting);

/// The lists of voids of one method. The amount is the number of voids for each unit of volume
/// (boolean), their number (overlay), the probability that a box has one (grid), or the factor on
/// their half-axes (foam).
template <int Dim>
struct VoidFamily {
    double most = 0;       ///< the largest amount
    double guess = 0;      ///< amount for the target, estimated
    double steepness = 0;  ///< as in `solveForBvtv`
    std::string remedy;
    double leastHalfAxis = 0;
    std::function<std::vector<Ellipsoid<Dim>>(double amount)> list;
    /// Makes further lists follow BV/TV by place, for voids that are stamped as the options say;
    /// empty: they do already, or it is the same everywhere. @throws as `localDilation`
    std::function<void(const StampOptions<Dim>& stamp)> follow{};
};

/// @param setting  must outlive the family.
/// @param bvtv     the target, for the first guess.
/// @param chosen   as for `voidRadii`.
/// @throws ParameterError, InputError, Interrupted
template <int Dim>
VoidFamily<Dim> voidFamily(const VoidSetting<Dim>& setting, double bvtv,
                           std::vector<std::string>* chosen);

}  // namespace vdbpack
