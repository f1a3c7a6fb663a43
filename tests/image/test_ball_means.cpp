#include "support/image_file.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/image/ball_means.h"

#include <cstring>

TEST_CASE("grey values of spheres are the means over their voxels", "[long]") {
    ImageGrid grid = turned(gridAround(20, {{0.6, 0.8, 1.2}}), 0.3, 0.7);
    if (GENERATE(false, true)) grid.step[1] = -grid.step[1];
    const auto valueAt = [](const Vec<3>& p) {
        return 1000 + 400 * std::sin(p[0] / 4) * std::cos(p[1] / 5) + 20 * p[2];
    };
    const auto made = Voxels<std::int16_t>::of(grid, valueAt);
    Image image;
    image.grid = grid;
    image.type = NumberType::i16;
    image.slope = 0.5;
    image.intercept = -100;
    image.bytes = voxelMemory(2 * made.values.size());
    std::memcpy(image.bytes.get(), made.values.data(), 2 * made.values.size());

    RandomStream random(4, 1);
    std::vector<Sphere<3>> spheres;
    const Box<3> box = grid.bounds();
    for (int k = 0; k < 1000; ++k) {
        Sphere<3> s;
        const Vec<3> middle = box.center();
        for (int d = 0; d < 3; ++d) s.center[d] = middle[d] + 14 * (random.uniform() - 0.5);
        s.radius = 0.3 + 3.7 * random.uniform();
        spheres.push_back(s);
    }
    const auto means = ballMeans(image, spheres);
    const double range = 0.5 * 1600;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        double sum = 0, count = 0;
        forEachVoxel(grid, [&](std::size_t v, const Vec<3>& at) {
            if (length(at - spheres[i].center) > spheres[i].radius) return;
            sum += 0.5 * made.values[v] - 100;
            ++count;
        });
        if (count > 0)
            CHECK(means[i] == Approx(sum / count).margin(1e-6));
        else
            CHECK(means[i] == Approx(0.5 * valueAt(spheres[i].center) - 100).margin(0.01 * range));
    }
    // Voxels that are not numbers (padding of a resampled CT) do not count.
    Image row;
    row.grid.size = {5, 1, 1};
    row.type = NumberType::f32;
    row.bytes = voxelMemory(20);
    const float nan = std::nanf(""), values[] = {nan, 3, 5, nan, nan};
    std::memcpy(row.bytes.get(), values, 20);
    CHECK(ballMeans(row, {{{{1, 0, 0}}, 1.2}}).front() == 4);
    CHECK(std::isnan(ballMeans(row, {{{{4, 0, 0}}, 0.5}}).front()));
    CHECK(fillFromNearest(row) == 3);
    for (int x = 0; x < 5; ++x) CHECK(ImageSampler(row).at({{1.0 * x, 0, 0}}) == (x < 2 ? 3 : 5));
    const auto outside = ballMeans(image, {{{{1000, 0, 0}}, 1}});
    CHECK(std::isnan(outside.front()));
}
