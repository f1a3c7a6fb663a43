// Packs of periodic cells for viewers, which know no periodic boundaries.
#pragma once

#include "vdbpack/core/pack.h"

namespace vdbpack {

/// The pack of a periodic cell with the images that protrude into the cell behind its own spheres,
/// and without the cell. An image has the attributes of its sphere and an id of its own; the column
/// `image_of` holds the id of the sphere, for the spheres of the cell their own.
template <int Dim>
Pack<Dim> withImages(const Pack<Dim>& pack);

}  // namespace vdbpack
