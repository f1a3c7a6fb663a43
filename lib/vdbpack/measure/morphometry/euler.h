// Private to measure: the Euler characteristic of the solid of a voxel image.
#pragma once

#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/labels.h"

namespace vdbpack {

struct EulerNumbers {
    double whole = 0;  ///< of the solid of the part as an isolated body
    double share =
        0;  ///< its contribution to the characteristic of the solid from which it was cut
};

/// Euler characteristic of the solid voxels of a part, the total volume or one label, taken as
/// closed cubes (so that they are connected through faces, edges and corners: 26 neighbors):
/// vertices - edges + faces - cubes. Exact.
///
/// For `share`, each vertex, edge and face of the solid counts by the share that the part has in
/// the solid voxels around it, those beyond the image being mirror images. Where the part is the
/// image this is the characteristic less chi2 / 2 + chi1 / 4 + chi0 / 8 for the
/// solid's intersections with faces, edges and corners of the image: Odgaard, Gundersen (1993),
/// doi:10.1016/8756-3282(93)90245-6, as in BoneJ's Connectivity. So the shares of parts add up,
/// and a solid that ends within the part is not treated as one that continues. At a border of any
/// shape across which the solid continues, this is its characteristic less half of that of the cut.
/// Voxels that are solid beyond a wall (`VoxelImage::depth`) count for nothing.
EulerNumbers eulerNumbers(const VoxelImage& image, int label = kAllLabels);

}  // namespace vdbpack
