// Makes voids, from the recipe to the cut.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/field/solid.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/void_field.h"
#include "vdbpack/voids/void_recipe.h"
#include "vdbpack/voids/void_report.h"

#include <functional>
#include <memory>
#include <vector>

namespace vdbpack {

struct PackOptions;
template <int Dim>
struct PackResult;
template <int Dim>
struct VoidSetting;

/// Voids and what they leave. All members are empty without voids, and for methods that only thin.
template <int Dim>
struct MadeVoids {
    std::vector<Ellipsoid<Dim>> list;
    std::shared_ptr<const StampedVoids<Dim>> stamped;
    /// 3D, once they are measured: `surface`, `voids` and `solid`, on one lattice.
    std::shared_ptr<const VdbGrid> surface, voids;
    Solid solid;
    VoidReport report;
    std::shared_ptr<KnownCore<Dim>> core;  ///< while they are made

    std::vector<std::shared_ptr<const VdbGrid>> levelSets() const;
};

/// Sets the thickness of the shell.
template <int Dim>
void noteShell(const VoidSetting<Dim>& setting, VoidReport& report);

/// Tolerance of the target BV/TV: of what is smaller, the solid or the voids, a share.
double bvtvTolerance(const VoidRecipe& recipe);

/// The voxel size of the level sets of voids with half-axes of at least `least` mm: as requested,
/// otherwise as fine as the voids need, mm.
double voidVoxelFor(const VoidRecipe& recipe, double least);

/// The voxel size of the level sets of voids if it follows from the recipe alone, mm; otherwise 0.
double plannedVoxel(const VoidRecipe& recipe, int dim);

/// Depth of the distance field that the shell and voids packed behind it need, mm.
/// @param voxel          of the voids, mm; 0: unknown.
/// @param largestSphere  mm: default sizes of voids follow from it.
double depthForVoids(const VoidRecipe& recipe, double voxel, double largestSphere, int dim);

/// Refuses a shell that leaves no core, and voids larger than the domain (voids of a list only if
/// `early`, since `makeVoids` checks them).
/// @throws InputError, ParameterError
template <int Dim>
void checkRoom(const VoidSetting<Dim>& setting, bool early);

/// The voids of a method that needs no spheres (grid, overlay, boolean, foam, list), as many or as
/// large as reach the target if there is one.
/// @throws ParameterError if the target cannot be reached, with the bound.
template <int Dim>
MadeVoids<Dim> makeVoids(const VoidSetting<Dim>& setting);

/// The same for a domain alone, with all checks, and in space with the level sets of the solid:
///
///     VoidRecipe recipe;
///     BooleanVoids voids;
///     voids.shape.radius = SizeDistribution::uniform(1, 2);
///     voids.targetBvtv = 0.3;
///     recipe.method = voids;
///     const MadeVoids<3> made = makeVoids(*boxDomain(box), recipe);
///
/// BV/TV by place and a specimen (`like`) are for whole runs.
template <int Dim>
MadeVoids<Dim> makeVoids(const Domain<Dim>& domain, const VoidRecipe& recipe,
                         std::uint64_t seed = 1, const Callbacks& callbacks = {});

/// Packs with holes among the spheres (mixed, ellipses), with the probability that reaches the
/// target if there is one. The returned pack contains no holes.
/// @param setting  of a recipe for `FrontHoles`.
/// @param options  without further species.
template <int Dim>
PackResult<Dim> packWithHoles(const VoidSetting<Dim>& setting, const PackOptions& options,
                              const std::vector<Sphere<Dim>>& existing, MadeVoids<Dim>& made);

/// Measures the solid without voids: `solid` and the other level sets, and which share of it and of
/// the spheres of a pack (null: none) is connected to the shell.
template <int Dim>
void measureVoids(const VoidSetting<Dim>& setting, double contactTolerance, const Pack<Dim>* pack,
                  MadeVoids<Dim>& made);

/// Which spheres are connected to the shell, or belong to the largest connected component; sets
/// their share in `report`.
template <int Dim>
std::vector<std::uint8_t> attachedToShell(const VoidSetting<Dim>& setting, double contactTolerance,
                                          const Pack<Dim>& pack, VoidReport& report);

/// Sets `region`, and removes from a pack the spheres that the voids cull and, if requested, those
/// not connected to the shell. The first `standing` spheres are always kept.
template <int Dim>
void cullPack(const VoidSetting<Dim>& setting, double contactTolerance, std::size_t standing,
              MadeVoids<Dim>& made, Pack<Dim>& pack);

}  // namespace vdbpack
