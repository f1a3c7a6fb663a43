// Private: planar slices of meshes.
#pragma once

#include "vdbpack/domain/mesh_domain.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace vdbpack {

/// The plane z = `height` of a mesh domain.
/// @param facing  per triangle: 1 if its normal points out of the domain, -1 if into it; empty if
///        that is unknown (a mesh with flaws): the field then decides inside and outside.
/// @param envelope  what `Domain::envelope` is to be; null: the slice itself.
/// @throws InputError if the plane misses the domain.
std::shared_ptr<const Domain<2>> meshSlice(std::shared_ptr<const MeshDomain> domain,
                                           const std::vector<std::int8_t>& facing, double height,
                                           std::shared_ptr<const Domain<2>> envelope);

}  // namespace vdbpack
