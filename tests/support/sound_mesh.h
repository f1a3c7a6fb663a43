// The properties of a valid surface of a solid.
#pragma once

#include "vdbpack/mesh/mesh_check.h"

#include <catch2/catch.hpp>

namespace vdbpack::test {

/// Closed, every component facing out of the solid, and no component enclosing the same volume
/// twice.
inline void requireSound(const TriangleMesh& mesh) {
    const MeshHealth health = checkMesh(mesh);
    CAPTURE(toText(health));
    REQUIRE(health.isWatertight());
    REQUIRE(health.inconsistentEdges == 0);
    REQUIRE(health.invertedShells == 0);
    REQUIRE(health.signedVolume == Approx(health.enclosedVolume));
}

}  // namespace vdbpack::test
