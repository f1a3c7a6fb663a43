// The only source that instantiates `meshToVolume`, which takes most of a minute: OpenVDB's library
// has it for points in float alone.
#include "vdbpack/field/sealed_band.h"

#include <openvdb/tools/MeshToVolume.h>

namespace vdbpack {

namespace {

/// What `meshToVolume` asks of a mesh.
class Adapter {
public:
    Adapter(const LatticeMesh& mesh, const std::vector<std::uint32_t>& chosen)
        : lattice_(mesh), chosen_(chosen), inverse_(1 / mesh.voxelSize) {}

    std::size_t polygonCount() const {
        return chosen_.empty() ? lattice_.mesh.triangles.size() : chosen_.size();
    }
    std::size_t pointCount() const { return lattice_.mesh.vertices.size(); }
    std::size_t vertexCount(std::size_t) const { return 3; }
    void getIndexSpacePoint(std::size_t polygon, std::size_t corner, openvdb::Vec3d& p) const {
        const TriangleMesh& mesh = lattice_.mesh;
        const std::size_t triangle = chosen_.empty() ? polygon : chosen_[polygon];
        const Vec<3> x = mesh.vertices[mesh.triangles[triangle][corner]] - lattice_.origin;
        p = openvdb::Vec3d(x[0] * inverse_, x[1] * inverse_, x[2] * inverse_);
    }

private:
    const LatticeMesh& lattice_;
    const std::vector<std::uint32_t>& chosen_;
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

openvdb::FloatGrid::Ptr band(const LatticeMesh& mesh, const std::vector<std::uint32_t>& chosen,
                             float inside, float outside, int flags, const Callbacks& callbacks) {
    Interrupter interrupter(callbacks);
    const auto transform = openvdb::math::Transform::createLinearTransform(mesh.voxelSize);
    auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        interrupter, Adapter(mesh, chosen), *transform, outside, inside, flags);
    interrupter.request.stop();  // an unfinished grid is no field
    return grid;
}

}  // namespace

openvdb::FloatGrid::Ptr sealedBand(const LatticeMesh& mesh,
                                   const std::vector<std::uint32_t>& chosen, float inside,
                                   float outside, const Callbacks& callbacks) {
    return band(mesh, chosen, inside, outside, openvdb::tools::DISABLE_RENORMALIZATION, callbacks);
}

openvdb::FloatGrid::Ptr unsignedBand(const LatticeMesh& mesh, float width,
                                     const Callbacks& callbacks) {
    return band(mesh, {}, width, width, openvdb::tools::UNSIGNED_DISTANCE_FIELD, callbacks);
}

}  // namespace vdbpack
