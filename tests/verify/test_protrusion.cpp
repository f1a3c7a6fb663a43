#include "measure/packs.h"
#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/verify/verify.h"
#include "vdbpack/verify/wall_tree.h"

namespace {

double protrusionOf(const Sphere<3>& s, const TriangleMesh& mesh) {
    return checkProtrusion({s}, mesh).max;
}

/// The mesh check and the formula agree about every sphere, one by one.
void requireAgreement(const std::vector<Sphere<3>>& spheres, const TriangleMesh& mesh,
                      const WallShape<3>& shape, double tolerance) {
    for (const auto& s : spheres) {
        const double formula = std::max(0.0, (s.radius - shape.innerDistance(s.center)) / s.radius);
        CAPTURE(s.center.c, s.radius);
        REQUIRE(protrusionOf(s, mesh) == Approx(formula).margin(tolerance));
    }
}

std::vector<WallPiece<3>> piecesOf(const TriangleMesh& mesh) {
    std::vector<WallPiece<3>> pieces;
    for (const auto& t : mesh.triangles)
        pieces.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
    return pieces;
}

/// Distance to a triangle by search: it is convex in s, and on the segment that s picks out the
/// nearest point is found directly.
double searchedDistance(const Vec<3>& x, const WallPiece<3>& t) {
    const auto onSegment = [&](double s) {
        const Vec<3> from = t[0] + s * (t[1] - t[0]), along = (1 - s) * (t[2] - t[0]);
        const double ee = squaredLength(along);
        const double at = ee > 0 ? std::clamp(dot(x - from, along) / ee, 0.0, 1.0) : 0;
        return length(x - from - at * along);
    };
    double lo = 0, hi = 1;
    for (int k = 0; k < 200; ++k) {
        const double a = lo + (hi - lo) / 3, b = hi - (hi - lo) / 3;
        (onSegment(a) < onSegment(b) ? hi : lo) = onSegment(a) < onSegment(b) ? b : a;
    }
    return std::min({onSegment(lo), onSegment(0), onSegment(1)});
}

}  // namespace

TEST_CASE("the distance to a triangle is that of a search over its points") {
    RandomStream random(5, 5);
    const auto point = [&](double scale) {
        return Vec<3>{{(random.uniform() - 0.5) * scale, (random.uniform() - 0.5) * scale,
                       (random.uniform() - 0.5) * scale}};
    };
    for (int k = 0; k < 300; ++k) {
        WallPiece<3> t{point(2), point(2), point(2)};
        if (k % 5 == 1) t[2] = t[0] + (t[1] - t[0]) * random.uniform();  // a line
        if (k % 5 == 2) t[2] = t[1];                                     // an edge twice
        if (k % 5 == 3) t[2] = t[1] + point(1e-9);                       // a needle
        if (k % 50 == 4) t[1] = t[2] = t[0];                             // a point
        const Vec<3> x = point(4);
        CAPTURE(k, t[0].c, t[1].c, t[2].c, x.c);
        REQUIRE(std::sqrt(squaredDistanceToPiece(x, t)) ==
                Approx(searchedDistance(x, t)).margin(1e-6));
    }
}

TEST_CASE("the tree finds the nearest of all triangles") {
    // Of long triangles it makes boxes along axes of their own; all of a ball are as near to its
    // center; those of a plane side lie in discs without height.
    const int shape = GENERATE(0, 1, 2, 3);
    const auto mesh =
        shape == 0   ? torusMesh(8, 3, 40, 20)
        : shape == 1 ? rotated(doubleConeMesh(10, 8, 3000), {{1, 2, 3}}, 0.7)
        : shape == 2
            ? ballMesh(14, 4)
            : rotated(subdivided(subdivided(subdivided(boxMesh({{-9, -8, -7}}, {{9, 8, 7}})))),
                      {{3, 1, 2}}, 0.4);
    const auto pieces = piecesOf(translated(mesh, {{700, -300, 55}}));
    const WallTree<3> tree(pieces);
    for (const auto& s : randomSpheres<3>(300, 30, 1, 1, 4)) {
        const Vec<3> x = s.center + Vec<3>{{700, -300, 55}};
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& t : pieces) nearest = std::min(nearest, squaredDistanceToPiece(x, t));
        REQUIRE(tree.squaredDistance(x, std::numeric_limits<double>::infinity()) == nearest);
        REQUIRE(tree.squaredDistance(x, nearest / 2) == nearest / 2);
    }
}

