#include "support/test.h"

#include "vdbpack/core/count.h"

TEST_CASE("counts beyond 32 bits are refused with their number, and never wrapped") {
    CHECK(indexable(0, "spheres", "") == 0);
    CHECK(indexable(0xfffffffeull, "spheres", "") == 0xfffffffeu);
    for (const std::uint64_t count : {0xffffffffull, 0x100000000ull, 0xffffffffffffffffull}) {
        CHECK_THROWS_AS(indexable(count, "spheres", "split the pack"), ResourceError);
        CHECK_THROWS_WITH(indexable(count, "spheres", "split the pack"),
                          Contains(std::to_string(count) + " spheres are more than 4294967294") &&
                              Contains("split the pack"));
    }
}
