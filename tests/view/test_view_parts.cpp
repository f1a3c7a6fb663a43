// Surfaces, outlines and numbers of a view.
#include "vdbpack/core/rng.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/view/coarse_mesh.h"
#include "vdbpack/view/contour_lines.h"
#include "vdbpack/view/packed_arrays.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <vector>

using namespace vdbpack;

namespace {

/// A sphere of radius `radius` around `center` as triangles between circles of latitude.
TriangleMesh globe(const Vec<3>& center, double radius, int steps) {
    TriangleMesh mesh;
    for (int i = 0; i <= steps; ++i)
        for (int j = 0; j < 2 * steps; ++j) {
            const double a = kPi * i / steps, b = kPi * j / steps;
            mesh.vertices.push_back(center + Vec<3>{{std::sin(a) * std::cos(b),
                                                     std::sin(a) * std::sin(b), std::cos(a)}} *
                                                 radius);
        }
    const auto at = [&](int i, int j) {
        return static_cast<std::uint32_t>(i * 2 * steps + j % (2 * steps));
    };
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < 2 * steps; ++j) {
            mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

}  // namespace

TEST_CASE("a coarse surface has few triangles and stays near the surface", "[view]") {
    const Vec<3> center{{300, -700, 50}};
    const TriangleMesh fine = globe(center, 20, 100);
    const TriangleMesh coarse = coarsened(fine, 3000);
    CHECK(coarse.triangles.size() <= 3000);
    CHECK(coarse.triangles.size() > 1000);
    for (const auto& v : coarse.vertices) REQUIRE(length(v - center) == Approx(20).margin(0.2));
    for (const auto& t : coarse.triangles)
        for (const auto v : t) REQUIRE(v < coarse.vertices.size());
    const TriangleMesh box = boxMesh({{{0, 0, 0}}, {{1, 2, 3}}});
    CHECK(coarsened(box, 12).triangles == box.triangles);
    CHECK(coarsened(box, 12).vertices == box.vertices);
}

TEST_CASE("the outline of a disc is a circle of its length", "[view]") {
    PlaneField field;
    field.columns = field.rows = 200;
    field.step = 0.15;
    field.origin = {{-4, 85}};
    const Vec<2> center{{10.3, 99.8}};
    for (std::int64_t j = 0; j < field.rows; ++j)
        for (std::int64_t i = 0; i < field.columns; ++i)
            field.distance.push_back(static_cast<float>(
                length(field.origin +
                       Vec<2>{{static_cast<double>(i), static_cast<double>(j)}} * field.step -
                       center) -
                9));
    const auto ends = contourLines(field);
    REQUIRE(ends.size() % 2 == 0);
    double total = 0;
    for (std::size_t k = 0; k < ends.size(); k += 2) {
        REQUIRE(length(ends[k] - center) == Approx(9).margin(0.002));
        total += length(ends[k] - ends[k + 1]);
    }
    CHECK(total == Approx(2 * kPi * 9).epsilon(1e-3));
}

TEST_CASE("Morton codes put the bits of three numbers in turns", "[view]") {
    RandomStream random(1, 2);
    for (int n = 0; n < 200; ++n) {
        std::uint32_t x[3];
        for (auto& each : x) each = static_cast<std::uint32_t>(random.bits() & 65535);
        std::uint64_t expected = 0;
        for (int bit = 0; bit < 16; ++bit)
            for (int d = 0; d < 3; ++d) expected |= std::uint64_t{x[d] >> bit & 1} << (3 * bit + d);
        REQUIRE(mortonCode(x[0], x[1], x[2]) == expected);
    }
}

TEST_CASE("quantized values are within half a step, those that are no numbers stand apart",
          "[view]") {
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    const auto q = quantized({1.5, nothing, -3.25, 7, 1e-3}, 1000);
    CHECK(q.numbers[1] == 1001);
    CHECK(q.numbers[2] == 0);
    CHECK(q.numbers[3] == 1000);
    CHECK(q.lo + q.step * static_cast<double>(q.numbers[4]) == Approx(1e-3).margin(q.step / 2));
    CHECK(quantized({2, 2}, 1000).numbers == std::vector<std::uint64_t>{0, 0});
    CHECK(quantized({nothing}, 1000).numbers == std::vector<std::uint64_t>{1001});
    CHECK(planesFor(0) == 1);
    CHECK(planesFor(255) == 1);
    CHECK(planesFor(256) == 2);
    CHECK(planesFor(std::numeric_limits<std::uint64_t>::max()) == 8);
}
