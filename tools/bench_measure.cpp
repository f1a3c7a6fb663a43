#include "bench_measure.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/run/run.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

using namespace vdbpack;

namespace {

double mebibytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// An ellipsoidal void: two minor half-axes `b`, the major one `a` along a unit axis, mm.
struct Void {
    Vec<3> center, axis;
    double a = 0, b = 0;
};

/// A Boolean model: ellipsoids at random positions (Poisson) and in random directions, removed from
/// a solid cube. The solid fraction is exp(-n v) for n voids of volume v per volume. Distances to
/// the ellipsoids are first-order accurate at their surfaces.
VoxelImage trabecularSample(int edge, double voxelSize, double solidFraction) {
    const double a = 0.36, b = 0.24, volume = 4.0 / 3.0 * kPi * a * b * b;
    const double side = edge * voxelSize, window = side + 2 * a;
    const auto count = static_cast<int>(-std::log(solidFraction) / volume * std::pow(window, 3));
    RandomStream random(1, 1);
    std::vector<Void> voids(static_cast<std::size_t>(count));
    for (Void& v : voids) {
        for (int d = 0; d < 3; ++d) v.center[d] = random.uniform() * window - a;
        const double z = 2 * random.uniform() - 1, angle = 2 * kPi * random.uniform();
        const double s = std::sqrt(1 - z * z);
        v.axis = {{s * std::cos(angle), s * std::sin(angle), z}};
        v.a = a;
        v.b = b;
    }
    VoxelImage image;
    image.size = {edge, edge, edge};
    image.voxelSize = voxelSize;
    image.origin = {{voxelSize / 2, voxelSize / 2, voxelSize / 2}};
    const auto n = static_cast<std::size_t>(edge);
    image.distance.assign(n * n * n, static_cast<float>(-3 * voxelSize));
    tbb::parallel_for(std::size_t{0}, n, [&](std::size_t k) {
        const double z = (static_cast<double>(k) + 0.5) * voxelSize;
        for (const Void& v : voids) {
            const double reach = v.a + 3 * voxelSize;
            if (std::fabs(z - v.center[2]) > reach) continue;
            const auto range = [&](int d) {
                const auto at = [&](double x) {
                    return static_cast<std::size_t>(
                        std::clamp(std::floor(x / voxelSize), 0.0, static_cast<double>(edge)));
                };
                return std::make_pair(at(v.center[d] - reach), at(v.center[d] + reach));
            };
            const auto [x0, x1] = range(0);
            const auto [y0, y1] = range(1);
            for (std::size_t j = y0; j < y1; ++j)
                for (std::size_t i = x0; i < x1; ++i) {
                    const Vec<3> to = Vec<3>{{(static_cast<double>(i) + 0.5) * voxelSize,
                                              (static_cast<double>(j) + 0.5) * voxelSize, z}} -
                                      v.center;
                    const double along = dot(to, v.axis);
                    const Vec<3> across = to - v.axis * along;
                    const double u = along / v.a, w2 = squaredLength(across) / (v.b * v.b);
                    const double f = std::sqrt(u * u + w2);
                    const double slope =
                        std::sqrt(u * u / (v.a * v.a) + w2 / (v.b * v.b)) / std::max(f, 1e-9);
                    const double outside = (f - 1) / std::max(slope, 1e-9);
                    float& d = image.distance[(k * n + j) * n + i];
                    d = std::max(d, static_cast<float>(std::min(-outside, 3 * voxelSize)));
                }
        }
    });
    return image;
}

}  // namespace

void benchMeasure(int threads, double side, int edge) {
    const std::string folder =
        (std::filesystem::temp_directory_path() / fmt::format("bench_measure.{}", ::getpid()))
            .string();
    std::filesystem::create_directory(folder);
    try {
        PackRecipe pack;
        pack.domain.source = fmt::format("box:{0:g},{0:g},{0:g}", side);
        pack.radius = SizeDistribution::uniform(1, 2);
        pack.threads = threads;
        pack.outputs = {folder + "/pack.vdb"};
        const double packing = runPack(pack).report.seconds.pack;
        MeasureRecipe recipe;
        recipe.pack = pack.outputs.front().text;
        recipe.domain = pack.domain;
        recipe.radius = pack.radius;
        recipe.threads = threads;
        recipe.shell = 3;
        const MeasureResult result = runMeasure(recipe);
        fmt::print(
            "box:{:g}, radii uniform:1,2, normal, {} threads: {} spheres packed in {:.2f} s, "
            "all measures in {:.2f} s\n\n{}\n",
            side, threads, result.run.report.count, packing, result.run.report.seconds.measure,
            summary(result));
    } catch (...) {
        std::filesystem::remove_all(folder);
        throw;
    }
    std::filesystem::remove_all(folder);
    std::fflush(stdout);

    const VoxelImage image = trabecularSample(edge, 0.02, 0.15);
    const double before = mebibytes();
    const auto start = std::chrono::steady_clock::now();
    const Morphometry m = withThreads(threads, [&] { return measureMorphometry(image); });
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    fmt::print(
        "{0}³ voxels of {1:g} mm, a Boolean model of ellipsoidal voids for BV/TV 0.15: "
        "morphometry in {2:.1f} s with {3:.0f} MB at most (before: {4:.0f})\n\n{5}",
        edge, image.voxelSize, seconds, mebibytes(), before, summary(m));
}
