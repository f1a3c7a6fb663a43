// Euler numbers and the connectivity that follows from them.
#include "measure/morphometry/voxel_images.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/measure/morphometry/euler.h"
#include "vdbpack/measure/morphometry/morphometry.h"

TEST_CASE("known solids have their Euler numbers") {
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

TEST_CASE("a lattice of struts has the connectivity of its graph") {
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

TEST_CASE("Euler numbers are those of cells counted one by one") {
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
