#include "vdbpack/core/error.h"

#include <catch2/catch.hpp>

#include <cerrno>
#include <new>
#include <stdexcept>
#include <system_error>

using namespace vdbpack;

TEST_CASE("exceptions that mean too little memory or too few threads are recognized", "[error]") {
    CHECK(isShortage(std::bad_alloc()));
    CHECK(isShortage(ResourceError("")));
    CHECK(isShortage(std::system_error(EAGAIN, std::generic_category())));
    CHECK(isShortage(std::runtime_error("pthread_create has failed: Resource temporarily ...")));
    CHECK_FALSE(isShortage(std::runtime_error("TBB Warning")));
    CHECK_FALSE(isShortage(std::system_error(ENOENT, std::generic_category())));
    CHECK_FALSE(isShortage(InputError("no spheres")));
}
