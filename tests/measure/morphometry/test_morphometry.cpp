#include "measure/morphometry/voxel_images.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/measure/morphometry/euler.h"
#include "vdbpack/measure/morphometry/mean_intercept.h"
#include "vdbpack/measure/morphometry/morphometry.h"

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <functional>
#include <limits>
#include <sstream>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;

namespace {

double alignment(const Vec<3>& a, const Vec<3>& b) {
    return std::abs(dot(normalized(a), normalized(b)));
}

/// A direction along the axes (the first three of a run of `i`) or anywhere.
Vec<3> direction(int i, RandomStream& random) {
    const Vec<3> any = randomDirection(random);
    Vec<3> axis;
    if (i < 3) axis[i] = 1;
    return i < 3 ? axis : any;
}

std::size_t columns(const std::string& text) {
    std::size_t n = 0;
    for (const char c : text) n += (static_cast<unsigned char>(c) & 0xC0) != 0x80;
    return n;
}

/// The image with voxel (x, y, z) taken from `from(x, y, z)`.
template <class From>
VoxelImage rearranged(const VoxelImage& image, const From& from) {
    VoxelImage result = image;
    const std::int64_t n = image.size[0];
    for (std::int64_t z = 0; z < n; ++z)
        for (std::int64_t y = 0; y < n; ++y)
            for (std::int64_t x = 0; x < n; ++x) {
                const std::array<std::int64_t, 3> at = from(x, y, z);
                result.distance[static_cast<std::size_t>((z * n + y) * n + x)] =
                    image.distance[static_cast<std::size_t>((at[2] * n + at[1]) * n + at[0])];
            }
    return result;
}

}  // namespace

TEST_CASE("slabs have their thickness, spacing and direction however they lie",
          "[morphometry][long]") {
    const double width = GENERATE(8.0, 8.5, 16.0);
    const int i = GENERATE(range(1, 5));
    RandomStream random(11, static_cast<std::uint64_t>(i));
    const Vec<3> normal = direction(i, random);
    const Slabs slabs{normal, width, 2 * width, 2 * width * random.uniform()};
    CAPTURE(width, i, normal.c, slabs.offset);
    const auto margin = static_cast<std::int64_t>(width * 1.25);
    const auto m = measureMorphometry(
        voxelImage(2 * margin + static_cast<std::int64_t>(4 * width), 1.0, slabs, margin));
    REQUIRE(m.thickness);
    REQUIRE(m.separation);
    REQUIRE(m.thickness->mean == within(width, 0.01));
    REQUIRE(m.separation->mean == within(width, 0.01));
    REQUIRE(m.thickness->max == within(width, 0.015));
    REQUIRE(m.thickness->sd < 0.005 * width);
    REQUIRE(m.number.value() == within(m.solidFraction / width, 0.01));
    REQUIRE(m.anisotropy);
    REQUIRE(m.anisotropy->degree > 0.999);
    REQUIRE(alignment(m.anisotropy->axes[2], normal) > 0.9999);
}

TEST_CASE("rods have their thickness and direction however they lie", "[morphometry][long]") {
    const double width = GENERATE(8.0, 8.5, 16.0);
    const int i = GENERATE(range(1, 5));
    RandomStream random(12, static_cast<std::uint64_t>(i));
    const Vec<3> axis = direction(i, random);
    const double period = 2.25 * width;
    const Rods rods{axis, width, period, {period * random.uniform(), period * random.uniform()}};
    CAPTURE(width, i, axis.c, rods.offset);
    const auto margin = static_cast<std::int64_t>(width * 1.25);
    const auto m = measureMorphometry(
        voxelImage(2 * margin + static_cast<std::int64_t>(4 * width), 1.0, rods, margin));
    REQUIRE(m.thickness);
    REQUIRE(m.thickness->mean == within(width, width < 10 ? 0.03 : 0.01));
    REQUIRE(m.thickness->max == within(width, width < 10 ? 0.03 : 0.01));
    REQUIRE(m.anisotropy);
    REQUIRE(m.anisotropy->degree > 0.99);
    REQUIRE(alignment(m.anisotropy->axes[0], axis) > 0.999);
}

