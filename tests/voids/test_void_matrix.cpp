#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/voids/void_list.h"

#include <cstddef>

namespace {

VoidMatrix read(const std::string& content) {
    const TextFile file(content, "m.txt");
    return readVoidMatrix(file.path());
}

std::string failure(const std::string& content) {
    return messageOf<InputError>([&] { read(content); });
}

using Indices = std::vector<std::array<int, 3>>;

/// Those of the cells that are 1, x fastest.
Indices onesOf(const VoidMatrix& m) {
    Indices ones;
    for (int k = 0; k < m.size[2]; ++k)
        for (int j = 0; j < m.size[1]; ++j)
            for (int i = 0; i < m.size[0]; ++i)
                if (m.at(i, j, k)) ones.push_back({i, j, k});
    return ones;
}

}  // namespace

TEST_CASE("a void matrix is read as printed on paper") {
    const auto m = read("110\n000\n001\n100\n");
    REQUIRE(m.size == std::array<int, 3>{3, 4, 1});
    // The first row is the top.
    CHECK(onesOf(m) == Indices{{0, 0, 0}, {2, 1, 0}, {0, 3, 0}, {1, 3, 0}});
}

TEST_CASE("cells of a void matrix may be separated in any way") {
    const auto expected = read("0110\n1000\n");
    for (const char* content :
         {"0,1,1,0\n1,0,0,0", "0 1 1 0\n1 0 0 0\n", "  0\t11 0\r\n1000\r\n\r\n",
          "\xef\xbb\xbf# cells\n\n0;1;1;0;  # top\n# next\n1;0;0;0\n\n\n"}) {
        CAPTURE(content);
        const auto m = read(content);
        CHECK(m.size == expected.size);
        CHECK(m.cells == expected.cells);
    }
}

TEST_CASE("blank lines separate the layers of a void matrix, the lowest first") {
    const auto m = read("10\n00\n\n\n# upper\n01\n11\n\n00\n00\n");
    REQUIRE(m.size == std::array<int, 3>{2, 2, 3});
    CHECK(onesOf(m) == Indices{{0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}});
}

TEST_CASE("any void matrix is read back from its text") {
    RandomStream random(8, 1);
    for (int round = 0; round < 20; ++round) {
        VoidMatrix m;
        std::size_t count = 1;
        for (int& n : m.size) count *= static_cast<std::size_t>(n = 1 + int(random.bits() % 6));
        for (std::size_t c = 0; c < count; ++c) m.cells.push_back(random.bits() % 2);
        std::string picture;
        for (int k = 0; k < m.size[2]; ++k, picture += '\n')
            for (int j = m.size[1]; j-- > 0; picture += '\n')
                for (int i = 0; i < m.size[0]; ++i) picture += m.at(i, j, k) ? '1' : '0';
        const auto back = read(picture);
        CAPTURE(round, picture);
        CHECK(back.size == m.size);
        CHECK(back.cells == m.cells);
    }
}

TEST_CASE("a malformed void matrix is refused with its line") {
    CHECK_THAT(failure(""), Contains("m.txt"));
    CHECK_THAT(failure("# no cells\n\n"), Contains("m.txt"));
    CHECK_THAT(failure("01\n0x\n"), Contains("m.txt: line 2") && Contains("'x'"));
    CHECK_THAT(failure("0 0.5 1\n"), Contains("m.txt: line 1") && Contains("'.5'"));
    CHECK_THAT(failure("0 2\n"), Contains("line 1") && Contains("'2'"));
    CHECK_THAT(failure("01\n,\n"), Contains("line 2") && Contains("','"));
    CHECK_THAT(failure("011\n\n011\n01\n"),
               Contains("m.txt: line 4") && Contains("2 cells") && Contains("line 1 has 3"));
    CHECK_THAT(failure("01\n01\n\n01\n\n01\n01\n"),
               Contains("m.txt: line 4") && Contains("layer 2 has 1 rows"));
    CHECK_THROWS_AS(readVoidMatrix("/nowhere/m.txt"), IoError);
}
