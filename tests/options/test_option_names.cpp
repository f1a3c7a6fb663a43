// Parameters of the library under their names on the command line.
#include "vdbpack/options/jobs.h"

#include <catch2/catch.hpp>

using namespace vdbpack;

TEST_CASE("a parameter in backquotes is shown as its option", "[cli]") {
    CHECK(withOptionNames("raise `memoryLimit`, or give a larger `voids.voxelSize`") ==
          "raise --memory-limit, or give a larger --void-voxel");
    CHECK(withOptionNames("`radius` 'x`': bad") == "--radius 'x`': bad");
}

TEST_CASE("other backquotes stay as they are", "[cli]") {
    for (const char* text : {"", "`", "``", "a`b", "`no such field`", "`x` y`", "plain"}) {
        CAPTURE(text);
        CHECK(withOptionNames(text) == text);
    }
    CHECK(withOptionNames("a`b, and `seed`") == "a`b, and --seed");
}
