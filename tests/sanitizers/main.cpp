// Tests under the thread sanitizer: four threads wherever a test asks for no number of its own.
#define CATCH_CONFIG_RUNNER
#include "vdbpack/core/parallel.h"

#include <catch2/catch.hpp>

int main(int argc, char** argv) {
    // Of several limits TBB takes the lowest: this one must not bind tests that ask for more.
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 64);
    tbb::task_arena arena(4);
    return arena.execute([&] { return Catch::Session().run(argc, argv); });
}
