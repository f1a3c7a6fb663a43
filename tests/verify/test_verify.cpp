#include "measure/packs.h"
#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/verify/verify.h"

#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

namespace {

template <int Dim>
double overlapOf(const Sphere<Dim>& a, const Sphere<Dim>& b) {
    return -gap(a, b) / std::min(a.radius, b.radius);
}

/// Every pair of spheres, one after the other.
template <int Dim>
OverlapCheck allPairs(const std::vector<Sphere<Dim>>& spheres) {
    OverlapCheck check;
    for (std::size_t i = 0; i < spheres.size(); ++i)
        for (std::size_t j = i + 1; j < spheres.size(); ++j) {
            const double overlap = overlapOf(spheres[i], spheres[j]);
            check.max = std::max(check.max, overlap);
            if (overlap > kVerifyTolerance) {
                ++check.pairs;
                check.worst.push_back({i, j, overlap});
            }
        }
    std::sort(check.worst.begin(), check.worst.end(),
              [](const OverlapPair& a, const OverlapPair& b) { return a.overlap > b.overlap; });
    check.worst.resize(std::min(check.worst.size(), kWorstNamed));
    return check;
}

template <int Dim>
void requireSame(const std::vector<Sphere<Dim>>& spheres) {
    const auto expected = allPairs(spheres);
    const auto found = checkOverlap(spheres);
    REQUIRE(found.complete);
    REQUIRE(found.pairs == expected.pairs);
    REQUIRE(found.max == Approx(expected.max).epsilon(1e-9));
    REQUIRE(found.worst.size() == expected.worst.size());
    for (std::size_t k = 0; k < found.worst.size(); ++k) {
        REQUIRE(found.worst[k].i < found.worst[k].j);
        REQUIRE(found.worst[k].overlap == Approx(expected.worst[k].overlap).epsilon(1e-9));
    }
}

}  // namespace

DIM_TEST_CASE("overlaps are those of an all-pairs search") {
    const auto seed = GENERATE(range(1u, 6u));
    const double ratio = GENERATE(1.0, 1.9, 3.0, 10.0, 100.0);
    CAPTURE(Dim, seed, ratio);
    requireSame(randomSpheres<Dim>(600, Dim == 2 ? 120.0 : 40.0, 0.5, ratio, seed));
}

DIM_TEST_CASE("overlaps are found wherever the spheres lie") {
    const auto seed = GENERATE(range(1u, 4u));
    CAPTURE(Dim, seed);
    auto spheres = randomSpheres<Dim>(300, 12.0, 0.3, 2.5, seed);
    SECTION("in clusters far apart") {
        RandomStream random(seed, 3);
        for (auto& s : spheres)
            for (int i = 0; i < Dim; ++i)
                if (random.uniform() < 0.5) s.center[i] += 1e7;
        requireSame(spheres);
    }
    SECTION("along a diagonal") {
        for (std::size_t k = 0; k < spheres.size(); ++k)
            for (int i = 0; i < Dim; ++i) spheres[k].center[i] += 0.7 * static_cast<double>(k);
        requireSame(spheres);
    }
    SECTION("at distances of every magnitude") {
        for (std::size_t k = 0; k < spheres.size(); ++k)
            spheres[k].center *= std::pow(10.0, static_cast<double>(k % 12) - 3);
        requireSame(spheres);
    }
    SECTION("far from the origin") {
        for (auto& s : spheres) s.center[0] += 1e6;
        requireSame(spheres);
    }
    SECTION("some of them far too large or too small") {
        spheres[3].radius = 1e9;
        spheres[4].radius = 40;
        spheres[5].radius = 1e-7;
        spheres[6].radius = 1e-25;
        spheres[7].center[0] = 1e25;
        requireSame(spheres);
    }
    SECTION("in one line") {
        for (auto& s : spheres)
            for (int i = 1; i < Dim; ++i) s.center[i] = 7;
        requireSame(spheres);
    }
}

