// Distances and sides by all triangles of a mesh, one after the other.
#pragma once

#include "support/triangle_oracle.h"

#include "vdbpack/field/sealed_band.h"

namespace vdbpack::test {

/// The truth about a point.
struct BandOracle {
    double distance;
    bool inside;
};

/// @param p  in voxels.
inline BandOracle oracleAt(const LatticeMesh& lattice, const Vec<3>& p) {
    BandOracle oracle{1e300, false};
    double angle = 0;
    const auto at = [&](std::uint32_t v) {
        return (lattice.mesh.vertices[v] - lattice.origin) * (1 / lattice.voxelSize);
    };
    for (const auto& t : lattice.mesh.triangles) {
        const Vec<3> a = at(t[0]), b = at(t[1]), c = at(t[2]);
        oracle.distance = std::min(oracle.distance, distanceTo(p, a, b, c));
        angle += solidAngle(p, a, b, c);
    }
    oracle.inside = std::lround(angle / (4 * 3.14159265358979)) % 2 != 0;
    return oracle;
}

}  // namespace vdbpack::test
