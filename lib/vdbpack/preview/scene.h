// Private to previews: the scene to draw and its description, in the plane and in space.
#pragma once

#include "vdbpack/preview/caption.h"
#include "vdbpack/preview/preview.h"

#include <cstddef>
#include <string>

namespace vdbpack {

/// The bounds of all spheres, mm. @throws ParameterError for a center or radius that is not finite,
/// or a radius that is not positive.
template <int Dim>
Box<Dim> boundsOf(const Pack<Dim>& pack);

/// Refuses a cut and a view of a plane. @throws ParameterError
void refuseInPlane(const PreviewOptions& options);

/// The options with the side that the cut keeps as `view` says. @throws ParameterError for a view
/// that sees the cut edge-on.
PreviewOptions facingCut(PreviewOptions options);

/// The camera of a scene and the caption below it.
struct SpaceFrame {
    PreviewCamera camera;
    Caption caption;
};
/// @param options  as `facingCut` returns them. @throws as `checkScene`
SpaceFrame frameOf(const SpacePreview& scene, const PreviewOptions& options, const Legend& legend);

/// The bounds of a scene, mm. @throws ParameterError for a size out of bounds, an empty scene, or a
/// cut that misses it.
Box<3> checkScene(const SpacePreview& scene, const PreviewOptions& options);

/// Sets the title and the description of a picture.
void describe(const std::string& title, const std::string& description, Picture& image);

/// A count with separators: 12,345.
std::string groupedCount(std::size_t n);

}  // namespace vdbpack
