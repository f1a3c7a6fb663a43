#include "support/generators.h"
#include "support/test.h"
#include "voids/stamping.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/voids/cull.h"
#include "vdbpack/voids/thinning.h"

namespace {

/// Spheres anywhere in a box, overlapping or not, radii uniform in [least, most].
template <int Dim>
std::vector<Sphere<Dim>> anySpheres(std::size_t count, double half, double least, double most,
                                    std::uint64_t seed) {
    RandomStream random(seed, 100 + Dim);
    std::vector<Sphere<Dim>> spheres(count);
    for (auto& s : spheres) {
        s.center = randomPoint(random, cube<Dim>(2 * half));
        s.radius = least + (most - least) * random.uniform();
    }
    return spheres;
}

std::size_t removed(const std::vector<std::uint8_t>& keep) {
    return static_cast<std::size_t>(std::count(keep.begin(), keep.end(), 0));
}

/// Two of three spheres may be removed.
std::vector<std::int32_t> someCandidates(std::size_t count) {
    std::vector<std::int32_t> candidates(count);
    for (std::size_t i = 0; i < count; ++i) candidates[i] = i % 3 != 0;
    return candidates;
}

}  // namespace

DIM_TEST_CASE("culling by lookup agrees with the ellipsoids themselves") {
    const auto domain = boxDomain<Dim>(cube<Dim>(20));
    const auto voids = anyVoids<Dim>(Dim == 3 ? 100 : 25, cube<Dim>(22), 0.8, 2, 0.5, 3, 21);
    const double h = GENERATE(0.1, 0.2);
    const auto spheres = anySpheres<Dim>(20000, 10, 0.1, 0.8, 22);
    auto options = stampOptions(*domain, h);
    options.reach = 0.8 + 2 * h;
    const auto stamped = stampVoids(voids, *domain, options);
    const auto center = spheresOutside(spheres, *stamped, Cull::center);
    const auto touch = spheresOutside(spheres, *stamped, Cull::touch);
    std::size_t byCenter = 0, byTouch = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const double d = distancesTo(voids, spheres[i].center)[0];
        CAPTURE(Dim, h, i, d, spheres[i].radius);
        bool within = false;
        for (const auto& e : voids) within = within || e.contains(spheres[i].center);
        if (std::fabs(d) > 0.5 * h) {
            ++byCenter;
            REQUIRE((center[i] == 0) == within);
        }
        if (std::fabs(d - spheres[i].radius) > 0.5 * h) {
            ++byTouch;
            REQUIRE((touch[i] == 0) == (d < spheres[i].radius));
        }
        // What stays reaches into voids by half a voxel at the most.
        if (touch[i]) REQUIRE(d > spheres[i].radius - 0.5 * h);
        if (touch[i]) REQUIRE(center[i]);
    }
    CHECK(byCenter > 15000);
    CHECK(byTouch > 15000);
    CHECK(removed(center) > 1000);
    CHECK(removed(center) < removed(touch));
    // Twice is once.
    std::vector<Sphere<Dim>> left;
    for (std::size_t i = 0; i < spheres.size(); ++i)
        if (touch[i]) left.push_back(spheres[i]);
    CHECK(removed(spheresOutside(left, *stamped, Cull::touch)) == 0);
    CHECK(withThreads(3, [&] { return spheresOutside(spheres, *stamped, Cull::touch); }) == touch);
    // Centers next to a surface, too, once the ellipsoids are asked.
    const auto candidates = someCandidates(spheres.size());
    const auto exact = centersOutside(spheres, voids, *stamped, candidates);
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        bool within = false;
        for (const auto& e : voids) within = within || e.contains(spheres[i].center);
        REQUIRE((exact[i] == 0) == (within && candidates[i] != 0));
    }
}

DIM_TEST_CASE("deeper than the shell, spheres that meet a void are removed") {
    const double h = 0.1, shell = 1.5;
    const auto domain = ballDomain<Dim>(10);
    const auto voids = anyVoids<Dim>(Dim == 3 ? 100 : 25, cube<Dim>(18), 0.8, 2, 0.5, 3, 23);
    const auto spheres = anySpheres<Dim>(20000, 7, 0.1, 0.6, 24);
    auto options = stampOptions(*domain, h, shell);
    options.reach = 0.6 + 2 * h;
    const auto stamped = stampVoids(voids, *domain, options);
    const auto center = spheresOutside(spheres, *stamped, Cull::center);
    const auto touch = spheresOutside(spheres, *stamped, Cull::touch);
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const double toVoid = distancesTo(voids, spheres[i].center)[0];
        const double toCore = length(spheres[i].center) - (10 - shell);
        CAPTURE(Dim, i, toVoid, toCore, spheres[i].radius);
        const double d = std::max(toVoid, toCore);
        if (std::fabs(d) > 0.5 * h) REQUIRE((center[i] == 0) == (d < 0));
        // At the edge of a void that the shell cuts off the distance is farther than both.
        if (touch[i]) REQUIRE(d > spheres[i].radius - 0.5 * h);
        if (!touch[i]) REQUIRE(toVoid < spheres[i].radius + 0.5 * h);
        if (!touch[i]) REQUIRE(toCore < spheres[i].radius + 0.5 * h);
    }
}

