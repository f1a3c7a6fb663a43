#include "support/generators.h"
#include "support/random_point.h"
#include "support/test.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/mesh_domain.h"

#include <tbb/global_control.h>

namespace {

FieldOptions options(double voxelSize, double depth = 2) {
    FieldOptions o;
    o.voxelSize = voxelSize;
    o.depth = depth;
    o.detail = voxelSize;
    o.name = "bone";
    return o;
}

/// Largest and mean difference of two domains' signed distances where neither is clamped.
struct Errors {
    double largest = 0, mean = 0;
};

Errors compare(const Domain<3>& domain, const Domain<3>& exact, double outside) {
    RandomStream random(11, 1);
    const auto a = domain.sampler(), b = exact.sampler();
    Errors errors;
    int count = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec<3> x = randomPoint(random, exact.bounds().grown(outside));
        const double expected = b->signedDistance(x);
        if (expected < -0.9 * domain.fieldDepth() || expected > outside) continue;
        const double error = std::abs(a->signedDistance(x) - expected);
        errors.largest = std::max(errors.largest, error);
        errors.mean += error;
        ++count;
    }
    errors.mean /= count;
    return errors;
}

std::vector<std::string> warningsOf(const TriangleMesh& mesh, const FieldOptions& o) {
    std::vector<std::string> warnings;
    Callbacks callbacks;
    callbacks.warning = [&](const std::string& text) { warnings.push_back(text); };
    meshDomain(mesh, o, callbacks);
    return warnings;
}

TriangleMesh withoutTriangle(TriangleMesh mesh, std::size_t index) {
    mesh.triangles.erase(mesh.triangles.begin() + static_cast<long>(index));
    return mesh;
}

}  // namespace

TEST_CASE("the field of a ball or box is right within a voxel, better in smaller voxels") {
    const Box<3> box{{{-4, -5, -6}}, {{5, 4, 3}}};
    const bool ball = GENERATE(true, false);
    const auto mesh = ball ? ballMesh(6, 5) : boxMesh(box.lo, box.hi);
    const auto exact = ball ? ballDomain<3>(6) : boxDomain<3>(box);
    Errors coarser{1e9, 1e9};
    for (const double voxelSize : {1.0, 0.5, 0.25}) {
        CAPTURE(ball, voxelSize);
        const auto domain = meshDomain(mesh, options(voxelSize));
        REQUIRE(domain->fieldDepth() >= 2);
        const Errors errors = compare(*domain, *exact, 2 * voxelSize);
        REQUIRE(errors.largest < voxelSize);
        REQUIRE(errors.mean < 0.7 * coarser.mean);
        REQUIRE(domain->volume() == Approx(exact->volume()).epsilon(0.003));
        REQUIRE(domain->wallArea() == Approx(exact->wallArea()).epsilon(0.003));
        for (const double depth : {0.5, 1.0, 2.0})
            REQUIRE(domain->volumeDeeperThan(depth) ==
                    Approx(exact->volumeDeeperThan(depth)).epsilon(0.1 * voxelSize * voxelSize));
        coarser = errors;
    }
}

TEST_CASE("the nearest wall of a mesh is exact however coarse the field") {
    const Box<3> box{{{-4, -5, -6}}, {{5, 4, 3}}};
    FieldOptions coarse = options(1.3);
    coarse.fieldFirst = GENERATE(false, true);
    const auto domain = meshDomain(boxMesh(box.lo, box.hi), coarse);
    const auto exact = boxDomain<3>(box);
    const auto a = domain->sampler(), b = exact->sampler();
    RandomStream random(8, 8);
    for (int i = 0; i < 5000; ++i) {
        const Vec<3> x = randomPoint(random, box.grown(2));
        const double reach = 4 * random.uniform();
        WallPoint<3> found, expected;
        const bool any = b->nearestWall(x, reach, expected);
        REQUIRE(a->nearestWall(x, reach, found) == any);
        if (!any) continue;
        REQUIRE(std::abs(found.distance - expected.distance) < 1e-12);
        REQUIRE(length(found.point - x) == Approx(found.distance).margin(1e-12));
        REQUIRE(std::abs(b->signedDistance(found.point)) < 1e-12);
    }
}

