// Private to runs: voids, from what is asked for to what is cut.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/field/solid.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/report/report.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/void_families.h"
#include "vdbpack/voids/void_field.h"
#include "vdbpack/voids/void_recipe.h"

#include <functional>
#include <memory>
#include <vector>

namespace vdbpack {

/// Voids as they were made. Without such as can be stamped (thinning, or none) all is empty.
template <int Dim>
struct MadeVoids {
    std::vector<Ellipsoid<Dim>> list;
    std::shared_ptr<const StampedVoids<Dim>> stamped;
    /// 3D, once they are measured: `surface`, `voids` and `solid`, on one lattice.
    std::shared_ptr<const VdbGrid> surface, voids;
    Solid solid;
    VoidReport report;

    std::vector<std::shared_ptr<const VdbGrid>> levelSets() const;
};

/// How near to a target BV/TV voids of a list are made.
inline constexpr double kBvtvTolerance = 0.0005;

/// The voxel size of the level sets of voids with half-axes of at least `least` mm: as asked for,
/// else as fine as they need, mm.
double voidVoxelFor(const VoidRecipe& recipe, double least);

/// The voxel size of the voids' level sets as far as a recipe tells, mm; 0: not yet.
double plannedVoxel(const VoidRecipe& recipe, int dim);

/// Depth below the wall up to which the field must know distances for the shell, mm.
double depthForShell(const VoidRecipe& recipe);

/// Refuses what the domain has no room for: a shell without anything inside, voids larger than it
/// is (those of a list only if `early`: `makeVoids` looks at them itself).
/// @throws InputError, ParameterError
template <int Dim>
void checkRoom(const VoidSetting<Dim>& setting, bool early);

/// The voids of a method that needs no sphere (grid, overlay, boolean, list), as many as hit the
/// target where there is one. @throws ParameterError if it cannot be hit, with what can.
template <int Dim>
MadeVoids<Dim> makeVoids(const VoidSetting<Dim>& setting);

/// Packs with holes among the spheres (mixed, ellipses), with the probability that hits the target
/// where there is one. What is returned holds no holes.
/// @param options  without further species.
template <int Dim>
PackResult<Dim> packWithHoles(const VoidSetting<Dim>& setting, const PackOptions& options,
                              const std::vector<Sphere<Dim>>& existing, MadeVoids<Dim>& made);

/// Measures what the voids leave: `solid` and the other level sets, and which share of it and of
/// the contacts of a pack (null: none) is connected with the shell.
template <int Dim>
void measureVoids(const VoidSetting<Dim>& setting, double contactTolerance, const Pack<Dim>* pack,
                  MadeVoids<Dim>& made);

/// Which spheres are connected with the shell, or belong to the largest connected component; sets
/// their share in `report`.
template <int Dim>
std::vector<std::uint8_t> attachedToShell(const VoidSetting<Dim>& setting, double contactTolerance,
                                          const Pack<Dim>& pack, VoidReport& report);

/// Warns where the steps between the possible amounts of voids leave BV/TV off its target.
template <int Dim>
void warnIfOff(const VoidSetting<Dim>& setting, const VoidReport& report);

/// Sets `region`, and takes out of a pack what the voids remove and, if asked for, what is
/// not connected with the shell. The first `standing` spheres stay in any case.
template <int Dim>
void cullPack(const VoidSetting<Dim>& setting, double contactTolerance, std::size_t standing,
              MadeVoids<Dim>& made, Pack<Dim>& pack);

}  // namespace vdbpack
