// Bodies in cells: all are there once, and rows of cells hold whatever is near.
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/densify/body_cells.h"

#include <numeric>

namespace {

struct Bodies {
    std::vector<Home> homes;
    std::vector<Body> bodies;
    float least = 0, largest = 0;

    /// @param size  of the box that they lie in, quanta; 0 in a direction: a plane.
    Bodies(std::size_t n, const Home& size, float from, float to) : least(from), largest(to) {
        RandomStream random(3, 0);
        for (std::size_t i = 0; i < n; ++i) {
            Home home{};
            for (std::size_t d = 0; d < 3; ++d) {
                const double share = random.uniform() - 0.3;
                home[d] = std::llround(share * static_cast<double>(size[d]));
            }
            const double share = i == 0 ? 0 : i == 1 ? 1 : random.uniform();
            homes.push_back(home);
            bodies.push_back({lowBits(home[0]), lowBits(home[1]), lowBits(home[2]),
                              from + static_cast<float>(share) * (to - from)});
        }
    }
    bool sortInto(BodyCells& cells) const {
        return cells.sort(homes, bodies.data(), least, largest, {2, 1000});
    }
    double distance(std::size_t i, std::size_t j) const {
        double sum = 0;
        for (std::size_t d = 0; d < 3; ++d) {
            const auto apart = static_cast<double>(homes[i][d] - homes[j][d]);
            sum += apart * apart;
        }
        return std::sqrt(sum);
    }
};

}  // namespace

TEST_CASE("rows of cells hold every body within reach") {
    const std::int64_t side = 100'000'000;
    const auto size = GENERATE(as<Home>{}, Home{side, side, side}, Home{side, side, 0},
                               Home{40 * side, side / 10, side / 10});
    const float largest = GENERATE(3e6f, 1e8f);
    CAPTURE(size[0], size[2], largest);
    const Bodies given(2000, size, 2e6f, largest);
    BodyCells cells;
    given.sortInto(cells);

    std::vector<std::uint32_t> numbers = cells.order();
    std::sort(numbers.begin(), numbers.end());
    std::vector<std::uint32_t> all(given.homes.size());
    std::iota(all.begin(), all.end(), 0u);
    REQUIRE(numbers == all);

    RandomStream random(4, 0);
    std::size_t visited = 0, near = 0;
    for (std::size_t i = 0; i < all.size(); i += 37) {
        const double reach = random.uniform() * 2 * static_cast<double>(largest);
        std::vector<bool> seen(all.size());
        for (const auto& level : cells.levels())
            cells.forEachRow(level, given.homes[i], given.homes[i], reach,
                             [&](std::uint32_t first, std::uint32_t last) {
                                 for (std::uint32_t place = first; place < last; ++place) {
                                     const std::uint32_t j = cells.order()[place];
                                     REQUIRE(!seen[j]);
                                     REQUIRE(given.bodies[j].radius <= level.largest);
                                     seen[j] = true;
                                     ++visited;
                                 }
                             });
        for (std::size_t j = 0; j < all.size(); ++j) {
            if (given.distance(i, j) > reach) continue;
            ++near;
            REQUIRE(seen[j]);
        }
    }
    REQUIRE(near > 0);
    REQUIRE(visited >= near);
}

TEST_CASE("bodies of one cell lie side by side, by their numbers") {
    const Bodies given(5000, {50'000'000, 50'000'000, 50'000'000}, 1e6f, 4e6f);
    BodyCells cells;
    given.sortInto(cells);
    for (std::size_t place = 1; place < given.homes.size(); ++place) {
        REQUIRE(cells.cellOf(place - 1) <= cells.cellOf(place));
        if (cells.cellOf(place - 1) == cells.cellOf(place))
            REQUIRE(cells.order()[place - 1] < cells.order()[place]);
    }
}

TEST_CASE("low bits that may deceive are reported") {
    BodyCells cells;
    CHECK_FALSE(Bodies(100, {1 << 29, 1 << 29, 1 << 29}, 1e6f, 2e6f).sortInto(cells));
    // Cells that are searched are near.
    CHECK_FALSE(Bodies(100, {std::int64_t(1) << 33, 1, 1}, 1e6f, 2e6f).sortInto(cells));
    CHECK(Bodies(100, {std::int64_t(1) << 33, 1, 1}, 1e8f, 2e8f).sortInto(cells));
}

TEST_CASE("a few bodies far apart take few cells") {
    const std::int64_t far = std::int64_t(1) << 45;
    const Bodies given(20, {far, far, far}, 1e6f, 2e6f);
    BodyCells cells;
    given.sortInto(cells);
    std::int64_t count = 0;
    for (const auto& level : cells.levels())
        count += level.count[0] * level.count[1] * level.count[2];
    CHECK(count < 2000);
}
