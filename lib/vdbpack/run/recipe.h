// What a pack is made from, as the command line, the tests and library users fill it in.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/units.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/preview/preview_recipe.h"
#include "vdbpack/run/domain_source.h"
#include "vdbpack/voids/void_recipe.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// Everything that decides a pack: what the command line, the tests and library users fill in.
struct PackRecipe {
    DomainRecipe domain;
    /// SPEC of SizeDistribution::parse, mm; empty: uniform, ratio 1:2, about 100,000 spheres.
    std::string radius;
    WeightBy weightBy = WeightBy::count;  ///< for table:FILE
    double targetCount = 0;               ///< scale the radii to about this many; 0: as given
    std::int64_t maxCount = 0;            ///< stop at this many; 0: when full
    Effort effort = Effort::normal;
    Order order = Order::sweep;
    double gap = 0;  ///< least distance between spheres and to the wall, mm
    /// Solid fraction to reach by moving and adding spheres, as that of DensifyOptions; 0: none.
    double densify = 0;
    VoidRecipe voids;
    std::string existing;              ///< pack file with spheres that stand; empty: none
    Unit packUnit = Unit::millimeter;  ///< of `existing`, if it says none
    std::uint64_t seed = 1;
    int threads = 0;  ///< 0: all cores
    Unit outUnit = Unit::millimeter;
    double contactTolerance = 1e-3;  ///< of the smaller radius
    double memoryLimit = 0;          ///< bytes that may be held; 0: what there is at the start
    std::string density;             ///< of the spheres in DEM files, as `particleDensity` takes it
    std::vector<std::string> outputs;  ///< -o
    std::string reportFile;            ///< .json or .html; empty: none
    PreviewRecipe preview;
    std::string command;  ///< for the report; empty: what is packed
    /// TOML with the options that repeat the run ({seed} for the seed): written beside the first
    /// output as NAME.recipe.toml. Empty: none is written.
    std::string optionsText;
};

/// Refuses before the work what would fail after it: formats, folders, outputs that are inputs.
/// @throws ParameterError, IoError
void checkOutputs(const PackRecipe& recipe);

/// "7", "1..50" or "1,4,9..12" as seeds, in that order.
/// @throws ParameterError for anything else, a range that falls, a seed named twice, or more than
/// a million seeds.
std::vector<std::uint64_t> parseSeeds(const std::string& text);

/// "max" as infinity, or a solid fraction from above 0 to below 1.
/// @throws ParameterError for anything else.
double parseDensify(const std::string& text);

/// The files that voids are made from; empty names where there is none.
std::vector<std::string> voidInputs(const VoidRecipe& recipe);

/// The sizes asked for, or the default, before any scaling.
struct RequestedSizes {
    SizeDistribution sizes;
    double targetCount = 0;           ///< spheres at which to aim by scaling the radii; 0: as given
    std::vector<std::string> chosen;  ///< what was chosen by default, a sentence each
};
/// @throws ParameterError for a bad SPEC or a ratio of sizes beyond the limit.
RequestedSizes requestedSizes(const PackRecipe& recipe, int dim);

/// The distribution with its radii times `factor`: where it is a formula, exactly what the formula
/// says when it is read again.
SizeDistribution scaledSizes(const SizeDistribution& sizes, double factor, int dim);

/// What the recipe asks of the packer, for spheres of these sizes.
PackOptions packOptions(const PackRecipe& recipe, const SizeDistribution& sizes);

/// @throws InputError "file: ..." where ids or orders end so close to 2^63 that none are left for
/// spheres that are added.
void requireRoomToNumber(const Pack<3>& pack, const std::string& file);

/// The spheres of `recipe.existing`; an empty pack if there are none.
/// @throws as readPack; InputError if they don't lie in the plane of a 2D domain at `sliceHeight`.
template <int Dim>
Pack<Dim> readExisting(const PackRecipe& recipe, double sliceHeight);

/// Both packs in one: those of `base` first, with all their attributes and columns. Added spheres
/// get further ids, and 0 or nothing in the columns of `base`. The column `existing` tells which
/// is which.
template <int Dim>
Pack<Dim> joined(Pack<Dim> base, const Pack<Dim>& added);

/// `base` with further spheres, which get further ids and places in the order, and 0 or nothing in
/// its columns. Depths and contacts of all are dropped.
template <int Dim>
Pack<Dim> appended(Pack<Dim> base, const std::vector<Sphere<Dim>>& added);

extern template Pack<2> readExisting(const PackRecipe&, double);
extern template Pack<3> readExisting(const PackRecipe&, double);
extern template Pack<2> appended(Pack<2>, const std::vector<Sphere<2>>&);
extern template Pack<3> appended(Pack<3>, const std::vector<Sphere<3>>&);
extern template Pack<2> joined(Pack<2>, const Pack<2>&);
extern template Pack<3> joined(Pack<3>, const Pack<3>&);

}  // namespace vdbpack
