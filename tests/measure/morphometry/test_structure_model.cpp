// Structure model index, and the curvature that it is from.
#include "measure/morphometry/voxel_images.h"
#include "support/test.h"

#include "vdbpack/measure/morphometry/curvature.h"
#include "vdbpack/measure/morphometry/morphometry.h"

#include <cstddef>

namespace {

/// Along z (0) or anywhere.
Vec<3> direction(int i) {
    RandomStream random(31, static_cast<std::uint64_t>(i));
    const Vec<3> any = randomDirection(random);
    return i == 0 ? Vec<3>{{0, 0, 1}} : any;
}

/// In the total volume, voxels.
double integral(const VoxelImage &image) {
    const auto byLabel = curvatureIntegrals(image);
    double sum = 0;
    for (std::size_t label = 1; label < byLabel.size(); ++label) sum += byLabel[label];
    return sum;
}

double smi(const VoxelImage &image) {
    return measureMorphometry(image).structureModelIndex.value();
}

/// Two balls of radius 12 whose centers are 14 apart.
struct Pair {
    static constexpr double kRadius = 12, kHalf = 7;
    Vec<3> axis;
    double first(const Vec<3> &x) const { return length(x - axis * kHalf) - kRadius; }
    double second(const Vec<3> &x) const { return length(x + axis * kHalf) - kRadius; }
    /// Length of the edge where they meet, times the angle between the normals
    /// there.
    static double edge() {
        return 2 * kPi * std::sqrt(kRadius * kRadius - kHalf * kHalf) * 2 *
               std::asin(kHalf / kRadius);
    }
    /// Area of both parts beyond (1) or before (-1) the plane of the edge.
    static double area(int side) { return 2 * 2 * kPi * kRadius * (kRadius + side * kHalf); }
};

}  // namespace

TEST_CASE("balls have a structure model index of 4") {
    const double radius = GENERATE(4.3, 6.0, 10.0, 15.0);
    CAPTURE(radius);
    const Vec<3> center{{0.3, -0.2, 0.45}};
    const auto image =
        voxelImage(40, 1.0, [&](const Vec<3> &x) { return length(x - center) - radius; });
    REQUIRE(smi(image) == within(4, 0.02));
    REQUIRE(integral(image) == within(8 * kPi * radius, radius < 10 ? 0.01 : 0.002));
}

TEST_CASE("rods that the image cuts have a structure model index of 3") {
    const double tilt = GENERATE(0.0, 0.15, 0.4);
    const std::int64_t margin = GENERATE(0, 6);
    CAPTURE(tilt, margin);
    // Their ends lie on two opposite faces.
    const Rods rod{normalized(Vec<3>{{0.6 * tilt, tilt, 1}}), 20, 1e6, {0.3, 0.4}};
    const auto image = voxelImage(64, 1.0, rod, margin);
    const auto m = measureMorphometry(image);
    REQUIRE(m.structureModelIndex.value() == within(3, 0.02));
    REQUIRE(integral(image) == within(m.solidSurface / 10, 0.02));
}

TEST_CASE("slabs have a structure model index of 0") {
    const int i = GENERATE(range(0, 4));
    CAPTURE(i);
    REQUIRE(smi(voxelImage(48, 1.0, Slabs{direction(i), 10, 1e6, 0.3})) == Approx(0).margin(1e-3));
    REQUIRE(smi(voxelImage(48, 1.0, Slabs{direction(i), 10, 20, 0.3}, 5)) ==
            Approx(0).margin(1e-3));
}

TEST_CASE("closed pores have a negative structure model index") {
    const double radius = 12;
    const auto image = voxelImage(40, 1.0, [&](const Vec<3> &x) { return radius - length(x); });
    REQUIRE(integral(image) == within(-8 * kPi * radius, 0.005));
    const double area = 4 * kPi * radius * radius;
    const double solid = 40.0 * 40 * 40 - area * radius / 3;
    REQUIRE(smi(image) == within(-6 * solid * 8 * kPi * radius / (area * area), 0.03));
}

