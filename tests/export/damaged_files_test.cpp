// Files cut short or with flipped bits must give an error or a pack, never a crash.
#include "export/scratch.h"

#include "vdbpack/core/error.h"
#include "vdbpack/export/pack_file.h"

#include <filesystem>
#include <string>

using namespace vdbpack;

namespace {

const char* const kFormats[] = {"vdb", "vtp", "csv", "ply", "yade"};

std::string prefixed(const std::string& format, const std::string& path) {
    return format + ":" + path;
}

Pack<3> smallPack() {
    // In one octant: OpenVDB's tree takes 300 kB for each that is touched.
    auto pack = latticePack<3>(4, {{9, 9, 9}}, 9, 21);
    pack.columns.push_back({"name", {}, std::vector<std::string>(4, "left, \"upper\"")});
    return pack;
}

/// Whether the file could be read; any error but ours escapes.
bool reads(const std::string& file) {
    try {
        readPack(file);
        return true;
    } catch (const InputError&) {
        return false;
    } catch (const ResourceError&) {
        return false;
    }
}

}  // namespace

TEST_CASE("a file cut short at any byte is an error or a shorter pack", "[export]") {
    const std::string format = GENERATE(from_range(std::begin(kFormats), std::end(kFormats)));
    CAPTURE(format);
    const Scratch scratch;
    const std::string path = scratch / "p.dat";
    writePack(smallPack(), prefixed(format, path), {});
    const std::string whole = contentOf(path);
    REQUIRE(reads(prefixed(format, path)));
    // Text cannot tell a cut between two lines; the others announce what they hold. What follows
    // the last sphere of a .vtp or .vdb does not matter.
    const bool announces = format == "ply" || format == "vdb" || format == "vtp";
    std::size_t readable = 0;
    for (std::size_t size = whole.size(); size-- > 0;) {
        CAPTURE(size);
        std::filesystem::resize_file(path, size);
        readable += reads(prefixed(format, path)) ? 1 : 0;
    }
    if (format == "ply") REQUIRE(readable == 0);
    if (announces) REQUIRE(readable < 260);
}

TEST_CASE("a file with flipped bits is an error or another pack", "[export]") {
    const std::string format = GENERATE(as<std::string>{}, "vtp", "csv", "ply", "yade");
    CAPTURE(format);
    const Scratch scratch;
    const std::string path = scratch / "p.dat";
    writePack(smallPack(), prefixed(format, path), {});
    const std::string whole = contentOf(path);
    RandomStream random(22, 1);
    for (int trial = 0; trial < 500; ++trial) {
        CAPTURE(trial);
        std::string damaged = whole;
        for (int flips = 0; flips < 1 + trial % 4; ++flips)
            damaged[random.bits() % damaged.size()] ^= static_cast<char>(1 << (random.bits() % 8));
        putContent(path, damaged);
        CHECK_NOTHROW(reads(prefixed(format, path)));
    }
}

TEST_CASE("one format under the name of another is refused", "[export]") {
    const Scratch scratch;
    const std::string path = scratch / "p.dat";
    for (const std::string written : kFormats) {
        writePack(smallPack(), prefixed(written, path), {});
        for (const std::string read : kFormats) {
            CAPTURE(written, read);
            if (written != read) REQUIRE_THROWS_AS(readPack(prefixed(read, path)), InputError);
        }
        for (const std::string read : {"lammps", "dump"}) {
            CAPTURE(written, read);
            REQUIRE_THROWS_AS(readPack(prefixed(read, path)), InputError);
        }
    }
}

TEST_CASE("a folder or a missing file is an IoError in every format", "[export]") {
    const Scratch scratch;
    for (const std::string format : {"vdb", "vtp", "csv", "ply", "yade", "lammps", "dump"}) {
        CAPTURE(format);
        REQUIRE_THROWS_AS(readPack(prefixed(format, scratch / "")), IoError);
        REQUIRE_THROWS_AS(readPack(prefixed(format, scratch / "none")), IoError);
    }
}
