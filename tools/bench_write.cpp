#include "bench_write.h"

#include "bench_clock.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/pack/packer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <string>

using namespace vdbpack;

void benchWrite(int threads, double side) {
    constexpr int kRuns = 3;
    const auto domain = boxDomain<3>({Box<3>::filled(-side / 2), Box<3>::filled(side / 2)});
    PackOptions options(SizeDistribution::parse("uniform:1,2", 3));
    options.threads = threads;
    double packing = std::numeric_limits<double>::infinity();
    for (int run = 0; run < kRuns; ++run) {
        const double start = now();
        packSpheres(*domain, options);
        packing = std::min(packing, now() - start);
    }
    options.effort = Effort::fast;
    const PackResult<3> result = packSpheres(*domain, options);
    const auto& pack = result.pack;
    const auto count = static_cast<double>(pack.spheres.size());
    fmt::print(
        "box:{:g}, radii uniform:1,2: {} spheres written; packing with normal effort {:.2f} s on "
        "{} "
        "threads\n{:<8} {:>8} {:>8} {:>10}\n",
        side, pack.spheres.size(), packing, threads, "format", "s", "share", "bytes each");
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / fmt::format("bench_write_{}", ::getpid());
    std::filesystem::create_directories(folder);
    PackWriteOptions write;
    write.pointVoxel =
        std::min(pointVoxelSize(count, domain->volume(), 3), result.quantum * 0x1p25);
    double both = 0;
    for (const std::string format : {"vdb", "vtp", "usda", "csv", "npz", "xyz", "data", "ply"}) {
        const std::string file = (folder / ("pack." + format)).string();
        double seconds = std::numeric_limits<double>::infinity();
        withThreads(threads, [&] {
            for (int run = 0; run < kRuns; ++run) {
                const double start = now();
                writePack(pack, file, write);
                seconds = std::min(seconds, now() - start);
            }
        });
        if (format == "vdb" || format == "vtp") both += seconds;
        fmt::print("{:<8} {:>8.2f} {:>8.3f} {:>10.1f}\n", format, seconds, seconds / packing,
                   static_cast<double>(std::filesystem::file_size(file)) / count);
        std::filesystem::remove(file);
        std::fflush(stdout);
    }
    fmt::print(".vdb and .vtp together: {:.2f} s, {:.3f} of packing\n", both, both / packing);
    std::filesystem::remove_all(folder);
}
