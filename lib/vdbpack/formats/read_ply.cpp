// Stanford polygon files: the vertices, as text or in either byte order.
#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

struct Property {
    std::string name;
    NumberType type = NumberType::f32;
    bool list = false;
    NumberType countType = NumberType::u8;
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;

    bool hasLists() const {
        return std::any_of(properties.begin(), properties.end(),
                           [](const Property& p) { return p.list; });
    }
    std::size_t bytes() const {
        std::size_t sum = 0;
        for (const auto& p : properties) sum += bytesOf(p.type);
        return sum;
    }
};

struct Header {
    bool ascii = false;
    bool bigEndian = false;
    Unit unit = Unit::millimeter;
    std::vector<Element> elements;
};

bool parseType(std::string_view name, NumberType& type) {
    static constexpr struct {
        const char* names[2];
        NumberType type;
    } kTypes[] = {{{"char", "int8"}, NumberType::i8},      {{"uchar", "uint8"}, NumberType::u8},
                  {{"short", "int16"}, NumberType::i16},   {{"ushort", "uint16"}, NumberType::u16},
                  {{"int", "int32"}, NumberType::i32},     {{"uint", "uint32"}, NumberType::u32},
                  {{"float", "float32"}, NumberType::f32}, {{"double", "float64"}, NumberType::f64},
                  {{"int64", "long"}, NumberType::i64},    {{"uint64", "ulong"}, NumberType::u64}};
    for (const auto& t : kTypes) {
        if (name != t.names[0] && name != t.names[1]) continue;
        type = t.type;
        return true;
    }
    return false;
}

Header readHeader(InputFile& file, Unit unit) {
    const std::string& path = file.path();
    std::string_view line;
    if (!file.nextLine(line) || trimmed(line) != "ply")
        throw InputError(path + ": is not a PLY file: the first line is not 'ply'");
    Header header;
    header.unit = unit;
    bool formatKnown = false;
    std::vector<std::string_view> words;
    while (file.nextLine(line)) {
        splitAtBlanks(trimmed(line), words);
        const auto fail = [&](const char* what) {
            throw InputError(fmt::format("{}: line {}: {} in '{}'; correct the header", path,
                                         file.lineNumber(), what, line.substr(0, 80)));
        };
        if (words.empty()) continue;
        if (words[0] == "end_header") {
            if (!formatKnown)
                throw InputError(path + ": the header names no format; add a format line");
            return header;
        }
        if (words[0] == "comment" || words[0] == "obj_info") {
            if (!parseUnitComment(trimmed(line), header.unit)) fail("unknown unit");
        } else if (words[0] == "format" && words.size() >= 2) {
            header.ascii = words[1] == "ascii";
            header.bigEndian = words[1] == "binary_big_endian";
            if (!header.ascii && !header.bigEndian && words[1] != "binary_little_endian")
                fail("unknown format");
            formatKnown = true;
        } else if (words[0] == "element" && words.size() == 3) {
            std::int64_t count = 0;
            if (!parseNumber(words[2], count) || count < 0) fail("unusable count");
            header.elements.push_back(
                {std::string(words[1]), static_cast<std::uint64_t>(count), {}});
        } else if (words[0] == "property" && !header.elements.empty()) {
            Property p;
            if (words.size() == 3) {
                if (!parseType(words[1], p.type)) fail("unknown type");
                p.name = words[2];
            } else if (words.size() == 5 && words[1] == "list") {
                p.list = true;
                if (!parseType(words[2], p.countType) || isReal(p.countType) ||
                    !parseType(words[3], p.type))
                    fail("unknown type");
                p.name = words[4];
            } else {
                fail("malformed property");
            }
            header.elements.back().properties.push_back(p);
        } else {
            fail("unknown statement");
        }
    }
    throw InputError(path + ": ends inside its header; the file is cut short");
}

/// The binary body, read forward in chunks.
class Body {
public:
    Body(const InputFile& file, std::uint64_t offset) : file_(file), offset_(offset) {}

    std::uint64_t offset() const { return offset_; }
    std::uint64_t left() const { return file_.size() - offset_; }
    void skip(std::uint64_t bytes) {
        // The next `take` reports a position beyond the end.
        offset_ += std::min(bytes, left());
    }
    /// The next `bytes`, valid until the next call. @throws InputError at the end of the file
    const char* take(std::size_t bytes) {
        if (offset_ < chunkOffset_ || offset_ + bytes > chunkOffset_ + chunk_.size()) {
            const std::uint64_t wanted = std::max<std::uint64_t>(bytes, 1 << 20);
            std::vector<char> chunk(
                bytes > left() ? 0 : static_cast<std::size_t>(std::min(wanted, left())));
            // Beyond the end of the file, `readAt` throws.
            file_.readAt(offset_, chunk.data(), bytes > left() ? bytes : chunk.size());
            chunk_.swap(chunk);
            chunkOffset_ = offset_;
        }
        const char* at = chunk_.data() + (offset_ - chunkOffset_);
        offset_ += bytes;
        return at;
    }

private:
    const InputFile& file_;
    std::uint64_t offset_;
    std::vector<char> chunk_;
    std::uint64_t chunkOffset_ = 0;
};

/// Length of the list that begins here. @throws InputError if it passes the end of the file
std::uint64_t takeListLength(Body& body, const Property& p, bool swap, const std::string& path) {
    const std::uint64_t at = body.offset();
    std::uint64_t length = 0;
    const bool sound =
        loadNumber(p.countType, body.take(bytesOf(p.countType)), swap, [&](auto value) {
            length = static_cast<std::uint64_t>(value);
            return value >= 0;
        });
    if (!sound || length > body.left() / bytesOf(p.type))
        throw InputError(
            fmt::format("{}: byte {}: list '{}' is longer than the file; the file is damaged", path,
                        at, p.name.substr(0, 40)));
    return length;
}

