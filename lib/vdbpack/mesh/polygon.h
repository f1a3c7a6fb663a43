// Triangles of polygons.
#pragma once

#include "vdbpack/core/vec.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// How the triangles of a polygon came about.
enum class PolygonSplit {
    fan,     ///< from the first corner, which sees all others
    ears,    ///< cut off one by one
    crossed  ///< a fan that folds back: the outline crosses itself
};

/// Cuts a polygon into triangles that name its corners by their position and face the same way.
///
/// A fan from the first corner wherever that covers the polygon once, as for all convex ones; else
/// ears are cut off in the plane that fits best (Meisters 1975, doi:10.2307/2319703), those without
/// area last. Each side of the outline belongs to one triangle. Corners may coincide, as where the
/// outline runs to a hole and back.
///
/// @param corners    three or more, finite, in order around; about in a plane.
/// @param triangles  two less than corners.
///
/// Cost: n log n in practice; corners that point inward are looked up in a grid.
PolygonSplit splitPolygon(const std::vector<Vec<3>>& corners,
                          std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace vdbpack
