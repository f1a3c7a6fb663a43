// Level sets as arrays, and back.
#pragma once

#include "vdbpack/core/vec.h"

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace vdbpack {

class VdbGrid;

/// Signed distances at the points of a lattice along x, y and z, negative inside; mm.
struct DenseLevelSet {
    std::array<std::size_t, 3> size{};
    Vec<3> origin;              ///< of the first point
    double spacing = 1;         ///< between neighbors
    std::vector<float> values;  ///< z fastest, then y, then x
};

/// The level set of an array; what lies three spacings from the surface is cut to that distance.
/// @throws InputError if values are not finite, if there is no surface, or if the solid reaches the
/// border of the array; ParameterError for a useless size or spacing; ResourceError
std::shared_ptr<const VdbGrid> levelSetOf(const DenseLevelSet& dense, const std::string& name);

/// The box around the band of a level set, with all its values. @throws ResourceError
DenseLevelSet denseLevelSet(const VdbGrid& grid);

}  // namespace vdbpack
