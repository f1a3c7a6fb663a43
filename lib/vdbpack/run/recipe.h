// The recipe of a pack, and what follows from it.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/options/recipes.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/voids/void_recipe.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

class ScalarField;

/// Refuses before the work what would fail after it: formats, folders, outputs that are inputs,
/// settings that exclude one another. @throws ParameterError, IoError
void checkRecipe(const PackRecipe& recipe);

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
