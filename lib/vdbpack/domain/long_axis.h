// The direction in which a domain is longest.
#pragma once

#include "vdbpack/domain/domain_source.h"

namespace vdbpack {

/// The first principal axis of what a domain has inside, of length one, its largest component
/// positive: exact for the mesh of a whole file, else from cells of 1/100 of the longest side.
/// @param built  from `source`. @throws InputError for a domain that is not longer than wide
template <int Dim>
Vec<Dim> longAxis(const DomainSource& source, const DomainSource::Built& built);

}  // namespace vdbpack
