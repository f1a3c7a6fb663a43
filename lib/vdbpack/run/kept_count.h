// Private to runs: how many spheres of a trial pack remain once the voids are cut.
#pragma once

#include "vdbpack/run/stages.h"

#include <optional>
#include <vector>

namespace vdbpack {

/// Cuts the voids of a run into a trial pack for its target count, and counts what remains.
/// @param existing  spheres that always remain, and do not count.
/// @param largest   radius of the spheres of the trial, mm.
/// @param voids     of all trials, and then of the run, where one list serves all; else none.
/// @throws as makeVoids
template <int Dim>
double keptCount(const Run<Dim>& run, const std::vector<Sphere<Dim>>& existing,
                 const std::vector<Sphere<Dim>>& trial, double largest,
                 std::optional<MadeVoids<Dim>>& voids);

}  // namespace vdbpack