TEST_CASE("a cavity stays empty whichever way its triangles face") {
    const bool inward = GENERATE(true, false);
    const bool outerFlipped = GENERATE(true, false);
    auto outer = ballMesh(10, 5);
    if (outerFlipped) outer = flipped(outer);
    auto cavity = ballMesh(5, 5);
    if (inward) cavity = flipped(cavity);
    const auto domain = meshDomain(merged(outer, cavity), options(0.4, 4));
    REQUIRE(domain->volume() == Approx(3665).epsilon(0.01));
    REQUIRE(domain->volumeDeeperThan(1) ==
            Approx(4.0 / 3 * kPi * (9.0 * 9 * 9 - 6 * 6 * 6)).epsilon(0.01));
    const auto asker = domain->sampler();
    REQUIRE(asker->signedDistance({{0, 0, 0}}) > 0);
    REQUIRE(asker->signedDistance({{4.5, 0, 0}}) == Approx(0.5).margin(0.05));
    REQUIRE(asker->signedDistance({{0, 7, 0}}) == Approx(-2).margin(0.05));
    // On the ridge between two walls the field rounds off, to the safe side.
    REQUIRE(asker->signedDistance({{0, 0, -7.5}}) == Approx(-2.5).margin(0.2));
    REQUIRE(asker->signedDistance({{0, 11, 0}}) > 0);
    const auto slice = sliceDomain(domain, 3);
    REQUIRE(slice->volume() == Approx(kPi * (91 - 16)).epsilon(0.01));
    // A cavity off the middle moves the centroid away from it.
    const Vec<3> to{{2, 1, -1}};
    const auto uneven = meshDomain(merged(outer, translated(cavity, to)), options(0.4, 4));
    REQUIRE(length(*uneven->centroid() + to * (1.0 / 7)) < 0.01);
    const auto half = clippedDomain<3>(domain, {{{{0, 0, -1}}, 0}});
    REQUIRE((*half->centroid())[2] == Approx(3.0 / 8 * (1e4 - 625) / (1e3 - 125)).epsilon(0.01));
    const auto disc = sliceDomain(uneven, -1);
    REQUIRE(length(*disc->centroid() + Vec<2>{{2, 1}} * (25.0 / 74)) < 0.01);
}

TEST_CASE("shells nest to any depth") {
    TriangleMesh mesh;
    double volume = 0;
    for (int i = 0; i < 5; ++i) {
        const double radius = 10 - 2 * i;
        mesh = merged(mesh, ballMesh(radius, 4));
        volume += (i % 2 == 0 ? 1 : -1) * Measure<3>::ball(radius);
    }
    const auto domain = meshDomain(mesh, options(0.3, 1));
    REQUIRE(domain->volume() == Approx(volume).epsilon(0.01));
    REQUIRE(domain->volumeDeeperThan(1e-9) == Approx(domain->volume()).epsilon(0.01));
    const auto asker = domain->sampler();
    for (int i = 0; i < 5; ++i)
        REQUIRE((asker->signedDistance({{9.0 - 2 * i, 0, 0}}) < 0) == (i % 2 == 0));
}

TEST_CASE("pieces side by side are one domain") {
    const auto mesh = merged(ballMesh(4, 4), ballMesh(3, 4, {{9, 0, 0}}));
    const auto domain = meshDomain(mesh, options(0.3));
    REQUIRE(domain->volume() == Approx(Measure<3>::ball(4) + Measure<3>::ball(3)).epsilon(0.01));
    REQUIRE((*domain->centroid())[0] == Approx(9 * 27.0 / (27 + 64)).epsilon(1e-3));
    REQUIRE(domain->sampler()->signedDistance({{9, 0, 0}}) < 0);
    REQUIRE(domain->sampler()->signedDistance({{5, 0, 0}}) > 0);
}

