// Stanford polygon files with vertices only.
#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
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

std::vector<std::string_view> wordsOf(std::string_view line) {
    std::vector<std::string_view> words;
    for (std::size_t at = 0;;) {
        const auto begin = line.find_first_not_of(" \t", at);
        if (begin == std::string_view::npos) return words;
        at = std::min(line.find_first_of(" \t", begin), line.size());
        words.push_back(line.substr(begin, at - begin));
    }
}

Header readHeader(InputFile& file, Unit unit) {
    const std::string& path = file.path();
    std::string_view line;
    if (!file.nextLine(line) || trimmed(line) != "ply")
        throw InputError(path + ": is not a PLY file: the first line is not 'ply'");
    Header header;
    header.unit = unit;
    bool formatKnown = false;
    while (file.nextLine(line)) {
        const auto words = wordsOf(trimmed(line));
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
        // Overshooting is found out by the next `take`.
        offset_ += std::min(bytes, left());
    }
    /// The next `bytes`, valid until the next call. @throws InputError at the end of the file
    const char* take(std::size_t bytes) {
        if (offset_ < chunkOffset_ || offset_ + bytes > chunkOffset_ + chunk_.size()) {
            const std::uint64_t wanted = std::max<std::uint64_t>(bytes, 1 << 20);
            std::vector<char> chunk(
                bytes > left() ? 0 : static_cast<std::size_t>(std::min(wanted, left())));
            // Asking for what is not there makes the file say so.
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

}  // namespace

void writePly(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    bool ids = true;
    for (std::size_t i = 0; i < pack.size() && ids; ++i)
        ids = pack.id(i) >= std::numeric_limits<std::int32_t>::min() &&
              pack.id(i) <= std::numeric_limits<std::int32_t>::max();
    // Positions in 32 bits would let spheres overlap by their rounding, which grows with the
    // distance from the origin. Radii are 32-bit numbers in mm, which some viewers ask for.
    bool narrow = true;
    for (std::size_t i = 0; i < pack.size() && narrow; ++i)
        narrow = static_cast<double>(static_cast<float>(pack.radius(i))) == pack.radius(i);
    std::string header = "ply\nformat binary_little_endian 1.0\n";
    header += fmt::format("comment {}{}\n", kUnitComment, unitName(options.unit));
    if (!options.generator.empty())
        header += fmt::format("comment {}: {}\n", kGeneratorKey, oneLine(options.generator));
    header += fmt::format("element vertex {}\n", pack.size());
    header += "property double x\nproperty double y\nproperty double z\n";
    header += fmt::format("property {} radius\n", narrow ? "float" : "double");
    // The format knows no whole numbers beyond 32 bits: better no names than wrong ones.
    if (ids) header += "property int id\n";
    header += "end_header\n";
    out.write(header);

    const bool swap = hostIsBigEndian();
    const auto append = [swap](std::string& text, auto value) {
        char bytes[sizeof value];
        std::memcpy(bytes, &value, sizeof value);
        if (swap) std::reverse(bytes, bytes + sizeof value);
        text.append(bytes, sizeof value);
    };
    writeRows(out, pack.size(), [&pack, &append, ids, narrow](std::string& text, std::size_t i) {
        for (const double c : pack.position(i)) append(text, c);
        if (narrow)
            append(text, static_cast<float>(pack.radius(i)));
        else
            append(text, pack.radius(i));
        if (ids) append(text, static_cast<std::int32_t>(pack.id(i)));
    });
}

Pack<3> readPly(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    const Header header = readHeader(file, options.unit);
    const auto vertex = std::find_if(header.elements.begin(), header.elements.end(),
                                     [](const Element& e) { return e.name == "vertex"; });
    if (vertex == header.elements.end())
        throw InputError(path + ": has no element 'vertex'; spheres are expected there");

    // Lists (none of ours) say nothing of spheres and are skipped.
    std::vector<std::string> names;
    for (const auto& p : vertex->properties)
        if (!p.list) names.push_back(p.name);
    PackBuilder builder(path, names, header.unit);
    const std::uint64_t count = vertex->count;

    if (header.ascii) {
        // Every number takes two bytes at least.
        const std::uint64_t left = file.size() - file.nextOffset() + 1;
        if (count > left / (2 * names.size()))
            throw InputError(
                fmt::format("{}: holds fewer than the {} vertices that its header "
                            "announces; the file is cut short",
                            path, count));
        builder.reserve(static_cast<std::size_t>(count));
        std::string_view line;
        for (auto e = header.elements.begin(); e != vertex; ++e)
            for (std::uint64_t i = 0; i < e->count; ++i)
                if (!file.nextLine(line)) break;
        for (std::uint64_t i = 0; i < count; ++i) {
            std::vector<std::string_view> words;
            while (words.empty()) {
                if (!file.nextLine(line))
                    throw InputError(fmt::format(
                        "{}: ends after {} of {} vertices; the file is cut short", path, i, count));
                words = wordsOf(trimmed(line));
            }
            const auto where = [&] { return fmt::format("line {}", file.lineNumber()); };
            builder.addRow();
            std::size_t word = 0;
            std::size_t column = 0;
            for (const auto& p : vertex->properties) {
                if (word >= words.size())
                    throw InputError(fmt::format("{}: {}: has {} numbers, too few for a vertex",
                                                 path, where(), words.size()));
                if (p.list) {
                    std::int64_t length = 0;
                    if (!parseNumber(words[word], length) || length < 0 ||
                        static_cast<std::uint64_t>(length) >= words.size() - word)
                        throw InputError(fmt::format("{}: {}: malformed list '{}'", path, where(),
                                                     p.name.substr(0, 40)));
                    word += static_cast<std::size_t>(length) + 1;
                    continue;
                }
                if (!builder.parse(column, words[word]))
                    builder.failCell(where(), column, words[word]);
                ++column;
                ++word;
            }
            if (!builder.problem().empty()) builder.failRow(where());
        }
        return builder.finish();
    }

    const bool swap = header.bigEndian != hostIsBigEndian();
    Body body(file, file.nextOffset());
    for (auto e = header.elements.begin(); e != vertex; ++e) skipBinary(body, *e, swap, path);
    const bool lists = vertex->hasLists();
    if (count > body.left() / vertex->bytes())
        if (!lists)
            throw InputError(
                fmt::format("{}: byte {}: {} vertices of {} bytes pass the end of the file at byte "
                            "{}; it is cut short",
                            path, body.offset(), count, vertex->bytes(), file.size()));
    if (!lists) builder.reserve(static_cast<std::size_t>(count));
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t start = body.offset();
        const auto where = [&] { return fmt::format("vertex {} at byte {}", i, start); };
        builder.addRow();
        std::size_t column = 0;
        for (const auto& p : vertex->properties) {
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
    return builder.finish();
}

}  // namespace vdbpack
