// Private to runs: domains from label maps and CT.
#pragma once

#include "vdbpack/image/image.h"
#include "vdbpack/image/image_surface.h"
#include "vdbpack/run/domain_source.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// The image of a recipe, in its world and in mm. @throws as `readImage`
Image readDomainImage(const DomainRecipe& recipe, const Callbacks& callbacks);

/// Warns of a part that the border of its image cuts off.
void warnOfBorder(const LabelPart& part, const ImageGrid& grid, const std::string& path,
                  const Callbacks& callbacks);

/// The surface, mm, of what a recipe selects of an image: a label or labels joined, or the values
/// from a threshold on.
/// @throws ParameterError if it selects nothing that there is, or several parts; else as
/// `readImage`.
TriangleMesh imageMesh(const DomainRecipe& recipe, const Callbacks& callbacks);

}  // namespace vdbpack
