// Private to repair: which triangles separate the inside corners of a cube from the others.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Corner c of a cube lies at (c & 1, c >> 1 & 1, c >> 2). Edges 0 to 3 run along x, 4 to 7 along
/// y, 8 to 11 along z.
struct CubeEdge {
    int axis = 0;
    int corner = 0;  ///< the lower end
};

constexpr CubeEdge cubeEdge(int edge) {
    const int axis = edge / 4, k = edge % 4;
    if (axis == 0) return {0, k << 1};
    if (axis == 1) return {1, (k & 1) | (k >> 1) << 2};
    return {2, k};
}

/// Loops of edge numbers for one of the 256 cases (bit c: corner c is inside), each around a part
/// of the inside, counter-clockwise seen from outside. At a face with two inside corners across
/// its diagonal these are kept apart.
using CubeLoops = std::vector<std::vector<std::uint8_t>>;

/// The loops of all cases, made by following the outlines of the six faces.
std::array<CubeLoops, 256> makeCubeLoops();

/// Whether two edges lie on one face of the cube.
bool shareFace(int edge, int other);

}  // namespace vdbpack