TEST_CASE("rods on the least lucky places of the lattice have their thickness", "[morphometry]") {
    // The axis through the middle of four voxels, of two, through a voxel.
    const double shift = GENERATE(0.0, 0.25, 0.5);
    const Rods rods{{{0, 0, 1}}, 8, 20, {shift, shift == 0.25 ? 0.5 : shift}};
    CAPTURE(shift);
    const auto m = measureMorphometry(voxelImage(40, 1.0, rods, 8));
    REQUIRE(m.thickness.value().mean == within(8, 0.03));
}

TEST_CASE("the spacing of rods is that of the balls between them", "[morphometry]") {
    // Balls fit between four rods of a square lattice: diagonal less width. Near the gap between
    // two rods smaller ones are the largest.
    RandomStream random(3, 3);
    const Vec<3> axis = randomDirection(random);
    const Rods rods{axis, 8, 20, {3.3, 5.7}};
    const auto m = measureMorphometry(voxelImage(88, 1.0, rods, 24));
    REQUIRE(m.separation.value().max == within(20 * std::sqrt(2.0) - 8, 0.02));
    REQUIRE(m.separation->mean < m.separation->max);
    REQUIRE(m.separation->mean > 0.95 * m.separation->max);
}

TEST_CASE("a ball has its diameter and surface", "[morphometry]") {
    const double radius = GENERATE(2.0, 4.3, 9.0);
    CAPTURE(radius);
    const Vec<3> center{{0.3, -0.2, 0.45}};
    const auto m = measureMorphometry(
        voxelImage(28, 1.0, [&](const Vec<3>& x) { return length(x - center) - radius; }));
    REQUIRE(m.thickness.value().mean == within(2 * radius, radius < 3 ? 0.1 : 0.02));
    REQUIRE(m.thickness->sd < 0.1);
    REQUIRE(m.solidSurface == within(4 * kPi * radius * radius, 0.03));
    REQUIRE(m.eulerNumber == 1);
    REQUIRE(m.deltaEuler == 1);
    REQUIRE(m.anisotropy.value().degree < (radius < 3 ? 0.2 : 0.12));
}

TEST_CASE("square rods get the balls that touch their four sides", "[morphometry]") {
    const double width = 10;
    RandomStream random(21, 1);
    const Vec<3> axis = randomDirection(random);
    const auto [e, g] = across(axis);
    const auto rod = [&, e = e, g = g](const Vec<3>& x) {
        const double a = std::abs(dot(x, e) + 0.3) - width / 2;
        const double b = std::abs(dot(x, g) - 0.2) - width / 2;
        return std::min(std::max(a, b), 0.0) + std::hypot(std::max(a, 0.0), std::max(b, 0.0));
    };
    const auto m = measureMorphometry(voxelImage(48, 1.0, rod, 14));
    // The corners have less than the full width: 4 - pi of a square of half the width, at most.
    REQUIRE(m.thickness.value().max == within(width, 0.02));
    REQUIRE(m.thickness->mean < width);
    REQUIRE(m.thickness->mean > 0.88 * width);
}

TEST_CASE("known solids have their Euler numbers", "[morphometry]") {
    const auto ball = [](const Vec<3>& x, const Vec<3>& c, double r) { return length(x - c) - r; };
    const auto torus = [](const Vec<3>& x, const Vec<3>& c) {
        const Vec<3> p = x - c;
        return std::hypot(std::hypot(p[0], p[1]) - 7, p[2]) - 3;
    };
    const auto euler = [](const std::function<double(const Vec<3>&)>& f) {
        const auto m = measureMorphometry(voxelImage(48, 1.0, f));
        REQUIRE(m.deltaEuler == m.eulerNumber);
        REQUIRE(m.connectivity == 1 - m.eulerNumber);
        REQUIRE(m.connectivityDensity == Approx((1 - m.eulerNumber) / (48.0 * 48 * 48)));
        return m.eulerNumber;
    };
    const Vec<3> left{{-11, 1, 0.3}}, right{{11, 0, 0}};
    REQUIRE(euler([&](const Vec<3>& x) { return ball(x, left, 9); }) == 1);
    REQUIRE(euler([&](const Vec<3>& x) { return std::max(ball(x, {}, 15), -ball(x, {}, 9)); }) ==
            2);
    REQUIRE(euler([&](const Vec<3>& x) { return std::min(ball(x, left, 9), ball(x, right, 8)); }) ==
            2);
    REQUIRE(euler([&](const Vec<3>& x) { return torus(x, {}); }) == 0);
    // Eight tori, linked in pairs by a strut: each pair has two holes.
    REQUIRE(euler([&](const Vec<3>& x) {
                double d = 1e9;
                for (int i = 0; i < 8; ++i)
                    d = std::min(d, torus(x, {{(i & 1) != 0 ? 11. : -11., (i & 2) != 0 ? 11. : -11.,
                                               (i & 4) != 0 ? 10. : -10.}}));
                const double strut = std::hypot(std::abs(x[1]) - 11, std::abs(x[2]) - 10) - 2;
                return std::min(d, std::max(strut, std::abs(x[0]) - 5));
            }) == -4);
}