DIM_TEST_CASE("depth below a shell is decided by the distance to the wall") {
    const double shell = 1.5;
    const auto check = [&](const Domain<Dim>& domain) {
        CAPTURE(domain.facts().kind, domain.facts().voxelSize);
        const auto spheres = anySpheres<Dim>(20000, 6.5, 0.1, 0.2, 25);
        const auto deep = deeperThan(spheres, domain, shell);
        const auto sampler = domain.sampler();
        std::size_t deeper = 0;
        for (std::size_t i = 0; i < spheres.size(); ++i) {
            WallPoint<Dim> wall;
            const bool expected = sampler->contains(spheres[i].center) &&
                                  !sampler->nearestWall(spheres[i].center, shell, wall);
            CAPTURE(spheres[i].center.c);
            REQUIRE(deep[i] == static_cast<std::int32_t>(expected));
            deeper += deep[i] != 0;
        }
        CHECK(deeper > 1000);
        CHECK(deeperThan(spheres, domain, 0) == std::vector<std::int32_t>(spheres.size(), 1));
    };
    check(*boxDomain<Dim>(cube<Dim>(12)));
    check(*ballDomain<Dim>(6));
    FieldOptions options;
    options.voxelSize = 0.5;
    options.depth = 1.1 * shell;
    const auto mesh = meshDomain(ballMesh(6, 4), options);
    if constexpr (Dim == 3) {
        check(*mesh);
        check(*clippedDomain<3>(mesh, {{{{1, 0.3, -0.2}}, 2}}));
    } else {
        check(*sliceDomain(mesh, 0.7));
    }
}

DIM_TEST_CASE("threshold takes the share D of uniform radii, the largest ones") {
    const double fraction = GENERATE(0.15, 0.3, 0.5, 0.8, 1.0);
    CAPTURE(Dim, fraction);
    const auto spheres = anySpheres<Dim>(30000, 10, 1, 2, 31);
    const auto candidates = someCandidates(spheres.size());
    const auto keep = removeLargest(spheres, candidates, fraction);
    const double n = 20000;
    CHECK(static_cast<double>(removed(keep)) / n ==
          Approx(fraction).margin(4 * std::sqrt(fraction * (1 - fraction) / n) + 1.5 / n));
    double largestLeft = 0, smallestGone = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        if (!candidates[i]) REQUIRE(keep[i] == 1);
        if (!candidates[i]) continue;
        if (keep[i]) largestLeft = std::max(largestLeft, spheres[i].radius);
        if (!keep[i]) smallestGone = std::min(smallestGone, spheres[i].radius);
    }
    CHECK(largestLeft < smallestGone);
    CHECK(smallestGone == Approx(2 - fraction).margin(1e-3));
}

DIM_TEST_CASE("concentric stops within one hole of the share D") {
    const double fraction = GENERATE(0.15, 0.3, 0.5, 0.9);
    const auto seed = GENERATE(1u, 2u, 3u);
    CAPTURE(Dim, fraction, seed);
    // As dense as a pack.
    const double half = Dim == 3 ? 24 : 120;
    const auto spheres = anySpheres<Dim>(6000, half, 1, 2, 32);
    const auto candidates = someCandidates(spheres.size());
    const auto keep = removeAround(spheres, candidates, fraction, seed);
    const double n = 4000, gone = static_cast<double>(removed(keep));
    // The most that one hole takes.
    double most = 0;
    for (std::size_t i = 0; i < spheres.size(); i += 7) {
        double taken = 0;
        for (std::size_t j = 0; j < spheres.size(); ++j)
            taken += candidates[j] && length(spheres[j].center - spheres[i].center) <
                                          2 / fraction + spheres[j].radius;
        most = std::max(most, taken);
    }
    CHECK(gone >= fraction * n);
    CHECK(gone < fraction * n + 1.2 * most);
    CHECK((1.2 * most < 0.5 * n || fraction < 0.2));
    for (std::size_t i = 0; i < spheres.size(); ++i)
        if (!candidates[i]) REQUIRE(keep[i] == 1);
    // Every one that is gone lies in a ball about another one that is gone or is its center.
    for (std::size_t i = 0; i < spheres.size(); i += 5) {
        if (keep[i]) continue;
        bool held = false;
        for (std::size_t j = 0; j < spheres.size() && !held; ++j)
            held = !keep[j] &&
                   length(spheres[j].center - spheres[i].center) < 2 / fraction + spheres[i].radius;
        REQUIRE(held);
    }
    CHECK(removeAround(spheres, candidates, fraction, seed) == keep);
    CHECK(removeAround(spheres, candidates, fraction, seed + 10) != keep);
}

