// Thickness of the solid that remains between voids.
#pragma once

#include "vdbpack/domain/domain.h"

#include <functional>
#include <optional>

namespace vdbpack {

class VdbGrid;

/// Tb.Th, mm: mean local thickness of a solid level set over the part of a domain that lies in a
/// box and deeper than a shell, as `measureMorphometry` defines it.
/// @param box    mm; where the domain continues beyond it, the surface there bounds the balls, too.
/// @param shell  mm; 0: all of the domain.
/// @return nothing if there is no solid in it. @throws as `sampleLevelSet`.
std::optional<double> trabecularThickness(const VdbGrid& solid, const Box<3>& box,
                                          const Domain<3>& domain, const ShellThickness& shell);

/// The same in a plane, by discs, as the local thickness of a section.
/// @param voidDistance  to the voids at a point, mm, negative in them.
/// @param origin        center of a voxel, mm.
std::optional<double> trabecularThickness(const std::function<double(const Vec<2>&)>& voidDistance,
                                          const Domain<2>& domain, const ShellThickness& shell,
                                          const Vec<2>& origin, double voxelSize);

}  // namespace vdbpack