TEST_CASE("a lattice of struts has the connectivity of its graph", "[morphometry]") {
    const double period = 16;
    const auto struts = [&](const Vec<3>& x) {
        Vec<3> p;
        for (int i = 0; i < 3; ++i) p[i] = std::abs(x[i] - period * std::round(x[i] / period));
        return std::min({std::hypot(p[0], p[1]), std::hypot(p[1], p[2]), std::hypot(p[0], p[2])}) -
               3;
    };
    SECTION("cut out with whole cells: one node and three struts a cell") {
        // Faces of the image cut the struts; 48 voxels hold three periods.
        const auto m = measureMorphometry(voxelImage(48, 1.0, struts));
        REQUIRE(m.deltaEuler == 27 * (1 - 3));
        REQUIRE(m.connectivityDensity == Approx((1 + 54) / (48.0 * 48 * 48)));
    }
    SECTION("with labels, the same from a larger image") {
        const auto m = measureMorphometry(voxelImage(64, 1.0, struts, 8));
        REQUIRE(m.totalVolume == Approx(48.0 * 48 * 48));
        REQUIRE(m.deltaEuler == 27 * (1 - 3));
    }
    SECTION("afloat") {
        const auto m = measureMorphometry(voxelImage(48, 1.0, [&](const Vec<3>& x) {
            const double out = std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])}) - 19.7;
            return std::max(struts(x), out);
        }));
        REQUIRE(m.eulerNumber == 27 - 54);
        REQUIRE(m.deltaEuler == 27 - 54);
    }
}

TEST_CASE("Euler numbers are those of cells counted one by one", "[morphometry]") {
    const auto seed = GENERATE(range(1u, 9u));
    CAPTURE(seed);
    RandomStream random(seed, 2);
    VoxelImage image;
    for (auto& n : image.size) n = 1 + static_cast<std::int64_t>(random.bits() % 7);
    image.voxelSize = 1;
    const double share = random.uniform();
    for (std::size_t i = 0; i < image.voxels(); ++i)
        image.distance.push_back(random.uniform() < share ? -0.5f : 0.5f);
    // Cells at doubled coordinates: odd along the axes they extend along.
    const auto& n = image.size;
    const auto present = [&](const std::array<std::int64_t, 3>& cell) {
        for (std::int64_t z = (cell[2] - 1) / 2; z <= cell[2] / 2; ++z)
            for (std::int64_t y = (cell[1] - 1) / 2; y <= cell[1] / 2; ++y)
                for (std::int64_t x = (cell[0] - 1) / 2; x <= cell[0] / 2; ++x)
                    if (x >= 0 && y >= 0 && z >= 0 && x < n[0] && y < n[1] && z < n[2] &&
                        (2 * x + 1 - cell[0]) * (2 * x + 1 - cell[0]) <= 1 &&
                        (2 * y + 1 - cell[1]) * (2 * y + 1 - cell[1]) <= 1 &&
                        (2 * z + 1 - cell[2]) * (2 * z + 1 - cell[2]) <= 1 &&
                        image.distance[static_cast<std::size_t>((z * n[1] + y) * n[0] + x)] < 0)
                        return true;
        return false;
    };
    // By the number of faces of the image that a cell lies in: all, surface, edges, corners.
    std::array<double, 4> chi{};
    for (std::int64_t z = 0; z <= 2 * n[2]; ++z)
        for (std::int64_t y = 0; y <= 2 * n[1]; ++y)
            for (std::int64_t x = 0; x <= 2 * n[0]; ++x) {
                if (!present({x, y, z})) continue;
                const double sign = (x + y + z) % 2 == 0 ? 1 : -1;
                const int planes = (x == 0 || x == 2 * n[0]) + (y == 0 || y == 2 * n[1]) +
                                   (z == 0 || z == 2 * n[2]);
                for (int k = 0; k <= planes; ++k) chi[static_cast<std::size_t>(k)] += sign;
            }
    const EulerNumbers euler = eulerNumbers(image);
    REQUIRE(euler.whole == chi[0]);
    // Odgaard and Gundersen's correction as BoneJ applies it.
    REQUIRE(euler.share == chi[0] - chi[1] / 2 - chi[2] / 4 - chi[3] / 8);

    // The shares of the parts of a solid add up.
    double sum = 0;
    for (std::uint8_t part = 0; part < 3; ++part) {
        RandomStream labels(seed, 3);
        image.label.clear();
        for (std::size_t i = 0; i < image.voxels(); ++i)
            image.label.push_back(labels.bits() % 3 == part ? 1 : 0);
        sum += eulerNumbers(image).share;
    }
    REQUIRE(sum == Approx(euler.share).margin(1e-9));
}

