#include "support/generators.h"
#include "support/random_point.h"
#include "support/test.h"
#include "support/triangle_oracle.h"

#include "vdbpack/repair/winding_number.h"

namespace {

/// Solid angles of all triangles, one by one, over 4 pi.
double sumOfAll(const TriangleMesh& mesh, const Vec<3>& x) {
    double sum = 0;
    for (const auto& t : mesh.triangles)
        sum += solidAngle(x, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
    return sum / (4 * kPi);
}

}  // namespace

TEST_CASE("a closed surface winds once around its inside") {
    const Vec<3> center = GENERATE(Vec<3>{{0, 0, 0}}, Vec<3>{{1e4, -1e4, 1e4}});
    const auto mesh = ballMesh(10, 4, center);
    const WindingNumber winding(mesh);
    RandomStream random(3, 1);
    for (int i = 0; i < 2000; ++i) {
        const Vec<3> p = randomPoint(random, 13);
        const double r = length(p);
        if (r < 9.9) CHECK(std::fabs(winding(center + p) - 1) < 0.02);
        if (r > 10) CHECK(std::fabs(winding(center + p)) < 0.02);
    }
}

TEST_CASE("clusters give what their triangles give") {
    // Half a ball, a torus facing inward and a ball that overlaps it.
    auto mesh = merged(ballMesh(10, 3), flipped(torusMesh(8, 3, 40, 20)));
    mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 640);
    const WindingNumber winding(mesh);
    RandomStream random(4, 1);
    double worst = 0;
    for (int i = 0; i < 3000; ++i) {
        const Vec<3> p = randomPoint(random, 16);
        worst = std::max(worst, std::fabs(winding(p) - sumOfAll(mesh, p)));
    }
    CHECK(worst < 0.02);
}

TEST_CASE("in the middle of an opening the winding number is one half") {
    // A cube without its lid, from the middle of the lid.
    auto mesh = boxMesh({{-1, -1, -1}}, {{1, 1, 1}});
    TriangleMesh open;
    open.vertices = mesh.vertices;
    for (const auto& t : mesh.triangles)
        if (!(mesh.vertices[t[0]][2] > 0 && mesh.vertices[t[1]][2] > 0 &&
              mesh.vertices[t[2]][2] > 0))
            open.triangles.push_back(t);
    REQUIRE(open.triangles.size() == 10);
    const WindingNumber winding(open);
    CHECK(winding({{0, 0, 1}}) == Approx(0.5).margin(1e-12));
    CHECK(winding({{0, 0, 0}}) == Approx(5.0 / 6).margin(1e-12));
    CHECK(winding({{0, 0, 1e6}}) == Approx(0).margin(1e-9));
}

TEST_CASE("overlaps count twice and what faces inward is taken off") {
    const auto ball = ballMesh(5, 3), other = ballMesh(5, 3, {{4, 0, 0}});
    CHECK(WindingNumber(merged(ball, other))({{2, 0, 0}}) == Approx(2).margin(0.02));
    CHECK(WindingNumber(merged(ball, flipped(other)))({{2, 0, 0}}) == Approx(0).margin(0.02));
    CHECK(WindingNumber(TriangleMesh{})({{0, 0, 0}}) == 0);
}
