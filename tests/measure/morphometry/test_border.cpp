// What the border of the total volume does to morphometry.
#include "measure/morphometry/voxel_images.h"
#include "support/test.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/label_voxels.h"
#include "vdbpack/measure/morphometry/border.h"
#include "vdbpack/measure/morphometry/euler.h"
#include "vdbpack/measure/morphometry/morphometry.h"

namespace {

constexpr double kPeriod = 12;

/// A cubic lattice of round struts, 12 apart and 4 thick: two independent loops a cell.
double struts(const Vec<3>& x) {
    Vec<3> p;
    for (int i = 0; i < 3; ++i) p[i] = x[i] - kPeriod * std::round(x[i] / kPeriod);
    return std::min({std::hypot(p[0], p[1]), std::hypot(p[1], p[2]), std::hypot(p[0], p[2])}) - 2;
}

/// Plates 12 apart and 4 thick, with struts between them.
double platesAndRods(const Vec<3>& x) {
    const double z = x[2] - kPeriod * std::round(x[2] / kPeriod);
    return std::min(std::abs(z) - 2, struts(x));
}

double insideBall(const Vec<3>& x, double radius) {
    return length(x) - radius;
}

double insideBox(const Vec<3>& x, double half) {
    return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])}) - half;
}

}  // namespace

TEST_CASE("pores end at the wall where the solid ends") {
    // A body of plates and rods with air around it, as a bone with open pores has.
    const bool ball = GENERATE(true, false);
    CAPTURE(ball);
    const double half = 20;
    const auto domain = ball ? ballDomain<3>(half)
                             : boxDomain<3>(Box<3>{{{-half, -half, -half}}, {{half, half, half}}});
    const auto body = [&](const Vec<3>& x) {
        return std::max(platesAndRods(x + Vec<3>{{3, 5, 4}}),
                        ball ? insideBall(x, half) : insideBox(x, half));
    };
    double separation = 0, density = 0;
    for (const std::int64_t edge : {48, 80}) {
        CAPTURE(edge);
        auto image = voxelImage(edge, 1.0, body);
        labelVoxels(image, *domain, 0, true);
        const auto m = measureMorphometry(image);
        REQUIRE(m.walled);
        CHECK(m.totalVolume == within(domain->volume(), 0.01));
        // Plates leave gaps of 8; nothing of the air counts.
        CHECK(m.separation.value().max < 1.05 * 8);
        CHECK(m.separation->mean < 8);
        CHECK(m.border.poresNearWall.value() > 0.05);
        CHECK(m.border.poresNearWall.value() < 0.5);
        CHECK(m.deltaEuler == m.eulerNumber);
        if (separation > 0) {
            CHECK(m.separation->mean == Approx(separation).epsilon(1e-3));
            CHECK(m.connectivityDensity == Approx(density));
        }
        separation = m.separation->mean;
        density = m.connectivityDensity;
    }
}

TEST_CASE("a pore wider than the domain counts as wide as the domain at most") {
    // One bead in a corner: balls in the opposite corner meet nothing else.
    const auto bead = [](const Vec<3>& x) { return length(x - Vec<3>{{9, 9, 9}}) - 3; };
    SECTION("a box cut from a sample") {
        const auto m = measureMorphometry(voxelImage(24, 1.0, bead));
        CHECK(m.separation.value().max <= 24);
    }
    SECTION("below a wall") {
        auto image = voxelImage(40, 1.0, bead);
        labelVoxels(image, *ballDomain<3>(16), 0, true);
        const auto m = measureMorphometry(image);
        CHECK(m.separation.value().max < 32.5);
        // A ball of half the domain's radius fits anywhere beside the bead.
        CHECK(m.separation->max > 16);
    }
}

