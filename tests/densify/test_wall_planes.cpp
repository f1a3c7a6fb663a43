// The planes that hold a sphere in tell the wall's distance as exactly as the wall itself does.
#include "support/generators.h"
#include "support/random_point.h"
#include "support/test.h"

#include "vdbpack/densify/wall_planes.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/inset_domain.h"
#include "vdbpack/domain/mesh_domain.h"

namespace {

constexpr double kQuantum = 1.0 / (1 << 22);

template <int Dim>
Home homeOf(const Vec<Dim>& x) {
    Home home{};
    for (int d = 0; d < Dim; ++d) home[static_cast<std::size_t>(d)] = std::llround(x[d] / kQuantum);
    return home;
}

template <int Dim>
Body bodyAt(const Vec<Dim>& x, double radius) {
    const Home home = homeOf(x);
    return {lowBits(home[0]), lowBits(home[1]), lowBits(home[2]),
            static_cast<float>(radius / kQuantum)};
}

/// Asks at random places inside, goes a share `slide` of the radius from there, and compares.
/// @param curved  whether the wall is, so that planes are right to second order only.
template <int Dim>
void requirePlanesOf(const Domain<Dim>& domain, double radius, double slide, bool curved) {
    WallPlanes<Dim> walls(domain, kQuantum);
    walls.setSlide(static_cast<float>(slide));
    RandomStream random(7, 8);
    const auto sampler = domain.sampler();
    const float margin = static_cast<float>(0.1 * radius / kQuantum);
    const double tolerance = (curved ? 2 * slide * slide : 0) * radius + 1e-5 * radius;
    int asked = 0;
    for (int k = 0; k < 20000 && asked < 500; ++k) {
        const Vec<Dim> x = randomPoint(random, domain.bounds());
        WallPoint<Dim> wall;
        if (!sampler->contains(x) || !sampler->nearestWall(x, 1.2 * radius, wall) ||
            wall.distance < 0.8 * radius)
            continue;
        ++asked;
        typename WallPlanes<Dim>::Vicinity vicinity;
        const Body body = bodyAt(x, radius);
        walls.ask(homeOf(x), body, margin, vicinity);
        REQUIRE(vicinity.wall != WallPlanes<Dim>::kNone);
        REQUIRE_FALSE(walls.isDue(body, vicinity, margin));
        Vec<Dim> to = x;
        for (int d = 0; d < Dim; ++d)
            to[d] += slide * radius * (2 * random.uniform() - 1) / std::sqrt(Dim);
        double least = std::numeric_limits<double>::infinity();
        for (const WallPlane& plane : walls[vicinity.wall])
            least =
                std::min(least, static_cast<double>(plane.distance(bodyAt(to, radius))) * kQuantum);
        REQUIRE(sampler->nearestWall(to, 2 * radius, wall));
        if (wall.distance < 1.1 * radius) CHECK(std::abs(least - wall.distance) < tolerance);
        REQUIRE_FALSE(walls.isDue(bodyAt(to, radius), vicinity, margin));
        Vec<Dim> far = x;
        far[0] += 1.01 * slide * radius;
        REQUIRE(walls.isDue(bodyAt(far, radius), vicinity, margin));
    }
    REQUIRE(asked > 50);
}

}  // namespace

TEST_CASE("planes hold a sphere in beside edges and corners") {
    const double slide = GENERATE(0.05, 0.3);
    const auto box = boxDomain<3>({{{-3, -4, -5}}, {{3, 4, 5}}});
    requirePlanesOf<3>(*box, 1, slide, false);
    const auto cut = clippedDomain<3>(
        box, {{{{1, 0.5, -0.3}}, 1.0}, {{{-0.2, -1, 0.4}}, 1.5}, {{{0.3, -0.4, 2}}, 2.0}});
    requirePlanesOf<3>(*cut, 1, slide, false);
    requirePlanesOf<3>(*insetDomain(*box, 0.25), 1, slide, false);
    const auto plate = boxDomain<3>({{{-3, -4, -1.1}}, {{3, 4, 1.1}}});
    requirePlanesOf<3>(*plate, 1, slide, false);
    const auto rect = boxDomain<2>({{{-3, -4}}, {{3, 4}}});
    requirePlanesOf<2>(*rect, 1, slide, false);
}

TEST_CASE("planes follow curved walls to second order") {
    const double slide = GENERATE(0.05, 0.3);
    requirePlanesOf<3>(*ballDomain<3>(4), 1, slide, true);
    requirePlanesOf<3>(*cylinderDomain(4, 6), 1, slide, true);
    requirePlanesOf<2>(*ballDomain<2>(4), 1, slide, true);
}

TEST_CASE("planes of a mesh are those of its triangles") {
    const double slide = GENERATE(0.05, 0.3);
    FieldOptions field;
    field.voxelSize = 0.3;
    field.depth = 3;
    const auto box = meshDomain(boxMesh({{-3, -4, -5}}, {{3, 4, 5}}), field);
    requirePlanesOf<3>(*box, 1, slide, false);
    const auto ball = meshDomain(ballMesh(4, 4), field);
    requirePlanesOf<3>(*ball, 1, slide, true);
}

TEST_CASE("a sphere outside is led back to the nearest wall") {
    const auto box = boxDomain<3>({{{-3, -4, -5}}, {{3, 4, 5}}});
    WallPlanes<3> walls(*box, kQuantum);
    typename WallPlanes<3>::Vicinity vicinity;
    const Vec<3> x{{3.5, 0, 0}};
    walls.ask(homeOf(x), bodyAt(x, 1.0), 0, vicinity);
    REQUIRE(vicinity.wall != WallPlanes<3>::kNone);
    REQUIRE(walls[vicinity.wall].count == 1);
    const WallPlane& plane = *walls[vicinity.wall].begin();
    CHECK(plane.nx == Approx(-1));
    CHECK(static_cast<double>(plane.distance(bodyAt(x, 1.0))) * kQuantum == Approx(-0.5));
}