TEST_CASE("a bone far from the origin or in another place on the lattice is the same bone") {
    const auto mesh = ballMesh(5, 4);
    const auto home = meshDomain(mesh, options(0.4));
    const Vec<3> shift{{1e4 + 1.0 / 3, -7e3, 123.456}};
    const auto away = meshDomain(translated(mesh, shift), options(0.4));
    REQUIRE(away->volume() == Approx(home->volume()).epsilon(1e-9));
    REQUIRE(length(*away->centroid() - *home->centroid() - shift) < 1e-9);
    REQUIRE(away->volumeDeeperThan(1) == Approx(home->volumeDeeperThan(1)).epsilon(1e-4));
    const auto a = home->sampler(), b = away->sampler();
    RandomStream random(2, 2);
    for (int i = 0; i < 2000; ++i) {
        const Vec<3> x = randomPoint(random, home->bounds().grown(1));
        REQUIRE(std::abs(b->signedDistance(x + shift) - a->signedDistance(x)) < 1e-4);
        WallPoint<3> near, far;
        REQUIRE(a->nearestWall(x, 20, near));
        REQUIRE(b->nearestWall(x + shift, 20, far));
        REQUIRE(std::abs(near.distance - far.distance) < 1e-10);
    }
}

TEST_CASE("a wall thinner than a voxel is still inside where it is") {
    // A plate of 20 x 20 x 0.3 in voxels of 0.5, then as one may ask.
    const auto mesh = boxMesh({{0, 0, 0}}, {{20, 20, 0.3}});
    const auto domain = meshDomain(mesh, options(0, 0.5));
    REQUIRE(domain->volume() == Approx(120));
    const auto asker = domain->sampler();
    RandomStream random(4, 2);
    for (int i = 0; i < 500; ++i) {
        const Vec<3> x{{1 + 18 * random.uniform(), 1 + 18 * random.uniform(), 0.15}};
        REQUIRE(asker->signedDistance(x) < 0);
        WallPoint<3> wall;
        REQUIRE(asker->nearestWall(x, 1, wall));
        REQUIRE(wall.distance == Approx(0.15).epsilon(1e-12));
    }
    REQUIRE(asker->signedDistance({{10, 10, 1.5}}) > 0);
    REQUIRE(asker->signedDistance({{10, 10, -1.2}}) > 0);
}

TEST_CASE("meshes without an inside are refused with a reason") {
    REQUIRE_THROWS_WITH(meshDomain(TriangleMesh(), options(0.5)), Contains("bone"));
    TriangleMesh one;
    one.vertices = {{{0, 0, 0}}, {{10, 0, 0}}, {{0, 10, 0}}};
    one.triangles = {{0, 1, 2}};
    REQUIRE_THROWS_AS(meshDomain(one, options(0.5)), InputError);
    REQUIRE_THROWS_WITH(meshDomain(one, options(0.5)), Contains("3 boundary edges"));
    auto flat = one;
    flat.triangles = {{0, 1, 1}};
    REQUIRE_THROWS_AS(meshDomain(flat, options(0.5)), InputError);
    auto wrong = one;
    wrong.triangles = {{0, 1, 7}};
    REQUIRE_THROWS_WITH(meshDomain(wrong, options(0.5)),
                        Contains("triangle 0") && Contains("vertex 7"));
    auto infinite = ballMesh(5, 1);
    infinite.vertices[3][1] = std::numeric_limits<double>::infinity();
    REQUIRE_THROWS_WITH(meshDomain(infinite, options(0.5)), Contains("vertex 3"));
    const auto ball = ballMesh(5, 2);
    REQUIRE_THROWS_AS(meshDomain(ball, options(-1)), ParameterError);
    REQUIRE_THROWS_AS(meshDomain(ball, options(1, std::nan(""))), ParameterError);
    REQUIRE_THROWS_AS(meshDomain(ball, options(3e-5)), ResourceError);
    REQUIRE_THROWS_WITH(meshDomain(ball, options(1e-5)), Contains("smaller than a field"));
}