TEST_CASE("points searched for together find what each finds alone") {
    const bool isLong = GENERATE(false, true);
    const auto pieces = piecesOf(isLong ? doubleConeMesh(10, 8, 3000) : torusMesh(8, 3, 40, 20));
    const WallTree<3> tree(pieces);
    const auto spheres = randomSpheres<3>(400, 30, 1, 1, 6);
    auto nearest = WallTree<3>::noPieces();
    for (std::size_t k = 0; k < spheres.size(); k += 4) {
        WallTree<3>::Points points;
        WallTree<3>::Squares bounds;
        for (std::size_t l = 0; l < 4; ++l) {
            points[l] = spheres[k + l].center;
            bounds[l] = l == 1 ? 0.01 : std::numeric_limits<double>::infinity();
        }
        const auto found = tree.squaredDistances(points, bounds, nearest);
        for (std::size_t l = 0; l < 4; ++l) {
            REQUIRE(found[l] == tree.squaredDistance(points[l], bounds[l]));
            if (found[l] < bounds[l])
                REQUIRE(squaredDistanceToPiece(points[l], tree.pieces()[nearest[l]]) == found[l]);
        }
    }
}

TEST_CASE("a check gives the distance of every center to the nearest triangle") {
    const auto mesh = torusMesh(8, 3, 40, 20);
    const auto pieces = piecesOf(mesh);
    // Near the wall and far from it, inside and outside; not a multiple of a block.
    const auto spheres = randomSpheres<3>(601, 40, 0.1, 2, 7);
    std::vector<double> distances;
    const auto check = checkProtrusion(spheres, mesh, {}, &distances);
    REQUIRE(distances.size() == spheres.size());
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& t : pieces)
            nearest = std::min(nearest, squaredDistanceToPiece(spheres[i].center, t));
        REQUIRE(distances[i] == std::sqrt(nearest));
    }
    const auto alone = checkProtrusion(spheres, mesh);
    REQUIRE(alone.spheres == check.spheres);
    REQUIRE(alone.centersOutside == check.centersOutside);
    REQUIRE(alone.max == check.max);
}

TEST_CASE("protrusion through a box of triangles is that of the formula") {
    const Vec<3> lo{{-4, -3, -2}}, hi{{4, 3, 2}};
    auto spheres = randomSpheres<3>(400, 11, 0.3, 5, 8);
    const WallShape<3> shape = WallShape<3>::ofBox({lo, hi});
    SECTION("of twelve triangles") {
        requireAgreement(spheres, boxMesh(lo, hi), shape, 1e-12);
    }
    SECTION("cut finer, facing inward") {
        requireAgreement(spheres, flipped(subdivided(subdivided(boxMesh(lo, hi)))), shape, 1e-12);
    }
    SECTION("turned and moved with the spheres") {
        const Vec<3> axis{{1, 2, -0.5}}, by{{1000, -730, 20}};
        const auto mesh = translated(rotated(subdivided(boxMesh(lo, hi)), axis, 0.7), by);
        for (const auto& s : spheres) {
            TriangleMesh point;
            point.vertices = {s.center};
            const Vec<3> moved = rotated(point, axis, 0.7).vertices[0] + by;
            const double formula =
                std::max(0.0, (s.radius - shape.innerDistance(s.center)) / s.radius);
            REQUIRE(protrusionOf({moved, s.radius}, mesh) == Approx(formula).margin(1e-10));
        }
    }
    SECTION("with centers on planes, edges and corners of the lattice") {
        // Lines through vertices and along edges: the parity rule decides, not luck.
        std::vector<Sphere<3>> onLattice;
        for (int x = -5; x <= 5; ++x)
            for (int y = -4; y <= 4; ++y)
                for (int z = -3; z <= 3; ++z)
                    onLattice.push_back(
                        {{{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}},
                         0.75});
        requireAgreement(onLattice, subdivided(subdivided(boxMesh(lo, hi))), shape, 1e-12);
    }
}

TEST_CASE("protrusion through a ball of triangles nears that of the formula") {
    const Vec<3> center{{3, -20, 100}};
    const auto spheres = [&] {
        auto s = randomSpheres<3>(40, 24, 0.5, 4, 11);
        for (auto& x : s) x.center += center;
        return s;
    }();
    const auto shape = WallShape<3>::ofBall(10, center);
    // The facets of level 5 lie up to 0.005 mm inside the sphere, the smallest radius is 0.5 mm.
    requireAgreement(spheres, ballMesh(10, 5, center), shape, 0.02);
    requireAgreement(spheres, uvBallMesh(10, 120, 160, center), shape, 0.02);
}

