// Private to runs: domains from label maps and CT.
#pragma once

#include "vdbpack/image/image.h"
#include "vdbpack/image/image_surface.h"
#include "vdbpack/run/domain_source.h"
#include "vdbpack/voids/void_recipe.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// The image of a recipe, in its world and in mm. @throws as `readImage`
Image readDomainImage(const DomainRecipe& recipe, const Callbacks& callbacks);

/// Refuses, before the work, a file that is no image by its name or is not there.
/// @param setting  for messages. @throws ParameterError, IoError
void requireGreyImage(const std::string& setting, const std::string& file);

/// Refuses, before the work, fields of voids whose files are of no known type or are not there.
/// @throws ParameterError, IoError
void requireVoidFields(const VoidRecipe& voids);

/// An image of one layer whose grey values are looked up, in the world of a domain.
/// @throws as `readImage`; InputError for one of several layers
Image readGreyImage(const std::string& file, const DomainRecipe& domain,
                    const Callbacks& callbacks);

/// BV/TV by place as a recipe of voids says; empty: the same everywhere.
/// @param domain  whose world an image lies in; in the plane at `sliceHeight`, mm.
/// @param bounds  of the domain. Warns where it reaches beyond an image.
/// @throws as `readImage` and `readScalarField`; InputError for an image of several layers or one
///         that lies elsewhere, and for another field that does not cover `bounds`
template <int Dim>
std::function<double(const Vec<Dim>&)> bvtvField(const VoidRecipe& voids,
                                                 const DomainRecipe& domain, const Box<Dim>& bounds,
                                                 double sliceHeight, const Callbacks& callbacks);

/// Warns of a part that the border of its image cuts off.
void warnOfBorder(const LabelPart& part, const ImageGrid& grid, const std::string& path,
                  const Callbacks& callbacks);

/// The surface, mm, of what a recipe selects of an image: a label or labels joined, or the values
/// from a threshold on.
/// @throws ParameterError if it selects nothing that there is, or several parts; else as
/// `readImage`.
/// @param grid, spaced  those of the image.
TriangleMesh imageMesh(const DomainRecipe& recipe, const Callbacks& callbacks,
                       std::optional<ImageGrid>& grid, bool& spaced);

}  // namespace vdbpack
