// Private to runs: how many spheres of a front remain once the voids are cut.
#pragma once

#include "vdbpack/run/recipe.h"
#include "vdbpack/run/stages.h"

namespace vdbpack {

/// The share of a domain that voids leave (`Fill::solid`), or of the spheres that fill it,
/// estimated before there are voids; 1 without voids.
double keptShare(const VoidRecipe& voids, const Extent& extent);

/// Cuts the voids of a run into trial packs.
template <int Dim>
class KeptCount {
public:
    /// @param existing  spheres that always remain, and do not count.
    KeptCount(const Run<Dim>& run, const std::vector<Sphere<Dim>>& existing)
        : run_(run), existing_(existing) {}

    /// @param largest  radius of the spheres of the trial, mm.
    /// @throws as makeVoids
    double operator()(const std::vector<Sphere<Dim>>& trial, double largest);

    /// The voids of the trials, where one list serves all; else none.
    std::optional<MadeVoids<Dim>>& voids() { return voids_; }

private:
    const Run<Dim>& run_;
    const std::vector<Sphere<Dim>>& existing_;
    std::optional<MadeVoids<Dim>> voids_;
};

}  // namespace vdbpack
