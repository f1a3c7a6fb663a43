#include "support/image_file.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/image/label_map.h"

namespace {

ImageGrid obliqueGrid() {
    ImageGrid grid = turned(gridAround(12, {{0.7, 0.9, 1.3}}), 0.4, -0.8);
    grid.step[1] = -grid.step[1];  // left-handed
    return grid;
}

/// Balls that do not overlap, some of them partly or wholly outside of the grid.
std::vector<Sphere<3>> looseBalls() {
    RandomStream random(7, 1);
    std::vector<Sphere<3>> balls;
    while (balls.size() < 120) {
        Sphere<3> s;
        for (int d = 0; d < 3; ++d) s.center[d] = 50 * (random.uniform() - 0.5);
        s.radius = 0.2 + 3 * random.uniform();
        if (std::none_of(balls.begin(), balls.end(), [&](const Sphere<3>& t) {
                return length(s.center - t.center) < s.radius + t.radius;
            }))
            balls.push_back(s);
    }
    return balls;
}

}  // namespace

TEST_CASE("a voxel has the label of the sphere that its center lies in") {
    const ImageGrid grid = obliqueGrid();
    const auto balls = looseBalls();
    std::vector<std::int32_t> labels;
    for (std::size_t i = 0; i < balls.size(); ++i)
        labels.push_back(static_cast<std::int32_t>(3 * i + 1));
    const LabelMap map = labelMapOf(balls, labels, grid);
    std::size_t labelled = 0, wrong = 0;
    forEachVoxel(grid, [&](std::size_t voxel, const Vec<3>& at) {
        std::int32_t expected = 0;
        for (std::size_t i = 0; i < balls.size(); ++i)
            if (length(at - balls[i].center) <= balls[i].radius) expected = labels[i];
        wrong += map.labels[voxel] != expected;
        labelled += expected != 0;
    });
    CHECK(wrong == 0);
    CHECK(labelled > 500);
}

TEST_CASE("voxels of another size cover the same space") {
    const ImageGrid grid = obliqueGrid();
    const ImageGrid fine = withSpacing(grid, {{0.35, 0.3, 1.3}});
    CHECK(fine.size ==
          std::array<std::size_t, 3>{2 * grid.size[0], 3 * grid.size[1], grid.size[2]});
    const Vec<3> corner{{-0.5, -0.5, -0.5}};
    CHECK(length(fine.at(corner) - grid.at(corner)) < 1e-12);
    CHECK(fine.bounds().volume() == Approx(grid.bounds().volume()));

    const Box<3> box{{{-1, 2, 3}}, {{4, 9, 5.5}}};
    const Vec<3> spacing{{0.5, 0.75, 0.5}};
    const ImageGrid around = gridAround(box, spacing);
    CHECK(around.size == std::array<std::size_t, 3>{12, 12, 7});
    CHECK(length(around.bounds().lo - (box.lo - spacing)) < 1e-12);
    CHECK_THROWS_AS(withSpacing(grid, {{1e-9, 1, 1}}), ParameterError);
}
