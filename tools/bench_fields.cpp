#include "bench_fields.h"

#include "bench_clock.h"
#include "bench_mesh.h"

#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/field/narrow_band.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/verify/wall_sides.h"
#include "vdbpack/verify/wall_tree.h"

#include <fmt/format.h>
#include <malloc.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>

using namespace vdbpack;

namespace {

/// A single call of meshToVolume: `depth` mm inside, three voxels outside.
openvdb::FloatGrid::Ptr bareField(const TriangleMesh& mesh, double voxelSize, double depth) {
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
    return grid;
}

/// The exact band of the same widths.
openvdb::FloatGrid::Ptr exactBand(const TriangleMesh& mesh, const Facing& facing, double voxelSize,
                                  double depth) {
    NarrowBandOptions options;
    options.origin = mesh.bounds().center();
    options.facing = &facing;
    const auto grid =
        narrowBand(mesh, voxelSize, static_cast<float>(depth / voxelSize) + 1.0f, 3, options);
    if (grid->activeVoxelCount() == 0) throw std::runtime_error("narrowBand made no voxels");
    return grid;
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

/// Distances and sides by the triangles themselves, with the code of `verify`.
class Exact {
public:
    explicit Exact(const TriangleMesh& mesh)
        : origin_(mesh.bounds().center()), tree_(wallPieces(mesh)) {}

    /// How far about 100,000 voxels, spread over those that are active, are off.
    std::string errorsOf(const openvdb::FloatGrid& grid, double voxelSize) const {
        struct Voxel {
            Vec<3> at;  // mm
            double value;
        };
        const std::uint64_t step = grid.activeVoxelCount() / kVoxels + 1;
        std::vector<Voxel> voxels;
        std::uint64_t n = 0;
        for (auto on = grid.cbeginValueOn(); on; ++on)
            if (n++ % step == 0) {
                const openvdb::Coord c = on.getCoord();
                const Vec<3> lattice{{double(c[0]), double(c[1]), double(c[2])}};
                voxels.push_back({origin_ + lattice * voxelSize, *on});
            }
        std::vector<Sphere<3>> points;
        for (const Voxel& voxel : voxels) points.push_back({voxel.at, 0});
        const WallSides<3> sides(tree_.pieces(), points);
        std::vector<double> errors(voxels.size());
        std::atomic<std::size_t> wrong{0};
        forAll(voxels.size(), [&](std::size_t i) {
            const auto& [at, value] = voxels[i];
            const double bound = 4 * std::abs(value) + voxelSize;
            const double distance = std::sqrt(tree_.squaredDistance(at, bound * bound));
            errors[i] = std::abs(distance - std::abs(value)) / voxelSize;
            // Closer than this to the wall, the sign is a matter of rounding.
            if (distance > 1e-4 * voxelSize && (value < 0) != sides.inside(i)) ++wrong;
        });
        const auto large =
            std::count_if(errors.begin(), errors.end(), [](double e) { return e > 1e-3; });
        return fmt::format("{:>9.1e} {:>8} {:>6}", *std::max_element(errors.begin(), errors.end()),
                           large, wrong.load());
    }
    static constexpr std::uint64_t kVoxels = 100000;

private:
    Vec<3> origin_;
    WallTree<3> tree_;
};

/// Wall and processor seconds of the quickest of some runs, and the most memory that one took
/// beyond what was held before it.
struct Least {
    double wall = std::numeric_limits<double>::infinity(), processor = wall, bytes = 0;

    template <class Work>
    void measureMemory(const Work& work) {
        ::malloc_trim(0);
        std::ofstream("/proc/self/clear_refs") << 5;  // resets the peak
        const double before = residentMemory();
        work();
        bytes = std::max(bytes, static_cast<double>(peakMemory()) - before);
    }

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
        "{} threads; seconds of wall / processor, least of three runs; ratio: processor time of "
        "the bare call / of the band;\nof some {} voxels each: largest error in voxels, errors "
        "above 0.001 voxel, wrong signs; MB: peak of memory of the bare call / of the band\n{:<22} "
        "{:>9} {:>7} {:>15} {:>15} {:>15} {:>6} {:>11}   {:<25} {}\n",
        std::thread::hardware_concurrency(), Exact::kVoxels, "mesh", "triangles", "voxel", "domain",
        "band", "meshToVolume", "ratio", "MB", "errors of the band", "of meshToVolume");
    const auto text = [](const Least& l) {
        return fmt::format("{:.3f} / {:.3f}", l.wall, l.processor);
    };
    const auto megabytes = [](const Least& l) { return std::ceil(l.bytes / 1e6); };
    for (const std::string& argument : meshes) {
        const BenchMesh input = readBenchMesh(argument);
        const FieldOptions options = input.fieldOptions();
        const Facing facing = facingOf(input.mesh);
        Least domain, band, bare;
        openvdb::FloatGrid::Ptr made, reference;
        double voxel = 0;
        for (int run = 0; run < 3; ++run) {
            domain.run([&] { voxel = meshDomain(input.mesh, options)->facts().voxelSize; });
            band.run([&] { made = exactBand(input.mesh, facing, voxel, options.depth); });
            bare.run([&] { reference = bareField(input.mesh, voxel, options.depth); });
        }
        made = reference = nullptr;
        band.measureMemory([&] { made = exactBand(input.mesh, facing, voxel, options.depth); });
        bare.measureMemory([&] { reference = bareField(input.mesh, voxel, options.depth); });
        const Exact exact(input.mesh);
        fmt::print("{:<22} {:>9} {:>7.4g} {:>15} {:>15} {:>15} {:>6.1f} {:>11} {} {}\n",
                   input.file.substr(input.file.find_last_of('/') + 1), input.mesh.triangles.size(),
                   voxel, text(domain), text(band), text(bare), bare.processor / band.processor,
                   fmt::format("{:.0f} / {:.0f}", megabytes(bare), megabytes(band)),
                   exact.errorsOf(*made, voxel), exact.errorsOf(*reference, voxel));
        std::fflush(stdout);
    }
}
