// The recipe of a pack, and what follows from it.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/formats/joined_packs.h"
#include "vdbpack/options/recipes.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/voids/void_recipe.h"

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

/// Spheres of a pack for which nothing else is requested.
inline constexpr double kDefaultCount = 100'000;

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

/// What differs by place in the sizes of a domain.
/// @param sliceHeight  2D: height of the plane, mm.
/// @throws as `factorsOver`
template <int Dim>
LocalSizes localSizes(const PackRecipe& recipe, const RequestedSizes& requested,
                      const Domain<Dim>& domain, double sliceHeight, const ShellThickness& shell);

/// The options of the packer for spheres of these sizes.
PackOptions packOptions(const PackRecipe& recipe, const SizeDistribution& sizes);

/// The spheres of `recipe.existing`; an empty pack if there are none.
/// @throws as readPack; InputError if they don't lie in the plane of a 2D domain at `sliceHeight`.
template <int Dim>
Pack<Dim> readExisting(const PackRecipe& recipe, double sliceHeight,
                       const Callbacks& callbacks = {});

}  // namespace vdbpack
