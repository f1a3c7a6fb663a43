// The recipe of a pack, and what follows from it.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/run/domain_source.h"
#include "vdbpack/run/settings.h"
#include "vdbpack/voids/scalar_field.h"
#include "vdbpack/voids/void_recipe.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// What a pack is made from.
struct PackRecipe : RunSettings {
    DomainRecipe domain;
    /// SPEC of SizeDistribution::parse, mm; empty: uniform, ratio 1:2, about 100,000 spheres.
    std::string radius;
    double radiusFactor = 1;  ///< on all radii
    /// File with a factor on the radii by place: as `readScalarField` reads it, or an image; empty:
    /// none.
    std::string sizeField;
    /// SPEC of the radii in the shell of `voids`, mm; empty: radii of all.
    std::string shellRadius;
    WeightBy weightBy = WeightBy::count;  ///< for table:FILE
    double targetCount = 0;               ///< scale the radii to about this many; 0: as given
    std::int64_t maxCount = 0;            ///< stop at this many; 0: when full
    Effort effort = Effort::normal;
    Order order = Order::sweep;
    double blockSide = 0;  ///< edge of a block, mm, as in PackOptions; 0: chosen
    double gap = 0;        ///< least distance between spheres and to the wall, mm
    /// Solid fraction to reach by moving and adding spheres, as in DensifyOptions; 0: none.
    double densify = 0;
    VoidRecipe voids;
    std::string existing;  ///< pack file with spheres to pack around; empty: none
    /// What a program has in memory, mm, in place of the file that `existing` names in messages.
    std::shared_ptr<const Pack<3>> givenExisting;
    Unit packUnit = Unit::millimeter;  ///< of `existing`, if the file states none
    /// What several parts are filled with, each in a domain of its own: bone and implant. Where
    /// they overlap, the later one has the space. Of a part, files and threads are not used; empty:
    /// `domain` is the only one, unless its `label` names several.
    std::vector<PackRecipe> parts;
    std::string name;       ///< of a part, in reports and level sets
    std::string partsFile;  ///< that `parts` were read from; empty: none
};

/// Refuses before the work what would fail after it: formats, folders, outputs that are inputs,
/// settings that exclude one another. @throws ParameterError, IoError
void checkRecipe(const PackRecipe& recipe);

/// "7", "1..50" or "1,4,9..12" as seeds, in that order.
/// @throws ParameterError for anything else, a range that falls, a seed named twice, or more than
/// a million seeds.
std::vector<std::uint64_t> parseSeeds(const std::string& text);

/// `name` with each {seed} replaced.
std::string withSeed(std::string name, std::uint64_t seed);

/// Sets the seed, and puts it in place of {seed} in names of files.
void setSeed(RunSettings& settings, std::uint64_t seed);

/// The recipe of a run with one of several seeds.
template <class Recipe>
Recipe recipeForSeed(Recipe recipe, std::uint64_t seed) {
    setSeed(recipe, seed);
    return recipe;
}

/// "max" as infinity, or a solid fraction from above 0 to below 1.
/// @throws ParameterError for anything else.
double parseDensify(const std::string& text);

/// The files that voids are made from; empty names where there is none.
std::vector<std::string> voidInputs(const VoidRecipe& recipe);

/// The requested sizes, or the default, before any scaling.
struct RequestedSizes {
    SizeDistribution sizes;
    double targetCount = 0;           ///< spheres at which to aim by scaling the radii; 0: as given
    std::vector<std::string> chosen;  ///< what was chosen by default, a sentence each
    std::optional<SizeDistribution> shellSizes;  ///< in the shell; none: sizes of all
    std::shared_ptr<const ScalarField> factor;   ///< on all radii by place; null: 1

    bool differByPlace() const { return factor || shellSizes; }
    /// The smallest and the largest radius anywhere, mm.
    double least() const;
    double largest() const;
    /// What the field of the domain is to resolve, mm (`FieldOptions::detail`): the finest sizes
    /// where the factor is the middle one. For the smallest factor it would have most of its voxels
    /// where none are needed, and spheres at walls are tested by the triangles anyway.
    double detail() const;
    /// Mean volume (2D: area) of a sphere where `shell` of the domain is shell, about, mm^dim.
    double meanBall(int dim, double shell) const;
};
/// @throws ParameterError for a bad SPEC or a ratio of sizes beyond the limit.
RequestedSizes requestedSizes(const PackRecipe& recipe, int dim);

/// The options of the packer for spheres of these sizes.
PackOptions packOptions(const PackRecipe& recipe, const SizeDistribution& sizes);

/// @throws InputError "file: ..." where ids or orders end so close to 2^63 that none are left for
/// spheres that are added.
template <int Dim>
void requireRoomToNumber(const Pack<Dim>& pack, const std::string& file);

/// The spheres of `recipe.existing`; an empty pack if there are none.
/// @throws as readPack; InputError if they don't lie in the plane of a 2D domain at `sliceHeight`.
template <int Dim>
Pack<Dim> readExisting(const PackRecipe& recipe, double sliceHeight);

/// Both packs in one: those of `base` first, with all their attributes and columns. Added spheres
/// get further ids, and 0 or nothing in the columns of `base`. The column `existing` marks the
/// spheres of `base`.
template <int Dim>
Pack<Dim> joined(Pack<Dim> base, const Pack<Dim>& added);

/// `base` with further spheres, which get further ids and places in the order, and 0 or nothing in
/// its columns. Depths and contacts of all are dropped.
template <int Dim>
Pack<Dim> appended(Pack<Dim> base, const std::vector<Sphere<Dim>>& added);

}  // namespace vdbpack