TEST_CASE("a Boolean model of balls has the volume and the chords of theory", "[morphometry]") {
    const double radius = 0.5, side = 6;
    Voids voids;
    voids.semiAxes = {radius, radius, radius};
    voids.perVolume = 1.6;
    double solid = 0, area = 0, crossings = 0, da = 0;
    constexpr int kSamples = 4;
    for (int i = 0; i < kSamples; ++i) {
        voids.seed = 100 + static_cast<std::uint64_t>(i);
        const auto m = measureMorphometry(voidsImage(72, side / 72, voids));
        REQUIRE(m.anisotropy);
        solid += m.solidFraction / kSamples;
        area += m.solidSurface / m.totalVolume / kSamples;
        for (const auto& length : m.anisotropy->meanInterceptLengths)
            crossings += 1 / length.value() / 3 / kSamples;
        da += m.anisotropy->degree / kSamples;
    }
    const double n = voids.perVolume;
    // Volume: exp(-n v). Standard error of four samples of 350 balls about 3 %.
    REQUIRE(solid == within(std::exp(-n * voids.volume()), 0.06));
    // What no ball covers has chords of mean length 1 / (n pi r²), two crossings each. Between
    // voxel centers h apart the short ones are missed: the two-point probability
    // exp(-n v (1 + 3h / 4r - h³ / 16r³)) says how many, about 5 %.
    const double h = side / 72, nv = n * voids.volume();
    const double step = 0.75 * h / radius - std::pow(h / radius, 3) / 16;
    const double chord = h / (1 - std::exp(-nv * step));
    REQUIRE(chord == within(1 / (n * kPi * radius * radius), 0.06));
    REQUIRE(2 * solid / crossings == within(chord, 0.02));
    REQUIRE(area == within(4 * solid / chord, 0.03));
    REQUIRE(da < 0.2);
}

TEST_CASE("an ellipsoid of intercepts is found again", "[morphometry]") {
    const auto directions = halfSphereDirections(500);
    const Vec<3> u = normalized(Vec<3>{{1, 2, -2}});
    const auto [e, g] = across(u);
    std::vector<double> rates;
    for (const auto& d : directions) {
        const double a = dot(d, u) / 0.9, b = dot(d, e) / 0.6, c = dot(d, g) / 0.5;
        rates.push_back(0.1 * std::sqrt(a * a + b * b + c * c));
    }
    const auto fit = fitAnisotropy(directions, rates, 0.1);
    REQUIRE(fit);
    REQUIRE(fit->meanInterceptLengths[0].value() == Approx(0.9));
    REQUIRE(fit->meanInterceptLengths[1].value() == Approx(0.6));
    REQUIRE(fit->meanInterceptLengths[2].value() == Approx(0.5));
    REQUIRE(fit->degree == Approx(1 - 25.0 / 81));
    REQUIRE(fit->ratio.value() == Approx(1.8));
    REQUIRE(fit->eigenvalues[2] == Approx(4));
    REQUIRE(alignment(fit->axes[0], u) == Approx(1));
    REQUIRE(fit->axes[0][1] > 0);
}

