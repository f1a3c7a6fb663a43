// Share of the solid in its largest connected component.
#include "measure/morphometry/voxel_images.h"
#include "support/test.h"

#include "vdbpack/measure/morphometry/components.h"
#include "vdbpack/measure/morphometry/morphometry.h"

#include <cstddef>

namespace {

/// The same by filling from voxel to voxel.
double filledShare(const VoxelImage& image) {
    const auto& n = image.size;
    std::vector<bool> open(image.voxels());
    std::size_t total = 0, largest = 0;
    for (std::size_t i = 0; i < open.size(); ++i) {
        open[i] = image.distance[i] < 0 && image.inTotal(i);
        total += open[i];
    }
    for (std::size_t start = 0; start < open.size(); ++start) {
        if (!open[start]) continue;
        std::vector<std::size_t> stack{start};
        open[start] = false;
        std::size_t count = 0;
        for (; !stack.empty(); ++count) {
            const auto at = static_cast<std::int64_t>(stack.back());
            stack.pop_back();
            const std::int64_t x = at % n[0], y = at / n[0] % n[1], z = at / (n[0] * n[1]);
            for (std::int64_t k = std::max<std::int64_t>(z - 1, 0); k < std::min(z + 2, n[2]); ++k)
                for (std::int64_t j = std::max<std::int64_t>(y - 1, 0); j < std::min(y + 2, n[1]);
                     ++j)
                    for (std::int64_t i = std::max<std::int64_t>(x - 1, 0);
                         i < std::min(x + 2, n[0]); ++i) {
                        const auto next = static_cast<std::size_t>((k * n[1] + j) * n[0] + i);
                        if (!open[next]) continue;
                        open[next] = false;
                        stack.push_back(next);
                    }
        }
        largest = std::max(largest, count);
    }
    return static_cast<double>(largest) / static_cast<double>(total);
}

}  // namespace

TEST_CASE("the largest component is that of filling from voxel to voxel") {
    const auto seed = GENERATE(range(1u, 31u));
    CAPTURE(seed);
    RandomStream random(seed, 7);
    VoxelImage image;
    for (auto& n : image.size) n = 1 + static_cast<std::int64_t>(random.bits() % 14);
    image.voxelSize = 1;
    // About where noise begins to connect.
    const double share = 0.05 + 0.1 * random.uniform();
    for (std::size_t i = 0; i < image.voxels(); ++i) {
        image.distance.push_back(random.uniform() < share ? -0.5f : 0.5f);
        if (seed % 2 == 0) image.label.push_back(random.uniform() < 0.9 ? 2 : 0);
    }
    image.distance[0] = -0.5f;
    if (!image.label.empty()) image.label[0] = 1;
    REQUIRE(largestComponentShare(image).value() == filledShare(image));
}

TEST_CASE("the largest of two balls has its share of the solid") {
    const auto balls = [](double apart) {
        return voxelImage(40, 0.5, [=](const Vec<3>& x) {
            const Vec<3> left{{-4.3, 0, 0}}, right{{apart - 4.3, 0, 0}};
            return std::min(length(x - left) - 4, length(x - right) - 3);
        });
    };
    const auto m = measureMorphometry(balls(8));
    REQUIRE(m.largestComponent.value() == within(64.0 / (64 + 27), 0.01));
    REQUIRE(measureMorphometry(balls(6.5)).largestComponent.value() == 1);
}

TEST_CASE("the total volume alone connects") {
    auto image = voxelImage(
        12, 1.0, [](const Vec<3>& x) { return std::hypot(x[0] - 0.5, x[1] - 0.5) - 2.2; });
    REQUIRE(largestComponentShare(image).value() == 1);
    image.label.assign(image.voxels(), 1);
    std::fill_n(image.label.begin() + 12 * 12 * 4, 12 * 12, std::uint8_t{0});  // one slice
    REQUIRE(largestComponentShare(image).value() == Approx(7.0 / 11));
}

TEST_CASE("no solid has no largest component") {
    const auto image = voxelImage(4, 1.0, [](const Vec<3>&) { return 1.0; });
    REQUIRE_FALSE(largestComponentShare(image));
    REQUIRE_FALSE(measureMorphometry(image).largestComponent);
}
