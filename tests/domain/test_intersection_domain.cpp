#include "support/random_point.h"
#include "support/test.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/intersection_domain.h"
#include "vdbpack/pack/packer.h"

DIM_TEST_CASE("spheres in the intersection of two domains leave neither") {
    const std::shared_ptr<const Domain<Dim>> ball = ballDomain<Dim>(10);
    Box<Dim> box;
    for (int d = 0; d < Dim; ++d) {
        box.lo[d] = -8;
        box.hi[d] = 9;
    }
    const std::shared_ptr<const Domain<Dim>> block = boxDomain<Dim>(box);
    const auto both = intersectionDomain<Dim>(block, ball);
    const auto pack =
        packSpheres(*both, PackOptions(SizeDistribution::uniform(0.5, 1))).pack.spheres;
    REQUIRE(pack.size() > 50);
    const auto inBall = ball->sampler(), inBox = block->sampler(), inBoth = both->sampler();
    for (const auto& s : pack) {
        const double a = -inBall->signedDistance(s.center), b = -inBox->signedDistance(s.center);
        CHECK(std::min(a, b) >= s.radius * (1 - 1e-6));
        WallPoint<Dim> wall;
        REQUIRE(inBoth->nearestWall(s.center, 100, wall));
        CHECK(wall.distance == Approx(std::min(a, b)));
        CHECK(inBoth->isWallCloser(s.center, 1.001 * wall.distance));
        CHECK_FALSE(inBoth->isWallCloser(s.center, 0.999 * wall.distance));
    }
}
