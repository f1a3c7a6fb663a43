// densify's own test of a pack decides as verify does.
#include "measure/packs.h"
#include "support/test.h"

#include "vdbpack/densify/input_check.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/verify/verify.h"

DIM_TEST_CASE("a pack is accepted where verify finds no fault") {
    const double share = GENERATE(-1e-3, 0.0, 0.9e-6, 1.1e-6, 1e-3);
    CAPTURE(Dim, share);
    // Two unit spheres, the first touching the wall, apart by 2 - share.
    Box<Dim> box;
    box.add(Box<Dim>::filled(-1));
    box.add(Box<Dim>::filled(5));
    const auto domain = boxDomain<Dim>(box);
    std::vector<Sphere<Dim>> spheres(2, Sphere<Dim>{{}, 1});
    SECTION("that overlap") {
        spheres[1].center[0] = 2 - share;
        REQUIRE(isAccepted(spheres, 0, *domain) == (checkOverlap(spheres).pairs == 0));
    }
    SECTION("that protrude, unless they are fixed") {
        spheres[1].center[0] = 3;
        spheres[0].center[0] = -share;
        const auto check = checkProtrusion(spheres, WallShape<Dim>::ofBox(box));
        REQUIRE(isAccepted(spheres, 0, *domain) == (check.spheres == 0));
        REQUIRE(isAccepted(spheres, 1, *domain));
    }
    SECTION("that are outside") {
        spheres[1].center[0] = 30;
        REQUIRE_FALSE(isAccepted(spheres, 0, *domain));
    }
    SECTION("that are no spheres") {
        spheres[1].center[0] = std::numeric_limits<double>::quiet_NaN();
        REQUIRE_THROWS_AS(isAccepted(spheres, 0, *domain), InputError);
    }
}
