// Thickness of what voids leave of a bone.
#pragma once

#include "vdbpack/domain/domain.h"

#include <optional>

namespace vdbpack {

class VdbGrid;

/// Tb.Th, mm: mean local thickness of a solid level set over the part of a domain that lies in a
/// box and deeper than a shell, as `measureMorphometry` defines it.
/// @param box    mm; what lies beyond it bounds the balls where the domain goes on there.
/// @param shell  mm; 0: all of the domain.
/// @return nothing where no solid lies there. @throws as `sampleLevelSet`.
std::optional<double> trabecularThickness(const VdbGrid& solid, const Box<3>& box,
                                          const Domain<3>& domain, double shell);

}  // namespace vdbpack
