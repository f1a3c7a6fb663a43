// Files cut short, with flipped bits or with numbers that lie must give an error or a pack, never
// a crash, and in no time.
#include "formats/lattice_pack.h"
#include "support/flipped_bits.h"
#include "support/test.h"

#include "vdbpack/formats/pack_file.h"

#include <cstring>

namespace {

const char* const kFormats[] = {"vdb", "vtp", "csv", "ply", "yade", "xyz", "npz", "lammps"};

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

/// A small pack in a file.
struct WrittenPack {
    const std::string format;
    const TemporaryFolder scratch;
    const std::string path = scratch.file("p.dat");
    std::string whole;

    explicit WrittenPack(std::string formatName) : format(std::move(formatName)) {
        if (format == "dump")  // is not written
            putContent(path,
                       "ITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp "
                       "ff\n-1 1\n-1 1\n-1 1\nITEM: ATOMS id type x y z radius\n7 1 1 2 3 0.5\n4 "
                       "3 4 5 -6 1\n");
        else
            writePack(smallPack(), prefixed(format, path), {});
        whole = contentOf(path);
    }
    bool isReadable() const { return reads(prefixed(format, path)); }
};

}  // namespace

TEST_CASE("a file cut short at any byte is an error or a shorter pack") {
    const WrittenPack file(GENERATE(from_range(std::begin(kFormats), std::end(kFormats))));
    CAPTURE(file.format);
    REQUIRE(file.isReadable());
    // Text cannot tell a cut between two lines, or within the last number; the others announce what
    // they hold. What follows the last sphere of a .vdb does not matter, nor the last line break of
    // a .vtp.
    std::size_t readable = 0;
    for (std::size_t size = file.whole.size(); size-- > 0;) {
        CAPTURE(size);
        std::filesystem::resize_file(file.path, size);
        readable += file.isReadable() ? 1 : 0;
    }
    if (file.format == "ply" || file.format == "npz") REQUIRE(readable == 0);
    if (file.format == "vtp") REQUIRE(readable == 1);
    if (file.format == "vdb") REQUIRE(readable < 260);
}

TEST_CASE("a file with flipped bits is an error or another pack") {
    const WrittenPack file(GENERATE(as<std::string>{}, "vdb", "vtp", "csv", "ply", "yade", "xyz",
                                    "npz", "lammps", "dump"));
    CAPTURE(file.format);
    RandomStream random(22, 1);
    for (int trial = 0; trial < 500; ++trial) {
        CAPTURE(trial);
        putContent(file.path, withFlippedBits(file.whole, 1 + trial % 4, random));
        if (!file.isReadable() || file.format != "npz") continue;
        // Names and sizes of the directory bear no checksum; numbers do.
        CHECK(readPack("npz:" + file.path).spheres == smallPack().spheres);
    }
}

TEST_CASE("one format under the name of another is refused") {
    const TemporaryFolder scratch;
    const std::string path = scratch.file("p.dat");
    for (const std::string written : kFormats) {
        writePack(smallPack(), prefixed(written, path), {});
        for (const std::string read : kFormats) {
            CAPTURE(written, read);
            if (written != read) REQUIRE_THROWS_AS(readPack(prefixed(read, path)), InputError);
        }
        REQUIRE_THROWS_AS(readPack(prefixed("dump", path)), InputError);
    }
}

TEST_CASE("a folder or a missing file is an IoError in every format") {
    const TemporaryFolder scratch;
    for (const std::string format :
         {"vdb", "vtp", "csv", "ply", "yade", "xyz", "npz", "lammps", "dump"}) {
        CAPTURE(format);
        REQUIRE_THROWS_AS(readPack(prefixed(format, scratch.file(""))), IoError);
        REQUIRE_THROWS_AS(readPack(prefixed(format, scratch.file("none"))), IoError);
    }
}