DIM_TEST_CASE("holes of equal spheres have the radius R / D") {
    // One in a row of points a millimeter apart: the hole takes all within R / D + R.
    std::vector<Sphere<Dim>> spheres(401);
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        spheres[i].center[Dim - 1] = static_cast<double>(i);
        spheres[i].radius = 0.4;
    }
    const std::vector<std::int32_t> all(spheres.size(), 1);
    const double fraction = 0.02;  // 0.4 / 0.02 = 20 mm on either side
    const auto keep = removeAround(spheres, all, fraction, 5);
    const std::size_t gone = removed(keep);
    CHECK(gone >= 21);
    CHECK(gone <= 41);
    const auto first = std::find(keep.begin(), keep.end(), 0) - keep.begin();
    CHECK(std::all_of(keep.begin() + first, keep.begin() + first + static_cast<long>(gone),
                      [](std::uint8_t k) { return k == 0; }));
}

DIM_TEST_CASE("thinning refuses a fraction out of range and accepts no candidates") {
    const auto spheres = anySpheres<Dim>(100, 5, 1, 2, 33);
    const std::vector<std::int32_t> all(spheres.size(), 1), none(spheres.size(), 0);
    for (const double fraction : {0.0, -0.5, 1.5, std::nan("")}) {
        CAPTURE(fraction);
        CHECK_THROWS_AS(removeLargest(spheres, all, fraction), ParameterError);
        CHECK_THROWS_AS(removeAround(spheres, all, fraction, 1), ParameterError);
    }
    CHECK(removed(removeLargest(spheres, none, 0.5)) == 0);
    CHECK(removed(removeAround(spheres, none, 0.5, 1)) == 0);
    CHECK(removed(removeAround(spheres, all, 1, 1)) == spheres.size());
    CHECK(removeLargest<Dim>({}, {}, 0.5).empty());
    CHECK(removeAround<Dim>({}, {}, 0.5, 1).empty());
}

DIM_TEST_CASE("kept spheres keep their attributes") {
    Pack<Dim> pack;
    pack.spheres = anySpheres<Dim>(1000, 10, 1, 2, 41);
    Column name{"name", {}, {}}, material{"material", {}, {}};
    std::vector<std::uint8_t> keep;
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        pack.id.push_back(static_cast<std::int64_t>(7 * i + 3));
        pack.order.push_back(static_cast<std::int64_t>(999 - i));
        pack.depth.push_back(static_cast<float>(i) / 8);
        name.texts.push_back("s" + std::to_string(i));
        material.numbers.push_back(static_cast<double>(i % 5));
        keep.push_back(i % 7 == 2 || i % 11 == 0);
        if (keep.back()) left.push_back(i);
    }
    pack.columns = {name, material};
    const auto before = pack;
    keepOnly(pack, keep);
    REQUIRE(pack.spheres.size() == left.size());
    REQUIRE(pack.id.size() == left.size());
    CHECK(pack.region.empty());
    CHECK(pack.contacts.empty());
    for (std::size_t n = 0; n < left.size(); ++n) {
        const std::size_t i = left[n];
        REQUIRE(pack.spheres[n].center == before.spheres[i].center);
        REQUIRE(pack.spheres[n].radius == before.spheres[i].radius);
        REQUIRE(pack.id[n] == before.id[i]);
        REQUIRE(pack.order[n] == before.order[i]);
        REQUIRE(pack.depth[n] == before.depth[i]);
        REQUIRE(pack.columns[0].texts[n] == name.texts[i]);
        REQUIRE(pack.columns[1].numbers[n] == material.numbers[i]);
    }
    keepOnly(pack, std::vector<std::uint8_t>(left.size(), 0));
    CHECK(pack.spheres.empty());
    CHECK(pack.columns[0].texts.empty());
}

