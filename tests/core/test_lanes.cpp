#include "support/test.h"

#include "vdbpack/core/lanes.h"
#include "vdbpack/core/rng.h"

TEST_CASE("eight numbers at a time give what one at a time gives") {
    const auto seed = GENERATE(range(1u, 21u));
    CAPTURE(seed);
    RandomStream random(seed, 0);
    std::array<float, kLanes> a{}, b{};
    for (std::size_t l = 0; l < kLanes; ++l) {
        a[l] = static_cast<float>(2 * random.uniform() - 1);
        b[l] = random.uniform() < 0.2 ? a[l] : static_cast<float>(2 * random.uniform() - 1);
    }
    const Float8 va = load(a.data()), vb = load(b.data());
    const Int8 less = va < vb;
    std::vector<std::size_t> set, expected;
    forEachSet(less, [&](std::size_t l) { set.push_back(l); });
    for (std::size_t l = 0; l < kLanes; ++l) {
        CHECK(larger(va, vb)[l] == larger(a[l], b[l]));
        CHECK(smaller(va, vb)[l] == smaller(a[l], b[l]));
        CHECK(withSign(va, vb)[l] == withSign(a[l], b[l]));
        CHECK(absolute(va)[l] == std::fabs(a[l]));
        CHECK(roundedUp(va)[l] == static_cast<int>(std::ceil(a[l])));
        CHECK(squareRoot(absolute(va))[l] == squareRoot(std::fabs(a[l])));
        CHECK(choose(less, va, vb)[l] == choose(a[l] < b[l], a[l], b[l]));
        CHECK(where8(less, va)[l] == (a[l] < b[l] ? a[l] : 0.0f));
        if (a[l] < b[l]) expected.push_back(l);
    }
    CHECK(set == expected);
    CHECK(noneOf(less) == expected.empty());
    CHECK(smallest(va) == *std::min_element(a.begin(), a.end()));
    CHECK(largest(va) == *std::max_element(a.begin(), a.end()));
    std::array<std::uint32_t, kLanes> written{};
    const Word8 numbers = {0, 1, 2, 3, 4, 5, 6, 7};
    const LanePacking packed(bitsOf(less));
    CHECK(packed.count() == expected.size());
    store(written.data(), packed(numbers));
    CHECK(std::equal(expected.begin(), expected.end(), written.begin()));
}
