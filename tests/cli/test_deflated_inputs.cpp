// Packs whose deflated arrays would fill the memory.
#include "formats/file_text.h"
#include "support/limited_tool.h"
#include "support/test.h"

#include "vdbpack/io/text.h"

#include <zlib.h>

namespace {

constexpr std::size_t kMebi = std::size_t{1} << 20;
/// Of memory that a run may reach which inflates none of the arrays.
constexpr double kQuiet = 120 * kMebi;
constexpr std::size_t kBombMebibytes = 399, kThird = kBombMebibytes / 3;

/// One array of repeated bytes, deflated.
struct Deflated {
    std::string bytes;
    std::uint64_t size = 0;
    uLong checksum = 0;
};

std::string deflatedPart(const std::string& bytes, int windowBits, int flush) {
    z_stream stream{};
    REQUIRE(::deflateInit2(&stream, 1, Z_DEFLATED, windowBits, 8, Z_DEFAULT_STRATEGY) == Z_OK);
    std::string out(::deflateBound(&stream, static_cast<uLong>(bytes.size())) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    ::deflate(&stream, flush);
    out.resize(stream.total_out);
    ::deflateEnd(&stream);
    return out;
}

uLong checksumOf(const std::string& bytes) {
    return ::crc32(0, reinterpret_cast<const Bytef*>(bytes.data()),
                   static_cast<uInt>(bytes.size()));
}

/// `begin`, then `mebibytes` of zeros: each mebibyte is the same deflated bytes again.
Deflated deflatedZeros(const std::string& begin, std::size_t mebibytes) {
    const std::string zeros(kMebi, '\0');
    const std::string part = deflatedPart(zeros, -15, Z_FULL_FLUSH);
    const uLong checksum = checksumOf(zeros);
    Deflated all{deflatedPart(begin, -15, Z_FULL_FLUSH), begin.size() + mebibytes * kMebi,
                 checksumOf(begin)};
    for (std::size_t i = 0; i < mebibytes; ++i) {
        all.bytes += part;
        all.checksum = ::crc32_combine(all.checksum, checksum, kMebi);
    }
    all.bytes += deflatedPart("", -15, Z_FINISH);
    return all;
}

/// How a .npy array of doubles begins.
std::string npyHeader(const std::string& shape) {
    std::string text = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + shape + "), }";
    text.resize(118 - 1, ' ');
    text += '\n';
    return std::string("\x93NUMPY\x01\x00", 8) +
           bytesOf<std::uint16_t>({static_cast<std::uint16_t>(text.size())}) + text;
}

Deflated npyArray(const std::string& shape, const std::vector<double>& numbers) {
    const std::string bytes = npyHeader(shape) + bytesOf(numbers);
    return {deflatedPart(bytes, -15, Z_FINISH), bytes.size(), checksumOf(bytes)};
}

/// An archive of these members, by name.
std::string zipOf(const std::vector<std::pair<std::string, Deflated>>& members) {
    const auto word = [](std::size_t n) {
        return bytesOf<std::uint32_t>({static_cast<std::uint32_t>(n)});
    };
    const auto half = [](std::size_t n) {
        return bytesOf<std::uint16_t>({static_cast<std::uint16_t>(n)});
    };
    std::string text, directory;
    const std::string method = bytesOf<std::uint16_t>({20, 0, 8, 0, 0x21});
    for (const auto& [name, member] : members) {
        const std::string sizes = word(member.checksum) + word(member.bytes.size()) +
                                  word(member.size) + half(name.size()) + half(0);
        directory += std::string("PK\1\2", 4) + half(20) + method + sizes + std::string(10, '\0') +
                     word(text.size()) + name;
        text += std::string("PK\3\4", 4) + method + sizes + name + member.bytes;
    }
    return text + directory + std::string("PK\5\6", 4) + half(0) + half(0) + half(members.size()) +
           half(members.size()) + word(directory.size()) + word(text.size()) + half(0);
}

/// A .vtp of zeros, deflated, as radii, and as positions where `points` do not stand in plain text.
std::string vtpText(std::uint64_t points, std::size_t radiusMebibytes,
                    std::size_t positionMebibytes) {
    const std::string block = deflatedPart(std::string(kMebi, '\0'), 15, Z_FINISH);
    std::string appended;
    const auto array = [&](const std::string& attributes, std::size_t mebibytes) {
        const std::string tag = "<DataArray type=\"Float64\" " + attributes +
                                " format=\"appended\" offset=\"" + std::to_string(appended.size()) +
                                "\"/>";
        appended += bytesOf<std::uint64_t>({mebibytes, kMebi, 0});
        for (std::size_t b = 0; b < mebibytes; ++b)
            appended += bytesOf<std::uint64_t>({block.size()});
        for (std::size_t b = 0; b < mebibytes; ++b) appended += block;
        return tag;
    };
    const std::string radii = array("Name=\"radius\"", radiusMebibytes);
    std::string positions =
        "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">";
    for (std::uint64_t i = 0; positionMebibytes == 0 && i < points; ++i) positions += "0 0 0\n";
    positions += "</DataArray>";
    if (positionMebibytes > 0) positions = array("NumberOfComponents=\"3\"", positionMebibytes);
    return "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" header_type=\"UInt64\" "
           "compressor=\"vtkZLibDataCompressor\"><PolyData><Piece NumberOfPoints=\"" +
           std::to_string(points) + "\"><PointData>" + radii + "</PointData><Points>" + positions +
           "</Points></Piece></PolyData><AppendedData encoding=\"raw\">_" + appended +
           "</AppendedData></VTKFile>";
}

Measured converted(const std::string& file, const TemporaryFolder& scratch) {
    return vdbPackWithin(
        60, {"convert", file, "-o", scratch.file("out.csv"), "--memory-limit", "200M"});
}

}  // namespace

TEST_CASE("arrays that would fill the memory are refused or left out uninflated") {
    const std::string rows = std::to_string(kThird * kMebi / 8);
    const std::string image = npyHeader(std::to_string(kBombMebibytes * kMebi / 8) + ",");
    const Deflated positions = npyArray("2, 3", {1, 2, 3, 4, 5, 6}), radii = npyArray("2,", {1, 2});
    struct Bomb {
        const char* what;
        std::string name, content;
        int code;
        const char* fact;
    };
    const Bomb bombs[] = {
        {"an array larger than its points take", "p.vtp", vtpText(4, kBombMebibytes, 0), 3,
         "radius"},
        {"beyond the limit on memory", "p.vtp", vtpText(kThird * kMebi / 8, kThird, kBombMebibytes),
         5, "--memory-limit"},
        {"an array that a pack has no use for", "p.npz",
         zipOf({{"image.npy", deflatedZeros(image, kBombMebibytes)},
                {"positions.npy", positions},
                {"radii.npy", radii}}),
         0, ""},
        // Positions of 24 bytes and radii of 8.
        {"beyond the limit on memory", "p.npz",
         zipOf({{"positions.npy", deflatedZeros(npyHeader(rows + ", 3"), 3 * kThird)},
                {"radii.npy", deflatedZeros(npyHeader(rows + ","), kThird)}}),
         5, "--memory-limit"},
        {"an array that holds more than its shape", "p.npz",
         zipOf({{"positions.npy", deflatedZeros(npyHeader("2, 3"), kBombMebibytes)},
                {"radii.npy", radii}}),
         3, "positions"}};
    for (const Bomb& bomb : bombs) {
        const TemporaryFolder scratch;
        const std::string file = scratch.file(bomb.name);
        putContent(file, bomb.content);
        const auto run = converted(file, scratch);
        CAPTURE(bomb.what, bomb.name, run.text);
        CHECK(run.code == bomb.code);
        CHECK(run.peakBytes < kQuiet);
        if (bomb.code != 0) CHECK_THAT(run.text, Contains(file) && Contains(bomb.fact));
        if (bomb.code == 0)
            CHECK(readPack(scratch.file("out.csv")).spheres ==
                  std::vector<Sphere<3>>{{{{1, 2, 3}}, 1}, {{{4, 5, 6}}, 2}});
    }
}

TEST_CASE("what a damaged file holds reaches the terminal as text") {
    const TemporaryFolder scratch;
    std::string bytes;
    for (int i = 1; i < 256; ++i) bytes += static_cast<char>(i == '\n' ? 0x9b : i);
    for (const char* name : {"p.csv", "p.xyz", "p.ply", "p.data", "p.vtp", "p.npz", "p.vdb"}) {
        CAPTURE(name);
        putContent(scratch.file(name), bytes);
        const auto run = converted(scratch.file(name), scratch);
        CHECK(run.code == 3);
        CHECK(run.text.size() < 1000);
        CHECK(printable(run.text) == run.text);
    }
}
