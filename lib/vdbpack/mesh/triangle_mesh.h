// Triangle meshes.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/vec.h"

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdbpack {

/// An indexed triangle mesh; vertices in mm, in the coordinates of the file (scaled to mm).
/// Triangles name vertices by index, counter-clockwise seen from outside where oriented.
struct TriangleMesh {
    std::vector<Vec<3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;

    Box<3> bounds() const {
        Box<3> b;
        for (const auto& v : vertices) b.add(v);
        return b;
    }
};

/// A mesh that several hold, and none changes.
using SharedMesh = std::shared_ptr<const TriangleMesh>;

/// The mesh with vertices of identical coordinates merged and unused ones dropped; the remaining
/// ones keep their order. Most functions
/// that examine a mesh need it welded; `readMesh` welds. Coordinates must be finite and indices in
/// range.
TriangleMesh welded(TriangleMesh mesh);

}  // namespace vdbpack
