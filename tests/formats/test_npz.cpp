// numpy's .npz: what we write, what numpy writes, and what is broken.
#include "formats/foreign.h"
#include "formats/lattice_pack.h"

#include <catch2/catch.hpp>

#include <cstdint>
#include <string>
#include <vector>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;

namespace {

Pack<3> packOfAll(std::size_t count) {
    auto pack = latticePack<3>(count, {{60, -700, 3}}, 40, 5);
    Column numbers, texts;
    numbers.name = "modulus/GPa";
    texts.name = "Körper";
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        pack.id.push_back(static_cast<std::int64_t>(2 * i + 1));
        numbers.numbers.push_back(static_cast<double>(i) / 3);
        texts.texts.push_back(i % 2 ? "größer, \xf0\x9f\xa6\xb4" : "");
    }
    pack.columns = {numbers, texts};
    return pack;
}

std::string written(const Pack<3>& pack, const PackWriteOptions& options = {}) {
    const TemporaryFolder scratch;
    writePack(pack, scratch.file("p.npz"), options);
    return contentOf(scratch.file("p.npz"));
}

}  // namespace

TEST_CASE("an .npz file gives back the same pack", "[export]") {
    const auto pack = packOfAll(GENERATE(0u, 1u, 500u));
    const auto read = readText("p.npz", written(pack));
    REQUIRE(read.spheres == pack.spheres);
    requireSameAttributes(read, pack);
    if (pack.spheres.empty()) return;
    REQUIRE(read.columns.size() == 2);
    REQUIRE(read.columns[0].name == "modulus_GPa");
    REQUIRE(read.columns[0].numbers == pack.columns[0].numbers);
    REQUIRE(read.columns[1].name == "Körper");
    REQUIRE(read.columns[1].texts == pack.columns[1].texts);
}

TEST_CASE("an .npz file records its unit, and its arrays begin where numpy maps them", "[export]") {
    Pack<3> pack;
    pack.spheres = {{{{1, 2, 3}}, 0.5}};
    PackWriteOptions options;
    options.unit = Unit::meter;
    const auto bytes = written(pack, options);
    REQUIRE(readText("p.npz", bytes).spheres == pack.spheres);
    REQUIRE_THAT(bytes, Contains("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 3), }"));
    REQUIRE(bytes == written(pack, options));
}

TEST_CASE("an .npz file that is cut short or damaged is an error or the same pack", "[export]") {
    const auto bytes = written(packOfAll(3));
    const auto whole = readText("p.npz", bytes).spheres;
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        CAPTURE(size);
        REQUIRE_FALSE(errorOf("p.npz", bytes.substr(0, size)).empty());
    }
    RandomStream random(3, 1);
    for (int trial = 0; trial < 2000; ++trial) {
        CAPTURE(trial);
        auto damaged = bytes;
        damaged[random.bits() % damaged.size()] ^= static_cast<char>(1 << (random.bits() % 8));
        // Names and sizes of the directory bear no checksum; numbers do.
        CHECK_NOTHROW(errorOf("p.npz", damaged));
    }
}

TEST_CASE("arrays that are missing are named with those that are there", "[export]") {
    auto bytes = written(packOfAll(2));
    for (std::size_t at = bytes.find("radii"); at != std::string::npos; at = bytes.find("radii"))
        bytes.replace(at, 5, "ridii");
    REQUIRE_THAT(errorOf("p.npz", bytes), Contains("positions (N, 3)") && Contains("ridii"));
    REQUIRE_THAT(errorOf("p.npz", "not a zip"), Contains("zip archive"));
}
