// Solid fraction in the cells of a coarse grid, and how much it varies.
#pragma once

#include "vdbpack/core/ranks.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdbpack {

/// Solid fraction in the cells of a coarse grid.
struct LocalFraction {
    double edge = 0;          ///< of a cell, mm
    std::uint64_t cells = 0;  ///< whose circumscribed sphere lies in the domain
    double mean = 0, sd = 0;  ///< over those
};

/// Cubes (2D: squares) laid over the middle of the domain's bounds; those near the wall do not
/// count. Spheres within a cell are taken exactly, others by 32 points each: about 0.001 of the
/// deviation at ten mean radii comes from that.
/// @param rows  where ranks share the pack: called by all of them.
/// @return nothing if no cell counts.
/// @throws ParameterError for an edge that is not positive or gives more than 1e8 cells.
template <int Dim>
std::optional<LocalFraction> localFraction(const std::vector<Sphere<Dim>>& spheres,
                                           const Domain<Dim>& domain, double edge,
                                           const SphereRows& rows = {});

}  // namespace vdbpack
