// Pair correlation of sphere centers.
#pragma once

#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/ranks.h"
#include "vdbpack/core/sphere.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdbpack {

/// The pair correlation g(r): density of centers at distance r from a center / mean density.
struct PairCorrelation {
    double width = 0;              ///< of a bin, mm; the first begins at 0
    std::vector<double> g;         ///< mean over each bin; 1 where there is no order
    std::vector<double> error;     ///< standard error of each, from the number of pairs in it
    std::uint64_t references = 0;  ///< number of centers used
    double density = 0;            ///< mean density of centers, mm^-dim
};

/// Uses centers that are at least `reach` deep, so that no spherical shell leaves the domain; at
/// most a fixed choice of 100,000 of them. Spheres of all sizes have the same weight.
///
/// @param depth   distance of each center to the wall, mm; empty in a cell without walls.
/// @param reach   mm, > 0; at most half the length of a periodic cell, beyond which centers are
///                paired with several images of one.
/// @param volume  of the part of the domain that is at least `reach` deep (2D: area), mm^dim: with
///                the centers in it, the mean density.
/// @param bins    > 0.
/// @param rows    where ranks share the pack: called by all of them, with the same arguments but
///                for the spheres of each.
/// @param cell    in which the spheres repeat: images count; not over ranks.
/// @return nothing for fewer than 100 references, with which g is noise.
/// @throws ParameterError for other arguments, InputError for an unusable sphere.
/// The same for any number of threads and ranks. Cost: about 1 microsecond per reference at `reach`
/// of three mean diameters.
template <int Dim>
std::optional<PairCorrelation> pairCorrelation(const std::vector<Sphere<Dim>>& spheres,
                                               const std::vector<float>& depth, double reach,
                                               double volume, int bins, const SphereRows& rows = {},
                                               const PeriodicCell<Dim>& cell = {});

}  // namespace vdbpack
