// Where the spheres of a pack lie as a whole, against the domain.
#pragma once

#include "vdbpack/core/ranks.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <array>
#include <optional>
#include <vector>

namespace vdbpack {

/// Center of mass of spheres of one density less the centroid of the domain.
struct MassOffset {
    /// Along each axis, mm; nothing along axes that repeat, and in 2D along z.
    std::array<std::optional<double>, 3> axes;
    double length = 0;  ///< mm
    double share = 0;   ///< length / the longest side of the domain's bounds
};

/// The same for any number of threads and ranks.
/// @param spheres  with centers in the domain. @param ranks  of whose spheres these are a share;
///                 null: they are all.
/// @return nothing without spheres, in a cell that repeats along all axes, or where the domain does
///         not know its centroid.
template <int Dim>
std::optional<MassOffset> massOffset(const std::vector<Sphere<Dim>>& spheres,
                                     const Domain<Dim>& domain, Ranks* ranks = nullptr);

}  // namespace vdbpack
