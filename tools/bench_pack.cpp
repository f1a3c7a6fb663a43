// bench_pack: how fast and how dense packs are, beside the time it takes to check them; and what
// the distance field of a mesh costs beside the one call that it cannot do without, OpenVDB's
// meshToVolume at the same voxel size and band; and how fast it answers. Each in one run.
#include "bench_densify.h"
#include "bench_lookups.h"
#include "bench_measure.h"
#include "bench_preview.h"
#include "bench_voids.h"
#include "bench_write.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/verify.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
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

/// MESH[:UNIT[:SMALLEST_RADIUS_MM]]
struct MeshArgument {
    std::string file;
    TriangleMesh mesh;
    double smallestRadius = FieldOptions{}.detail;  ///< mm
};

MeshArgument readMeshArgument(const std::string& argument) {
    std::vector<std::string> words(1);
    for (const char c : argument) {
        if (c == ':')
            words.emplace_back();
        else
            words.back() += c;
    }
    MeshArgument result;
    result.file = words[0];
    MeshReadOptions read;
    if (words.size() > 1) read.unit = parseUnit(words[1]);
    result.mesh = readMesh(words[0], read);
    if (words.size() > 2) result.smallestRadius = std::atof(words[2].c_str());
    return result;
}

int benchFields(const std::vector<std::string>& meshes) {
    openvdb::initialize();
    fmt::print("{} threads\n{:<28} {:>10} {:>8} {:>9} {:>12} {:>7}\n",
               std::thread::hardware_concurrency(), "mesh", "triangles", "voxel", "field s",
               "bare call s", "ratio");
    for (const std::string& argument : meshes) {
        const auto [file, mesh, smallestRadius] = readMeshArgument(argument);
        FieldOptions options;
        options.name = file;
        options.detail = smallestRadius;
        options.depth = 6 * options.detail;  // three largest radii at a ratio of 1:2
        double field = std::numeric_limits<double>::infinity(), bare = field, voxel = 0;
        for (int run = 0; run < 3; ++run) {
            const auto timeField = [&, &m = mesh] {
                return secondsOf([&] { voxel = meshDomain(m, options)->facts().voxelSize; });
            };
            field = std::min(field, timeField());
            bare =
                std::min(bare, secondsOf([&, &m = mesh] { bareField(m, voxel, options.depth); }));
        }
        fmt::print("{:<28} {:>10} {:>8.4g} {:>9.2f} {:>12.2f} {:>7.2f}\n",
                   file.substr(file.find_last_of('/') + 1), mesh.triangles.size(), voxel, field,
                   bare, field / bare);
        std::fflush(stdout);
    }
    return 0;
}

int benchAllLookups([[maybe_unused]] const std::vector<std::string>& meshes) {
#ifdef VDBPACK_BENCH_CGAL
    fmt::print(
        "one thread; the same random points in the bounding box\n{:<24} {:<42} {:>12} {:>10}\n",
        "mesh", "lookup", "a second", "times");
    for (const std::string& argument : meshes) {
        const MeshArgument a = readMeshArgument(argument);
        withThreads(1, [&] { ::benchLookups(a.mesh, a.file, a.smallestRadius); });
    }
    return 0;
#else
    fmt::print(stderr,
               "bench_pack: lookups are held against CGAL: install libcgal-dev and configure "
               "with -DVDBPACK_BENCH_CGAL=ON\n");
    return 2;
#endif
}

struct Job {
    int dim;
    double side;        ///< of the box or square, mm
    std::string radii;  ///< SPEC; empty: from the mesh's smallest radius on, ratio 1:2
    Effort effort;
    int threads;  ///< 0: as asked for
    bool oneBlock;
    std::string mesh;  ///< MESH[:UNIT[:SMALLEST_RADIUS_MM]]; empty: a box or square
};

const char* nameOf(Effort effort) {
    return effort == Effort::fast ? "fast" : effort == Effort::normal ? "normal" : "dense";
}