DIM_TEST_CASE("touching spheres pass, a disturbed one is named") {
    std::vector<Sphere<Dim>> spheres = disjointSpheres<Dim>(Dim == 2 ? 100 : 20, 7);
    for (auto& s : spheres) s.radius = 1;
    auto check = checkOverlap(spheres);
    REQUIRE(check.pairs == 0);
    REQUIRE(check.max < 1e-12);
    const std::size_t victim = spheres.size() / 2 + 5;
    SECTION("moved by a tenth of its radius") {
        spheres[victim].center[0] += 0.1;
    }
    SECTION("doubled") {
        spheres[victim].radius *= 2;
    }
    check = checkOverlap(spheres);
    REQUIRE(check.pairs >= 1);
    for (const auto& w : check.worst) REQUIRE((w.i == victim || w.j == victim));
}

TEST_CASE("a pack of coincident spheres ends the count early") {
    const std::vector<Sphere<3>> spheres(20000, Sphere<3>{{}, 1.0});
    const auto check = checkOverlap(spheres);
    REQUIRE_FALSE(check.complete);
    REQUIRE(check.pairs > 1000000);
    REQUIRE(check.max == Approx(2.0));
}

TEST_CASE("few or no spheres") {
    REQUIRE(checkOverlap(std::vector<Sphere<3>>{}).pairs == 0);
    REQUIRE(checkOverlap(std::vector<Sphere<3>>{{{}, 1.0}}).pairs == 0);
    REQUIRE(checkOverlap(std::vector<Sphere<2>>{{{}, 1.0}, {{{1, 0}}, 2.0}}).pairs == 1);
    REQUIRE(verifyPack(Pack<3>{}).passed());
}

TEST_CASE("spheres that are no numbers are refused by number") {
    auto spheres = disjointSpheres<3>(4, 1);
    const double bad = GENERATE(std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::infinity(), -1.0, 0.0, 1e300);
    CAPTURE(bad);
    spheres[17].radius = bad;
    REQUIRE_THROWS_AS(checkOverlap(spheres), InputError);
    REQUIRE_THROWS_WITH(checkOverlap(spheres), Contains("sphere number 17"));
}

TEST_CASE("the Kolmogorov-Smirnov distance is that found by hand") {
    const auto uniform = [](double r) { return std::clamp(r - 1, 0.0, 1.0); };
    // Shares 1/4, 3/4 (a tie), 1 at 1.2, 1.5, 1.9: largest difference just after 1.5 or before.
    REQUIRE(ksDistance({1.5, 1.2, 1.9, 1.5}, uniform) == Approx(0.25).margin(1e-5));
    REQUIRE(ksDistance({1.9}, uniform) == Approx(0.9).margin(1e-5));
    REQUIRE(ksDistance({3.0, 4.0}, uniform) == Approx(1.0).margin(1e-5));
    REQUIRE(ksDistance({}, uniform) == 0);
    std::vector<double> even;
    for (int i = 0; i < 1000; ++i) even.push_back(1 + (i + 0.5) / 1000);
    REQUIRE(ksDistance(even, uniform) == Approx(0.0005).margin(1e-5));
}

TEST_CASE("atoms of a distribution are met by ties") {
    // Radius 0.3 with weight 0.4, 0.7 with weight 0.6.
    const auto upTo = [](double r) { return (r >= 0.3 ? 0.4 : 0.0) + (r >= 0.7 ? 0.6 : 0.0); };
    const auto before = [](double r) { return (r > 0.3 ? 0.4 : 0.0) + (r > 0.7 ? 0.6 : 0.0); };
    REQUIRE(ksDistance({0.3, 0.3, 0.7, 0.7, 0.7}, upTo, before) == Approx(0).margin(1e-12));
    REQUIRE(ksDistance({0.3, 0.7, 0.7, 0.7}, upTo, before) == Approx(0.15));
    REQUIRE(ksDistance({0.3, 0.3}, upTo, before) == Approx(0.6));
    REQUIRE(ksDistance({0.7}, upTo, before) == Approx(0.4));
    // As 32-bit floats, 0.3 lies above and 0.7 below the double.
    const double f3 = static_cast<double>(0.3f), f7 = static_cast<double>(0.7f);
    REQUIRE(ksDistance({f3, f3, f7, f7, f7}, upTo, before) == Approx(0).margin(1e-12));
}

