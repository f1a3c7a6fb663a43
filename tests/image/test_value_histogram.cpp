#include "support/image_file.h"
#include "support/jobs.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/domain/domain_recipe.h"
#include "vdbpack/image/image.h"
#include "vdbpack/image/value_histogram.h"
#include "vdbpack/image/voxel_axes.h"

#include <cmath>
#include <limits>

namespace {

/// An image of one row of voxels.
template <class T>
Image rowOf(NumberType type, const std::vector<T>& values) {
    Image image;
    image.grid.size = {values.size(), 1, 1};
    image.type = type;
    image.bytes = voxelMemory(values.size() * sizeof(T));
    std::copy(values.begin(), values.end(), reinterpret_cast<T*>(image.bytes.get()));
    return image;
}

/// The variance between the classes on both sides of a threshold, by its definition.
double varianceBetween(const std::vector<std::int16_t>& values, double threshold) {
    double count[2] = {}, sum[2] = {};
    for (const auto value : values) {
        ++count[value >= threshold];
        sum[value >= threshold] += value;
    }
    const double apart = sum[1] / count[1] - sum[0] / count[0];
    return count[0] * count[1] * apart * apart;
}

}  // namespace

TEST_CASE("Otsu's threshold has the largest variance between its classes") {
    RandomStream random(3, 1);
    std::vector<std::int16_t> values;
    for (int i = 0; i < 5000; ++i)
        values.push_back(static_cast<std::int16_t>((i % 5 == 0 ? 300 : 20) +
                                                   60 * (random.uniform() + random.uniform() - 1)));
    const Image image = rowOf(NumberType::i16, values);
    const double found = otsuThreshold(histogramOf(image));
    double best = -1;
    for (int at = -38; at < 360; ++at)
        if (const double variance = varianceBetween(values, at + 0.5); std::isfinite(variance))
            best = std::max(best, variance);
    CHECK(varianceBetween(values, found) == Approx(best).epsilon(1e-12));
    CHECK(found > 60);
    CHECK(found < 250);
}

TEST_CASE("Otsu's threshold lies midway between two values, and in other units likewise") {
    std::vector<std::uint8_t> values(100, 0);
    std::fill(values.begin(), values.begin() + 30, std::uint8_t{255});
    Image image = rowOf(NumberType::u8, values);
    CHECK(otsuThreshold(histogramOf(image)) == 127.5);
    image.slope = 0.01;
    image.intercept = -1;
    CHECK(otsuThreshold(histogramOf(image)) == Approx(0.275).epsilon(1e-12));
    std::vector<float> real(100, -2.5f);
    real[7] = 3.5f;
    CHECK(otsuThreshold(histogramOf(rowOf(NumberType::f32, real))) == Approx(0.5).epsilon(1e-4));
}

TEST_CASE("a threshold by Otsu's method leaves out air, and warns where it separates air") {
    // Air, soft tissue and bone of a CT in HU: 50, 45 and 5 of 100.
    std::vector<std::int16_t> values(100, -1000);
    std::fill(values.begin() + 50, values.end(), std::int16_t{40});
    std::fill(values.begin() + 95, values.end(), std::int16_t{900});
    const Image image = rowOf(NumberType::i16, values);
    Listener listener;
    CHECK(Threshold::otsu().of(image, "ct.nii", listener.callbacks).value == -480);
    REQUIRE(listener.warnings.size() == 1);
    CHECK_THAT(listener.warnings[0], Contains("50 %") && Contains("otsu:-200"));
    CHECK(Threshold::parse("otsu:-200").of(image, "ct.nii", listener.callbacks).value == 470);
    CHECK(listener.warnings.size() == 1);
    CHECK(Threshold(17).of(image, "ct.nii", {}).value == 17);
    CHECK_THROWS_WITH(Threshold::otsu(41).of(image, "ct.nii", {}),
                      Contains("ct.nii") && Contains("no two different values"));
    for (const char* wrong : {"otsu:", "otsu:x", "otsu:nan", "otsuu", "otsu -200"})
        CHECK_THROWS_AS(Threshold::parse(wrong), ParameterError);
    for (const char* text : {"otsu", "otsu:-200", "otsu:0.5"})
        CHECK(Threshold::parse(text).text() == text);
}

