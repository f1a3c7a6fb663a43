// Spheres in a domain given by a formula.
#include <vdbpack/vdbpack.h>

#include <cmath>
#include <iostream>

using namespace vdbpack;

int main() {
    // A torus: signed distance in mm, negative inside.
    const auto torus = [](const Vec<3>& p) {
        return std::hypot(std::hypot(p[0], p[1]) - 20, p[2]) - 6;
    };
    const auto domain = functionDomain<3>(torus, Box<3>{{{-27, -27, -7}}, {{27, 27, 7}}});

    PackOptions options(SizeDistribution::uniform(1, 2));  // the shape: the radii are scaled
    Callbacks callbacks;
    callbacks.progress = [](const Progress& p) { std::cerr << p.stage << ' ' << p.count << '\r'; };
    const Pack<3> pack = packToCount(*domain, options, 5000, callbacks).pack;
    std::cout << pack.spheres.size() << " spheres, radii " << options.sizes.spec() << " mm\n";
    writePack(pack, "torus.vtp");
}
