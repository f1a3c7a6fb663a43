// Private to voids: stamps a list of voids and measures the solid that it leaves.
#pragma once

#include "vdbpack/voids/make_voids.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace vdbpack {

/// The voxel size of the level sets of voids with half-axes of at least `least` mm: `voidVoxelFor`,
/// unless it is requested, such that a whole number of voxels makes the shortest length along which
/// a domain repeats: then each of its planes counts once.
template <int Dim>
double voxelFor(const VoidSetting<Dim>& setting, double least);

template <int Dim>
StampOptions<Dim> stampOptions(const VoidSetting<Dim>& setting, double voxelSize);

/// Stamps `made.list`, and cuts it where components are to be removed; sets and returns BV/TV.
template <int Dim>
double bvtvOf(const VoidSetting<Dim>& setting, double voxelSize, MadeVoids<Dim>& made);

/// The level sets of space; what is dropped of the solid is taken off BV/TV.
void cut(const VoidSetting<3>& setting, MadeVoids<3>& made);
inline void cut(const VoidSetting<2>&, MadeVoids<2>&) {}

/// Tb.Th of what voids leave, mm: near the deepest point, since a part of a large bone represents
/// the thickness of all of it. Nothing: no solid is left.
template <int Dim>
std::optional<double> thicknessOf(const VoidSetting<Dim>& setting, MadeVoids<Dim>& made,
                                  const Vec<Dim>& deepest);

/// The longest half-axis of all, mm; 0 if there are none.
template <int Dim>
double longestHalfAxis(const std::vector<Ellipsoid<Dim>>& voids) {
    double longest = 0;
    for (const auto& e : voids) longest = std::max({longest, e.a, e.b});
    return longest;
}

/// Refuses voids that are larger than the domain. @throws ParameterError
template <int Dim>
void requireFitting(const VoidSetting<Dim>& setting, double halfAxis);

/// Warns if BV/TV misses its target, since the amount of voids changes in steps.
template <int Dim>
void warnIfOff(const VoidSetting<Dim>& setting, const VoidReport& report);

}  // namespace vdbpack
