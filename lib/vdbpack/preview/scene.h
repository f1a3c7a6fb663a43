// Private to previews: the scene to draw and its description, in the plane and in space.
#pragma once

#include "vdbpack/preview/preview.h"

#include <cstddef>
#include <string>

namespace vdbpack {

/// The bounds of all spheres, mm. @throws ParameterError for a center or radius that is not finite,
/// or a radius that is not positive.
template <int Dim>
Box<Dim> boundsOf(const Pack<Dim>& pack);

/// The bounds of a scene, mm. @throws ParameterError for a size out of bounds, an empty scene, or a
/// cut that misses it.
Box<3> checkScene(const SpacePreview& scene, const PreviewOptions& options);

/// Sets the title and the description of a picture.
void describe(const std::string& title, const std::string& description, Picture& image);

/// A count with separators: 12,345.
std::string groupedCount(std::size_t n);

}  // namespace vdbpack
