// bench_pack: the benchmarks of packs and of what is done with them, one per command.
#include "bench_densify.h"
#include "bench_fields.h"
#include "bench_lookups.h"
#include "bench_measure.h"
#include "bench_mesh.h"
#include "bench_packs.h"
#include "bench_preview.h"
#include "bench_ranks.h"
#include "bench_relax.h"
#include "bench_threads.h"
#include "bench_voids.h"
#include "bench_write.h"
#include "rank_session.h"

#include "vdbpack/core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <thread>
#include <vector>

using namespace vdbpack;

namespace {

struct Arguments {
    bool quick = false;
    int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    std::vector<std::string> words;  ///< meshes, domains or a number
    Ranks* ranks = nullptr;          ///< null: started alone
};

/// A command: what follows its name, what it prints, the number of words that it takes, and its
/// work, which returns the exit code.
struct Command {
    const char* name;
    const char* arguments;
    const char* summary;
    std::size_t fewest, most;
    int (*work)(const Arguments&);
};

int benchAllLookups([[maybe_unused]] const std::vector<std::string>& meshes) {
#ifdef VDBPACK_BENCH_CGAL
    fmt::print(
        "one thread; the same random points in the bounding box\n{:<24} {:<42} {:>12} {:>10}\n",
        "mesh", "lookup", "per second", "times");
    for (const std::string& argument : meshes) {
        const BenchMesh a = readBenchMesh(argument);
        withThreads(1, [&] { ::benchLookups(a.mesh, a.file, a.smallestRadius); });
    }
    return 0;
#else
    fmt::print(stderr,
               "bench_pack: lookups are compared with CGAL; install libcgal-dev and configure "
               "with -DVDBPACK_BENCH_CGAL=ON\n");
    return 2;
#endif
}

int drawSpheres(const Arguments& a) {
    const double count = a.words.empty() ? 1e6 : std::atof(a.words[0].c_str());
    if (!(count >= 1 && count <= 1e9)) {
        fmt::print(stderr, "bench_pack: give a number of spheres from 1 to 1e9\n");
        return 2;
    }
    benchPreview(a.threads, count);
    return 0;
}

constexpr std::size_t kAny = static_cast<std::size_t>(-1);

const Command kCommands[] = {
    {"packs", "[--quick] [--threads T] [MESH[:UNIT[:SMALLEST_RADIUS_MM]] ...]",
     "density and speed of packs of boxes, squares and meshes, and the time to check them", 0, kAny,
     [](const Arguments& a) { return benchPacks(a.quick, a.threads, a.words) ? 0 : 1; }},
    {"fields", "MESH[:UNIT[:SMALLEST_RADIUS_MM]] ...",
     "seconds of the domain of each mesh, of an exact narrow band, and of one call of\n    "
     "meshToVolume with the same voxels and widths; the least of three runs each, in turn",
     1, kAny,
     [](const Arguments& a) {
         benchFields(a.words);
         return 0;
     }},
    {"measure", "[--quick] [--threads T]",
     "cost of all measures of a pack and of the morphometry of a sample", 0, 0,
     [](const Arguments& a) {
         benchMeasure(a.threads, a.quick ? 120 : 370, a.quick ? 128 : 256);
         return 0;
     }},
    {"write", "[--quick] [--threads T]",
     "cost of writing a pack to each format, compared with packing it", 0, 0,
     [](const Arguments& a) {
         benchWrite(a.threads, a.quick ? 120 : 370);
         return 0;
     }},
    {"densify", "[--quick] [--threads T] [DOMAIN[@UNIT]=FRACTION[=SPEC[=COUNT]] ...]",
     "density of packs beyond that of the front, and its cost", 0, kAny,
     [](const Arguments& a) {
         benchDensify(a.threads, a.quick, a.words);
         return 0;
     }},
    {"relax", "[--quick] [--threads T] [SPHERES ...] [gpu:N ...]",
     "cost of the steps that move spheres, on the processor and on devices of OpenCL; exit code 1\n"
     "    if a device makes another pack",
     0, kAny, [](const Arguments& a) { return benchRelax(a.threads, a.quick, a.words) ? 0 : 1; }},
    {"voids", "[--quick] [--threads T] MESH[:UNIT] ...",
     "cost of stamping 100,000 ellipsoids, compared with csgDifference one by one and with\n    "
     "packing",
     1, kAny,
     [](const Arguments& a) {
         for (const auto& mesh : a.words) benchVoids(mesh, a.threads, a.quick ? 50000 : 349748);
         return 0;
     }},
    {"ranks", "[--quick] [--threads T]",
     "blocks, what smaller ones cost, and the efficiency that a model predicts for many cores;\n   "
     " "
     "started by mpirun -n P: time, messages and bytes of P ranks, beside the prediction",
     0, 0,
     [](const Arguments& a) {
         benchRanks(a.threads, a.quick, a.ranks);
         return 0;
     }},
    {"threads", "[--quick] [--threads T] [MESH[:UNIT[:SMALLEST_RADIUS_MM]] ...]",
     "seconds of each stage of whole runs with 1, 2, 4, ... and T threads", 0, kAny,
     [](const Arguments& a) {
         benchThreads(a.threads, a.quick, a.words);
         return 0;
     }},
    {"preview", "[--threads T] [N]", "cost of drawing about N spheres (default: a million)", 0, 1,
     drawSpheres},
    {"lookups", "MESH[:UNIT[:SMALLEST_RADIUS_MM]] ...",
     "clearances per second, compared with CGAL's AABB tree and a loop over all triangles", 1, kAny,
     [](const Arguments& a) { return benchAllLookups(a.words); }},
};

/// The arguments after the command's name. @return whether they are usable.
bool parse(const std::vector<std::string>& words, Arguments& arguments) {
    for (std::size_t i = 1; i < words.size(); ++i) {
        if (words[i] == "--quick")
            arguments.quick = true;
        else if (words[i] == "--threads" && i + 1 < words.size() &&
                 (arguments.threads = std::atoi(words[i + 1].c_str())) > 0)
            ++i;
        else if (words[i].rfind("--", 0) != 0)
            arguments.words.push_back(words[i]);
        else
            return false;
    }
    return true;
}

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    Arguments arguments;
    try {
        const auto session = startRanks();
        if (session) {
            arguments.ranks = &session->ranks();
            if (words.empty() || words[0] != "ranks" || !parse(words, arguments))
                return session->end(true, 2, [] {
                    fmt::print(stderr, "bench_pack: several processes run `ranks` alone\n");
                });
            benchRanks(arguments.threads, arguments.quick, arguments.ranks);
            return session->end(false, 0, {});
        }
        if (!words.empty() && parse(words, arguments))
            for (const Command& c : kCommands)
                if (words[0] == c.name && arguments.words.size() >= c.fewest &&
                    arguments.words.size() <= c.most)
                    return c.work(arguments);
    } catch (const std::exception& e) {
        fmt::print(stderr, "bench_pack: {}\n", e.what());
        return 1;
    }
    for (const Command& c : kCommands)
        fmt::print(stderr, "bench_pack {} {}\n    {}\n", c.name, c.arguments, c.summary);
    return 2;
}
