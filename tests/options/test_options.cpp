// The table of options: names in messages, values, words that are alike.
#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/io/suggest.h"
#include "vdbpack/options/command_line.h"
#include "vdbpack/options/jobs.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

using namespace vdbpack;

TEST_CASE("a parameter in backquotes is shown as its option", "[options]") {
    CHECK(withOptionNames("raise `memoryLimit`, or give a larger `voids.voxelSize`") ==
          "raise --memory-limit, or give a larger --void-voxel");
    CHECK(withOptionNames("`radius` 'x`': bad") == "--radius 'x`': bad");
}

TEST_CASE("other backquotes stay as they are", "[options]") {
    for (const char* text : {"", "`", "``", "a`b", "`no such field`", "`x` y`", "plain"}) {
        CAPTURE(text);
        CHECK(withOptionNames(text) == text);
    }
    CHECK(withOptionNames("a`b, and `seed`") == "a`b, and --seed");
}

TEST_CASE("seeds are numbers, ranges and lists", "[options]") {
    using Seeds = std::vector<std::uint64_t>;
    CHECK(parseSeeds("7") == Seeds{7});
    CHECK(parseSeeds("1..4") == Seeds{1, 2, 3, 4});
    CHECK(parseSeeds("9,1..2,5..5") == Seeds{9, 1, 2, 5});
    CHECK(parseSeeds("18446744073709551615").front() == ~std::uint64_t{0});
    for (const char* text : {"", "-1", "1..", "..3", "4..2", "1,,2", "1.5", "x", "1..5000000",
                             "99999999999999999999", "1 2", "1,", "1,2,1", "1..5,3"}) {
        CAPTURE(text);
        CHECK_THROWS_AS(parseSeeds(text), ParameterError);
    }
}

TEST_CASE("columns of a pack are named in order, or some by their names", "[options]") {
    const auto columnsOf = [](const std::string& text) {
        return std::get<MeasureRecipe>(jobOf({"measure", "p.csv", "--columns", text})).packColumns;
    };
    CHECK(columnsOf("x, y,z,r").inOrder == std::vector<std::string>{"x", "y", "z", "r"});
    const auto renamed = columnsOf("x [m]=Pos East,diameter=size").renamed;
    REQUIRE(renamed.size() == 2);
    CHECK(renamed[0] == std::pair<std::string, std::string>("x [m]", "Pos East"));
    for (const char* text : {"x,,y", "x=", "=x", "x,y=b", ","}) {
        CAPTURE(text);
        CHECK_THROWS(columnsOf(text));
    }
}

TEST_CASE("distances of words are those of their letters", "[options]") {
    CHECK(editDistance("", "") == 0);
    CHECK(editDistance("", "abc") == 3);
    CHECK(editDistance("radius", "radius") == 0);
    CHECK(editDistance("raduis", "radius") == 1);  // neighbors swapped
    CHECK(editDistance("kitten", "sitting") == 3);
    CHECK(editDistance("sitting", "kitten") == 3);
    CHECK(mostLike("--raduis", {"--seed", "--radius"}) == "--radius");
    CHECK(mostLike("--vox", {"--seed", "--voxel"}) == "--voxel");
    CHECK(mostLike("--thickness", {"--seed", "--radius"}) == "");
    CHECK(similarWord("vertebrae_l3", {"hip_left", "vertebrae_L3"}) ==
          " (did you mean vertebrae_L3?)");
    CHECK(similarWord("skull", {"hip_left", "vertebrae_L3"}).empty());
}

TEST_CASE("a page names the options that differ from their defaults, once", "[options]") {
    PackJob job;
    job.domain.source = "ball:3";
    job.packing.blockSide = 40;
    job.request.method = "boolean";
    job.domain.clips = {parseClip("plane:1,0,0,1"), parseClip("plane:0,1,0,1")};
    const auto given = givenOptions(job);
    using Row = std::pair<std::string, std::string>;
    const auto count = [&](const Row& row) { return std::count(given.begin(), given.end(), row); };
    CHECK(count({"DOMAIN", "ball:3"}) == 1);
    CHECK(count({"--block-side", "40 mm"}) == 1);
    CHECK(count({"--voids", "boolean"}) == 1);
    CHECK(count({"--clip", "plane:1,0,0,1"}) == 1);
    CHECK(count({"--clip", "plane:0,1,0,1"}) == 1);
    for (const char* usual : {"--gap", "--effort", "--unit"})
        CHECK(std::none_of(given.begin(), given.end(),
                           [&](const Row& row) { return row.first == usual; }));
}