TEST_CASE("the hash is that of the documented formula") {
    // Computed by numpy with the lines that assets/guides/files.md shows.
    Pack<3> pack;
    pack.spheres = {
        {{{0.0, -0.0, 1.5}}, 1.0}, {{{-12.25, 3e5, 0.1}}, 0.3}, {{{1.0 / 3, -2.0 / 3, 7.0}}, 2.5}};
    REQUIRE(hashText(packHash(pack)) == "d9c82dca516a1306");
    Pack<2> circles;
    circles.sliceHeight = 4;
    circles.spheres = {{{{1.25, -0.5}}, 0.75}, {{{0.1, 0.2}}, 0.3}};
    REQUIRE(hashText(packHash(circles)) == "8a1f8ce4415aae6f");
}

TEST_CASE("the hash knows no order, no threads, but every bit") {
    Pack<3> pack;
    pack.spheres = randomSpheres<3>(20000, 50, 0.5, 3, 9);
    const auto hash = packHash(pack);
    {
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        REQUIRE(packHash(pack) == hash);
    }
    auto turned = pack;
    std::rotate(turned.spheres.begin(), turned.spheres.begin() + 777, turned.spheres.end());
    std::reverse(turned.spheres.begin() + 5000, turned.spheres.end());
    REQUIRE(packHash(turned) == hash);
    turned.spheres[4].center[2] = std::nextafter(turned.spheres[4].center[2], 1e9);
    REQUIRE(packHash(turned) != hash);
    turned = pack;
    std::swap(turned.spheres[0].radius, turned.spheres[1].radius);
    REQUIRE(packHash(turned) != hash);
}

TEST_CASE("checks give the same for any number of threads") {
    const auto spheres = randomSpheres<3>(5000, 60, 0.5, 10, 3);
    const auto many = checkOverlap(spheres);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const auto alone = checkOverlap(spheres);
    REQUIRE(alone.pairs == many.pairs);
    REQUIRE(alone.max == many.max);
    REQUIRE(alone.worst.size() == many.worst.size());
    for (std::size_t k = 0; k < many.worst.size(); ++k) {
        REQUIRE(alone.worst[k].i == many.worst[k].i);
        REQUIRE(alone.worst[k].j == many.worst[k].j);
    }
}

TEST_CASE("a pack is verified against its wall in one call") {
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 0}}, 1}, {{{2.5, 0, 0}}, 1}};
    const Vec<3> lo{{-1, -1, -1}}, hi{{3.5, 1, 1}}, tight{{3.4, 1, 1}};
    CHECK(verifyPack(pack, boxMesh(lo, hi)).passed());
    CHECK(verifyPack(pack, WallShape<3>::ofBox({lo, hi})).passed());
    for (const auto& result : {verifyPack(pack, boxMesh(lo, tight)),
                               verifyPack(pack, WallShape<3>::ofBox({lo, tight}))}) {
        CHECK_FALSE(result.passed());
        REQUIRE(result.protrusion);
        CHECK(result.protrusion->spheres == 1);
        CHECK(result.protrusion->max == Approx(0.1));
    }
}

TEST_CASE("a result is shown with ids, positions and a verdict") {
    Pack<3> pack;
    pack.spheres = disjointSpheres<3>(5, 2);
    for (std::size_t i = 0; i < pack.spheres.size(); ++i)
        pack.id.push_back(1000 + static_cast<std::int64_t>(i));
    auto result = verifyPack(pack);
    REQUIRE(result.passed());
    REQUIRE(toJson(result, pack)["protrusion"]["max"].is_null());
    pack.spheres[31].radius = 3.5;
    result = verifyPack(pack);
    result.protrusion =
        checkProtrusion(pack.spheres, WallShape<3>::ofBox({{{0, 0, 0}}, {{10, 10, 10}}}));
    result.ks = 0.5;
    REQUIRE_FALSE(result.passed());
    const auto json = toJson(result, pack);
    REQUIRE(json["passed"] == false);
    REQUIRE(json["spheres"]["count"] == 125);
    REQUIRE(json["overlap"]["pairs"] == result.overlap.pairs);
    const auto& pair = json["overlap"]["worst"][0]["spheres"];
    REQUIRE((pair[0]["id"] == 1031 || pair[1]["id"] == 1031));
    REQUIRE(pair[0]["position"].size() == 3);
    REQUIRE(json["protrusion"]["worst"][0]["id"] == 1031);
    const auto text = describe(result, pack);
    REQUIRE_THAT(text, Contains("FAILED") && Contains("1031 at ("));
    result = verifyPack(Pack<3>{});
    result.ks = 0.02;
    result.ksLimit = 0.01;
    REQUIRE_FALSE(result.passed());
}