TEST_CASE("bins of a histogram hold all finite numbers, and coarser ones the same") {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    const auto histogram =
        histogramOf(rowOf<float>(NumberType::f32, {0, 1.5f, 2, kNan, 10, 10, 7.25f}));
    CHECK(histogram.total() == 6);
    CHECK(histogram.shareFrom(7) == Approx(0.5));
    const ValueHistogram coarse = histogram.coarser(10);
    CHECK(coarse.counts.size() <= 10);
    CHECK(coarse.counts.front() == 1);
    CHECK(coarse.counts.back() == 2);
    CHECK(coarse.total() == 6);
    const auto whole = histogramOf(rowOf<std::int16_t>(NumberType::i16, {-3, 5, 5, 0}), -2.5);
    CHECK(whole.counts == std::vector<std::uint64_t>{0, 0, 1, 0, 0, 0, 0, 2});
    CHECK(whole.edge(0) == -2.5);
    CHECK(histogramOf(rowOf<std::uint8_t>(NumberType::u8, {4, 4})).counts.empty());
}

TEST_CASE("principal axes of labels reach to the faces of their voxels") {
    // A bar of 2 x 3 x 8 voxels of 1 x 2 x 0.5 mm, and one voxel beside it, on a turned grid.
    ImageGrid grid;
    grid.size = {6, 5, 10};
    grid.step = {{{{1, 0, 0}}, {{0, 2, 0}}, {{0, 0, 0.5}}}};
    grid = turned(grid, 0.4, -0.7);
    const std::size_t voxels = grid.voxels();
    Image image;
    image.grid = grid;
    image.bytes = voxelMemory(voxels);
    auto* const labels = reinterpret_cast<std::uint8_t*>(image.bytes.get());
    std::fill(labels, labels + voxels, std::uint8_t{0});
    for (std::size_t z = 1; z < 9; ++z)
        for (std::size_t y = 1; y < 4; ++y)
            for (std::size_t x = 1; x < 3; ++x) labels[(z * 5 + y) * 6 + x] = 7;
    labels[5] = 9;
    const auto solids = labelSolids(image, labelsOf(image, true).value());
    REQUIRE(solids.size() == 2);
    CHECK(solids[0].voxels == 48);
    // By its lengths of 6, 4 and 2 mm.
    const PrincipalAxes<3>& bar = solids[0].axes;
    const std::array<Vec<3>, 3> along{grid.step[1] * 0.5, grid.step[2] * 2, grid.step[0]};
    for (std::size_t d = 0; d < 3; ++d) {
        const double length = 6 - 2 * static_cast<double>(d);
        CHECK(bar.lengths.c[d] == Approx(length));
        CHECK(bar.spread.c[d] == Approx(length / std::sqrt(12.0)));
        CHECK(std::fabs(dot(bar.axes[d], along[d])) == Approx(1));
    }
    CHECK(dot(cross(bar.axes[0], bar.axes[1]), bar.axes[2]) == Approx(1));
    CHECK(length(bar.center - grid.at({{1.5, 2, 4.5}})) < 1e-12);
    CHECK(solids[1].voxels == 1);
    CHECK(solids[1].axes.lengths[0] == Approx(2));
    CHECK(length(solids[1].axes.center - grid.at({{5, 0, 0}})) < 1e-12);
    const VoxelSolid all = solidFrom(image, 8);
    CHECK(all.voxels == 1);
    CHECK(solidFrom(image, 1).voxels == 49);
    CHECK(solidFrom(image, 10).voxels == 0);
}
