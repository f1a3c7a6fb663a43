// Private to runs: warnings of packs that can hardly be used.
#pragma once

#include "vdbpack/run/stages.h"

namespace vdbpack {

/// Warns if contacts connect few of the spheres with one another or, with voids, with the shell.
/// Not of packs with a gap, nor of densified ones, whose spheres touch within a tolerance only.
template <int Dim>
void warnOfLooseSpheres(const Run<Dim>& run);

/// Warns if the spheres are larger than the voids that are cut into their pack: BV/TV is that of
/// the level set, which such a pack cannot show.
template <int Dim>
void warnOfSmallVoids(const Run<Dim>& run);

/// @param before  spheres of the pack before the voids were cut.
/// @throws ParameterError if none of them remains
template <int Dim>
void requireSpheresLeft(const Run<Dim>& run, std::size_t before);

}  // namespace vdbpack
