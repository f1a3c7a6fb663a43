#include "bench_fields.h"

#include "bench_clock.h"
#include "bench_mesh.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <thread>

using namespace vdbpack;

namespace {

/// A single call of meshToVolume: `depth` mm inside, three voxels outside.
void bareField(const TriangleMesh& mesh, double voxelSize, double depth) {
    const Vec<3> origin = mesh.bounds().center();
    std::vector<openvdb::Vec3s> points;
    points.reserve(mesh.vertices.size());
    for (const auto& v : mesh.vertices) {
        const Vec<3> p = (v - origin) * (1 / voxelSize);
        points.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]),
                            static_cast<float>(p[2]));
    }
    std::vector<openvdb::Vec3I> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> adapter(
        points, triangles);
    const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
    const auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        adapter, *transform, 3.0f, static_cast<float>(depth / voxelSize) + 1.0f);
    if (grid->activeVoxelCount() == 0) throw std::runtime_error("meshToVolume made no voxels");
}

}  // namespace

void benchFields(const std::vector<std::string>& meshes) {
    openvdb::initialize();
    fmt::print("{} threads\n{:<28} {:>10} {:>8} {:>9} {:>12} {:>7}\n",
               std::thread::hardware_concurrency(), "mesh", "triangles", "voxel", "field s",
               "bare call s", "ratio");
    for (const std::string& argument : meshes) {
        const BenchMesh input = readBenchMesh(argument);
        const FieldOptions options = input.fieldOptions();
        double field = std::numeric_limits<double>::infinity(), bare = field, voxel = 0;
        for (int run = 0; run < 3; ++run) {
            field = std::min(field, secondsOf([&] {
                                 voxel = meshDomain(input.mesh, options)->facts().voxelSize;
                             }));
            bare = std::min(bare, secondsOf([&] { bareField(input.mesh, voxel, options.depth); }));
        }
        fmt::print("{:<28} {:>10} {:>8.4g} {:>9.2f} {:>12.2f} {:>7.2f}\n",
                   input.file.substr(input.file.find_last_of('/') + 1), input.mesh.triangles.size(),
                   voxel, field, bare, field / bare);
        std::fflush(stdout);
    }
}
