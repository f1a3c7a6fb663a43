#include "vdbpack/io/ply_header.h"

#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

NumberType parseType(const InputFile& file, std::string_view name) {
    static constexpr std::pair<std::string_view, NumberType> kTypes[] = {
        {"char", NumberType::i8},    {"uchar", NumberType::u8},  {"short", NumberType::i16},
        {"ushort", NumberType::u16}, {"int", NumberType::i32},   {"uint", NumberType::u32},
        {"long", NumberType::i64},   {"ulong", NumberType::u64}, {"float", NumberType::f32},
        {"double", NumberType::f64},
    };
    for (const auto& [known, type] : kTypes)
        if (name == known) return type;
    if (const auto type = numberTypeNamed(name)) return *type;
    file.failAtLine("type of a property expected, found " + quotedExcerpt(name));
}

PlyFormat parseFormat(const InputFile& file, std::string_view name) {
    if (name == "ascii") return PlyFormat::ascii;
    if (name == "binary_little_endian") return PlyFormat::littleEndian;
    if (name == "binary_big_endian") return PlyFormat::bigEndian;
    file.failAtLine(
        "format 'ascii', 'binary_little_endian' or 'binary_big_endian' expected, found " +
        quotedExcerpt(name));
}

PlyElement parseElement(const InputFile& file, Words words) {
    PlyElement element;
    element.name = words.next();
    const std::string_view word = words.next();
    std::int64_t count = 0;
    if (!parseInteger(word, count))
        file.failAtLine("the number of elements expected, found " + quotedExcerpt(word));
    if (count < 0) file.failAtLine(fmt::format("negative count: {}", count));
    element.count = static_cast<std::uint64_t>(count);
    return element;
}

PlyProperty parseProperty(const InputFile& file, Words words) {
    PlyProperty property;
    std::string_view word = words.next();
    if (word == "list") {
        property.isList = true;
        property.countType = parseType(file, words.next());
        if (isReal(property.countType))
            file.failAtLine("the length of a list must have an integer type");
        word = words.next();
    }
    property.type = parseType(file, word);
    property.name = words.next();
    if (property.name.empty()) file.failAtLine("name of a property expected");
    return property;
}

}  // namespace

bool PlyElement::hasLists() const {
    return std::any_of(properties.begin(), properties.end(),
                       [](const PlyProperty& p) { return p.isList; });
}

std::size_t PlyElement::bytes() const {
    std::size_t sum = 0;
    for (const auto& p : properties) sum += bytesOf(p.type);
    return sum;
}

PlyHeader readPlyHeader(InputFile& file) {
    PlyHeader header;
    std::set<std::string> names;  // of the elements: a header may have any number of them
    std::string_view line;
    if (!file.nextLine(line) || Words(line).next() != "ply")
        file.fail("is not a PLY file: it does not begin with 'ply'");
    bool hasFormat = false;
    for (;;) {
        if (!file.nextLine(line))
            file.failAtLine("the file ends before 'end_header'; it is truncated");
        Words words(line);
        const std::string_view keyword = words.next();
        if (keyword.empty()) continue;
        if (keyword == "end_header") break;
        if (keyword == "comment" || keyword == "obj_info") {
            header.comments.emplace_back(trimmed(line));
        } else if (keyword == "format") {
            header.format = parseFormat(file, words.next());
            hasFormat = true;
        } else if (keyword == "element") {
            header.elements.push_back(parseElement(file, words));
            const std::string& name = header.elements.back().name;
            if (!names.insert(name).second)
                file.failAtLine("element " + quotedExcerpt(name) + " is declared twice");
        } else if (keyword == "property") {
            if (header.elements.empty()) file.failAtLine("property before any element");
            header.elements.back().properties.push_back(parseProperty(file, words));
        } else {
            file.failAtLine("is not a statement of a PLY header: " + quotedExcerpt(keyword));
        }
    }
    if (!hasFormat) file.failAtLine("the header names no format");
    return header;
}

}  // namespace vdbpack
