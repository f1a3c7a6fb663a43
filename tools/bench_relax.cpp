#include "bench_relax.h"

#include "bench_clock.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/verify.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

using namespace vdbpack;

namespace {

constexpr double kFraction = 0.66;

/// A row. @return the hash of the pack
std::string row(const Domain<3>& domain, const std::vector<Sphere<3>>& front,
                const SizeDistribution& sizes, const DeviceChoice& device) {
    DensifyOptions options;
    options.fraction = kFraction;
    options.sizes = sizes;
    options.device = device;
    DensifyResult<3> result;
    double wall = 0;
    const double processor = processorSecondsOf(
        [&] { wall = secondsOf([&] { result = densify(domain, front, options); }); });
    const auto count = static_cast<double>(result.spheres.size());
    const bool moved = result.device.steps > 0;
    const auto steps = static_cast<double>(moved ? result.device.steps : result.steps);
    Pack<3> pack;
    pack.spheres = std::move(result.spheres);
    const std::string hash = hashText(packHash(pack));
    fmt::print("{:>9.0f} {:<34} {:>6} {:>8.2f} {:>9.2f} {:>8} {:>8.2f} {}\n", count,
               moved ? result.device.name.substr(0, 34) : "processor", result.steps, wall,
               processor, moved ? fmt::format("{:.3f}", result.device.seconds) : "-",
               1e9 * (moved ? result.device.seconds : wall) / steps / count, hash);
    return hash;
}

}  // namespace

bool benchRelax(int threads, bool quick, std::vector<std::string> words) {
    std::vector<DeviceChoice> devices;
    std::vector<double> counts;
    for (const std::string& word : words) {
        if (word.rfind("gpu:", 0) == 0)
            devices.push_back({DeviceChoice::Kind::gpu, std::atoi(word.c_str() + 4)});
        else if (const double count = std::atof(word.c_str()); count >= 1000 && count <= 1e9)
            counts.push_back(count);
        else
            throw ParameterError(word + ": write a number of spheres from 1000 to 1e9, or gpu:N");
    }
    if (counts.empty()) counts = quick ? std::vector<double>{20000} : std::vector{7e4, 1e6};
    if (devices.empty()) devices = {{DeviceChoice::Kind::gpu, 0}};
    fmt::print(
        "{} threads; boxes, radii 1 to 2, from the front to {}. s: wall, all of densifying; "
        "cpu: processor\nseconds; kernels: seconds of the device; ns: by step and sphere, of "
        "kernels or of s\n{:>9} {:<34} {:>6} {:>8} {:>9} {:>8} {:>8} hash\n",
        threads, kFraction, "spheres", "device", "steps", "s", "cpu", "kernels", "ns");
    bool same = true;
    withThreads(threads, [&] {
        const auto sizes = SizeDistribution::uniform(1, 2);
        for (const double count : counts) {
            const double side = std::cbrt(count * sizes.meanBall(3) / kFraction);
            const auto domain = boxDomain<3>({{}, Box<3>::filled(side)});
            const auto front = packSpheres(*domain, PackOptions(sizes)).pack.spheres;
            const std::string own = row(*domain, front, sizes, {DeviceChoice::Kind::processor, 0});
            for (const DeviceChoice& device : devices) try {
                    same = row(*domain, front, sizes, device) == own && same;
                } catch (const ParameterError& e) {
                    fmt::print("{}\n", e.what());
                }
        }
    });
    return same;
}
