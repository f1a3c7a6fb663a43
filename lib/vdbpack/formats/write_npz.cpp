// numpy's .npz: a zip archive with one .npy array per member. Sources: numpy.lib.format, version 1;
// PKWARE's APPNOTE 6.3, with the 64-bit extension, as Python's zipfile writes it.
//
// Written without a library: members that are only stored take one pass and no temporary file, and
// the bytes do not depend on the version of a library or on the clock.
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/npy_array.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::uint32_t kLocal = 0x04034b50, kCentral = 0x02014b50, kEnd = 0x06054b50,
                        kEnd64 = 0x06064b50, kLocator64 = 0x07064b50;
constexpr std::uint64_t kIn64 = 0xffffffff;  // the number is in the 64-bit extension
constexpr std::uint16_t kExtra64 = 1;

void put16(std::string& bytes, std::uint64_t value) {
    appendLittleEndian(bytes, static_cast<std::uint16_t>(value));
}
void put32(std::string& bytes, std::uint64_t value) {
    appendLittleEndian(bytes, static_cast<std::uint32_t>(value));
}

std::uint32_t crcOf(const std::string& bytes) {
    return static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

/// An archive of members that are stored as they are. Sizes are always those of 64 bits, so that
/// large packs take no path of their own.
class Zip {
public:
    explicit Zip(OutputFile& out) : out_(out) {}

    void add(const std::string& name, const std::string& header, const std::string& data) {
        const std::string file = name + ".npy";
        const std::uint64_t size = header.size() + data.size();
        const auto crc = static_cast<std::uint32_t>(
            crc32_combine(crcOf(header), crcOf(data), static_cast<z_off_t>(data.size())));
        std::string common;       // of local and central header
        put16(common, 0x800);     // names in UTF-8
        put16(common, 0);         // stored
        put32(common, 0x210000);  // 1980-01-01: files do not depend on when they are written
        put32(common, crc);
        put32(common, kIn64);
        put32(common, kIn64);
        put16(common, file.size());
        std::string sizes;
        appendLittleEndian(sizes, size);
        appendLittleEndian(sizes, size);

        std::string local;
        put32(local, kLocal);
        put16(local, 45);
        local += common;
        put16(local, 20);
        local += file;
        put16(local, kExtra64);
        put16(local, 16);
        local += sizes;

        put32(directory_, kCentral);
        put16(directory_, 0x032d);  // made on Unix, by version 4.5
        put16(directory_, 45);
        directory_ += common;
        put16(directory_, 28);
        put16(directory_, 0);               // comment
        put16(directory_, 0);               // disk
        put16(directory_, 0);               // internal attributes
        put32(directory_, 0100644u << 16);  // an ordinary file
        put32(directory_, kIn64);
        directory_ += file;
        put16(directory_, kExtra64);
        put16(directory_, 24);
        directory_ += sizes;
        appendLittleEndian(directory_, offset_);

        out_.write(local);
        out_.write(header);
        out_.write(data);
        offset_ += local.size() + size;
        ++members_;
    }

    void finish() {
        std::string end;
        put32(end, kEnd64);
        appendLittleEndian(end, std::uint64_t{44});
        put16(end, 0x032d);
        put16(end, 45);
        put32(end, 0);
        put32(end, 0);
        appendLittleEndian(end, members_);
        appendLittleEndian(end, members_);
        appendLittleEndian(end, static_cast<std::uint64_t>(directory_.size()));
        appendLittleEndian(end, offset_);
        put32(end, kLocator64);
        put32(end, 0);
        appendLittleEndian(end, offset_ + directory_.size());
        put32(end, 1);
        put32(end, kEnd);
        put32(end, 0);
        put16(end, 0xffff);
        put16(end, 0xffff);
        put32(end, kIn64);
        put32(end, kIn64);
        put16(end, 0);
        out_.write(directory_);
        out_.write(end);
    }

private:
    OutputFile& out_;
    std::string directory_;
    std::uint64_t offset_ = 0, members_ = 0;
};

/// The header of an array: `descr` as numpy writes it, `shape` such as "(3, 2)".
std::string arrayHeader(const std::string& descr, const std::string& shape) {
    std::string dict =
        fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", descr, shape);
    // Data begins at a multiple of 64 bytes.
    while ((10 + dict.size() + 1) % 64 != 0) dict += ' ';
    dict += '\n';
    std::string header = kNpyMagic;
    header += '\x01';
    header += '\0';
    put16(header, dict.size());
    return header + dict;
}

template <typename T, typename Get>
std::string bytesOfAll(std::size_t n, const Get& get) {
    std::string bytes;
    bytes.reserve(n * sizeof(T));
    for (std::size_t i = 0; i < n; ++i) appendLittleEndian(bytes, static_cast<T>(get(i)));
    return bytes;
}

/// The characters of UTF-8; bytes that are no UTF-8 stand for themselves.
std::vector<std::uint32_t> codePoints(std::string_view text) {
    std::vector<std::uint32_t> points;
    for (std::size_t i = 0; i < text.size();) {
        const auto byte = static_cast<unsigned char>(text[i]);
        const std::size_t more = byte >= 0xf0 && byte < 0xf8   ? 3
                                 : byte >= 0xe0 && byte < 0xf0 ? 2
                                 : byte >= 0xc0 && byte < 0xe0 ? 1
                                                               : 0;
        std::uint32_t point = more == 0 ? byte : byte & (0x3fu >> more);
        std::size_t k = 1;
        for (; k <= more && i + k < text.size(); ++k) {
            const auto next = static_cast<unsigned char>(text[i + k]);
            if ((next & 0xc0) != 0x80) break;
            point = point << 6 | (next & 0x3fu);
        }
        const bool sound = k == more + 1 && point <= 0x10ffff;
        points.push_back(sound ? point : byte);
        i += sound ? more + 1 : 1;
    }
    return points;
}

void addTexts(Zip& zip, const std::string& name, const std::vector<std::string>& texts,
              const std::string& shape) {
    std::size_t longest = 1;
    for (const auto& t : texts) longest = std::max(longest, codePoints(t).size());
    std::string bytes;
    bytes.reserve(texts.size() * longest * 4);
    for (const auto& t : texts) {
        auto points = codePoints(t);
        points.resize(longest, 0);
        for (const std::uint32_t p : points) appendLittleEndian(bytes, p);
    }
    zip.add(name, arrayHeader(fmt::format("<U{}", longest), shape), bytes);
}

/// A name for a member of the archive, which is a file to the programs that unpack it.
std::string memberName(std::string_view attribute) {
    std::string name = oneLine(std::string(attribute)).substr(0, 1000);
    std::replace(name.begin(), name.end(), '/', '_');
    return name;
}

}  // namespace

