// Domains from label maps and CT.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/image/image.h"
#include "vdbpack/image/image_surface.h"

#include <optional>
#include <string>

namespace vdbpack {

/// The image of a recipe, in its world and in mm. @throws as `readImage`
Image readDomainImage(const DomainRecipe& recipe, const Callbacks& callbacks);

/// Refuses, before the work, a file that is no image by its name or is not there.
/// @param setting  for messages. @throws ParameterError, IoError
void requireGreyImage(const std::string& setting, const std::string& file);

/// An image of one layer whose grey values are looked up, in the world of a domain.
/// @throws as `readImage`; InputError for one of several layers
Image readGreyImage(const std::string& file, const DomainRecipe& domain,
                    const Callbacks& callbacks);

/// The labels of the image of a recipe without threshold. Warns of an asked label of an image that
/// seems to be grey. @throws ParameterError if it has none
std::vector<LabelCount> requiredLabels(const DomainRecipe& recipe, const Image& image,
                                       const Callbacks& callbacks = {});

/// The labels that a recipe selects of an image without threshold.
/// @param labels  of the image. @throws ParameterError if it selects nothing, or several parts.
LabelPart selectedPart(const DomainRecipe& recipe, const std::vector<LabelCount>& labels);

/// Warns once of the parts that the border of their image cuts off.
void warnOfBorder(const std::vector<LabelPart>& parts, const ImageGrid& grid,
                  const std::string& path, const Callbacks& callbacks);
/// The same of what a threshold takes of an image.
void warnOfBorder(const Image& image, double threshold, const std::string& path,
                  const Callbacks& callbacks);

/// The surface, mm, of what a recipe selects of an image: a label or labels joined, or the values
/// from a threshold on.
/// @throws ParameterError if it selects nothing that there is, or several parts; else as
/// `readImage`.
/// @param recipe  whose threshold is found, if it is Otsu's.
/// @param grid    of the image. @param spaced  whether its file states distances of voxels.
/// @param sided   as `Image::isSided`.
TriangleMesh imageMesh(DomainRecipe& recipe, const Callbacks& callbacks,
                       std::optional<ImageGrid>& grid, bool& spaced, bool& sided);

}  // namespace vdbpack