TEST_CASE("loose triangles are refused before anything is made of them, thin ones too") {
    const double width = GENERATE(1.0, 1e-4);
    RandomStream random(5, 2);
    const auto point = [&](double size) {
        return Vec<3>{{size * (random.uniform() - 0.5), size * (random.uniform() - 0.5),
                       size * (random.uniform() - 0.5)}};
    };
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < 3000; i += 3) {
        const Vec<3> at = point(100), along = point(100);
        for (const Vec<3>& v : {at, at + along, at + along * 0.5 + point(width)})
            mesh.vertices.push_back(v);
        mesh.triangles.push_back({i, i + 1, i + 2});
    }
    std::size_t reports = 0;
    Callbacks callbacks;
    callbacks.progress = [&](const Progress&) { ++reports; };
    const std::string message =
        messageOf<InputError>([&] { meshDomain(mesh, options(0), callbacks); });
    CHECK_THAT(message, Contains("bone") && Contains("not closed") && Contains("3000"));
    CHECK(reports == 0);
}

TEST_CASE("a hole wider than a voxel is refused and named") {
    const auto mesh = withoutTriangle(ballMesh(10, 3), 100);
    REQUIRE_THROWS_AS(meshDomain(mesh, options(0.3)), InputError);
    REQUIRE_THROWS_WITH(meshDomain(mesh, options(0.3)), Contains("3 boundary edges") &&
                                                            Contains("first at vertex") &&
                                                            Contains("mm³"));
}

TEST_CASE("a hole much smaller than a voxel is a warning") {
    const auto mesh = withoutTriangle(ballMesh(10, 6), 1234);
    const auto warnings = warningsOf(mesh, options(1.0));
    REQUIRE(warnings.size() == 1);
    REQUIRE_THAT(warnings[0], Contains("3 boundary edges") && Contains("first at vertex"));
    REQUIRE(warningsOf(ballMesh(10, 3), options(1.0)).empty());
    const auto domain = meshDomain(mesh, options(1.0));
    REQUIRE(domain->volume() == Approx(Measure<3>::ball(10)).epsilon(0.01));
    REQUIRE(domain->facts().boundaryEdges == 3);
}

TEST_CASE("a coarse mesh with more open edges than triangles, but no gap, is a warning") {
    // A vertex in the middle of a side that only one of its triangles has: three open edges each.
    auto mesh = boxMesh({{-5, -5, -5}}, {{5, 5, 5}});
    for (const std::size_t i : {0u, 2u, 4u, 6u, 8u, 10u}) {
        const auto t = mesh.triangles[i];
        const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back((mesh.vertices[t[0]] + mesh.vertices[t[1]]) * 0.5);
        mesh.triangles[i] = {t[0], middle, t[2]};
        mesh.triangles.push_back({middle, t[1], t[2]});
    }
    REQUIRE(warningsOf(mesh, options(0.5)).size() == 1);
    REQUIRE(meshDomain(mesh, options(0.5))->volume() == Approx(1000).epsilon(0.01));
}

TEST_CASE("overlapping pieces are refused with both volumes") {
    const auto mesh = merged(ballMesh(5, 4), ballMesh(5, 4, {{6, 0, 0}}));
    REQUIRE_THROWS_AS(meshDomain(mesh, options(0.3)), InputError);
    REQUIRE_THROWS_WITH(meshDomain(mesh, options(0.3)), Contains("mm³"));
}

