// The surfaces of labeled voxels, shared by the labels on both sides.
#pragma once

#include "vdbpack/image/image_grid.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace vdbpack {

/// Labels of voxels: 0 for none; x fastest, then y, then z.
struct LabelVoxels {
    static constexpr std::uint16_t kBeyond = 65535;  ///< past the border; no voxel has it

    std::array<std::size_t, 3> size{};  ///< each at most 65,534
    std::vector<std::uint16_t> labels;
};

/// Faces between voxels of different labels. The vertices of a face lie in the four cells around
/// it; a cell is a cube from center to center of eight voxels, and has one vertex.
struct SurfaceNet {
    struct Face {
        /// Counter-clockwise seen from the voxel above, where "above" is along `axis`.
        std::array<std::uint32_t, 4> vertices;
        std::uint16_t below, above;  ///< labels of both voxels
        std::uint8_t axis;
    };
    /// Indices of the image's voxels; at first in the middle of each cell.
    std::vector<Vec<3>> vertices;
    std::vector<std::array<std::uint16_t, 3>> cells;  ///< of each vertex, from 0: before voxel 0
    /// Of each vertex: bits 0 to 5 are set where three labels or more meet on the side of its cell
    /// to -x, +x, -y, +y, -z, +z.
    std::vector<std::uint8_t> junctions;
    std::vector<Face> faces;

    /// Whether a label means the background, or what lies beyond the image.
    static bool isEmpty(std::uint16_t l) { return l == 0 || l == LabelVoxels::kBeyond; }
    /// Whether voxels of two labels have a face between them: there is none between the background
    /// and what lies beyond the image.
    static bool isFace(std::uint16_t a, std::uint16_t b) {
        return a != b && !(isEmpty(a) && isEmpty(b));
    }
};

/// The faces around all labels but 0. What lies past the border of the image has a label of its
/// own, so that the border closes whatever it cuts.
/// Cost: about 2 ns a voxel on two threads. @throws ResourceError for more than 2^32 vertices
SurfaceNet surfaceNet(const LabelVoxels& voxels);

/// Moves the vertices of labels to where a smooth surface would have met the voxels. No vertex
/// leaves its cell, and each label has the volume of its voxels. Vertices where three labels meet
/// move along that line alone, those on the border of the image within the border.
///
/// Source: Frisken (2022), "SurfaceNets for Multi-Label Segmentations with Preservation of Sharp
/// Boundaries", Journal of Computer Graphics Techniques 11(1), 34-54, http://jcgt.org: its cells,
/// its constraint and its rule for lines of three labels. Its averaging flattens a ball of ten
/// voxels by some percent; here the bending is averaged instead of the positions, but for sharp
/// edges, and in the end all faces between two labels move by the same distance, until the volumes
/// are right. Surfaces of balls and tori lie 0.03 to 0.1 voxels (rms) off the true ones, and so do
/// flat sides, but those that fewer than four steps of voxels cross: these lie up to 0.7 voxels
/// off, where sides along the voxels may lie half a voxel off unseen.
/// Cost: about 2.5 microseconds and 110 bytes a vertex on two threads.
void smooth(SurfaceNet& net, const std::array<std::size_t, 3>& size);

/// Moves each vertex to the mean of the points at which the edges of its cell cross a threshold.
/// @param shareOf  where the values of two neighbors, given by their indices in the image, have the
///                 threshold between them: from 0 (at the first) to 1.
void interpolate(SurfaceNet& net, const LabelVoxels& voxels,
                 const std::function<double(std::size_t, std::size_t)>& shareOf);

/// The closed surface of the voxels whose labels are `inside`, in the world of `grid`. Each of its
/// edges has two triangles. Surfaces of labels that touch share their triangles, apart from the
/// orientation; normals point outwards. Coordinates have single precision where that is
/// far below a voxel.
TriangleMesh surfaceOf(const SurfaceNet& net, const ImageGrid& grid,
                       const std::function<bool(std::uint16_t)>& inside);

}  // namespace vdbpack