TEST_CASE("a part of a lattice has the connectivity density of the lattice") {
    // Two loops a cell, whatever the shape and wherever it cuts; less what chance cuts add.
    const bool ball = GENERATE(true, false);
    CAPTURE(ball);
    const double half = 42;
    const auto domain = ball ? ballDomain<3>(half)
                             : boxDomain<3>(Box<3>{{{-half, -half, -half}}, {{half, half, half}}});
    const auto shifted = [](const Vec<3>& x) { return struts(x + Vec<3>{{1.3, 2.9, 4.1}}); };
    auto image = voxelImage(96, 1.0, shifted);
    labelVoxels(image, *domain, 0);
    const auto m = measureMorphometry(image);
    const double cells = m.totalVolume / (kPeriod * kPeriod * kPeriod);
    CHECK(m.border.continued > 0.6);
    CHECK(-m.deltaEuler / cells == Approx(2).epsilon(0.06));
    // Counted as a body that ends there, it lacks the loops that the cut opened.
    CHECK(m.eulerNumber > 0.93 * m.deltaEuler);
    CHECK_FALSE(m.border.poresNearWall);
}

TEST_CASE("regions are measured as the whole is, and add up to it") {
    // Thin plates across x in the shell, thick ones across z in the core.
    const double half = 30, shell = 12;
    const Slabs thin{{{1, 0, 0}}, 3, 6, 0.4}, thick{{{0, 0, 1}}, 6, 12, 0.7};
    auto image = voxelImage(72, 1.0, [&](const Vec<3>& x) {
        const bool core = length(x) < half - shell;
        return core ? thick(x) : thin(x);
    });
    labelVoxels(image, *ballDomain<3>(half), shell, true);
    const auto m = measureMorphometry(image);
    REQUIRE(m.regions.size() == 2);
    const auto& outer = m.regions[0];
    const auto& inner = m.regions[1];
    CHECK(std::abs(outer.anisotropy.value().axes[2][0]) > 0.95);
    CHECK(std::abs(inner.anisotropy.value().axes[2][2]) > 0.95);
    CHECK(inner.voxelAnisotropy.value().degree > outer.voxelAnisotropy.value().degree / 2);
    CHECK(inner.thickness.value().mean > 1.4 * outer.thickness.value().mean);
    CHECK(inner.number.value() == Approx(inner.solidFraction / inner.thickness->mean));
    CHECK(outer.solidSurface + inner.solidSurface == within(m.solidSurface, 1e-9));
    CHECK(outer.solidVolume + inner.solidVolume == within(m.solidVolume, 1e-9));
    CHECK(outer.deltaEuler + inner.deltaEuler == Approx(m.deltaEuler).margin(1e-9));
    CHECK(inner.connectivityDensity == Approx((1 - inner.deltaEuler) / inner.totalVolume));
}

TEST_CASE("voxels beyond the wall count for nothing") {
    // Where wall and solid are one surface, a voxel more or less is chance.
    auto image = voxelImage(40, 1.0, [](const Vec<3>& x) { return std::abs(length(x) - 12) - 4; });
    labelVoxels(image, *ballDomain<3>(16), 0, true);
    const auto before = measureMorphometry(image);
    REQUIRE(before.eulerNumber == 2);
    REQUIRE(before.deltaEuler == 2);
    RandomStream random(4, 1);
    for (std::size_t i = 0; i < image.voxels(); ++i)
        if (image.label[i] == 0 && image.distance[i] < 1 && random.uniform() < 0.3)
            image.distance[i] = -0.01f;
    const auto after = measureMorphometry(image);
    CHECK(after.deltaEuler == 2);
    CHECK(after.solidVolume == before.solidVolume);
    CHECK(after.border.continued < 0.2);
}

TEST_CASE("shares of the border are those of its faces") {
    // Half of a cube is solid, up to and beyond the border of the inner cube.
    auto image = voxelImage(
        16, 1.0, [](const Vec<3>& x) { return x[2]; }, 4);
    const BorderShares inner = borderShares(image);
    // One of the faces across z, and half of the four others.
    CHECK(inner.solid == Approx(0.5));
    CHECK(inner.continued == 1);
    image.label.clear();
    CHECK(borderShares(image).solid == Approx(0.5));
    CHECK(borderShares(image).continued == 0);
    CHECK_FALSE(inner.poresNearWall);
}
