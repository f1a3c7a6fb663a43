// What a surface around a solid keeps to.
#pragma once

#include "vdbpack/mesh/mesh_check.h"

#include <catch2/catch.hpp>

namespace vdbpack::test {

/// Closed, every shell faces outward (cavities into themselves), and no shell encloses twice.
inline void requireSound(const TriangleMesh& mesh) {
    const MeshHealth health = checkMesh(mesh);
    CAPTURE(toText(health));
    REQUIRE(health.isWatertight());
    REQUIRE(health.inconsistentEdges == 0);
    REQUIRE(health.invertedShells == 0);
    REQUIRE(health.signedVolume == Approx(health.enclosedVolume));
}

}  // namespace vdbpack::test