/// Solid fraction within one largest diameter of the faces between blocks less that elsewhere, both
/// deeper than three largest radii; nothing where there is one block.
template <int Dim>
std::optional<double> seams(const PackResult<Dim>& result, const Domain<Dim>& domain,
                            double largestRadius) {
    if (result.blocks < 2) return std::nullopt;
    const Box<Dim> bounds = domain.bounds().grown(-3 * largestRadius);
    const Vec<Dim> edge = result.firstBlock.size();
    const CellLevels<Dim> cells(result.pack.spheres);
    constexpr std::size_t kPoints = 4000000, kBatch = 4096;
    std::array<std::atomic<std::size_t>, 2> asked{}, solid{};  // elsewhere, near a face
    tbb::parallel_for(std::size_t{0}, kPoints / kBatch, [&](std::size_t batch) {
        RandomStream random(7, batch);
        for (std::size_t k = 0; k < kBatch; ++k) {
            Vec<Dim> x;
            bool near = false;
            for (int d = 0; d < Dim; ++d) {
                x[d] = bounds.lo[d] + random.uniform() * (bounds.hi[d] - bounds.lo[d]);
                const double from = std::remainder(x[d] - result.firstBlock.lo[d], edge[d]);
                // The faces of the domain itself are farther away.
                near = near || std::fabs(from) < 2 * largestRadius;
            }
            ++asked[near];
            solid[near] += !cells.forEachNear(x, 0, [&](std::uint32_t, const Sphere<Dim>& s) {
                return squaredLength(x - s.center) > s.radius * s.radius;
            });
        }
    });
    const auto fraction = [&](std::size_t n) {
        return static_cast<double>(solid[n]) / static_cast<double>(asked[n]);
    };
    return fraction(1) - fraction(0);
}

