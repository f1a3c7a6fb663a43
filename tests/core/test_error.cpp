#include "support/test.h"

#include <cerrno>
#include <new>
#include <system_error>

TEST_CASE("exceptions that mean too little memory or too few threads are recognized") {
    CHECK(isShortage(std::bad_alloc()));
    CHECK(isShortage(ResourceError("")));
    CHECK(isShortage(std::system_error(EAGAIN, std::generic_category())));
    CHECK(isShortage(std::runtime_error("pthread_create has failed: Resource temporarily ...")));
    CHECK_FALSE(isShortage(std::runtime_error("TBB Warning")));
    CHECK_FALSE(isShortage(std::system_error(ENOENT, std::generic_category())));
    CHECK_FALSE(isShortage(InputError("no spheres")));
}
