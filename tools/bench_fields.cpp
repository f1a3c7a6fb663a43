#include "bench_fields.h"

#include "bench_clock.h"
#include "bench_mesh.h"

#include "vdbpack/field/narrow_band.h"
#include "vdbpack/mesh/mesh_shells.h"

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

/// The exact band of the same widths.
void exactBand(const TriangleMesh& mesh, const Facing& facing, double voxelSize, double depth) {
    const auto grid = narrowBand({mesh, mesh.bounds().center(), voxelSize},
                                 static_cast<float>(depth / voxelSize) + 1.0f, 3, facing);
    if (grid->activeVoxelCount() == 0) throw std::runtime_error("narrowBand made no voxels");
}

/// Which way the triangles of closed shells face.
Facing facingOf(const TriangleMesh& mesh) {
    const ShellAnalysis shells = analyzeShells(mesh);
    Facing facing(mesh.triangles.size());
    for (std::size_t i = 0; i < facing.size(); ++i) {
        const Shell& shell = shells.shells[shells.shellOfTriangle[i]];
        facing[i] = (shell.signedVolume > 0) == (shell.depth % 2 == 0) ? 1 : -1;
    }
    return facing;
}

/// Wall and processor seconds of the quickest of some runs.
struct Least {
    double wall = std::numeric_limits<double>::infinity(), processor = wall;

    template <class Work>
    void run(const Work& work) {
        wall = std::min(
            wall, secondsOf([&] { processor = std::min(processor, processorSecondsOf(work)); }));
    }
};

}  // namespace

void benchFields(const std::vector<std::string>& meshes) {
    openvdb::initialize();
    fmt::print(
        "{} threads; seconds of wall / processor, least of three runs; ratio: processor "
        "time of the bare call / of the band\n{:<24} {:>10} {:>8} {:>15} {:>15} {:>15} "
        "{:>7}\n",
        std::thread::hardware_concurrency(), "mesh", "triangles", "voxel", "domain", "band",
        "meshToVolume", "ratio");
    const auto text = [](const Least& l) {
        return fmt::format("{:.3f} / {:.3f}", l.wall, l.processor);
    };
    for (const std::string& argument : meshes) {
        const BenchMesh input = readBenchMesh(argument);
        const FieldOptions options = input.fieldOptions();
        const Facing facing = facingOf(input.mesh);
        Least domain, band, bare;
        double voxel = 0;
        for (int run = 0; run < 3; ++run) {
            domain.run([&] { voxel = meshDomain(input.mesh, options)->facts().voxelSize; });
            band.run([&] { exactBand(input.mesh, facing, voxel, options.depth); });
            bare.run([&] { bareField(input.mesh, voxel, options.depth); });
        }
        fmt::print("{:<24} {:>10} {:>8.4g} {:>15} {:>15} {:>15} {:>7.1f}\n",
                   input.file.substr(input.file.find_last_of('/') + 1), input.mesh.triangles.size(),
                   voxel, text(domain), text(band), text(bare), bare.processor / band.processor);
        std::fflush(stdout);
    }
}