TEST_CASE("voxels too coarse for a sound mesh are what a message names, with a size that works") {
    TriangleMesh cubes;  // 0.02 mm apart
    for (int i = 0; i < 27; ++i) {
        const Vec<3> lo{{0.22 * (i % 3), 0.22 * (i / 3 % 3), 0.22 * (i / 9)}};
        cubes = merged(cubes, boxMesh(lo, lo + Vec<3>{{0.2, 0.2, 0.2}}));
    }
    const auto [mesh, voxel, volume, cause] =
        GENERATE_COPY(table<TriangleMesh, double, double, std::string>(
            {{boxMesh({{-2, -2, -50}}, {{2, 2, 50}}), 30, 1600, "about 2 mm thick"},
             {boxMesh({{0, 0, 0}}, {{30, 0.1, 0.1}}), 0.2, 0.3, "walls are about 0.06"},
             {cubes, 0.1, 27 * 0.008, "gaps of about 0.0"},
             {hollowBallMesh(1, 0.98, 5), 0.08, 0.246, "walls are about 0.01"}}));
    const std::string message =
        messageOf<InputError>([&, m = mesh, v = voxel] { meshDomain(m, options(v)); });
    CHECK_THAT(message, Contains("bone") && Contains(cause) && Contains("`voxelSize`") &&
                            !Contains("intersect") && !Contains("overlap") && !Contains("repair"));
    const auto at = message.rfind("to ");
    const double fine = std::stod(message.substr(at + 3));
    CHECK(meshDomain(mesh, options(fine, 0.01))->volume() == Approx(volume).epsilon(0.001));
    // As many of them as are affordable are taken unless a size was asked for.
    FieldOptions chosen = options(0, 0.01);
    chosen.detail = voxel;
    CHECK_NOTHROW(meshDomain(mesh, chosen));
}

TEST_CASE("a single surface that intersects itself is named as such") {
    auto mesh = ballMesh(5, 4);
    for (Vec<3>& v : mesh.vertices) v[0] -= 8 * std::max(0.0, v[0] - 2);
    CHECK_THAT(messageOf<InputError>([&] { meshDomain(mesh, options(0)); }),
               Contains("the surface intersects itself") && Contains("`repair`"));
}

TEST_CASE("a surface given twice is named as such") {
    auto mesh = ballMesh(5, 3);
    const bool inward = GENERATE(false, true);
    const auto once = inward ? flipped(mesh).triangles : mesh.triangles;
    mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());
    bool begun = false;
    Callbacks callbacks;
    callbacks.progress = [&](const Progress&) { begun = true; };
    CHECK_THAT(messageOf<InputError>([&] { meshDomain(mesh, options(0.3), callbacks); }),
               Contains("1280 of its 2560") && Contains("`repair`") && !Contains("intersects"));
    // Two layers that cancel are refused before a field is made.
    CHECK(begun == !inward);
}

TEST_CASE("copies of triangles do not count twice") {
    auto mesh = ballMesh(6, 4);
    for (std::size_t i = 0; i < 60; i += 3) mesh.triangles.push_back(mesh.triangles[i]);
    const auto domain = meshDomain(mesh, options(0.4));
    REQUIRE(domain->volume() == Approx(Measure<3>::ball(6)).epsilon(0.01));
    REQUIRE(warningsOf(mesh, options(0.4)).size() == 1);
}

TEST_CASE("voxels by default fit detail, bone and memory") {
    const auto ball = ballMesh(10, 4);
    REQUIRE(defaultVoxelSize(ball, 0.3) == Approx(0.33));
    REQUIRE(defaultVoxelSize(ball, 0) < 1);
    REQUIRE(defaultVoxelSize(ball, 100) < 1);
    const double smallest = defaultVoxelSize(ball, 1e-9);
    REQUIRE(9 * 4 * kPi * 100 / (smallest * smallest) < 5e7);
    REQUIRE(defaultVoxelSize(scaled(ball, 1000), 300) == Approx(330));
}

TEST_CASE("a field is the same for any number of threads") {
    const auto mesh = torusMesh(8, 3, 60, 30);
    const auto build = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return meshDomain(mesh, options(0.3));
    };
    const auto one = build(1), many = build(8);
    REQUIRE(one->volumeDeeperThan(0.7) == many->volumeDeeperThan(0.7));
    const auto a = one->sampler();
    RandomStream random(6, 9);
    std::vector<Vec<3>> points;
    for (int i = 0; i < 50000; ++i) points.push_back(randomPoint(random, one->bounds().grown(1)));
    const auto batch = many->signedDistances(points);
    for (std::size_t i = 0; i < points.size(); ++i)
        REQUIRE(a->signedDistance(points[i]) == batch[i]);
}