TEST_CASE("a nested shell is a cavity whichever way it faces") {
    const bool inward = GENERATE(true, false);
    CAPTURE(inward);
    auto mesh = hollowBallMesh(10, 5, 4, inward);
    REQUIRE(protrusionOf({{{7.5, 0, 0}}, 2.4}, mesh) == 0);
    REQUIRE(protrusionOf({{{0, 0, 0}}, 1.0}, mesh) == Approx(6).margin(0.05));
    REQUIRE(protrusionOf({{{0, 6, 0}}, 1.5}, mesh) == Approx(1.0 / 3).margin(0.02));
    // An island in the cavity is solid again.
    mesh = merged(mesh, ballMesh(2, 3));
    REQUIRE(protrusionOf({{{0, 0, 0}}, 1.0}, mesh) == 0);
    REQUIRE(protrusionOf({{{0, 3.5, 0}}, 0.5}, mesh) > 1);
}

TEST_CASE("a pack in a box passes, a disturbed sphere is named") {
    auto spheres = disjointSpheres<3>(12, 4);
    const auto mesh = boxMesh({{0, 0, 0}}, {{24, 24, 24}});
    const auto check = checkProtrusion(spheres, mesh);
    REQUIRE(check.closed);
    REQUIRE(check.spheres == 0);
    spheres[0].center[0] = 0.7 * spheres[0].radius;
    spheres[700].center[2] = 1e6;
    const auto failed = checkProtrusion(spheres, mesh);
    REQUIRE(failed.spheres == 2);
    REQUIRE(failed.centersOutside == 1);
    REQUIRE(failed.worst.size() == 2);
    REQUIRE(failed.worst[0].i == 700);
    REQUIRE(failed.worst[1].i == 0);
    REQUIRE(failed.worst[1].protrusion == Approx(0.3));
    const auto cut = checkProtrusion(disjointSpheres<3>(12, 4), mesh, {{{{0, 0, 2}}, 44}});
    REQUIRE(cut.spheres == 144);
}

TEST_CASE("a pack in the wrong place is wholly outside") {
    auto spheres = disjointSpheres<3>(20, 4);
    for (auto& s : spheres) s.center *= 1000;
    const auto check = checkProtrusion(spheres, ballMesh(1, 4));
    REQUIRE(check.spheres == spheres.size());
    REQUIRE(check.centersOutside == spheres.size());
    REQUIRE(check.worst.size() == kWorstNamed);
}

TEST_CASE("a hole in the wall is outvoted") {
    auto mesh = ballMesh(10, 4);
    // Away goes a cap about +z.
    auto& t = mesh.triangles;
    t.erase(std::remove_if(t.begin(), t.end(),
                           [&](const auto& tri) { return mesh.vertices[tri[0]][2] > 9; }),
            t.end());
    const std::vector<Sphere<3>> spheres{
        {{{0.1, 0.2, 0.3}}, 2}, {{{5, 2, -3}}, 2}, {{{0.1, 0.2, 12}}, 1}, {{{0.1, 0.2, -12}}, 1}};
    const auto check = checkProtrusion(spheres, mesh);
    REQUIRE_FALSE(check.closed);
    REQUIRE(check.spheres == 2);
    REQUIRE(std::max(check.worst[0].i, check.worst[1].i) == 3);
    REQUIRE(std::min(check.worst[0].i, check.worst[1].i) == 2);
}

TEST_CASE("edges of four triangles keep the wall closed, degenerate ones do no harm") {
    // Two boxes that share an edge, and triangles without area.
    auto mesh = merged(boxMesh({{0, 0, 0}}, {{2, 2, 2}}), boxMesh({{2, 2, 0}}, {{4, 4, 2}}));
    mesh.triangles.push_back({0, 1, 1});
    mesh.triangles.push_back({3, 3, 3});
    const auto check = checkProtrusion(
        {{{{1, 1, 1}}, 0.9}, {{{3, 3, 1}}, 0.9}, {{{1, 3, 1}}, 0.5}, {{{3, 1, 1}}, 0.5}}, mesh);
    REQUIRE(check.closed);
    REQUIRE(check.spheres == 2);
    REQUIRE(check.max == Approx(3));
}

TEST_CASE("unusable meshes are refused") {
    TriangleMesh mesh;
    REQUIRE_THROWS_AS(checkProtrusion({}, mesh), InputError);
    mesh = boxMesh({{0, 0, 0}}, {{1, 1, 1}});
    mesh.triangles[3][1] = 8;
    REQUIRE_THROWS_WITH(checkProtrusion({}, mesh), Contains("triangle 3") && Contains("vertex 8"));
    mesh = boxMesh({{0, 0, 0}}, {{1, 1, 1}});
    mesh.vertices[2][1] = std::numeric_limits<double>::quiet_NaN();
    REQUIRE_THROWS_AS(checkProtrusion({}, mesh), InputError);
    REQUIRE_THROWS_AS(checkProtrusion(std::vector<Sphere<2>>{}, std::vector<WallPiece<2>>{}),
                      InputError);
    WallShape<3> shape = WallShape<3>::ofBall(1);
    shape.clips = {{{{0, 0, 0}}, 1}};
    REQUIRE_THROWS_AS(checkProtrusion(std::vector<Sphere<3>>{}, shape), ParameterError);
}