TEST_CASE("the structure model index needs no exact distances") {
    // The gradient has the length 0.4 at the surface, and changes across it.
    const auto image =
        voxelImage(40, 1.0, [](const Vec<3> &x) { return (squaredLength(x) - 144) / 60; });
    REQUIRE(integral(image) == within(8 * kPi * 12, 0.005));
    REQUIRE(smi(image) == within(4, 0.03));
    // Inside and outside alone: the surface has steps, and is too large.
    auto binary = image;
    for (float &d : binary.distance) d = d < 0 ? -0.5f : 0.5f;
    REQUIRE(smi(binary) == within(3.65, 0.02));
}

TEST_CASE("edges of unions and intersections bend by their angle") {
    const int i = GENERATE(range(0, 4));
    CAPTURE(i);
    const Pair pair{direction(i)};
    const auto both = voxelImage(
        56, 1.0, [&](const Vec<3> &x) { return std::min(pair.first(x), pair.second(x)); });
    const double joined = 2 / Pair::kRadius * Pair::area(1) - Pair::edge();
    REQUIRE(integral(both) == within(joined, 0.01));
    const double r = Pair::kRadius, cap = r - Pair::kHalf;
    const double solid = 2 * kPi * (4.0 / 3 * r * r * r - cap * cap * (r - cap / 3));
    REQUIRE(smi(both) == within(6 * solid * joined / std::pow(Pair::area(1), 2), 0.03));

    const auto lens = voxelImage(
        56, 1.0, [&](const Vec<3> &x) { return std::max(pair.first(x), pair.second(x)); });
    REQUIRE(integral(lens) == within(2 / r * Pair::area(-1) + Pair::edge(), 0.02));
}

TEST_CASE("edges of a cube bend by a right angle") {
    const int i = GENERATE(range(0, 4));
    CAPTURE(i);
    const Vec<3> u = direction(i);
    const auto [e, g] = across(u);
    const auto cube = voxelImage(44, 1.0, [&, e = e, g = g](const Vec<3> &x) {
        return std::max({std::abs(dot(x, e)), std::abs(dot(x, g)), std::abs(dot(x, u))}) - 10;
    });
    REQUIRE(integral(cube) == within(6 * kPi * 20, 0.03));  // 12 edges of 20 by pi / 2
    REQUIRE(smi(cube) == within(kPi, 0.06));
}

TEST_CASE("curvature belongs to the labels of the solid") {
    auto image = voxelImage(40, 0.5, [](const Vec<3> &x) { return length(x) - 6; });
    const double whole = integral(image);
    image.label.assign(image.voxels(), 3);
    std::fill_n(image.label.begin(), image.voxels() / 2, std::uint8_t{9});
    const auto byLabel = curvatureIntegrals(image);
    REQUIRE(byLabel[3] == Approx(whole / 2));
    REQUIRE(byLabel[9] == Approx(whole / 2));
    const auto m = measureMorphometry(image);
    // Half of the volume, the curvature and the surface.
    REQUIRE(m.regions.at(0).structureModelIndex.value() == within(4, 0.02));
    REQUIRE(m.regions.at(1).structureModelIndex.value() == within(4, 0.02));
    REQUIRE(m.structureModelIndex.value() == within(4, 0.02));
}

TEST_CASE("noise has a bounded curvature, and thin images none") {
    RandomStream random(5, 5);
    auto image = voxelImage(20, 1.0, [&](const Vec<3> &) { return -1.0; });
    for (float &d : image.distance) d = static_cast<float>(random.uniform() - 0.5);
    REQUIRE(std::abs(smi(image)) < 100);
    const auto sheet = voxelImage(2, 1.0, [](const Vec<3> &x) { return x[0] - 0.1; });
    REQUIRE(curvatureIntegrals(sheet).empty());
    REQUIRE_FALSE(measureMorphometry(sheet).structureModelIndex);
}
