#include "bench_threads.h"

#include "bench_mesh.h"

#include "vdbpack/run/run.h"
#include "vdbpack/verify/verify.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <stdexcept>

using namespace vdbpack;

namespace {

constexpr int kRuns = 3;

using Seconds = Report::Seconds;
struct Stage {
    const char* name;
    double Seconds::*seconds;
};
constexpr std::array<Stage, 9> kStages{{{"mesh", &Seconds::mesh},
                                        {"domain", &Seconds::domain},
                                        {"pack", &Seconds::pack},
                                        {"settle", &Seconds::settle},
                                        {"densify", &Seconds::densify},
                                        {"voids", &Seconds::voids},
                                        {"measure", &Seconds::measure},
                                        {"write", &Seconds::write},
                                        {"total", &Seconds::total}}};

struct Job {
    std::string name;
    PackRecipe recipe;
};

Job boxJob(const std::string& box, double fraction) {
    Job job;
    job.name = box + ", radii uniform:1,2";
    if (fraction > 0) job.name += fmt::format(", densified to {}", fraction);
    job.recipe.domain.source = box;
    job.recipe.radius = SizeDistribution::uniform(1, 2);
    job.recipe.densify.fraction = fraction;
    return job;
}

Job meshJob(const MeshArgument& mesh) {
    const double smallest = mesh.smallestRadius;
    Job job;
    PackRecipe& recipe = job.recipe;
    recipe.domain.source = mesh.file;
    recipe.domain.unit = mesh.unit;
    recipe.radius = SizeDistribution::uniform(smallest, 2 * smallest);
    BooleanVoids voids;
    voids.shape.radius = SizeDistribution::uniform(3 * smallest, 6 * smallest);
    voids.targetBvtv = 0.3;
    recipe.voids.method = voids;
    recipe.voids.shell = 4 * smallest;
    job.name = fmt::format("{}, radii {}, voids boolean of {}, shell {:g}, BV/TV 0.3",
                           std::filesystem::path(mesh.file).filename().string(),
                           recipe.radius.spec(), voids.shape.radius.spec(), recipe.voids.shell);
    return job;
}

/// Prints a row for each number of threads.
void bench(const Job& job, const std::vector<int>& threads, const std::string& file) {
    Seconds alone;
    std::string hash;
    for (const int t : threads) {
        PackRecipe recipe = job.recipe;
        recipe.threads = t;
        recipe.outputs = {file};
        Seconds least;
        for (const Stage& stage : kStages)
            least.*stage.seconds = std::numeric_limits<double>::infinity();
        Report report;
        for (int run = 0; run < kRuns; ++run) {
            report = runPack(recipe).report;
            for (const Stage& stage : kStages)
                least.*stage.seconds =
                    std::min(least.*stage.seconds, report.seconds.*stage.seconds);
        }
        const std::string now = hashText(report.hash);
        if (hash.empty()) {
            alone = least;
            hash = now;
            fmt::print("{}: {} spheres, hash {}\n{:>7}", job.name, report.count, hash, "threads");
            for (const Stage& stage : kStages) fmt::print(" {:>14}", stage.name);
            fmt::print("\n");
        }
        if (now != hash)
            throw std::runtime_error(fmt::format("{}: {} threads give another pack", job.name, t));
        fmt::print("{:>7}", t);
        for (const Stage& stage : kStages) {
            const double s = least.*stage.seconds, one = alone.*stage.seconds;
            fmt::print(" {:>14}", s < 0.01 ? fmt::format("{:.3f}", s)
                                           : fmt::format("{:.3f} ({:4.1f})", s, one / s));
        }
        fmt::print("\n");
        std::fflush(stdout);
    }
}

}  // namespace

void benchThreads(int most, bool quick, const std::vector<std::string>& meshes) {
    std::vector<int> threads;
    for (int t = 1; t < most; t *= 2) threads.push_back(t);
    threads.push_back(most);
    std::vector<Job> jobs;
    jobs.push_back(boxJob(quick ? "box:120,120,120" : "box:370,370,370", 0));
    jobs.push_back(boxJob(quick ? "box:60,60,60" : "box:200,200,200", 0.645));
    for (const auto& mesh : meshes) jobs.push_back(meshJob(parseMeshArgument(mesh)));
    fmt::print(
        "seconds of the stages of `pack -o .vdb`, least of {} runs; in brackets how many "
        "times as fast as one\nthread\n",
        kRuns);
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / fmt::format("bench_threads_{}", ::getpid());
    std::filesystem::create_directories(folder);
    for (const Job& job : jobs) bench(job, threads, (folder / "pack.vdb").string());
    std::filesystem::remove_all(folder);
}
