// Stanford polygon files: the vertices, as text or in either byte order.
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/ply_header.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

/// The next bytes of a binary body. @throws InputError at the end of the file
const char* take(InputFile& file, std::size_t bytes) {
    const std::uint64_t at = file.offset();
    const char* const data = file.take(bytes);
    if (data == nullptr)
        file.failAtByte(at, fmt::format("{} bytes were expected, but the file ends at byte {}; it "
                                        "is cut short or damaged",
                                        bytes, file.size()));
    return data;
}

void skip(InputFile& file, std::uint64_t bytes) {
    file.seek(file.offset() + std::min(bytes, file.remaining()), file.lineNumber());
}

/// Length of the list that begins here. @throws InputError if it passes the end of the file
std::uint64_t takeListLength(InputFile& file, const PlyProperty& p, bool swap) {
    const std::uint64_t at = file.offset();
    std::uint64_t length = 0;
    const bool sound =
        loadNumber(p.countType, take(file, bytesOf(p.countType)), swap, [&](auto value) {
            length = static_cast<std::uint64_t>(value);
            return value >= 0;
        });
    if (!sound || length > file.remaining() / bytesOf(p.type))
        file.failAtByte(at, fmt::format("list '{}' is longer than the file; the file is damaged",
                                        p.name.substr(0, 40)));
    return length;
}

void skipBinary(InputFile& file, const PlyElement& element, bool swap) {
    if (!element.hasLists()) {
        const std::size_t stride = element.bytes();
        if (stride > 0 && element.count > file.remaining() / stride)
            file.failAtByte(
                file.offset(),
                fmt::format("{} entries of element '{}' pass the end of the file; it is cut short",
                            element.count, element.name.substr(0, 40)));
        skip(file, element.count * stride);
        return;
    }
    for (std::uint64_t i = 0; i < element.count; ++i) {
        for (const auto& p : element.properties) {
            if (p.isList)
                skip(file, takeListLength(file, p, swap) * bytesOf(p.type));
            else
                take(file, bytesOf(p.type));
        }
    }
}

/// Fills the vertices of a text body, whose first lines belong to the elements before them.
void readAsciiVertices(InputFile& file, const PlyHeader& header, const PlyElement& vertex,
                       PackBuilder& builder) {
    std::string_view line;
    for (const auto& element : header.elements) {
        if (element.name == vertex.name) break;
        for (std::uint64_t i = 0; i < element.count; ++i)
            if (!file.nextLine(line)) break;
    }
    std::vector<std::string_view> words;
    for (std::uint64_t i = 0; i < vertex.count; ++i) {
        do {
            if (!file.nextLine(line))
                file.fail(fmt::format("ends after {} of {} vertices; the file is cut short", i,
                                      vertex.count));
            splitAtBlanks(line, words);
        } while (words.empty());
        const auto where = [&] { return fmt::format("line {}", file.lineNumber()); };
        builder.addRow();
        std::size_t word = 0;
        std::size_t column = 0;
        for (const auto& p : vertex.properties) {
            if (word >= words.size())
                file.failAtLine(fmt::format("has {} numbers, too few for a vertex", words.size()));
            if (p.isList) {
                std::int64_t length = 0;
                if (!parseNumber(words[word], length) || length < 0 ||
                    static_cast<std::uint64_t>(length) >= words.size() - word)
                    file.failAtLine(fmt::format("malformed list '{}'", p.name.substr(0, 40)));
                word += static_cast<std::size_t>(length) + 1;
                continue;
            }
            if (!builder.parse(column, words[word])) builder.failCell(where(), column, words[word]);
            ++column;
            ++word;
        }
        builder.checkRow(where);
    }
}

/// The same for the rows of a binary body, at whose first vertex the file is.
void readBinaryVertices(InputFile& file, const PlyElement& vertex, bool swap,
                        PackBuilder& builder) {
    for (std::uint64_t i = 0; i < vertex.count; ++i) {
        const std::uint64_t start = file.offset();
        const auto where = [&] { return fmt::format("vertex {} at byte {}", i, start); };
        builder.addRow();
        std::size_t column = 0;
        for (const auto& p : vertex.properties) {
            if (p.isList) {
                skip(file, takeListLength(file, p, swap) * bytesOf(p.type));
                continue;
            }
            const bool sound = loadNumber(p.type, take(file, bytesOf(p.type)), swap,
                                          [&](auto value) { return builder.set(column, value); });
            if (!sound) builder.failCell(where(), column, "out of range");
            ++column;
        }
        builder.checkRow(where);
    }
}

}  // namespace

Pack<3> readPly(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    const PlyHeader header = readPlyHeader(file);
    const auto vertex = std::find_if(header.elements.begin(), header.elements.end(),
                                     [](const PlyElement& e) { return e.name == "vertex"; });
    if (vertex == header.elements.end())
        file.fail("has no element 'vertex'; spheres are expected there");

    // Lists (none of ours) have no data of spheres and are skipped.
    std::vector<std::string> names;
    for (const auto& p : vertex->properties)
        if (!p.isList) names.push_back(p.name);
    Unit unit = options.unit;
    for (const auto& comment : header.comments) unit = unitIn(comment, unit, file);
    PackBuilder builder(path, names, unit);
    const std::uint64_t count = vertex->count;

    if (header.format == PlyFormat::ascii) {
        // Every number takes two bytes at least.
        if (count > (file.remaining() + 1) / (2 * names.size()))
            file.fail(fmt::format(
                "holds fewer than the {} vertices that its header announces; the file is cut short",
                count));
        builder.reserve(static_cast<std::size_t>(count));
        readAsciiVertices(file, header, *vertex, builder);
        return builder.finish();
    }
    const bool swap = (header.format == PlyFormat::bigEndian) != hostIsBigEndian();
    for (auto e = header.elements.begin(); e != vertex; ++e) skipBinary(file, *e, swap);
    if (!vertex->hasLists()) {
        if (count > file.remaining() / vertex->bytes())
            file.failAtByte(file.offset(),
                            fmt::format("{} vertices of {} bytes pass the end of the file at byte "
                                        "{}; it is cut short",
                                        count, vertex->bytes(), file.size()));
        builder.reserve(static_cast<std::size_t>(count));
    }
    readBinaryVertices(file, *vertex, swap, builder);
    return builder.finish();
}

}  // namespace vdbpack
