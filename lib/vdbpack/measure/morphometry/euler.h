// Private to measure: the Euler characteristic of the solid of a voxel image.
#pragma once

#include "vdbpack/field/voxel_image.h"

namespace vdbpack {

struct EulerNumbers {
    double whole = 0;  ///< of the solid in the total volume as an isolated body
    double share = 0;  ///< its contribution to that of the solid from which it was cut
};

/// Euler characteristic of the solid voxels of the total volume, taken as closed cubes (so that
/// they are connected through faces, edges and corners: 26 neighbors): vertices - edges + faces -
/// cubes. Exact.
///
/// For `share`, each vertex, edge and face of the solid counts by the share that the total volume
/// has in the solid voxels around it, those beyond the image being mirror images. Where the total
/// volume is the image this is the characteristic less chi2 / 2 + chi1 / 4 + chi0 / 8 for the
/// solid's intersections with faces, edges and corners of the image: Odgaard, Gundersen (1993),
/// doi:10.1016/8756-3282(93)90245-6, as in BoneJ's Connectivity. So the shares of parts add up,
/// and a solid that ends within the total volume is not treated as one that continues.
EulerNumbers eulerNumbers(const VoxelImage& image);

}  // namespace vdbpack
