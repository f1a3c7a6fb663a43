// Which spheres can be seen.
#include "vdbpack/view/exposure.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

using namespace vdbpack;

namespace {

constexpr int kSide = 24;

/// A cube of touching spheres of radius 1 about the origin, without those that `leaveOut` names.
std::vector<Sphere<3>> cubeOfSpheres(const std::function<bool(const Vec<3>&)>& leaveOut) {
    std::vector<Sphere<3>> spheres;
    for (int x = 0; x < kSide; ++x)
        for (int y = 0; y < kSide; ++y)
            for (int z = 0; z < kSide; ++z) {
                const Vec<3> at{{2.0 * x + 1 - kSide, 2.0 * y + 1 - kSide, 2.0 * z + 1 - kSide}};
                if (!leaveOut(at)) spheres.push_back({at, 1});
            }
    return spheres;
}

/// Distance of a point inside the cube to its faces.
double depthIn(const Vec<3>& x) {
    double depth = kSide;
    for (int d = 0; d < 3; ++d) depth = std::min(depth, kSide - std::fabs(x[d]));
    return depth;
}

}  // namespace

TEST_CASE("the optical radius of equal spheres is theirs, of others that of the large ones",
          "[view]") {
    CHECK(opticalRadius({{{{0, 0, 0}}, 2}, {{{9, 0, 0}}, 2}}) == Approx(2));
    CHECK(opticalRadius({{{{0, 0, 0}}, 1}, {{{9, 0, 0}}, 3}}) == Approx(28.0 / 10));
    CHECK(opticalRadius({}) == 0);
}

TEST_CASE("spheres near the surface are seen, those within are buried", "[view]") {
    const auto spheres = cubeOfSpheres([](const Vec<3>&) { return false; });
    const auto exposure = exposureOf(spheres);
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const double depth = depthIn(spheres[i].center);
        if (depth < 4) REQUIRE(exposure[i] == Exposure::outer);
        // Marks lie on cells, and reach up to two of them farther.
        if (depth > kOpticalDepth + 3) REQUIRE(exposure[i] == Exposure::buried);
    }
}

TEST_CASE("a closed void shows its spheres to cuts, an open one to all", "[view]") {
    const bool open = GENERATE(false, true);
    CAPTURE(open);
    const auto inVoid = [&](const Vec<3>& x) {
        return length(x) < 6 || (open && x[2] > 0 && std::hypot(x[0], x[1]) < 4);
    };
    const auto spheres = cubeOfSpheres(inVoid);
    const auto exposure = exposureOf(spheres);
    std::size_t near = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const Vec<3>& x = spheres[i].center;
        if (length(x) > 8.5 || depthIn(x) < kOpticalDepth + 3) continue;
        ++near;
        REQUIRE(exposure[i] == (open ? Exposure::outer : Exposure::inner));
    }
    CHECK(near > 50);
}

TEST_CASE("single spheres and loose ones are all seen", "[view]") {
    CHECK(exposureOf({}).empty());
    CHECK(exposureOf({{{{5, 5, 5}}, 1}}) == std::vector<Exposure>{Exposure::outer});
    std::vector<Sphere<3>> loose;
    for (int i = 0; i < 1000; ++i)
        loose.push_back({{{10.0 * (i % 10), 10.0 * (i / 10 % 10), 10.0 * (i / 100)}}, 1});
    const auto exposure = exposureOf(loose);
    CHECK(std::count(exposure.begin(), exposure.end(), Exposure::outer) == 1000);
}
