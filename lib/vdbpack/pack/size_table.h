// Private: tables of radii and weights, and grading curves, as files of two columns.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

enum class SizeTable { weights, sieve };

/// Rows of a radius and its weight, or of a diameter and percent finer by mass; lengths in mm.
///
/// The columns are read by the names of the first line, or of the comment above it: radius or
/// diameter, with a unit ("d [mm]", diameter_um), and a weight, or percent finer (passing) or
/// coarser (retained, which is subtracted from 100), in either order. Without names: radius, weight
/// (curve: diameter, percent finer), in mm.
/// @throws InputError naming line or columns that are not understood; IoError
std::vector<std::pair<double, double>> readSizeTable(const std::string& path, SizeTable kind);

}  // namespace vdbpack
