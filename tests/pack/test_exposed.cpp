// Spheres that stand without those under others: nothing that keeps clear of the rest meets them.
#include "support/cube.h"
#include "support/random_point.h"
#include "support/test.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/pack/exposed.h"

namespace {

/// Whether the center of a sphere of radius `least` may not be there.
template <int Dim>
bool isBarred(const std::vector<Sphere<Dim>>& spheres, const Vec<Dim>& x, double least) {
    return std::any_of(spheres.begin(), spheres.end(), [&](const Sphere<Dim>& s) {
        return length(s.center - x) < s.radius + least;
    });
}

template <int Dim>
std::vector<Sphere<Dim>> lattice(int along, double spacing) {
    std::vector<Sphere<Dim>> spheres;
    int count = 1;
    for (int d = 0; d < Dim; ++d) count *= along;
    for (int i = 0; i < count; ++i) {
        Vec<Dim> x;
        for (int d = 0, rest = i; d < Dim; ++d, rest /= along) x[d] = spacing * (rest % along);
        spheres.push_back({x, 1});
    }
    return spheres;
}

}  // namespace

DIM_TEST_CASE("what is left bars the same places") {
    const double half = GENERATE(0.001, 1.0, 4.0);  // from a clump to a loose heap
    const double ratio = GENERATE(1.0, 4.0);
    const double least = GENERATE(0.05, 1.0, 5.0);
    CAPTURE(Dim, half, ratio, least);
    RandomStream random(5, 0);
    std::vector<Sphere<Dim>> spheres;
    for (int i = 0; i < 400; ++i) {
        const Vec<Dim> center = randomPoint(random, cube<Dim>(2 * (half)));
        spheres.push_back({center, 1 + (ratio - 1) * random.uniform()});
    }
    const auto left = exposedSpheres(spheres, least);
    if (half < 1) REQUIRE(left.size() < spheres.size() / 3);
    // In their order, and none but those.
    auto at = spheres.begin();
    for (const auto& s : left) {
        at = std::find(at, spheres.end(), s);
        REQUIRE(at != spheres.end());
        ++at;
    }
    int barred = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec<Dim> x = randomPoint(random, cube<Dim>(2 * (half + 1.1 * (ratio + least))));
        const bool now = isBarred(left, x, least);
        REQUIRE(now == isBarred(spheres, x, least));
        barred += now;
    }
    REQUIRE(barred > 0);
    REQUIRE(barred < 20000);
    // Where only some few would differ: just within the edge of what each one bars.
    for (int i = 0; i < 20000; ++i) {
        const auto& s = spheres[static_cast<std::size_t>(i) % spheres.size()];
        const Vec<Dim> x = s.center + normalized(randomPoint(random, cube<Dim>(2 * (1)))) *
                                          ((s.radius + least) * (1 - 1e-7));
        REQUIRE(isBarred(left, x, least));
    }
}

DIM_TEST_CASE("spheres that only touch are all left") {
    const auto spheres = lattice<Dim>(8, 2);
    CHECK(exposedSpheres(spheres, 1) == spheres);
    CHECK(exposedSpheres(spheres, 0.1) == spheres);
    CHECK(exposedSpheres(std::vector<Sphere<Dim>>{}, 1).empty());
}

DIM_TEST_CASE("of copies one is left, and nothing inside others") {
    std::vector<Sphere<Dim>> spheres(5000, {Vec<Dim>{}, 2});
    spheres.push_back({Box<Dim>::filled(0.5), 1});
    CHECK(exposedSpheres(spheres, 0.3) == std::vector<Sphere<Dim>>{{Vec<Dim>{}, 2}});
}

TEST_CASE("of a body filled with spheres the skin is left") {
    const auto spheres = lattice<3>(20, 0.4);
    const auto left = exposedSpheres(spheres, 0.5);
    CHECK(left.size() < spheres.size() / 2);
    for (const double corner : {0.0, 19 * 0.4})
        CHECK(std::find(left.begin(), left.end(), Sphere<3>{Box<3>::filled(corner), 1}) !=
              left.end());
}

TEST_CASE("thousands of spheres around one point are refused") {
    RandomStream random(6, 0);
    std::vector<Sphere<3>> spheres;
    for (int i = 0; i < 3000; ++i)
        spheres.push_back({normalized(randomPoint(random, cube<3>(2))) * 1e-3, 1});
    REQUIRE_THROWS_MATCHES(exposedSpheres(spheres, 1), InputError,
                           Catch::Predicate<InputError>([](const InputError& e) {
                               return std::string(e.what()).find("2000") != std::string::npos;
                           }));
    spheres[17].center[0] = std::nan("");
    REQUIRE_THROWS_AS(exposedSpheres(spheres, 1), InputError);
}
