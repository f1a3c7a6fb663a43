#include "vdbpack/io/vtk_legacy.h"

#include "vdbpack/core/memory.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>

#include <charconv>
#include <cstring>
#include <utility>

namespace vdbpack {

namespace {

/// A name or text of a file, with "%20" as a blank.
std::string decoded(std::string_view text) {
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        unsigned code = 0;
        const char *const from = text.data() + i + 1, *const to = from + 2;
        const bool isCode =
            text[i] == '%' && i + 2 < text.size() && std::from_chars(from, to, code, 16).ptr == to;
        result += isCode ? static_cast<char>(code) : text[i];
        i += isCode ? 2 : 0;
    }
    return result;
}

}  // namespace

VtkLegacy::VtkLegacy(const std::string& path, double memoryLimit)
    : file_(path), memoryLimit_(memoryLimit) {
    if (!startsWith(lowered(takeLine("its first line")), "# vtk datafile"))
        file_.failAtLine("'# vtk DataFile Version ...' expected; this is no legacy VTK file");
    takeLine("a title");
    const std::string encoding = lowered(trimmed(takeLine("ASCII or BINARY")));
    if (encoding != "ascii" && encoding != "binary")
        file_.failAtLine("ASCII or BINARY expected, found " + quotedExcerpt(encoding));
    isText_ = encoding == "ascii";
    std::string keyword;
    if (nextStatement(keyword)) dataSet_ = lowered(word());
    if (keyword != "dataset") file_.failAtLine("DATASET expected, found " + quotedExcerpt(keyword));
}

std::string_view VtkLegacy::takeLine(const char* what) {
    std::string_view line;
    if (!file_.nextLine(line))
        file_.fail(fmt::format("ends where {} is expected; it is truncated", what));
    return line;
}

void VtkLegacy::fail(const std::string& what) const {
    if (isText_) file_.failAtLine(what);
    file_.failAtByte(file_.offset(), what);
}

bool VtkLegacy::nextStatement(std::string& keyword) {
    row_ = Words({});
    std::string_view line;
    while (file_.nextLine(line)) {
        statement_ = line;
        words_ = Words(statement_);
        keyword = lowered(words_.next());
        if (!keyword.empty()) return true;
    }
    return false;
}

std::uint64_t VtkLegacy::count(const char* what) {
    const std::string_view text = word();
    std::int64_t number = 0;
    if (!parseInteger(text, number) || number < 0)
        file_.failAtLine(fmt::format("{} expected, found {}", what, quotedExcerpt(text)));
    const auto count = static_cast<std::uint64_t>(number);
    if (count > file_.size())
        fail(fmt::format("{}: {} are announced, more than the file holds; it is truncated", what,
                         count));
    return count;
}

NumberType VtkLegacy::typeIn(std::string_view name) const {
    constexpr std::pair<std::string_view, NumberType> kTypes[] = {
        {"char", NumberType::i8},          {"unsigned_char", NumberType::u8},
        {"short", NumberType::i16},        {"unsigned_short", NumberType::u16},
        {"int", NumberType::i32},          {"unsigned_int", NumberType::u32},
        {"long", NumberType::i64},         {"unsigned_long", NumberType::u64},
        {"vtktypeint32", NumberType::i32}, {"vtktypeint64", NumberType::i64},
        {"vtkidtype", NumberType::i32},    {"float", NumberType::f32},
        {"double", NumberType::f64}};
    for (const auto& [known, type] : kTypes)
        if (equalsNoCase(name, known)) return type;
    file_.failAtLine("a type such as float or int expected, found " + quotedExcerpt(name));
}

std::string VtkLegacy::name() {
    return decoded(word());
}

VtkArray VtkLegacy::typed(std::string name, std::uint64_t components) {
    constexpr std::uint64_t kMostComponents = 16;
    VtkArray array;
    array.name = std::move(name);
    array.components = components;
    if (components < 1 || components > kMostComponents)
        file_.failAtLine(fmt::format("array {} has {} components; 1 to {} are needed",
                                     quotedExcerpt(array.name), components, kMostComponents));
    const std::string_view type = word();
    array.string = equalsNoCase(type, "string");
    if (!array.string) array.type = typeIn(type);
    return array;
}

VtkNumbers VtkLegacy::numbers(const VtkArray& array, std::uint64_t count) {
    const bool real = isReal(array.type);
    const std::size_t size = isText_ ? 8 : bytesOf(array.type);
    // In text, a digit and a blank each, but for the last one.
    if (count > (file_.remaining() + 1) / (isText_ ? 2 : size))
        fail(fmt::format("{} numbers are announced, more than the file holds; it is truncated",
                         count));
    requireMemoryToRead(path(), static_cast<double>(count * size), memoryLimit_);
    VtkNumbers found{std::vector<char>(count * size), array.type, !hostIsBigEndian()};
    if (!isText_) {
        const std::uint64_t from = file_.offset();
        file_.readAt(from, found.bytes.data(), found.bytes.size());
        file_.seek(from + found.bytes.size(), file_.lineNumber());
        return found;
    }
    found.swap = false;
    found.type = real ? NumberType::f64 : NumberType::i64;
    for (std::uint64_t i = 0; i < count; ++i) {
        std::string_view text = row_.next();
        for (; text.empty(); text = row_.next()) row_ = Words(takeLine("a number"));
        double value = 0;
        std::int64_t whole = 0;
        if (!(real ? parseReal(text, value) : parseNumber(text, whole)))
            fail(fmt::format("array {} has {} as number {}; a {}number is needed",
                             quotedExcerpt(array.name), quotedExcerpt(text), i,
                             real ? "" : "whole "));
        std::memcpy(found.bytes.data() + 8 * i, real ? static_cast<const void*>(&value) : &whole,
                    8);
    }
    return found;
}

