// bench_pack: what the distance field of a mesh costs beside the one call that it cannot do
// without, OpenVDB's meshToVolume at the same voxel size and band, in the same run.
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/mesh/mesh_io.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <vector>

using namespace vdbpack;

namespace {

double secondsOf(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// One bare meshToVolume: `depth` mm inside, three voxels outside.
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

int main(int argc, char** argv) {
    if (argc < 2) {
        fmt::print(stderr,
                   "bench_pack MESH[:UNIT[:SMALLEST_RADIUS_MM]] ...\n"
                   "    seconds to make the field of each mesh, against one bare meshToVolume at "
                   "the same\n    voxel size and band; the least of three runs each, in turn\n");
        return 2;
    }
    try {
        openvdb::initialize();
        fmt::print("{} threads\n{:<28} {:>10} {:>8} {:>9} {:>12} {:>7}\n",
                   std::thread::hardware_concurrency(), "mesh", "triangles", "voxel", "field s",
                   "bare call s", "ratio");
        for (int i = 1; i < argc; ++i) {
            std::vector<std::string> words(1);
            for (const char* c = argv[i]; *c; ++c) {
                if (*c == ':')
                    words.emplace_back();
                else
                    words.back() += *c;
            }
            MeshReadOptions read;
            if (words.size() > 1) read.unit = parseUnit(words[1]);
            const TriangleMesh mesh = readMesh(words[0], read);
            FieldOptions options;
            options.name = words[0];
            if (words.size() > 2) options.detail = std::atof(words[2].c_str());
            options.depth = 6 * options.detail;  // three largest radii at a ratio of 1:2
            double field = std::numeric_limits<double>::infinity(), bare = field, voxel = 0;
            for (int run = 0; run < 3; ++run) {
                field = std::min(field, secondsOf([&] {
                                     voxel = meshDomain(mesh, options)->facts().voxelSize;
                                 }));
                bare = std::min(bare, secondsOf([&] { bareField(mesh, voxel, options.depth); }));
            }
            fmt::print("{:<28} {:>10} {:>8.4g} {:>9.2f} {:>12.2f} {:>7.2f}\n",
                       words[0].substr(words[0].find_last_of('/') + 1), mesh.triangles.size(),
                       voxel, field, bare, field / bare);
            std::fflush(stdout);
        }
    } catch (const std::exception& e) {
        fmt::print(stderr, "bench_pack: {}\n", e.what());
        return 1;
    }
    return 0;
}
