// numpy's .npz: a zip archive with one .npy array per member. Source: numpy.lib.format, version 1.
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/npy_array.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/zip_writer.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace vdbpack {

namespace {

std::uint32_t crcOf(const std::string& bytes) {
    return static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

/// An archive of arrays.
class NpzArchive {
public:
    explicit NpzArchive(OutputFile& out) : out_(out), zip_(out, ZipWriter::Form::zip64) {}

    void add(const std::string& name, const std::string& header, const std::string& data) {
        const auto crc = static_cast<std::uint32_t>(
            crc32_combine(crcOf(header), crcOf(data), static_cast<z_off_t>(data.size())));
        zip_.begin(name + ".npy", header.size() + data.size(), crc);
        out_.write(header);
        out_.write(data);
    }
    void finish() { zip_.finish(); }

private:
    OutputFile& out_;
    ZipWriter zip_;
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
    appendLittleEndian(header, static_cast<std::uint16_t>(dict.size()));
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
    while (!text.empty()) {
        const std::size_t bytes = std::max<std::size_t>(utf8Bytes(text), 1);
        std::uint32_t point = static_cast<unsigned char>(text.front());
        if (bytes > 1) point &= 0x7fu >> bytes;
        for (std::size_t k = 1; k < bytes; ++k)
            point = point << 6 | (static_cast<unsigned char>(text[k]) & 0x3fu);
        points.push_back(point);
        text.remove_prefix(bytes);
    }
    return points;
}

void addTexts(NpzArchive& zip, const std::string& name, const std::vector<std::string>& texts,
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
    NpzArchive zip(out);
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
    if (const auto& names = partNames(pack.attributes()); !names.empty())
        addTexts(zip, kPartNamesKey, names, fmt::format("({},)", names.size()));
    if (!options.generator.empty()) addTexts(zip, kGeneratorKey, {options.generator}, "()");
    zip.finish();
}

}  // namespace vdbpack