DIM_TEST_CASE("attached spheres are those that a flood from the shell reaches") {
    const auto seed = GENERATE(51u, 52u, 53u);
    // So thin that sets of many sizes form.
    const auto spheres = anySpheres<Dim>(1500, Dim == 3 ? 13 : 38, 0.5, 1, seed);
    const double tolerance = 0.05;
    const std::size_t n = spheres.size();
    std::vector<std::int32_t> region(n, 1);
    for (std::size_t i = 0; i < n; ++i) region[i] = i % 60 != 0;
    std::vector<std::vector<std::size_t>> near(n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            if (gap(spheres[i], spheres[j]) <
                tolerance * std::min(spheres[i].radius, spheres[j].radius)) {
                near[i].push_back(j);
                near[j].push_back(i);
            }
    const auto flood = [&](std::vector<std::size_t> stack) {
        std::vector<std::uint8_t> reached(n);
        for (const std::size_t i : stack) reached[i] = 1;
        while (!stack.empty()) {
            const std::size_t i = stack.back();
            stack.pop_back();
            for (const std::size_t j : near[i])
                if (!reached[j]) {
                    reached[j] = 1;
                    stack.push_back(j);
                }
        }
        return reached;
    };
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < n; ++i)
        if (region[i] == 0) roots.push_back(i);
    const auto expected = flood(roots);
    CHECK(removed(expected) > 100);
    CHECK(removed(expected) < n - roots.size());
    CHECK(attachedSpheres(spheres, region, tolerance) == expected);
    std::size_t largest = 0;
    for (std::size_t i = 0; i < n; ++i) largest = std::max(largest, n - removed(flood({i})));
    const auto ofLargest = attachedSpheres(spheres, {}, tolerance);
    CHECK(n - removed(ofLargest) == largest);
    const auto any = static_cast<std::size_t>(std::find(ofLargest.begin(), ofLargest.end(), 1) -
                                              ofLargest.begin());
    CHECK(flood({any}) == ofLargest);
    CHECK(attachedSpheres<Dim>({}, {}, tolerance).empty());
    // A shell that nothing reaches.
    CHECK(removed(attachedSpheres(spheres, std::vector<std::int32_t>(n, 1), tolerance)) == n);
}

TEST_CASE("a small cluster of the shell that touches nothing else is not attached") {
    std::vector<Sphere<3>> spheres;
    for (int i = 0; i < 3000; ++i) spheres.push_back({{{2.0 * i, 0, 0}}, 1});
    spheres.push_back({{{0, 10, 0}}, 1});
    spheres.push_back({{{2, 10, 0}}, 1});
    for (int i = 0; i < 4; ++i) spheres.push_back({{{2.0 * i, 20, 0}}, 1});
    std::vector<std::int32_t> region(spheres.size(), 1);
    region[0] = region[3000] = region[3002] = 0;
    const auto attached = attachedSpheres(spheres, region, 0.001);
    CHECK(attached[2999] == 1);
    CHECK(attached[3000] == 0);  // 2 of 3000
    CHECK(attached[3005] == 1);  // 4 of 3000
}

DIM_TEST_CASE("balls that remove spheres reach across the faces of a periodic cell") {
    PeriodicCell<Dim> cell{cube<Dim>(40), {}};
    cell.wraps.fill(true);
    // Pairs that touch across a face, far from all others.
    std::vector<Sphere<Dim>> spheres;
    for (const double y : {-15.0, -5.0, 5.0, 15.0}) {
        Sphere<Dim> low;
        low.center[0] = -19.75;
        low.center[1] = y;
        low.radius = 0.5;
        Sphere<Dim> high = low;
        high.center[0] = 19.25;
        spheres.push_back(low);
        spheres.push_back(high);
    }
    const std::vector<std::int32_t> all(spheres.size(), 1);
    const auto seed = GENERATE(range(1u, 6u));
    const auto keep = removeAround(spheres, all, 0.25, seed, cell);
    CHECK(std::count(keep.begin(), keep.end(), 0) == 2);
    for (std::size_t i = 0; i < keep.size(); i += 2) CHECK(keep[i] == keep[i + 1]);
    // Without the cell, one of a pair stays.
    const auto alone = removeAround(spheres, all, 0.25, seed);
    CHECK(std::count(alone.begin(), alone.end(), 0) == 2);
    const auto attached = attachedSpheres(spheres, {}, 1e-6, cell);
    CHECK(std::count(attached.begin(), attached.end(), 1) == 2);
    CHECK(attachedSpheres(spheres, {}, 1e-6) != attached);
}