TEST_CASE("labels name regions", "[morphometry]") {
    // Slabs of 6 below, of 10 above, and nothing to measure in a layer around both.
    const Slabs thin{{{1, 0, 0}}, 6, 12, 1.3}, thick{{{0, 1, 0}}, 10, 20, 2.1};
    auto image = voxelImage(
        64, 0.1,
        [&](const Vec<3>& x) {
            const Vec<3> voxel = x * 10.0;
            return 0.1 * (voxel[2] < 0 ? thin(voxel) : thick(voxel));
        },
        12);
    std::array<double, 2> solid{}, all{};
    for (std::size_t i = 0; i < image.voxels(); ++i) {
        if (image.label[i] == 0) continue;
        const std::size_t z = i / (64 * 64);
        // Apart from where the two meet.
        image.label[i] = z < 22 ? 7 : z >= 42 ? 200 : 0;
        if (image.label[i] == 0) continue;
        ++all[z < 32 ? 0 : 1];
        solid[z < 32 ? 0 : 1] += image.distance[i] < 0;
    }
    const auto m = measureMorphometry(image);
    REQUIRE(m.regions.size() == 2);
    REQUIRE(m.regions[0].label == 7);
    REQUIRE(m.regions[1].label == 200);
    REQUIRE(m.regions[0].solidFraction == solid[0] / all[0]);
    REQUIRE(m.regions[1].solidFraction == solid[1] / all[1]);
    REQUIRE(m.solidFraction == (solid[0] + solid[1]) / (all[0] + all[1]));
    REQUIRE(m.regions[0].totalVolume + m.regions[1].totalVolume == Approx(m.totalVolume));
    REQUIRE(m.regions[0].solidVolume == Approx(solid[0] * 1e-3));
    REQUIRE(m.regions[0].thickness.value().mean == within(0.6, 0.01));
    REQUIRE(m.regions[1].thickness.value().mean == within(1.0, 0.01));
    REQUIRE(m.regions[0].separation.value().mean == within(0.6, 0.01));
    REQUIRE(m.regions[1].separation.value().max == within(1.0, 0.01));
}

TEST_CASE("morphometry is the same for any number of threads", "[morphometry]") {
    Voids voids = trabecular();
    const auto image = voidsImage(64, 0.04, voids);
    const auto text = [&](int threads) {
        return toJson(withThreads(threads, [&] { return measureMorphometry(image); })).dump();
    };
    const std::string one = text(1);
    REQUIRE(text(2) == one);
    REQUIRE(text(8) == one);
}

TEST_CASE("mirrored and turned solids measure the same", "[morphometry]") {
    Voids voids = trabecular();
    const auto image = voidsImage(72, 0.04, voids);
    const std::int64_t n = image.size[0];
    const auto m = measureMorphometry(image);
    const bool mirror = GENERATE(true, false);
    CAPTURE(mirror);
    using At = std::array<std::int64_t, 3>;
    const auto other =
        measureMorphometry(rearranged(image, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
            return mirror ? At{n - 1 - x, y, z} : At{x, z, n - 1 - y};
        }));
    REQUIRE(other.solidFraction == m.solidFraction);
    REQUIRE(other.eulerNumber == m.eulerNumber);
    REQUIRE(other.deltaEuler == m.deltaEuler);
    REQUIRE(other.structureModelIndex.value() == within(m.structureModelIndex.value(), 1e-4));
    REQUIRE(other.largestComponent == m.largestComponent);
    REQUIRE(other.solidSurface == within(m.solidSurface, 1e-6));
    REQUIRE(other.thickness.value().mean == within(m.thickness.value().mean, 2e-3));
    REQUIRE(other.thickness->sd == within(m.thickness->sd, 5e-3));
    REQUIRE(other.thickness->max == within(m.thickness->max, 2e-3));
    REQUIRE(other.separation.value().mean == within(m.separation.value().mean, 2e-3));
    REQUIRE(other.anisotropy.value().degree == Approx(m.anisotropy.value().degree).margin(2e-3));
    const Vec<3> a = m.anisotropy->axes[0];
    const Vec<3> expected = mirror ? Vec<3>{{-a[0], a[1], a[2]}} : Vec<3>{{a[0], -a[2], a[1]}};
    REQUIRE(alignment(other.anisotropy->axes[0], expected) > 0.999);
}

