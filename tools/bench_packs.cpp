#include "bench_packs.h"

#include "bench_clock.h"
#include "bench_mesh.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/verify.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

using namespace vdbpack;

namespace {

struct Job {
    int dim;
    double side;        ///< of the box or square, mm
    std::string radii;  ///< SPEC; empty: from the mesh's smallest radius to twice that
    Effort effort;
    int threads;  ///< 0: the number of the call
    bool oneBlock;
    std::string mesh;  ///< MESH[:UNIT[:SMALLEST_RADIUS_MM]]; empty: a box or square
};

/// Solid fraction within one largest diameter of the faces between blocks, minus that elsewhere,
/// both deeper than three largest radii; nothing if there is one block.
template <int Dim>
std::optional<double> seams(const PackResult<Dim>& result, const Domain<Dim>& domain,
                            double largestRadius) {
    if (result.blocks < 2) return std::nullopt;
    const Box<Dim> bounds = domain.bounds().grown(-3 * largestRadius);
    const Vec<Dim> edge = result.firstBlock.size();
    const CellLevels<Dim> cells(result.pack.spheres);
    constexpr std::size_t kPoints = 4000000, kBatch = 4096;
    std::array<std::atomic<std::size_t>, 2> total{}, solid{};  // elsewhere, near a face
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
            ++total[near];
            solid[near] += !cells.forEachNear(x, 0, [&](std::uint32_t, const Sphere<Dim>& s) {
                return squaredLength(x - s.center) > s.radius * s.radius;
            });
        }
    });
    const auto fraction = [&](std::size_t n) {
        return static_cast<double>(solid[n]) / static_cast<double>(total[n]);
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
    // Stable: depths are clamped deep inside, and equal ones keep the order of placing.
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

/// What a job packs.
template <int Dim>
struct Subject {
    std::shared_ptr<const Domain<Dim>> domain;
    std::string name, radii;
    double field = 0;  ///< seconds for the field of a mesh
};

template <int Dim>
Subject<Dim> subjectOf(const Job& job, int threads) {
    Subject<Dim> made;
    if constexpr (Dim == 3) {
        if (!job.mesh.empty()) {
            const BenchMesh argument = readBenchMesh(job.mesh);
            const FieldOptions make = argument.fieldOptions();
            withThreads(threads, [&] {
                made.field = secondsOf([&] { made.domain = meshDomain(argument.mesh, make); });
            });
            made.name = argument.file.substr(argument.file.find_last_of('/') + 1);
            made.name = made.name.substr(0, made.name.find_first_of("._"));
            made.radii =
                fmt::format("uniform:{},{}", argument.smallestRadius, 2 * argument.smallestRadius);
            return made;
        }
    }
    const double half = job.side / 2;
    made.domain = boxDomain<Dim>({Box<Dim>::filled(-half), Box<Dim>::filled(half)});
    made.name = fmt::format("{}:{:.0f}", Dim == 3 ? "box" : "rect", job.side);
    made.radii = job.radii;
    return made;
}

/// Packs, checks and prints a row.
template <int Dim>
void runJob(const Job& job, int threads) {
    const auto [domain, name, radii, field] = subjectOf<Dim>(job, threads);
    PackOptions options(SizeDistribution::parse(radii, Dim));
    options.effort = job.effort;
    options.threads = job.threads > 0 ? job.threads : threads;
    if (job.oneBlock) options.blockSide = 2 * job.side;
    PackResult<Dim> result;
    const auto& space = *domain;
    const double pack = secondsOf([&] { result = packSpheres(space, options); });
    auto& spheres = result.pack.spheres;
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    double total = 0, check = std::numeric_limits<double>::infinity(), shuffled = check, ks = 0;
    std::optional<double> interior, seam;
    double halves = 0;
    std::size_t overlaps = 0;
    withThreads(threads, [&] {
        total = solidFraction(spheres, space);
        interior = interiorFraction(spheres, space, 3 * options.sizes.max());
        std::vector<double> placed;
        for (const auto& s : spheres) placed.push_back(s.radius);
        ks = ksDistance(std::move(placed), [&](double r) { return options.sizes.cdf(r); });
        for (int run = 0; run < 3; ++run)
            check = std::min(check, secondsOf([&] { overlaps += checkOverlap(spheres).pairs; }));
        if (job.mesh.empty()) seam = seams(result, space, options.sizes.max());
        halves = ksOfHalves(spheres, space);
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

std::vector<Job> jobsOf(bool quick, const std::vector<std::string>& meshes) {
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
    return jobs;
}

void printHeader() {
    std::string hardware = "unknown processor";
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.rfind("model name", 0) == 0) {
            hardware = line.substr(line.find(':') + 2);
            break;
        }
    fmt::print(
        "{}, {} hardware threads; seed 1, default block size unless there is one block.\n"
        "check: seconds of verify's overlap check, least of three; shuffled: the same with the "
        "spheres\nin random order; ratio: pack / check. chain: longest chain of dependent blocks. "
        "MB: "
        "peak of\npacking. halves: ks between the radii of the outer and the inner "
        "half "
        "of the spheres. seams: solid\nfraction within a largest diameter of block faces minus "
        "that "
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
}

/// Runs a job in a process of its own, so that the peak of memory is that of the job.
/// @return whether it succeeded.
bool runApart(const Job& job, int threads) {
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
    return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

bool benchPacks(bool quick, int threads, const std::vector<std::string>& meshes) {
    printHeader();
    for (const Job& job : jobsOf(quick, meshes))
        if (!runApart(job, threads)) return false;
    return true;
}
