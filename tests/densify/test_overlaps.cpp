// Packs of any origin, whose overlaps are removed.
#include "densify/densifying.h"
#include "support/paths.h"
#include "support/test.h"

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/measure/density.h"

DIM_TEST_CASE("overlaps of packs of any origin are removed") {
    // Far off the origin, and in lengths of another size.
    const double unit = GENERATE(1e-3, 1.0, 1e3);
    CAPTURE(Dim, unit);
    const Vec<Dim> center = Box<Dim>::filled(300 * unit);
    const auto domain = box<Dim>((Dim == 3 ? 24 : 60) * unit, center);
    auto given = front<Dim>(*box<Dim>(Dim == 3 ? 24 : 60), "uniform:1,2");
    given = shaken(given, 0.04);
    for (auto& s : given) {
        s.center = s.center * unit + center;
        s.radius *= unit;
    }
    REQUIRE(checkOverlap(given).max > 0.02);
    REQUIRE(protrusion(given, *domain) > 0);
    const auto result = densify(*domain, given, {});
    CHECK(result.apart);
    CHECK(result.spheres.size() == given.size());
    checkRadii(given, result.spheres);
    checkSound(result.spheres, *domain);
}

TEST_CASE("the spheres of a pack that YADE compressed are separated") {
    const auto given = readPack("yade:" + kTests + "/densify/yade_pack.txt").spheres;
    const auto domain = boxDomain<3>({{}, Box<3>::filled(10)});
    REQUIRE(checkOverlap(given).max > 0.02);
    const auto result = densify(*domain, given, {});
    CHECK(result.apart);
    checkRadii(given, result.spheres);
    checkSound(result.spheres, *domain);
    CHECK(solidFraction(result.spheres, *domain) ==
          Approx(solidFraction(given, *domain)).margin(0.002));
}

TEST_CASE("a pack without overlaps is left as it is") {
    const auto domain = box<3>(20);
    const auto before = front(*domain, "uniform:1,2");
    const auto result = densify(*domain, before, {});
    CHECK(result.apart);
    CHECK(result.steps == 0);
    CHECK(result.spheres == before);
}

TEST_CASE("spheres on the same spot are separated") {
    const auto domain = box<3>(20);
    std::vector<Sphere<3>> given(30, Sphere<3>{{{1, 2, 3}}, 1.0});
    const auto result = densify(*domain, given, {});
    CHECK(result.apart);
    checkSound(result.spheres, *domain);
}

TEST_CASE("more spheres than fit cannot be separated, and are returned") {
    const auto domain = box<3>(6);
    const std::vector<Sphere<3>> given(40, Sphere<3>{{{1, 0, 0}}, 1.5});
    const auto result = densify(*domain, given, {});
    CHECK_FALSE(result.apart);
    CHECK_FALSE(result.reached);
    CHECK(result.spheres == given);
}
