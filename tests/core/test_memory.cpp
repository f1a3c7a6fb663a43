#include "support/test.h"

#include "vdbpack/core/memory.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/pack/packer.h"

TEST_CASE("sizes of memory are reported in numbers of three digits") {
    CHECK(bytesText(12.0 * 1024) == "12 KiB");
    CHECK(bytesText(820.0 * (1 << 20)) == "820 MiB");
    CHECK(bytesText(1.5 * (1 << 30)) == "1.5 GiB");
    CHECK(bytesText(1023.0 * 1024) == "0.999 MiB");
    CHECK(bytesText(2.0 * (1 << 20)) == "2 MiB");
    CHECK(bytesText(1e30) == "9.09e+17 TiB");
}

TEST_CASE("what there is of memory and space is reported") {
    CHECK(residentMemory() > 1e6);
    CHECK(residentMemory() < 1e12);
    CHECK(availableMemory() > 0);
    CHECK(availableSpace("/tmp/p.csv") > 0);
    CHECK(availableSpace("/nowhere/at/all/p.csv") == std::numeric_limits<double>::infinity());
}

TEST_CASE("what may be cancelled is stopped beyond a limit of memory") {
    CHECK_THROWS_AS(withinMemory({}, 1).cancelled(), ResourceError);
    CHECK_FALSE(withinMemory({}, 1e15).cancelled());
    Callbacks asked;
    asked.cancelled = [] { return true; };
    CHECK(withinMemory(asked, 1e15).cancelled());
    // Out of the blocks of a pack, on any number of threads.
    const auto domain = boxDomain<3>(Box<3>{{{0, 0, 0}}, {{60, 60, 60}}});
    for (const int threads : {1, 4}) {
        PackOptions options(SizeDistribution::parse("constant:1", 3));
        options.threads = threads;
        CHECK_THROWS_WITH(packSpheres(*domain, options, withinMemory({}, 1), {}),
                          Contains("are allowed") && Contains("memoryLimit"));
    }
}