TEST_CASE("lengths scale with the voxel size", "[morphometry]") {
    const auto image = voidsImage(48, 0.05, trabecular());
    const auto m = measureMorphometry(image);
    const double scale = GENERATE(1e-3, 20.0);
    CAPTURE(scale);
    auto scaled = image;
    scaled.voxelSize *= scale;
    for (float& d : scaled.distance) d *= static_cast<float>(scale);
    const auto s = measureMorphometry(scaled);
    REQUIRE(s.solidFraction == m.solidFraction);
    REQUIRE(s.totalVolume == Approx(m.totalVolume * scale * scale * scale));
    REQUIRE(s.solidVolume == Approx(m.solidVolume * scale * scale * scale));
    REQUIRE(s.solidSurface == Approx(m.solidSurface * scale * scale));
    REQUIRE(s.thickness.value().mean == within(m.thickness.value().mean * scale, 1e-4));
    REQUIRE(s.thickness->sd == within(m.thickness->sd * scale, 1e-3));
    REQUIRE(s.separation.value().max == within(m.separation.value().max * scale, 1e-4));
    REQUIRE(s.number.value() == within(m.number.value() / scale, 1e-4));
    REQUIRE(s.thickness->quantile(25) == within(m.thickness->quantile(25) * scale, 1e-3));
    REQUIRE(s.structureModelIndex.value() == within(m.structureModelIndex.value(), 1e-4));
    REQUIRE(s.largestComponent == m.largestComponent);
    REQUIRE(s.deltaEuler == m.deltaEuler);
    REQUIRE(s.connectivityDensity == Approx(m.connectivityDensity / (scale * scale * scale)));
    REQUIRE(s.anisotropy.value().degree == Approx(m.anisotropy.value().degree).margin(1e-4));
    REQUIRE(s.anisotropy->meanInterceptLengths[0].value() ==
            within(m.anisotropy->meanInterceptLengths[0].value() * scale, 1e-4));
}

TEST_CASE("solids without a surface have volumes but no thickness", "[morphometry]") {
    const bool full = GENERATE(true, false);
    const std::int64_t n = GENERATE(1, 2, 9);
    CAPTURE(full, n);
    const auto m =
        measureMorphometry(voxelImage(n, 0.5, [&](const Vec<3>&) { return full ? -1.0 : 1.0; }));
    const double volume = static_cast<double>(n * n * n) * 0.125;
    REQUIRE(m.totalVolume == Approx(volume));
    REQUIRE(m.solidVolume == Approx(full ? volume : 0));
    REQUIRE(m.solidFraction == (full ? 1 : 0));
    REQUIRE(m.solidSurface == 0);
    REQUIRE_FALSE(m.thickness);
    REQUIRE_FALSE(m.separation);
    REQUIRE_FALSE(m.number);
    REQUIRE_FALSE(m.structureModelIndex);
    REQUIRE_FALSE(m.anisotropy);
    REQUIRE(m.eulerNumber == (full ? 1 : 0));
    // A piece of a solid without end.
    REQUIRE(m.deltaEuler == 0);
    const auto json = toJson(m);
    REQUIRE(json["Tb.Th"].is_null());
    REQUIRE(json["DA"].is_null());
    REQUIRE_THAT(summary(m), Contains("Tb.Th      none"));
}

TEST_CASE("one solid voxel is measured", "[morphometry]") {
    const auto m =
        measureMorphometry(voxelImage(5, 1.0, [](const Vec<3>& x) { return length(x) - 0.6; }));
    REQUIRE(m.solidVolume == 1);
    REQUIRE(m.thickness.value().mean == Approx(1.2).margin(0.15));
    REQUIRE(m.eulerNumber == 1);
    REQUIRE(m.anisotropy.value().degree == Approx(0).margin(0.15));
}

TEST_CASE("binary images are measured to about a voxel", "[morphometry]") {
    // Distances of half a voxel say no more than inside and outside.
    RandomStream random(9, 9);
    const Vec<3> normal = randomDirection(random);
    const Slabs slabs{normal, 12, 24, 5};
    auto image = voxelImage(72, 1.0, slabs, 14);
    for (float& d : image.distance) d = d < 0 ? -0.5f : 0.5f;
    const auto m = measureMorphometry(image);
    REQUIRE(m.thickness.value().mean == Approx(12).margin(0.6));
    REQUIRE(m.separation.value().mean == Approx(12).margin(0.6));
    REQUIRE(m.anisotropy.value().degree > 0.95);
    REQUIRE(alignment(m.anisotropy->axes[2], normal) > 0.99);
}