void skipBinary(Body& body, const Element& element, bool swap, const std::string& path) {
    if (!element.hasLists()) {
        const std::size_t stride = element.bytes();
        if (stride > 0 && element.count > body.left() / stride)
            throw InputError(fmt::format(
                "{}: byte {}: {} entries of element '{}' pass the end of the file; it is cut short",
                path, body.offset(), element.count, element.name.substr(0, 40)));
        body.skip(element.count * stride);
        return;
    }
    for (std::uint64_t i = 0; i < element.count; ++i) {
        for (const auto& p : element.properties) {
            const std::uint64_t n = p.list ? takeListLength(body, p, swap, path) : 1;
            if (!p.list)
                body.take(bytesOf(p.type));
            else
                body.skip(n * bytesOf(p.type));
        }
    }
}

/// Adds the vertex whose words are those of the last line.
void addVertex(const Element& vertex, const std::vector<std::string_view>& words,
               const InputFile& file, PackBuilder& builder) {
    const auto where = [&file] { return fmt::format("line {}", file.lineNumber()); };
    builder.addRow();
    std::size_t word = 0;
    std::size_t column = 0;
    for (const Property& p : vertex.properties) {
        if (word >= words.size())
            throw InputError(fmt::format("{}: {}: has {} numbers, too few for a vertex",
                                         file.path(), where(), words.size()));
        if (p.list) {
            std::int64_t length = 0;
            if (!parseNumber(words[word], length) || length < 0 ||
                static_cast<std::uint64_t>(length) >= words.size() - word)
                throw InputError(fmt::format("{}: {}: malformed list '{}'", file.path(), where(),
                                             p.name.substr(0, 40)));
            word += static_cast<std::size_t>(length) + 1;
            continue;
        }
        if (!builder.parse(column, words[word])) builder.failCell(where(), column, words[word]);
        ++column;
        ++word;
    }
    if (!builder.problem().empty()) builder.failRow(where());
}

using Vertex = std::vector<Element>::const_iterator;

void readText(InputFile& file, const Header& header, Vertex vertex, PackBuilder& builder) {
    const std::string& path = file.path();
    // Every number takes two bytes at least.
    const std::uint64_t left = file.size() - file.nextOffset() + 1;
    if (vertex->count > left / (2 * builder.columns()))
        throw InputError(
            fmt::format("{}: holds fewer than the {} vertices that its header announces; the file "
                        "is cut short",
                        path, vertex->count));
    builder.reserve(static_cast<std::size_t>(vertex->count));
    std::string_view line;
    for (auto e = header.elements.begin(); e != vertex; ++e)
        for (std::uint64_t i = 0; i < e->count; ++i)
            if (!file.nextLine(line)) break;
    for (std::uint64_t i = 0; i < vertex->count; ++i) {
        std::vector<std::string_view> words;
        while (words.empty()) {
            if (!file.nextLine(line))
                throw InputError(
                    fmt::format("{}: ends after {} of {} vertices; the file is cut "
                                "short",
                                path, i, vertex->count));
            splitAtBlanks(trimmed(line), words);
        }
        addVertex(*vertex, words, file, builder);
    }
}

void readBinary(const InputFile& file, const Header& header, Vertex vertex, PackBuilder& builder) {
    const std::string& path = file.path();
    const bool swap = header.bigEndian != hostIsBigEndian();
    Body body(file, file.nextOffset());
    for (auto e = header.elements.begin(); e != vertex; ++e) skipBinary(body, *e, swap, path);
    const bool lists = vertex->hasLists();
    if (!lists && vertex->count > body.left() / vertex->bytes())
        throw InputError(
            fmt::format("{}: byte {}: {} vertices of {} bytes pass the end of the file at byte {}; "
                        "it is cut short",
                        path, body.offset(), vertex->count, vertex->bytes(), file.size()));
    if (!lists) builder.reserve(static_cast<std::size_t>(vertex->count));
    for (std::uint64_t i = 0; i < vertex->count; ++i) {
        const std::uint64_t start = body.offset();
        const auto where = [i, start] { return fmt::format("vertex {} at byte {}", i, start); };
        builder.addRow();
        std::size_t column = 0;
        for (const Property& p : vertex->properties) {
            if (p.list) {
                body.skip(takeListLength(body, p, swap, path) * bytesOf(p.type));
                continue;
            }
            const char* bytes = body.take(bytesOf(p.type));
            const bool sound = loadNumber(p.type, bytes, swap,
                                          [&](auto value) { return builder.set(column, value); });
            if (!sound) builder.failCell(where(), column, "out of range");
            ++column;
        }
        if (!builder.problem().empty()) builder.failRow(where());
    }
}

}  // namespace

Pack<3> readPly(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    const Header header = readHeader(file, options.unit);
    const auto vertex = std::find_if(header.elements.begin(), header.elements.end(),
                                     [](const Element& e) { return e.name == "vertex"; });
    if (vertex == header.elements.end())
        throw InputError(path + ": has no element 'vertex'; spheres are expected there");

    // Lists are not attributes of spheres and are skipped.
    std::vector<std::string> names;
    for (const auto& p : vertex->properties)
        if (!p.list) names.push_back(p.name);
    PackBuilder builder(path, names, header.unit);
    if (header.ascii)
        readText(file, header, vertex, builder);
    else
        readBinary(file, header, vertex, builder);
    return builder.finish();
}

}  // namespace vdbpack
