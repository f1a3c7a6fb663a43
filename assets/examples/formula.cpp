// Spheres in a domain given by a formula.
#include <vdbpack/vdbpack.h>

#include <cmath>
#include <cstdio>

using namespace vdbpack;

int main() {
    // A torus: signed distance in mm, negative inside.
    const auto torus = [](const Vec<3>& p) {
        return std::hypot(std::hypot(p[0], p[1]) - 20, p[2]) - 6;
    };
    const auto domain = functionDomain<3>(torus, Box<3>{{{-27, -27, -7}}, {{27, 27, 7}}});

    PackOptions options(SizeDistribution::uniform(1, 2));  // a shape: the radii are scaled
    Callbacks callbacks;
    callbacks.progress = [](const Progress& p) {
        std::fprintf(stderr, "\r%s %3.0f %%", p.stage.c_str(), 100 * p.fraction);
    };
    const auto result = packToCount(*domain, options, 5000, callbacks);
    writePack(result.pack, "torus.vtp");

    std::printf("%zu spheres of %.2f to %.2f mm\n", result.pack.spheres.size(), options.sizes.min(),
                options.sizes.max());
    return result.pack.spheres.empty() ? 1 : 0;
}