TEST_CASE("unusable images are refused with the reason", "[morphometry]") {
    auto image = voxelImage(4, 1.0, [](const Vec<3>& x) { return length(x) - 1; });
    REQUIRE_NOTHROW(measureMorphometry(image));
    SECTION("a size that does not fit") {
        image.size[1] = 5;
        REQUIRE_THROWS_AS(measureMorphometry(image), ParameterError);
        REQUIRE_THROWS_WITH(measureMorphometry(image), Contains("64 distances for 4 x 5 x 4"));
    }
    SECTION("no voxels") {
        image.size[2] = 0;
        REQUIRE_THROWS_AS(measureMorphometry(image), ParameterError);
    }
    SECTION("a size whose product overflows") {
        image.size = {std::int64_t{1} << 40, std::int64_t{1} << 40, 1};
        REQUIRE_THROWS_AS(measureMorphometry(image), ParameterError);
    }
    SECTION("a voxel size of nothing") {
        image.voxelSize = GENERATE(0.0, -1.0, std::nan(""));
        REQUIRE_THROWS_AS(measureMorphometry(image), ParameterError);
    }
    SECTION("labels that do not fit") {
        image.label.assign(63, 1);
        REQUIRE_THROWS_WITH(measureMorphometry(image), Contains("63 labels for 64 voxels"));
    }
    SECTION("depths that do not fit") {
        image.label.assign(64, 1);
        image.depth.assign(63, 1);
        REQUIRE_THROWS_WITH(measureMorphometry(image), Contains("63 depths"));
    }
    SECTION("no total volume") {
        image.label.assign(64, 0);
        REQUIRE_THROWS_AS(measureMorphometry(image), InputError);
        REQUIRE_THROWS_WITH(measureMorphometry(image), Contains("label 0"));
    }
    SECTION("a distance that is not finite") {
        image.distance[4 * (4 * 2 + 3) + 1] = std::numeric_limits<float>::quiet_NaN();
        REQUIRE_THROWS_AS(measureMorphometry(image), InputError);
        REQUIRE_THROWS_WITH(measureMorphometry(image), Contains("voxel (1, 3, 2)"));
    }
}

TEST_CASE("the summary fits a terminal and the report has the symbols", "[morphometry]") {
    auto image = voidsImage(40, 0.06, trabecular());
    image.label.assign(image.voxels(), 1);
    image.label[0] = 255;
    const auto m = measureMorphometry(image);
    std::istringstream lines(summary(m));
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
        CAPTURE(line);
        REQUIRE(columns(line) <= 80);
    }
    // The whole, its border, and two regions, one of them without a surface.
    REQUIRE(count == 14 + 2 + 13 + 9);
    const auto json = toJson(m);
    for (const char* key :
         {"TV", "BV", "BV/TV", "BS", "Tb.N", "SMI", "Conn.D", "connectivity", "largestComponent"})
        REQUIRE(json[key].is_number());
    REQUIRE(json["Tb.Th"]["mean"] == m.thickness.value().mean);
    REQUIRE(json["Tb.Sp"]["p50"] == m.separation.value().quantile(50));
    for (const char* key : {"p5", "p25", "p50", "p75", "p95"})
        REQUIRE(json["Tb.Th"][key].is_number());
    REQUIRE(json["DA"]["axes"].size() == 3);
    REQUIRE(json["DA"]["MIL"][0] == m.anisotropy.value().meanInterceptLengths[0].value());
    REQUIRE(json["regions"].size() == 2);
    REQUIRE(json["regions"][1]["label"] == 255);
    REQUIRE(json["regions"][0]["DA"]["degree"] == m.regions[0].anisotropy.value().degree);
    REQUIRE(json["regions"][0]["Conn.D"].is_number());
    REQUIRE(json["border"]["kind"] == "cut");
    REQUIRE(json["border"]["solid"] == m.border.solid);
}

TEST_CASE("a sample of trabecular bone is measured in seconds", "[morphometry][.slow]") {
    const auto image = voidsImage(256, 0.02, trabecular());
    const auto start = std::chrono::steady_clock::now();
    const auto m = measureMorphometry(image);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    WARN(fmt::format("256³ voxels in {:.2f} s\n{}", seconds, summary(m)));
    REQUIRE(m.solidFraction == Approx(0.15).margin(0.03));
    REQUIRE(m.thickness.value().mean == Approx(0.2).margin(0.05));
    REQUIRE(m.anisotropy.value().degree > 0.1);
    REQUIRE(m.anisotropy->axes[0][2] > 0.9);
    REQUIRE(m.connectivityDensity > 0);
}