/// Kolmogorov-Smirnov distance between the radii of the outer and the inner half of the spheres.
template <int Dim>
double ksOfHalves(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain) {
    const auto sampler = domain.sampler();
    std::vector<std::pair<double, double>> byDepth;
    for (const auto& s : spheres)
        byDepth.emplace_back(-sampler->signedDistance(s.center), s.radius);
    // By depth alone: fields are clamped where they are deep, and those that are equal keep the
    // order in which they were placed.
    std::stable_sort(byDepth.begin(), byDepth.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<double> outer, inner;
    for (std::size_t i = 0; i < byDepth.size(); ++i)
        (i < byDepth.size() / 2 ? outer : inner).push_back(byDepth[i].second);
    std::sort(inner.begin(), inner.end());
    const auto share = [&](auto end) {
        return static_cast<double>(end - inner.begin()) / static_cast<double>(inner.size());
    };
    return ksDistance(
        std::move(outer),
        [&](double r) { return share(std::upper_bound(inner.begin(), inner.end(), r)); },
        [&](double r) { return share(std::lower_bound(inner.begin(), inner.end(), r)); });
}

/// Packs, checks and prints a row.
template <int Dim>
void runJob(const Job& job, int threads) {
    const double half = job.side / 2;
    std::shared_ptr<const Domain<Dim>> domain =
        boxDomain<Dim>({Box<Dim>::filled(-half), Box<Dim>::filled(half)});
    std::string name = fmt::format("{}:{:.0f}", Dim == 3 ? "box" : "rect", job.side);
    std::string radii = job.radii;
    double field = 0;
    if constexpr (Dim == 3) {
        if (!job.mesh.empty()) {
            const MeshArgument argument = readMeshArgument(job.mesh);
            FieldOptions make;
            make.name = argument.file;
            make.detail = argument.smallestRadius;
            make.depth = 6 * argument.smallestRadius;
            withThreads(threads, [&] {
                field = secondsOf([&] { domain = meshDomain(argument.mesh, make); });
            });
            name = argument.file.substr(argument.file.find_last_of('/') + 1);
            name = name.substr(0, name.find_first_of("._"));
            radii =
                fmt::format("uniform:{},{}", argument.smallestRadius, 2 * argument.smallestRadius);
        }
    }
    PackOptions options(SizeDistribution::parse(radii, Dim));
    options.effort = job.effort;
    options.threads = job.threads > 0 ? job.threads : threads;
    if (job.oneBlock) options.blockSide = 2 * job.side;
    PackResult<Dim> result;
    const double pack = secondsOf([&] { result = packSpheres(*domain, options); });
    auto& spheres = result.pack.spheres;
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    double total = 0, check = std::numeric_limits<double>::infinity(), shuffled = check, ks = 0;
    std::optional<double> interior, seam;
    double halves = 0;
    std::size_t overlaps = 0;
    withThreads(threads, [&] {
        total = solidFraction(spheres, *domain);
        interior = interiorFraction(spheres, *domain, 3 * options.sizes.max());
        std::vector<double> placed;
        for (const auto& s : spheres) placed.push_back(s.radius);
        ks = ksDistance(std::move(placed), [&](double r) { return options.sizes.cdf(r); });
        for (int run = 0; run < 3; ++run)
            check = std::min(check, secondsOf([&] { overlaps += checkOverlap(spheres).pairs; }));
        if (job.mesh.empty()) seam = seams(result, *domain, options.sizes.max());
        halves = ksOfHalves(spheres, *domain);
        RandomStream random(1, 0);
        for (std::size_t i = spheres.size(); i > 1; --i)
            std::swap(spheres[i - 1],
                      spheres[static_cast<std::size_t>(random.uniform() * static_cast<double>(i))]);
        for (int run = 0; run < 3; ++run)
            shuffled =
                std::min(shuffled, secondsOf([&] { overlaps += checkOverlap(spheres).pairs; }));
    });
    const auto count = static_cast<double>(spheres.size());
    fmt::print(
        "{:<10} {:<21} {:<6} {:>2} {:>9} {:>6.4f} {:>8} {:>7.5f} {:>7.5f} {:>7} {:>7.2f} {:>7.2f} "
        "{:>9.0f} "
        "{:>6.3f} {:>6.1f} {:>6.3f} {:>6.1f} {:>6} {:>5} {:>6}{}\n",
        name, radii, nameOf(job.effort), options.threads, spheres.size(), total,
        interior ? fmt::format("{:.4f}", *interior) : "-", ks, halves,
        seam ? fmt::format("{:+.4f}", *seam) : "-", field, pack, count / pack, check, pack / check,
        shuffled, pack / shuffled, result.blocks, result.longestChain, usage.ru_maxrss / 1024,
        overlaps > 0 ? "  OVERLAPS" : "");
    std::fflush(stdout);
    if (overlaps > 0) throw std::runtime_error("a pack has overlaps");
}

int benchPacks(bool quick, int threads, const std::vector<std::string>& meshes) {
    std::vector<Job> jobs;
    const auto add = [&](int dim, double side, const char* radii, Effort effort, int t = 0,
                         bool one = false) {
        jobs.push_back({dim, side, radii, effort, t, one, {}});
    };
    const char* const narrow = "uniform:1,2";
    for (const Effort effort : {Effort::fast, Effort::normal, Effort::dense})
        add(3, quick ? 120 : 370, narrow, effort);
    add(3, quick ? 120 : 370, narrow, Effort::normal, 1);
    for (const Effort effort : {Effort::normal, Effort::dense}) add(3, 200, narrow, effort);
    add(3, 200, narrow, Effort::normal, 1, true);
    add(3, quick ? 120 : 200, "uniform:0.3,3", Effort::normal);
    if (!quick) add(3, 200, "lognormal:1,0.5,0.3,3", Effort::normal);
    for (const Effort effort : {Effort::fast, Effort::normal})
        add(2, quick ? 1000 : 3000, narrow, effort);
    for (const std::string& mesh : meshes)
        jobs.push_back({3, 1, {}, Effort::normal, 0, false, mesh});

    std::string hardware = "unknown processor";
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.rfind("model name", 0) == 0) {
            hardware = line.substr(line.find(':') + 2);
            break;
        }
    fmt::print(
        "{}, {} hardware threads; seed 1, blocks of the default size but where there is one.\n"
        "check: seconds of verify's overlap pass over the pack, least of three; shuffled: the same "
        "with the\nspheres in random order; ratio: pack / check. chain: blocks that wait for one "
        "another. MB: peak of\npacking. halves: ks between the radii of the outer and the inner "
        "half "
        "of the spheres. seams: solid\nfraction within a largest diameter of block faces less that "
        "elsewhere, both deeper than three\nlargest radii.\n",
        hardware, std::thread::hardware_concurrency());
    fmt::print(
        "{:<10} {:<21} {:<6} {:>2} {:>9} {:>6} {:>8} {:>7} {:>7} {:>7} {:>7} {:>7} {:>9} {:>6} "
        "{:>6} "
        "{:>6} {:>6} {:>6} {:>5} {:>6}\n",
        "domain", "radii", "effort", "t", "spheres", "total", "interior", "ks", "halves", "seams",
        "field s", "pack s", "spheres/s", "check", "ratio", "shuff.", "ratio", "blocks", "chain",
        "MB");
    std::fflush(stdout);
    for (const Job& job : jobs) {
        // A process each: the peak of memory is its own.
        const pid_t child = fork();
        if (child < 0) throw std::runtime_error("cannot start a process");
        if (child == 0) {
            try {
                if (job.dim == 3)
                    runJob<3>(job, threads);
                else
                    runJob<2>(job, threads);
                _exit(0);
            } catch (const std::exception& e) {
                fmt::print(stderr, "bench_pack: {}\n", e.what());
                _exit(1);
            }
        }
        int status = 0;
        if (waitpid(child, &status, 0) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
            return 1;
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    try {
        if (words.size() > 1 && words[0] == "fields")
            return benchFields({words.begin() + 1, words.end()});
        if (words.size() > 1 && words[0] == "lookups")
            return benchAllLookups({words.begin() + 1, words.end()});
        std::vector<std::string> meshes;
        const bool preview = !words.empty() && words[0] == "preview";
        const bool measures = !words.empty() && words[0] == "measure";
        const bool voids = !words.empty() && words[0] == "voids";
        const bool densifies = !words.empty() && words[0] == "densify";
        const bool writes = !words.empty() && words[0] == "write";
        bool quick = false, usable = !words.empty() && (words[0] == "packs" || measures || voids ||
                                                        preview || writes || densifies);
        int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
        for (std::size_t i = 1; usable && i < words.size(); ++i) {
            if (words[i] == "--quick")
                quick = true;
            else if (words[i] == "--threads" && i + 1 < words.size() &&
                     (threads = std::atoi(words[i + 1].c_str())) > 0)
                ++i;
            else if (words[i].rfind("--", 0) != 0)
                meshes.push_back(words[i]);
            else
                usable = false;
        }
        if (usable && preview) {
            const double count = meshes.empty() ? 1e6 : std::atof(meshes[0].c_str());
            if (meshes.size() < 2 && count >= 1 && count <= 1e9) {
                benchPreview(threads, count);
                return 0;
            }
        } else if (usable && voids) {
            for (const auto& mesh : meshes) benchVoids(mesh, threads, quick ? 50000 : 349748);
            if (!meshes.empty()) return 0;
        } else if (usable && densifies) {
            benchDensify(threads, quick, meshes);
            return 0;
        } else if (usable && writes) {
            if (meshes.empty()) {
                benchWrite(threads, quick ? 120 : 370);
                return 0;
            }
        } else if (usable && measures) {
            if (meshes.empty()) {
                benchMeasure(threads, quick ? 120 : 370, quick ? 128 : 256);
                return 0;
            }
        } else if (usable) {
            return benchPacks(quick, threads, meshes);
        }
    } catch (const std::exception& e) {
        fmt::print(stderr, "bench_pack: {}\n", e.what());
        return 1;
    }
    fmt::print(
        stderr,
        "bench_pack packs [--quick] [--threads T] [MESH[:UNIT[:SMALLEST_RADIUS_MM]] ...]\n"
        "    packs of boxes, squares and meshes: density, speed, the time to check them\n"
        "bench_pack fields MESH[:UNIT[:SMALLEST_RADIUS_MM]] ...\n"
        "    seconds to make the field of each mesh, against one bare meshToVolume at the "
        "same\n    voxel size and band; the least of three runs each, in turn\n"
        "bench_pack measure [--quick] [--threads T]\n"
        "    what all measures of a pack and the morphometry of a sample cost\n"
        "bench_pack write [--quick] [--threads T]\n"
        "    what writing a pack to each format costs beside packing it\n"
        "bench_pack densify [--quick] [--threads T] [DOMAIN[@UNIT]=FRACTION[=SPEC[=COUNT]] ...]\n"
        "    how dense packs become beyond the front, and what it costs\n"
        "bench_pack voids [--quick] [--threads T] MESH[:UNIT] ...\n"
        "    what stamping 100,000 ellipsoids costs, beside csgDifference one by one and\n"
        "    beside packing\n"
        "bench_pack preview [--threads T] [N]\n"
        "    what drawing about N spheres (a million) costs\n"
        "bench_pack lookups MESH[:UNIT[:SMALLEST_RADIUS_MM]] ...\n"
        "    clearances a second beside CGAL's AABB tree and the loop over all triangles\n");
    return 2;
}
