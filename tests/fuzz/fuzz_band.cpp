// Narrow bands of closed meshes that no scanner makes: tetrahedra on a coarse lattice, flat ones
// and overlapping ones among them, against distances to all triangles.
#include "fuzz_file.h"
#include "support/band_oracle.h"

#include "vdbpack/field/narrow_band.h"
#include "vdbpack/field/sealed_band.h"

#include <set>

using namespace vdbpack;

namespace {

/// Three bytes a vertex, in sixteenths of a voxel; four vertices from anywhere a tetrahedron.
TriangleMesh meshOf(const std::uint8_t* data, std::size_t size) {
    constexpr std::size_t kVertices = 12, kMost = 6;
    TriangleMesh mesh;
    const std::size_t n = std::min(kVertices, size / 4);
    for (std::size_t i = 0; i < n; ++i) {
        const auto at = [&](std::size_t k) { return data[3 * i + k] / 16.0; };
        mesh.vertices.push_back({{at(0), at(1), at(2)}});
    }
    const std::uint8_t* const end = data + size;
    const std::uint8_t* corners = data + 3 * n;
    for (std::size_t made = 0; made < kMost && end - corners >= 4; ++made, corners += 4) {
        std::array<std::uint32_t, 4> c;
        for (std::size_t k = 0; k < 4; ++k) c[k] = static_cast<std::uint32_t>(corners[k] % n);
        // Triangles that name a vertex twice do not count: others must be left.
        if (std::set<std::uint32_t>(c.begin(), c.end()).size() < 3) continue;
        mesh.triangles.insert(
            mesh.triangles.end(),
            {{c[0], c[1], c[2]}, {c[0], c[3], c[1]}, {c[1], c[3], c[2]}, {c[2], c[3], c[0]}});
    }
    return mesh;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr float kInside = 4, kOutside = 3;
    const TriangleMesh mesh = meshOf(data, size);
    if (mesh.triangles.empty()) return 0;
    const LatticeMesh lattice{mesh, {}, 1};
    const auto grid = narrowBand(mesh, 1, kInside, kOutside);
    for (int x = -4; x <= 20; x += 2)
        for (int y = -4; y <= 20; y += 2)
            for (int z = -4; z <= 20; ++z) {
                const openvdb::Coord at(x, y, z);
                const auto truth = test::oracleAt(lattice, {{double(x), double(y), double(z)}});
                const double width = truth.inside ? kInside : kOutside;
                const double value = grid->tree().getValue(at);
                if (truth.distance > 1e-4 && (value < 0) != truth.inside)
                    fuzz::report("a voxel on the wrong side");
                if (truth.distance > 1e-4 &&
                    std::abs(std::abs(value) - std::min(truth.distance, width)) > 2e-5)
                    fuzz::report("a distance is wrong");
            }
    return 0;
}