void writeNpz(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    Zip zip(out);
    const std::size_t n = pack.size();
    const std::string shape = fmt::format("({},)", n);
    std::string positions;
    positions.reserve(n * 24);
    for (std::size_t i = 0; i < n; ++i)
        for (const double c : pack.position(i)) appendLittleEndian(positions, c);
    zip.add("positions", arrayHeader("<f8", fmt::format("({}, 3)", n)), positions);
    positions = {};
    const auto reals = [&](const std::string& name, const auto& get) {
        zip.add(name, arrayHeader("<f8", shape), bytesOfAll<double>(n, get));
    };
    const auto wholes = [&](const std::string& name, const auto& get) {
        zip.add(name, arrayHeader("<i8", shape), bytesOfAll<std::int64_t>(n, get));
    };
    reals("radii", [&](std::size_t i) { return pack.radius(i); });
    wholes("id", [&](std::size_t i) { return pack.id(i); });
    pack.forEachAttribute(
        [&](std::string_view name, const auto& numbers) {
            const auto get = [&](std::size_t i) { return pack.value(numbers, i); };
            if constexpr (std::is_integral_v<ValueOf<decltype(numbers)>>)
                wholes(memberName(name), get);
            else
                reals(memberName(name), get);
        },
        [&](std::string_view name, const auto& texts) {
            addTexts(zip, memberName(name), texts, shape);
        });
    addTexts(zip, kUnitKey, {unitName(options.unit)}, "()");
    if (!options.generator.empty()) addTexts(zip, kGeneratorKey, {options.generator}, "()");
    zip.finish();
}

}  // namespace vdbpack
