#include "vdbpack/field/sealed_band.h"

#include <openvdb/tools/MeshToVolume.h>

namespace vdbpack {

namespace {

/// What OpenVDB asks, from any thread, whether to go on.
struct Interrupter : openvdb::util::NullInterrupter {
    explicit Interrupter(const Callbacks& callbacks) : request(callbacks.cancelled) {}
    bool wasInterrupted(int) override { return request.made(); }

    StopRequest request;
};

/// With the types for which OpenVDB's library has `meshToVolume`: others compile for most of a
/// minute.
openvdb::FloatGrid::Ptr band(const LatticeMesh& lattice, const std::vector<std::uint32_t>& chosen,
                             float inside, float outside, int flags, const Callbacks& callbacks) {
    const TriangleMesh& mesh = lattice.mesh;
    std::vector<openvdb::Vec3s> points;
    points.reserve(mesh.vertices.size());
    for (const Vec<3>& v : mesh.vertices) {
        const Vec<3> x = (v - lattice.origin) * (1 / lattice.voxelSize);
        points.emplace_back(openvdb::Vec3d(x[0], x[1], x[2]));
    }
    const std::size_t n = chosen.empty() ? mesh.triangles.size() : chosen.size();
    std::vector<openvdb::Vec3I> triangles;
    triangles.reserve(n);
    for (std::size_t i = 0; i < n; ++i)
        triangles.emplace_back(mesh.triangles[chosen.empty() ? i : chosen[i]].data());
    Interrupter interrupter(callbacks);
    const auto transform = openvdb::math::Transform::createLinearTransform(lattice.voxelSize);
    auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        interrupter.interrupter(),
        openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I>(points,
                                                                                   triangles),
        *transform, outside, inside, flags);
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
