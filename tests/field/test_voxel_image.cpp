// Level sets sampled into voxels.
#include "support/generators.h"
#include "support/test.h"
#include "voids/stamping.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/measure/morphometry/morphometry.h"

namespace {

const Vec<3> kCenter{{3.1, -40.2, 100.7}};
constexpr double kRadius = 5;

std::shared_ptr<const VdbGrid> ballGrid(double voxelSize) {
    FieldOptions options;
    options.voxelSize = voxelSize;
    options.depth = 1;
    return meshDomain(ballMesh(kRadius, 5, kCenter), options)->grid();
}

double distanceAt(const VoxelImage& image, std::size_t voxel) {
    return length(centerOf(image, voxel) - kCenter) - kRadius;
}

}  // namespace

TEST_CASE("a level set is sampled where it lies") {
    const auto grid = ballGrid(0.4);
    const double voxelSize = GENERATE(0.0, 0.3, 0.4);
    CAPTURE(voxelSize);
    const auto image = sampleLevelSet(*grid, {}, voxelSize);
    REQUIRE(image.voxelSize == Approx(voxelSize > 0 ? voxelSize : 0.4));
    REQUIRE(image.label.size() == image.voxels());
    double largest = 0;
    for (std::size_t i = 0; i < image.voxels(); ++i) {
        const double exact = distanceAt(image, i), value = double{image.distance[i]};
        if (std::abs(exact) < 0.7) largest = std::max(largest, std::abs(exact - value));
        if (std::abs(exact) >= 0.7) REQUIRE((exact < 0) == (value < 0));
        // The margin is outside.
        if (image.label[i] == 0) REQUIRE(image.distance[i] > 0);
    }
    REQUIRE(largest < (voxelSize == 0 ? 0.03 : 0.05));

    const auto m = measureMorphometry(image);
    REQUIRE(m.solidVolume == Approx(4.0 / 3 * kPi * 125).epsilon(0.02));
    REQUIRE(m.totalVolume == Approx(1000).epsilon(0.2));
    REQUIRE(m.thickness.value().mean == Approx(10).epsilon(0.01));
    REQUIRE(m.solidSurface == Approx(4 * kPi * 25).epsilon(0.02));
    REQUIRE(m.eulerNumber == 1);
}

TEST_CASE("bounds cut a level set, a margin looks beyond them") {
    const auto grid = ballGrid(0.4);
    const Box<3> box{kCenter + Vec<3>{{-2, -2, 0}}, kCenter + Vec<3>{{2, 3, 4}}};
    const auto plain = sampleLevelSet(*grid, box, 0.25);
    REQUIRE(plain.size == std::array<std::int64_t, 3>{16, 20, 16});
    REQUIRE(plain.label.empty());
    REQUIRE(length(plain.origin - (box.lo + Vec<3>{{0.125, 0.125, 0.125}})) < 1e-9);

    const auto wide = sampleLevelSet(*grid, box, 0.25, 0.6);
    REQUIRE(wide.size == std::array<std::int64_t, 3>{22, 26, 22});
    REQUIRE(std::count(wide.label.begin(), wide.label.end(), 1) == 16 * 20 * 16);
    const auto a = measureMorphometry(plain), b = measureMorphometry(wide);
    REQUIRE(a.totalVolume == Approx(box.volume()));
    REQUIRE(b.totalVolume == Approx(box.volume()));
    REQUIRE(a.solidVolume == Approx(b.solidVolume));

    // The grid's own voxels: those whose centers are inside.
    const auto own = sampleLevelSet(*grid, box);
    for (int j = 0; j < 3; ++j) {
        const auto n = static_cast<double>(own.size[static_cast<std::size_t>(j)] - 1);
        REQUIRE(own.origin[j] >= box.lo[j] - 1e-6);
        REQUIRE(own.origin[j] < box.lo[j] + 0.4);
        REQUIRE(own.origin[j] + n * 0.4 <= box.hi[j] + 1e-6);
        REQUIRE(own.origin[j] + n * 0.4 > box.hi[j] - 0.4 - 1e-6);
    }
    for (std::size_t i = 0; i < own.voxels(); ++i)
        if (std::abs(distanceAt(own, i)) < 0.7)
            REQUIRE(double{own.distance[i]} == Approx(distanceAt(own, i)).margin(0.03));
}

TEST_CASE("sampling is the same for any number of threads") {
    const auto grid = ballGrid(0.5);
    const auto one = withThreads(1, [&] { return sampleLevelSet(*grid, {}, 0.23); });
    const auto eight = withThreads(8, [&] { return sampleLevelSet(*grid, {}, 0.23); });
    REQUIRE(one.size == eight.size);
    REQUIRE(one.distance == eight.distance);
}

TEST_CASE("images that cannot be made are refused with the reason") {
    const auto grid = ballGrid(0.5);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    REQUIRE_THROWS_AS(sampleLevelSet(*grid, {}, -1), ParameterError);
    REQUIRE_THROWS_AS(sampleLevelSet(*grid, {}, nan), ParameterError);
    REQUIRE_THROWS_AS(sampleLevelSet(*grid, {}, 0.5, -1), ParameterError);
    REQUIRE_THROWS_AS(sampleLevelSet(*grid, Box<3>{}), ParameterError);
    REQUIRE_THROWS_AS(sampleLevelSet(*grid, Box<3>{{{0, 0, 0}}, {{nan, 1, 1}}}), ParameterError);
    const Box<3> thin{kCenter, kCenter + Vec<3>{{1e-9, 1, 1}}};
    REQUIRE_THROWS_WITH(sampleLevelSet(*grid, thin), Contains("voxels"));
    REQUIRE_THROWS_AS(sampleLevelSet(*grid, {}, 1e-4), ResourceError);
    REQUIRE_THROWS_WITH(sampleLevelSet(*grid, {}, 1e-4), Contains("voxels"));
    REQUIRE_THROWS_AS(sampleLevelSet(*grid, {}, 1e-300), ResourceError);
}
