// Private to runs: warnings of packs that can hardly be used.
#pragma once

#include "vdbpack/run/stages.h"

namespace vdbpack {

/// Warns if contacts connect few of the spheres with one another or, with voids, with the shell.
/// Not of packs with a gap; of densified ones by voids alone.
template <int Dim>
void warnOfLooseSpheres(const Run<Dim>& run);

/// Warns if the spheres fill little of a solid that they are packed into (`Fill::solid`), deeper
/// than the shell: its trabeculae are hardly thicker than they are.
template <int Dim>
void warnOfThinSolid(const Run<Dim>& run);

/// Warns if a pack is nearly empty, because its radii hardly fit into the domain.
/// @param largest  radius, mm.
template <int Dim>
void warnOfFewSpheres(const Run<Dim>& run, double largest);

/// Warns if by far not `target` spheres are left of those that were packed.
template <int Dim>
void warnOfCount(const Run<Dim>& run, double target);

/// Warns if the spheres are larger than the voids that are cut into their pack: BV/TV is that of
/// the level set, which such a pack cannot show.
template <int Dim>
void warnOfSmallVoids(const Run<Dim>& run);

/// @param before  spheres of the pack (of this rank) before the voids were cut.
/// @throws ParameterError if none of them remains
template <int Dim>
void requireSpheresLeft(const Run<Dim>& run, std::uint64_t before);

}  // namespace vdbpack
