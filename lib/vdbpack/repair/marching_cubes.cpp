#include "vdbpack/repair/marching_cubes.h"

namespace vdbpack {

namespace {

/// Corners of the six faces, counter-clockwise seen from outside the cube.
constexpr std::array<std::array<int, 4>, 6> kFaces{{{{0, 4, 6, 2}},
                                                    {{1, 3, 7, 5}},
                                                    {{0, 1, 5, 4}},
                                                    {{2, 6, 7, 3}},
                                                    {{0, 2, 3, 1}},
                                                    {{4, 5, 7, 6}}}};

int edgeBetween(int a, int b) {
    const int low = a < b ? a : b, difference = a ^ b;
    const int axis = difference == 1 ? 0 : difference == 2 ? 1 : 2;
    for (int k = 0; k < 4; ++k)
        if (cubeEdge(4 * axis + k).corner == low) return 4 * axis + k;
    return -1;
}

}  // namespace

bool shareFace(int edge, int other) {
    for (const auto& face : kFaces) {
        bool first = false, second = false;
        for (int k = 0; k < 4; ++k) {
            const int e = edgeBetween(face[static_cast<std::size_t>(k)],
                                      face[static_cast<std::size_t>((k + 1) % 4)]);
            first = first || e == edge;
            second = second || e == other;
        }
        if (first && second) return true;
    }
    return false;
}

std::array<CubeLoops, 256> makeCubeLoops() {
    std::array<CubeLoops, 256> all;
    for (int inside = 0; inside < 256; ++inside) {
        // The outline of the inside on each face leaves the face's rim where it goes from an
        // outside to an inside corner and comes back where it leaves that run of inside corners.
        std::array<int, 12> next;
        next.fill(-1);
        for (const auto& face : kFaces) {
            const auto is = [&](int k) {
                return (inside >> face[static_cast<std::size_t>(k % 4)] & 1) != 0;
            };
            for (int k = 0; k < 4; ++k) {
                if (is(k) || !is(k + 1)) continue;
                int end = k + 1;
                while (is(end + 1)) ++end;
                const auto corner = [&](int i) { return face[static_cast<std::size_t>(i % 4)]; };
                const int enters = edgeBetween(corner(k), corner(k + 1));
                const int leaves = edgeBetween(corner(end), corner(end + 1));
                next[static_cast<std::size_t>(enters)] = leaves;
            }
        }
        std::array<bool, 12> done{};
        for (std::size_t e = 0; e < 12; ++e) {
            if (next[e] < 0 || done[e]) continue;
            std::vector<std::uint8_t> loop;
            for (std::size_t k = e; !done[k]; k = static_cast<std::size_t>(next[k])) {
                done[k] = true;
                loop.push_back(static_cast<std::uint8_t>(k));
            }
            all[static_cast<std::size_t>(inside)].push_back(std::move(loop));
        }
    }
    return all;
}

}  // namespace vdbpack