TEST_CASE("an empty file is an error, except a list that may be empty") {
    const TemporaryFolder scratch;
    const std::string path = scratch.file("p.dat");
    for (const std::string content : {"", "\n", "\n\n \n", "\xef\xbb\xbf"}) {
        putContent(path, content);
        for (const std::string format :
             {"vdb", "vtp", "csv", "ply", "xyz", "npz", "lammps", "dump"}) {
            CAPTURE(format, content);
            REQUIRE_THROWS_AS(readPack(prefixed(format, path)), InputError);
        }
    }
    putContent(path, "");
    REQUIRE(readPack(prefixed("yade", path)).spheres.empty());
}

namespace {

/// A file of one sphere with a number of it left open.
struct Open {
    const char* format;
    const char* before;
    const char* after;

    std::string with(const std::string& number) const { return before + number + after; }
};

/// Left open is how many spheres there are.
const Open kCounts[] = {
    {"ply", "ply\nformat ascii 1.0\nelement vertex ",
     "\nproperty float x\nproperty float y\nproperty float z\nproperty float radius\nend_header\n"
     "1 2 3 4\n"},
    {"ply", "ply\nformat binary_big_endian 1.0\nelement vertex ",
     "\nproperty char x\nproperty char y\nproperty char z\nproperty char radius\nend_header\n"
     "\1\2\3\4"},
    {"ply", "ply\nformat binary_little_endian 1.0\nelement other ",
     "\nproperty list char double l\nelement vertex 1\nproperty char x\nproperty char y\n"
     "property char z\nproperty char radius\nend_header\n\1\2\3\4"},
    {"xyz", "", "\nProperties=pos:R:3:radius:R:1\n0 0 0 1\n"},
    {"lammps", "title\n\n", " atoms\n\nAtoms # sphere\n\n1 1 1 1 0 0 0\n"},
    {"dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n",
     "\nITEM: ATOMS id x y z radius\n1 0 0 0 1\n"},
    {"vtp", "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"",
     "\"><PointData><DataArray type=\"Float32\" Name=\"radius\" format=\"ascii\">1</DataArray>"
     "</PointData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 "
     "0 "
     "0</DataArray></Points></Piece></PolyData></VTKFile>"}};

/// Left open is a coordinate.
const Open kCoordinates[] = {
    {"csv", "x,y,z,radius\n0,", ",0,1\n"},
    {"yade", "0\t", "\t0\t1\n"},
    {"xyz", "1\nProperties=pos:R:3:radius:R:1\n0 ", " 0 1\n"},
    {"ply",
     "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
     "z\nproperty float radius\nend_header\n1 ",
     " 3 4\n"},
    {"lammps", "title\n\n1 atoms\n\nAtoms # sphere\n\n1 1 1 1 0 ", " 0\n"},
    {"dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id x y z radius\n1 0 ",
     " 0 1\n"},
    {"vtp",
     "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"1\"><PointData><DataArray "
     "type=\"Float32\" Name=\"radius\" "
     "format=\"ascii\">1</DataArray></PointData><Points><DataArray "
     "type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 ",
     " 0</DataArray></Points></Piece></PolyData></VTKFile>"}};

/// Each of these numbers in the open place makes the file an InputError.
void requireRefused(const Open& open, const std::vector<std::string>& numbers) {
    const TemporaryFolder scratch;
    const std::string path = scratch.file("p.dat"), file = prefixed(open.format, path);
    for (const std::string& number : numbers) {
        CAPTURE(open.format, number);
        putContent(path, open.with(number));
        REQUIRE_THROWS_AS(readPack(file), InputError);
    }
}

}  // namespace

TEST_CASE("counts that no file of its size can hold are refused") {
    for (const Open& open : kCounts)
        requireRefused(open,
                       {"10000000000", "-1", "-9223372036854775808", "9223372036854775807",
                        "9223372036854775808", "18446744073709551615", "1e18", "1e999", "nan", ""});
}

TEST_CASE("coordinates that are not finite are refused with their place") {
    for (const Open& open : kCoordinates) {
        const TemporaryFolder scratch;
        const std::string path = scratch.file("p.dat");
        putContent(path, open.with("2"));
        REQUIRE(readPack(prefixed(open.format, path)).spheres.size() == 1);
        requireRefused(open, {"nan", "-nan", "inf", "-inf", "1e999", "0x1p3", "1,5"});
    }
}