TEST_CASE("a flat or very coarse and very fine wall keeps its answers") {
    // A needle of a box 1000 long among thousands of small triangles.
    const auto mesh = merged(rotated(boxMesh({{-500, -1, -1}}, {{500, 1, 1}}), {{1, 1, 1}}, 0.6),
                             translated(ballMesh(3, 5), {{0, 0, 40}}));
    TriangleMesh axis;
    axis.vertices = {{{430, 0, 0}}};
    const Vec<3> inNeedle = rotated(axis, {{1, 1, 1}}, 0.6).vertices[0];
    REQUIRE(protrusionOf({inNeedle, 0.99}, mesh) == 0);
    REQUIRE(protrusionOf({inNeedle, 1.25}, mesh) == Approx(0.2));
    REQUIRE(protrusionOf({{{0, 0, 40}}, 2.9}, mesh) == 0);
    REQUIRE(protrusionOf({{{0, 0, 50}}, 1}, mesh) > 1);
}

TEST_CASE("formulas of shapes give distances inside and outside") {
    const auto box = WallShape<2>::ofBox({{{0, 0}}, {{4, 2}}});
    REQUIRE(box.innerDistance({{1, 1.5}}) == Approx(0.5));
    REQUIRE(box.innerDistance({{-3, -4}}) == Approx(-5));
    const auto disc = WallShape<2>::ofBall(3, {{1, 1}});
    REQUIRE(disc.innerDistance({{1, 2}}) == Approx(2));
    REQUIRE(disc.innerDistance({{1, 6}}) == Approx(-2));
    auto can = WallShape<3>::ofCylinder(5, 8);
    REQUIRE(can.innerDistance({{3, 0, 0}}) == Approx(2));
    REQUIRE(can.innerDistance({{0, 0, -3}}) == Approx(1));
    REQUIRE(can.innerDistance({{8, 0, 8}}) == Approx(-5));
    can.clips = {{{{3, 0, 4}}, 10}};
    REQUIRE(can.innerDistance({{0, 0, 0}}) == Approx(2));
    REQUIRE(can.innerDistance({{0, 0, 3.5}}) == Approx(-0.8));
    const auto check =
        checkProtrusion<3>({{{{0, 0, 0}}, 2}, {{{0, 0, 0}}, 2.5}, {{{-3, 0, 0}}, 1}}, can);
    REQUIRE(check.spheres == 1);
    REQUIRE(check.max == Approx(0.2));
}

TEST_CASE("circles against a slice: segments, shape and mesh agree") {
    const double height = 3;
    const auto ball = hollowBallMesh(10, 5, 5);
    const auto segments = sliceSegments(ball, height);
    const auto outer = sliceShape(WallShape<3>::ofBall(10), height);
    const auto inner = sliceShape(WallShape<3>::ofBall(5), height);
    REQUIRE(outer->radius == Approx(std::sqrt(91.0)));
    REQUIRE(inner->radius == Approx(4));
    for (const auto& c : randomSpheres<2>(400, 24, 0.4, 3, 6)) {
        const double d = std::min(outer->innerDistance(c.center), -inner->innerDistance(c.center));
        const double formula = std::max(0.0, (c.radius - d) / c.radius);
        const auto check = checkProtrusion({c}, segments);
        REQUIRE(check.closed);
        REQUIRE(check.max == Approx(formula).margin(0.03));
    }
    REQUIRE_FALSE(sliceShape(WallShape<3>::ofBall(10), 10.5));
    REQUIRE(sliceShape(WallShape<3>::ofCylinder(2, 6), 2.9)->radius == 2);
    REQUIRE(sliceSegments(ball, 11).empty());
    // The plane through the vertices of a box: once, closed.
    const auto box = subdivided(boxMesh({{-1, -1, -1}}, {{1, 1, 1}}));
    const auto middle =
        checkProtrusion(std::vector<Sphere<2>>{{{}, 0.9}, {{{2, 0}}, 0.5}}, sliceSegments(box, 0));
    REQUIRE(middle.closed);
    REQUIRE(middle.spheres == 1);
    REQUIRE(middle.max == Approx(3));
}