std::vector<std::int64_t> VtkLegacy::integers(NumberType type, std::uint64_t count) {
    VtkArray array;
    array.name = "of whole numbers";
    array.type = type;
    const VtkNumbers found = numbers(array, count);
    std::vector<std::int64_t> integers(count);
    for (std::uint64_t i = 0; i < count; ++i)
        found.at(i, [&](auto value) {
            integers[i] = static_cast<std::int64_t>(value);
            return true;
        });
    return integers;
}

std::string VtkLegacy::takeText() {
    if (isText_) return decoded(takeLine("a text"));
    // The two high bits of the first byte tell in how many bytes the length stands.
    const std::string_view first = file_.peek(1);
    const auto bytes =
        first.empty() ? 1 : std::size_t{8} >> (static_cast<unsigned char>(first[0]) >> 6);
    const auto* const length = reinterpret_cast<const unsigned char*>(file_.take(bytes));
    const std::uint64_t size =
        length ? unsignedNumber(length, bytes, true) & (~std::uint64_t{0} >> (66 - 8 * bytes)) : 0;
    const char* const text = length && size <= file_.remaining() ? file_.take(size) : nullptr;
    if (!text) fail(fmt::format("a text of {} bytes passes the end of the file", size));
    return {text, size};
}

VtkTuples VtkLegacy::tuples(const VtkArray& array, std::uint64_t count) {
    VtkTuples found;
    found.count = count;
    if (!array.string) found.numbers = numbers(array, count * array.components);
    for (std::uint64_t i = 0; array.string && i < count * array.components; ++i)
        found.texts.push_back(takeText());
    return found;
}

void VtkLegacy::forFieldArrays(const std::function<void(const VtkArray&, const VtkTuples&)>& use) {
    word();
    for (std::uint64_t left = count("a number of arrays"); left > 0; --left) {
        std::string keyword;
        bool found = nextStatement(keyword);
        if (found && keyword == "metadata") {
            skipMetadata();
            found = nextStatement(keyword);
        }
        if (!found) file_.fail("ends where an array of a FIELD is expected; it is truncated");
        words_ = Words(statement_);
        std::string called = name();
        const std::uint64_t components = count("a number of components");
        const std::uint64_t rows = count("a number of tuples");
        const VtkArray array = typed(std::move(called), components);
        use(array, tuples(array, rows));
    }
}

VtkCells VtkLegacy::cells() {
    const std::uint64_t first = count("a number of cells"), second = count("a number of entries");
    VtkCells cells;
    std::string keyword;
    if (startsWith(lowered(file_.peek(8)), "offsets ")) {  // since version 5
        nextStatement(keyword);
        const auto offsets = integers(typeIn(word()), first);
        if (!nextStatement(keyword) || keyword != "connectivity")
            file_.failAtLine("CONNECTIVITY expected, found " + quotedExcerpt(keyword));
        cells.corners = integers(typeIn(word()), second);
        for (std::size_t i = 0; i < offsets.size(); ++i) {
            const std::int64_t before = i == 0 ? 0 : offsets[i - 1];
            if (offsets[i] < before || offsets[i] > static_cast<std::int64_t>(second) ||
                (i == 0 && offsets[i] != 0))
                fail(fmt::format("offset {} is {}, after {} and of {} entries", i, offsets[i],
                                 before, second));
            if (i > 0) cells.ends.push_back(static_cast<std::size_t>(offsets[i]));
        }
        return cells;
    }
    const auto entries = integers(NumberType::i32, second);
    for (std::uint64_t i = 0, at = 0; i < first; ++i) {
        const std::int64_t length = at < second ? entries[at++] : -1;
        if (length < 0 || static_cast<std::uint64_t>(length) > second - at)
            fail(fmt::format("cell {} has {} corners, more than are announced", i, length));
        const auto begin = entries.begin() + static_cast<std::ptrdiff_t>(at);
        cells.corners.insert(cells.corners.end(), begin, begin + length);
        cells.ends.push_back(cells.corners.size());
        at += static_cast<std::uint64_t>(length);
    }
    return cells;
}

void VtkLegacy::skipColors(std::uint64_t count) {
    VtkArray colors;
    colors.type = isText_ ? NumberType::f32 : NumberType::u8;
    numbers(colors, count);
}

void VtkLegacy::skipMetadata() {
    std::string_view line;
    while (file_.nextLine(line) && !trimmed(line).empty()) {
    }
}

}  // namespace vdbpack
