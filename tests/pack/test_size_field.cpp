// A factor on radii as numbers at the nodes of a lattice: values, bounds and constancy.
#include "support/random_point.h"
#include "support/test.h"

#include "vdbpack/pack/size_field.h"

namespace {

const Box<3> kBounds{{{-3, -2, 1}}, {{8, 7, 11}}};
constexpr double kStep = 0.5;

/// Constant in cubes of 3 mm; or different at every node.
double cubes(const Vec<3>& x) {
    double sum = 0;
    for (int d = 0; d < 3; ++d) sum += std::floor(x[d] / 3 + 1e-9);
    return 1 + std::fmod(sum + 100, 2.0);
}
double uneven(const Vec<3>& x) {
    return 1.5 + 0.4 * std::sin(7 * x[0]) * std::cos(5 * x[1] + 3 * x[2]);
}

/// From a point to boxes of a tenth of a step, and of all of the field.
Box<3> randomBox(RandomStream& random) {
    const Vec<3> x = randomPoint(random, kBounds.grown(1));
    const double longest = std::exp2(6 * random.uniform() - 4);
    Vec<3> half;
    for (int d = 0; d < 3; ++d) half[d] = longest * random.uniform();
    return {x - half, x + half};
}

}  // namespace

TEST_CASE("a size field has the values of its nodes, and lies between them elsewhere") {
    const SizeField field(kBounds, {}, kStep, uneven);
    RandomStream random(1, 1);
    for (int k = 0; k < 2000; ++k) {
        const Vec<3> x = randomPoint(random, kBounds);
        Vec<3> low, share;
        for (int d = 0; d < 3; ++d) {
            low[d] = std::floor(x[d] / kStep) * kStep;
            share[d] = (x[d] - low[d]) / kStep;
        }
        double value = 0;
        for (int corner = 0; corner < 8; ++corner) {
            Vec<3> node = low;
            double weight = 1;
            for (int d = 0; d < 3; ++d) {
                const bool up = corner >> d & 1;
                node[d] += up ? kStep : 0;
                weight *= up ? share[d] : 1 - share[d];
            }
            value += weight * uneven(node);
        }
        CHECK(field.at(x) == Approx(value).epsilon(1e-6));
    }
}

TEST_CASE("the bounds of a size field within a box hold for all of its points") {
    for (const auto function : {&cubes, &uneven}) {
        const SizeField field(kBounds, {}, kStep, function);
        RandomStream random(2, 1);
        for (int k = 0; k < 400; ++k) {
            const Box<3> box = randomBox(random);
            const auto [least, most] = field.within(box);
            const Box<3> around = box.grown(8 * kStep);
            double low = field.all().most, high = field.all().least;
            for (int point = 0; point < 200; ++point) {
                const double inside = field.at(randomPoint(random, box));
                CHECK(least <= inside);
                CHECK(inside <= most);
            }
            // They are those of nodes at most a few steps away.
            const auto from = [&](int d) { return std::floor(around.lo[d] / kStep) * kStep; };
            for (double z = from(2); z <= around.hi[2]; z += kStep)
                for (double y = from(1); y <= around.hi[1]; y += kStep)
                    for (double x = from(0); x <= around.hi[0]; x += kStep) {
                        const double value = field.at(Vec<3>{{x, y, z}});
                        low = std::min(low, value);
                        high = std::max(high, value);
                    }
            const Vec<3> size = box.size();
            if (*std::max_element(size.c.begin(), size.c.end()) > 4 * kStep) continue;
            CHECK(low <= least);
            CHECK(most <= high);
        }
    }
}

TEST_CASE("a size field is constant in a box exactly where its nodes around that are equal") {
    const SizeField field(kBounds, {}, kStep, cubes);
    RandomStream random(3, 1);
    int constant = 0;
    for (int k = 0; k < 2000; ++k) {
        const Box<3> box = randomBox(random);
        std::vector<double> values;
        std::array<int, 3> from{}, to{};
        for (std::size_t d = 0; d < 3; ++d) {
            from[d] = static_cast<int>(std::floor(box.lo.c[d] / kStep));
            to[d] = static_cast<int>(std::floor(box.hi.c[d] / kStep)) + 1;
        }
        for (int i = from[0]; i <= to[0]; ++i)
            for (int j = from[1]; j <= to[1]; ++j)
                for (int n = from[2]; n <= to[2]; ++n)
                    values.push_back(field.at(Vec<3>{{i * kStep, j * kStep, n * kStep}}));
        const bool same = std::count(values.begin(), values.end(), values.front()) ==
                          static_cast<std::ptrdiff_t>(values.size());
        CHECK(field.isConstant(box) == same);
        constant += same ? 1 : 0;
    }
    CHECK(constant > 200);
}
