#include "measure/morphometry/voxel_images.h"
#include "support/test.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/measure/morphometry/euler.h"
#include "vdbpack/measure/morphometry/mean_intercept.h"
#include "vdbpack/measure/morphometry/morphometry.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chrono>

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

TEST_CASE("slabs have their thickness, spacing and direction however they lie", "[long]") {
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

TEST_CASE("rods have their thickness and direction however they lie", "[long]") {
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

TEST_CASE("rods on the least lucky places of the lattice have their thickness") {
    // The axis through the middle of four voxels, of two, through a voxel.
    const double shift = GENERATE(0.0, 0.25, 0.5);
    const Rods rods{{{0, 0, 1}}, 8, 20, {shift, shift == 0.25 ? 0.5 : shift}};
    CAPTURE(shift);
    const auto m = measureMorphometry(voxelImage(40, 1.0, rods, 8));
    REQUIRE(m.thickness.value().mean == within(8, 0.03));
}

TEST_CASE("the spacing of rods is that of the balls between them") {
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

TEST_CASE("a ball has its diameter and surface") {
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

TEST_CASE("square rods get the balls that touch their four sides") {
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

TEST_CASE("labels name regions") {
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

TEST_CASE("morphometry is the same for any number of threads") {
    Voids voids = trabecular();
    const auto image = voidsImage(64, 0.04, voids);
    const auto text = [&](int threads) {
        return toJson(withThreads(threads, [&] { return measureMorphometry(image); })).dump();
    };
    const std::string one = text(1);
    REQUIRE(text(2) == one);
    REQUIRE(text(8) == one);
}

TEST_CASE("mirrored and turned solids measure the same") {
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

TEST_CASE("lengths scale with the voxel size") {
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

TEST_CASE("solids without a surface have volumes but no thickness") {
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

TEST_CASE("one solid voxel is measured") {
    const auto m =
        measureMorphometry(voxelImage(5, 1.0, [](const Vec<3>& x) { return length(x) - 0.6; }));
    REQUIRE(m.solidVolume == 1);
    REQUIRE(m.thickness.value().mean == Approx(1.2).margin(0.15));
    REQUIRE(m.eulerNumber == 1);
    REQUIRE(m.anisotropy.value().degree == Approx(0).margin(0.15));
}

TEST_CASE("binary images are measured to about a voxel") {
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

TEST_CASE("unusable images are refused with the reason") {
    const auto image = voxelImage(4, 1.0, [](const Vec<3>& x) { return length(x) - 1; });
    REQUIRE_NOTHROW(measureMorphometry(image));
    const float none = std::numeric_limits<float>::quiet_NaN();
    const auto refused = [&](auto&& change, const std::string& reason, bool input = false) {
        auto bad = image;
        change(bad);
        if (input) CHECK_THROWS_AS(measureMorphometry(bad), InputError);
        if (!input) CHECK_THROWS_AS(measureMorphometry(bad), ParameterError);
        CHECK_THROWS_WITH(measureMorphometry(bad), Contains(reason));
    };
    refused([](auto& i) { i.size[1] = 5; }, "64 distances for 4 x 5 x 4");
    refused([](auto& i) { i.size[2] = 0; }, "");
    refused([](auto& i) { i.size = {std::int64_t{1} << 40, std::int64_t{1} << 40, 1}; }, "");
    for (const double voxel : {0.0, -1.0, std::nan("")})
        refused([&](auto& i) { i.voxelSize = voxel; }, "");
    refused([](auto& i) { i.label.assign(63, 1); }, "63 labels for 64 voxels");
    refused([](auto& i) { i.label.assign(64, 1), i.depth.assign(63, 1); }, "63 depths");
    refused([](auto& i) { i.label.assign(64, 0); }, "label 0", true);
    refused([&](auto& i) { i.distance[4 * (4 * 2 + 3) + 1] = none; }, "voxel (1, 3, 2)", true);
}

TEST_CASE("the summary fits a terminal and the report has the symbols") {
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
    REQUIRE(count == 15 + 2 + 13 + 9);
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

TEST_CASE("a sample of trabecular bone is measured in seconds", "[.slow]") {
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
