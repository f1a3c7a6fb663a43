// Packs of equal spheres: dense, at random, and the denser the more effort is spent.
#include "support/cube.h"
#include "support/test.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/measure/bond_order.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/verify.h"

namespace {

std::vector<Sphere<3>> packed(const Domain<3>& domain, Effort effort, const std::string& spec,
                              int threads = 2) {
    PackOptions options(SizeDistribution::parse(spec, 3));
    options.effort = effort;
    options.threads = threads;
    return packSpheres(domain, options).pack.spheres;
}

}  // namespace

TEST_CASE("equal spheres are packed densely and at random") {
    const auto domain = boxDomain<3>(cube<3>(50));
    for (const std::string spec : {"constant:1", "uniform:0.97,1.03", "uniform:0.9,1.1"}) {
        CAPTURE(spec);
        const double depth = 3 * SizeDistribution::parse(spec, 3).max();
        double fractions[3];
        for (const Effort effort : {Effort::fast, Effort::normal, Effort::dense}) {
            const auto spheres = packed(*domain, effort, spec);
            CHECK(checkOverlap(spheres).max == 0);
            fractions[static_cast<int>(effort)] = *interiorFraction(spheres, *domain, depth);
            if (effort != Effort::fast) CHECK(solidLikeShare(spheres) < 0.02);
        }
        const double normal = fractions[static_cast<int>(Effort::normal)];
        CHECK(normal > 0.606);
        CHECK(normal > fractions[static_cast<int>(Effort::fast)] + 0.003);
        CHECK(fractions[static_cast<int>(Effort::dense)] > 0.608);
    }
}

TEST_CASE("a front of equal spheres is the same for any number of threads") {
    const auto domain = ballDomain<3>(24);
    const auto one = packed(*domain, Effort::normal, "constant:1", 1);
    for (const int threads : {2, 3, 8}) {
        CAPTURE(threads);
        CHECK(one == packed(*domain, Effort::normal, "constant:1", threads));
    }
}

TEST_CASE("a cell of equal spheres without walls is packed as densely as a box inside") {
    PeriodicCell<3> cell;
    cell.box = cube<3>(41);
    cell.wraps = {true, true, true};
    const auto domain = periodicDomain<3>(cell);
    const auto spheres = packed(*domain, Effort::normal, "constant:1");
    CHECK(solidFraction(spheres, *domain) > 0.600);
    CHECK(solidLikeShare(spheres, cell) < 0.01);
}