TEST_CASE("tags of a .vtp may nest without end") {
    const TemporaryFolder scratch;
    const std::string path = scratch.file("p.vtp");
    std::string content = "<VTKFile type=\"PolyData\">";
    for (int i = 0; i < 200000; ++i) content += "<PolyData>";
    putContent(path, content);
    REQUIRE_THROWS_AS(readPack(path), InputError);
}

TEST_CASE("a .vtp of nothing but tags is refused before they take memory") {
    const TemporaryFolder scratch;
    const std::string path = scratch.file("p.vtp");
    std::string content = "<VTKFile type=\"PolyData\"><PolyData>";
    for (int i = 0; i < 1100000; ++i) content += "<a/>";
    putContent(path, content + "</PolyData></VTKFile>");
    REQUIRE_THAT(messageOf<InputError>([&] { readPack(path); }), Contains("tags"));
}

TEST_CASE("members of an .npz that share their bytes are refused") {
    const TemporaryFolder scratch;
    const std::string path = scratch.file("p.npz");
    writePack(smallPack(), path, {});
    std::string content = contentOf(path);
    // The directory, listed twenty times over; what ends the archive tells its size and counts.
    const std::size_t begin = content.find("PK\1\2"), end = content.find("PK\6\6");
    REQUIRE(begin < end);
    REQUIRE(end != std::string::npos);
    constexpr std::uint64_t kTimes = 20;
    const std::string directory = content.substr(begin, end - begin);
    for (std::uint64_t i = 1; i < kTimes; ++i) content.insert(end, directory);
    const std::uint64_t added = (kTimes - 1) * directory.size();
    const auto change = [&content, place = end + added](std::size_t at, std::uint64_t factor,
                                                        std::uint64_t more) {
        std::uint64_t value = 0;
        std::memcpy(&value, content.data() + place + at, sizeof value);
        value = value * factor + more;
        std::memcpy(content.data() + place + at, &value, sizeof value);
    };
    for (const std::size_t at : {24, 32, 40}) change(at, kTimes, 0);
    change(56 + 8, 1, added);
    putContent(path, content);
    REQUIRE_THAT(messageOf<InputError>([&] { readPack(path); }), Contains(path));
}

TEST_CASE("arrays of a .vtp that share their bytes are refused") {
    const TemporaryFolder scratch;
    const std::string path = scratch.file("p.vtp");
    constexpr std::size_t kPoints = 100, kArrays = 50;
    const auto file = [](std::size_t arrays) {
        std::string text =
            "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" "
            "header_type=\"UInt64\"><PolyData>"
            "<Piece NumberOfPoints=\"100\"><PointData>";
        for (std::size_t a = 0; a < arrays; ++a)
            text += "<DataArray type=\"Float64\" Name=\"" +
                    (a == 0 ? std::string("radius") : "a" + std::to_string(a)) +
                    "\" format=\"appended\" offset=\"0\"/>";
        text +=
            "</PointData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
            "format=\"appended\" offset=\"808\"/></Points></Piece></PolyData><AppendedData "
            "encoding=\"raw\">_";
        for (const std::size_t numbers : {kPoints, 3 * kPoints}) {
            const std::uint64_t bytes = 8 * numbers;
            text.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
            const double one = 1;
            for (std::size_t i = 0; i < numbers; ++i)
                text.append(reinterpret_cast<const char*>(&one), sizeof one);
        }
        return text + "</AppendedData></VTKFile>";
    };
    putContent(path, file(1));
    REQUIRE(readPack(path).spheres.size() == kPoints);
    putContent(path, file(kArrays));
    REQUIRE_THAT(messageOf<InputError>([&] { readPack(path); }), Contains(path));
}

TEST_CASE("an .xyz that announces more columns than follow is refused") {
    const TemporaryFolder scratch;
    const std::string path = scratch.file("p.xyz");
    std::string content = "1\nProperties=pos:R:3:radius:R:1";
    for (int i = 0; i < 2000; ++i) content += ":c" + std::to_string(i) + ":R:1000";
    putContent(path, content + "\n0 0 0 1\n");
    REQUIRE_THROWS_AS(readPack(path), InputError);
}
