// From a sculpture to a closed triangle mesh, through an OpenVDB level set.
#pragma once

#include "sculpture.h"

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstddef>
#include <string>

namespace vdbpack {

/// The surface of a sculpture as triangles of edge about 0.9 `voxelSize`, counter-clockwise
/// seen from outside, the same bytes for any number of threads.
///
/// Vertices lie on multiples of 2^-10 mm, which a float holds exactly, and on the sculpture's
/// surface up to this rounding; a few at sharp creases are off by up to a voxel.
///
/// @param voxelSize  mm, > 0; parts thinner than two voxels are lost.
TriangleMesh surfaceOf(const Sculpture& sculpture, double voxelSize);

struct SurfaceCheck {
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    std::size_t badEdges = 0;     ///< not shared by exactly two triangles in opposite directions
    std::size_t badVertices = 0;  ///< unused, or their triangles are not a single fan
    std::size_t slivers = 0;      ///< triangles with an angle under one degree
    std::size_t pieces = 0;
    long eulerNumber = 0;  ///< vertices - edges + triangles: 2 - 2 x tunnels for one piece
    double volume = 0;     ///< mm³, positive if the faces point outward
    double area = 0;       ///< mm²

    /// One closed 2-manifold surface, facing outward.
    bool sound() const {
        return triangles > 0 && badEdges == 0 && badVertices == 0 && slivers == 0 && pieces == 1 &&
               volume > 0;
    }
};

SurfaceCheck checkSurface(const TriangleMesh& mesh);

/// A binary little-endian PLY file with float vertices, as bytes.
std::string plyBytes(const TriangleMesh& mesh, const std::string& comment);

}  // namespace vdbpack
