// The only source that instantiates `meshToVolume`, which takes most of a minute: OpenVDB's library
// has it for points in float alone.
#include "vdbpack/field/narrow_band.h"

#include <openvdb/tools/MeshToVolume.h>

namespace vdbpack {

namespace {

/// What `meshToVolume` asks of a mesh.
class Adapter {
public:
    explicit Adapter(const LatticeMesh& triangles)
        : triangles_(triangles), inverse_(1 / triangles.voxelSize) {}

    std::size_t polygonCount() const {
        return triangles_.chosen.empty() ? triangles_.mesh.triangles.size()
                                         : triangles_.chosen.size();
    }
    std::size_t pointCount() const { return triangles_.mesh.vertices.size(); }
    std::size_t vertexCount(std::size_t) const { return 3; }
    void getIndexSpacePoint(std::size_t polygon, std::size_t corner, openvdb::Vec3d& p) const {
        const TriangleMesh& mesh = triangles_.mesh;
        const std::size_t triangle =
            triangles_.chosen.empty() ? polygon : triangles_.chosen[polygon];
        const Vec<3> x = mesh.vertices[mesh.triangles[triangle][corner]] - triangles_.origin;
        p = openvdb::Vec3d(x[0] * inverse_, x[1] * inverse_, x[2] * inverse_);
    }

private:
    const LatticeMesh& triangles_;
    double inverse_;
};

/// What OpenVDB asks, from any thread, whether to go on.
struct Interrupter {
    explicit Interrupter(const Callbacks& callbacks) : request(callbacks.cancelled) {}
    void start(const char* = nullptr) {}
    void end() {}
    bool wasInterrupted(int = -1) { return request.made(); }

    StopRequest request;
};

openvdb::FloatGrid::Ptr band(const LatticeMesh& triangles, float inside, float outside, int flags,
                             const Callbacks& callbacks) {
    Interrupter interrupter(callbacks);
    const auto transform = openvdb::math::Transform::createLinearTransform(triangles.voxelSize);
    auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        interrupter, Adapter(triangles), *transform, outside, inside, flags);
    interrupter.request.stop();  // an unfinished grid is no field
    return grid;
}

}  // namespace

openvdb::FloatGrid::Ptr narrowBand(const LatticeMesh& triangles, float inside, float outside,
                                   const Callbacks& callbacks) {
    return band(triangles, inside, outside, openvdb::tools::DISABLE_RENORMALIZATION, callbacks);
}

openvdb::FloatGrid::Ptr unsignedBand(const LatticeMesh& triangles, float width,
                                     const Callbacks& callbacks) {
    return band(triangles, width, width, openvdb::tools::UNSIGNED_DISTANCE_FIELD, callbacks);
}

}  // namespace vdbpack