TEST_CASE("a slice of a mesh is the outline of its triangles") {
    const Vec<3> center{{700, -30, 5}};
    const auto domain = meshDomain(ballMesh(10, 5, center), options(0.4));
    const double height = GENERATE(5.0, 8.0, -3.0, 14.0);
    CAPTURE(height);
    const double radius = std::sqrt(100 - (height - 5) * (height - 5));
    const auto slice = sliceDomain(domain, height);
    const auto disc = ballDomain<2>(radius, {{700, -30}});
    REQUIRE(slice->facts().kind == "slice");
    REQUIRE(slice->volume() == Approx(disc->volume()).epsilon(0.01));
    REQUIRE(slice->wallArea() == Approx(disc->wallArea()).epsilon(0.01));
    REQUIRE(slice->volumeDeeperThan(1) == Approx(disc->volumeDeeperThan(1)).epsilon(0.02));
    const auto a = slice->sampler(), b = disc->sampler();
    RandomStream random(1, 5);
    for (int i = 0; i < 2000; ++i) {
        const Vec<2> x{{700 + 24 * (random.uniform() - 0.5), -30 + 24 * (random.uniform() - 0.5)}};
        const double expected = b->signedDistance(x);
        if (std::abs(expected) < 1) {
            REQUIRE(std::abs(a->signedDistance(x) - expected) < 0.05);
            WallPoint<2> wall;
            REQUIRE(a->nearestWall(x, 2, wall));
            REQUIRE(wall.distance == Approx(std::abs(expected)).margin(0.03));
        } else {
            REQUIRE((a->signedDistance(x) < 0) == (expected < 0));
        }
    }
}

TEST_CASE("vertices exactly on the slice's plane do no harm") {
    // The equator of this ball is a ring of vertices, the box has faces and edges in the plane.
    const auto ball = meshDomain(uvBallMesh(10, 16, 32), options(0.4));
    REQUIRE(sliceDomain(ball, 0)->volume() == Approx(16 * 100 * std::sin(kPi / 16)).epsilon(1e-6));
    const auto box = meshDomain(boxMesh({{0, 0, 0}}, {{3, 4, 5}}), options(0.2));
    REQUIRE(sliceDomain(box, 5)->volume() == Approx(12));
    REQUIRE(sliceDomain(box, 2.5)->volume() == Approx(12));
    REQUIRE(sliceDomain(box, 2.5)->wallArea() == Approx(14));
    REQUIRE_THROWS_AS(sliceDomain(box, 0), InputError);
    REQUIRE_THROWS_WITH(sliceDomain(box, 6), Contains("0 to 5"));
}

TEST_CASE("a clipped mesh has the volume of its half") {
    const auto ball = meshDomain(ballMesh(10, 5), options(0.4));
    const auto half = clippedDomain<3>(ball, {{{{0, 0, 1}}, 2}});
    const double expected = kPi * 144 * (10 - 4);
    REQUIRE(half->volume() == Approx(expected).epsilon(0.005));
    REQUIRE(half->wallArea() == Approx(2 * kPi * 10 * 12 + kPi * 96).epsilon(0.03));
    const auto asker = half->sampler();
    REQUIRE(asker->signedDistance({{0, 0, 1.5}}) == Approx(-0.5));
    REQUIRE(asker->signedDistance({{0, 0, 2.5}}) > 0);
    WallPoint<3> wall;
    REQUIRE(asker->nearestWall({{1, 1, 1.5}}, 1, wall));
    REQUIRE(wall.point == Vec<3>{{1, 1, 2}});
    REQUIRE(sliceDomain(half, 1)->volume() == Approx(kPi * 99).epsilon(0.01));
    REQUIRE_THROWS_AS(sliceDomain(half, 3), InputError);
}
