// numpy's .npz: what we write, what numpy writes, and what is broken.
#include "formats/file_text.h"
#include "formats/lattice_pack.h"
#include "support/test.h"

namespace {

Pack<3> packOfAll(std::size_t count) {
    return packWithColumns(count, "modulus/GPa", "Körper", {"", "größer, \xf0\x9f\xa6\xb4"});
}

std::string written(const Pack<3>& pack, const PackWriteOptions& options = {}) {
    return writtenText(pack, "p.npz", options);
}

}  // namespace

TEST_CASE("an .npz file records its unit, and its arrays begin where numpy maps them") {
    Pack<3> pack;
    pack.spheres = {{{{1, 2, 3}}, 0.5}};
    PackWriteOptions options;
    options.unit = Unit::meter;
    const auto bytes = written(pack, options);
    REQUIRE(readText("p.npz", bytes).spheres == pack.spheres);
    REQUIRE_THAT(bytes, Contains("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 3), }"));
    REQUIRE_THAT(written(packOfAll(2)), Contains("modulus_GPa.npy"));
    REQUIRE(bytes == written(pack, options));
}

TEST_CASE("arrays that are missing are named with those that are there") {
    auto bytes = written(packOfAll(2));
    for (std::size_t at = bytes.find("radii"); at != std::string::npos; at = bytes.find("radii"))
        bytes.replace(at, 5, "ridii");
    REQUIRE_THAT(errorOf("p.npz", bytes), Contains("positions (N, 3)") && Contains("ridii"));
    REQUIRE_THAT(errorOf("p.npz", "not a zip"), Contains("p.npz"));
}

TEST_CASE("an archive that announces more than it holds is refused") {
    const auto whole = written(packOfAll(4));
    const auto changed = [&whole](const char* record, std::size_t at, std::uint64_t value,
                                  std::size_t bytes) {
        auto content = whole;
        const auto begin = content.rfind(std::string(record, 4));
        REQUIRE(begin != std::string::npos);
        for (std::size_t k = 0; k < bytes; ++k)
            content[begin + at + k] =
                static_cast<char>(static_cast<unsigned char>(value >> (8 * k)));
        return content;
    };
    constexpr std::uint64_t kHuge = std::uint64_t{1} << 60;
    // Members in the archive, bytes of its directory, begin of the directory.
    for (const std::size_t at : {24, 32, 40, 48}) {
        CAPTURE(at);
        REQUIRE(errorOf("p.npz", changed("PK\6\6", at, kHuge, 8)) != "");
    }
    // The last member: its size beside its packed size, in the extension after its name.
    const auto entry = whole.rfind("PK\1\2");
    const auto name = static_cast<std::size_t>(static_cast<unsigned char>(whole[entry + 28]));
    for (const std::size_t field : {0, 8, 16}) {
        CAPTURE(field);
        REQUIRE(errorOf("p.npz", changed("PK\1\2", 46 + name + 4 + field, kHuge, 8)) != "");
    }
    REQUIRE_THAT(errorOf("p.npz", changed("PK\1\2", 10, 12, 2)), Contains("method 12"));
    REQUIRE_THAT(errorOf("p.npz", changed("PK\1\2", 8, 0x801, 2)), Contains("encrypted"));
}
