// Private to views: the outline of a domain of the plane.
#pragma once

#include "vdbpack/preview/preview.h"

#include <vector>

namespace vdbpack {

/// The zero line of a field as line segments, two ends each, mm (marching squares).
std::vector<Vec<2>> contourLines(const PlaneField& field);

}  // namespace vdbpack
