// Triangles of polygons: they cover the polygon once, whatever its shape.
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/mesh/polygon.h"

namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;
using Outline = std::vector<Vec<3>>;

/// Corners from x and y in turn.
Outline flat(const std::vector<double>& numbers) {
    Outline corners;
    for (std::size_t k = 0; k < numbers.size(); k += 2)
        corners.push_back({{numbers[k], numbers[k + 1], 0}});
    return corners;
}

Vec<3> normalOf(const Outline& corners, const std::array<std::uint32_t, 3>& t) {
    return cross(corners[t[1]] - corners[t[0]], corners[t[2]] - corners[t[0]]) * 0.5;
}

/// Of the outline, by its sides.
double outlineArea(const Outline& corners) {
    Vec<3> sum{};
    for (std::size_t k = 0; k < corners.size(); ++k)
        sum += cross(corners[k] - corners[0], corners[(k + 1) % corners.size()] - corners[0]);
    return 0.5 * length(sum);
}

double triangleArea(const Outline& corners, const Triangles& triangles) {
    double area = 0;
    for (const auto& t : triangles) area += length(normalOf(corners, t));
    return area;
}

/// Every side of the outline once, in its direction; every other edge once in each direction.
bool isBoundedByOutline(std::size_t corners, const Triangles& triangles) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    for (const auto& t : triangles)
        for (std::size_t k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
    for (const auto& [edge, count] : uses) {
        const bool isSide = (edge.first + 1) % corners == edge.second;
        if (count != 1 || (!isSide && uses.count({edge.second, edge.first}) == 0)) return false;
    }
    return triangles.size() == corners - 2;
}

/// Turned and moved out of the planes of the axes.
Outline placed(Outline corners) {
    const Vec<3> u = normalized(Vec<3>{{1, 2, -1}}), v = normalized(cross(u, Vec<3>{{0, 1, 3}})),
                 w = cross(u, v);
    for (auto& c : corners) c = Vec<3>{{70, -30, 500}} + u * c[0] + v * c[1] + w * c[2];
    return corners;
}

Outline fromCorner(Outline corners, std::size_t first) {
    std::rotate(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(first),
                corners.end());
    return corners;
}

void requireCovered(const Outline& corners) {
    Triangles triangles;
    REQUIRE(splitPolygon(corners, triangles) != PolygonSplit::crossed);
    REQUIRE(isBoundedByOutline(corners.size(), triangles));
    const double area = outlineArea(corners);
    REQUIRE(triangleArea(corners, triangles) == Approx(area).epsilon(1e-9));
}

}  // namespace

TEST_CASE("concave polygons are covered once, from whichever corner they begin") {
    const std::vector<Outline> outlines{
        flat({0, 0, 50, 0, 50, 20, 20, 20, 20, 60, 0, 60}),
        flat({0, 0, 4, 2, 0, 4, 1, 2}),  // an arrowhead
        // Corners within straight sides.
        flat({0, 0, 2, 0, 5, 0, 5, 1, 2, 1, 2, 2, 2, 6, 0, 6, 0, 1}),
        // A square with a square hole, to which the outline runs and back.
        flat({0, 0, 9, 0, 9, 9, 0, 9, 0, 0, 3, 3, 3, 6, 6, 6, 6, 3, 3, 3})};
    for (const Outline& outline : outlines)
        for (std::size_t first = 0; first < outline.size(); ++first) {
            CAPTURE(outline.size(), first);
            requireCovered(fromCorner(outline, first));
            requireCovered(placed(fromCorner(outline, first)));
            Outline reversed = placed(fromCorner(outline, first));
            std::reverse(reversed.begin(), reversed.end());
            requireCovered(reversed);
        }
}

TEST_CASE("stars, combs and spirals of any number of corners are covered once") {
    const std::uint32_t corners = GENERATE(8u, 100u, 30000u);
    CAPTURE(corners);
    RandomStream random(3, 1);
    Outline star, comb{{{0, -5, 0}}, {{10, -5, 0}}}, spiral;
    const double turns = std::min(20.0, 0.125 * corners);
    for (std::uint32_t k = 0; k < corners; ++k) {
        const double angle = 2 * kPi * k / corners, r = 2 + 8 * random.uniform();
        star.push_back({{r * std::cos(angle), r * std::sin(angle), 0}});
        comb.push_back({{10.0 - 10.0 * k / corners, k % 2 == 0 ? 5.0 : random.uniform(), 0}});
    }
    for (const double side : {1.0, -1.0})
        for (std::uint32_t k = 0; k < corners / 2; ++k) {
            const double at = side > 0 ? k : corners / 2 - 1 - k;
            const double angle = 2 * turns * at / corners, r = 1 + angle + side * 0.5;
            spiral.push_back({{r * std::cos(angle), r * std::sin(angle), 0}});
        }
    requireCovered(placed(star));
    requireCovered(placed(comb));
    requireCovered(placed(spiral));
}

TEST_CASE("convex and nearly plane polygons stay fans from their first corner") {
    Outline ring;
    for (int k = 0; k < 50; ++k) {
        const double angle = 2 * kPi * k / 50;
        ring.push_back({{std::cos(angle), std::sin(angle), 0.01 * std::cos(2 * angle)}});
    }
    Triangles triangles;
    for (std::size_t first = 0; first < ring.size(); ++first) {
        REQUIRE(splitPolygon(placed(fromCorner(ring, first)), triangles) == PolygonSplit::fan);
        REQUIRE(triangles.size() == 48);
        for (std::uint32_t k = 0; k < 48; ++k)
            REQUIRE(triangles[k] == std::array<std::uint32_t, 3>{0, k + 1, k + 2});
    }
}

TEST_CASE("outlines that cross themselves are named, those without area are not") {
    Triangles triangles;
    const Outline bowTie{{{0, 0, 0}}, {{2, 2, 0}}, {{2, 0, 0}}, {{0, 2, 0}}};
    const Outline loop{{{0, 0, 0}}, {{4, 4, 0}}, {{4, 0, 0}}, {{0, 3, 0}}, {{-2, 2, 0}}};
    const Outline line{{{0, 0, 0}}, {{1, 1, 1}}, {{3, 3, 3}}, {{2, 2, 2}}};
    for (const Outline& outline : {bowTie, loop, placed(bowTie)}) {
        CHECK(splitPolygon(outline, triangles) == PolygonSplit::crossed);
        CHECK(isBoundedByOutline(outline.size(), triangles));
    }
    CHECK(splitPolygon(line, triangles) == PolygonSplit::fan);
    CHECK(splitPolygon({{}, {}, {}, {}}, triangles) == PolygonSplit::fan);
    CHECK(isBoundedByOutline(4, triangles));
}
