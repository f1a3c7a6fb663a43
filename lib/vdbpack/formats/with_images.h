// Packs of periodic cells for viewers, which know no periodic boundaries.
#pragma once

#include "vdbpack/core/pack.h"

namespace vdbpack {

/// Column of the id of the sphere that each one is an image of; its own, if it is none.
inline constexpr const char* kImageColumn = "image_of";

/// The pack of a periodic cell with the images that protrude into the cell behind its own spheres,
/// and without the cell. An image has the attributes of its sphere and an id of its own.
template <int Dim>
Pack<Dim> withImages(const Pack<Dim>& pack);

}  // namespace vdbpack
