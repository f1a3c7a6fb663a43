#include "vdbpack/formats/npy_array.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::int64_t kWidestText = 1 << 20;  ///< characters of an element

std::optional<NumberType> numberType(char kind, std::size_t bytes) {
    if (kind == 'b' && bytes == 1) return NumberType::u8;
    const char* const word = kind == 'f'   ? "float"
                             : kind == 'i' ? "int"
                             : kind == 'u' ? "uint"
                                           : "";
    return numberTypeNamed(fmt::format("{}{}", word, 8 * bytes));
}

/// What follows "'key':" in the header of an array, a dictionary as Python prints it; nothing if
/// there is no such key.
std::optional<std::string_view> entryOf(std::string_view header, std::string_view key) {
    const auto at = header.find(key);
    if (at == std::string_view::npos) return std::nullopt;
    const auto colon = std::min(header.find(':', at), header.size() - 1);
    return header.substr(std::min(header.find_first_not_of(' ', colon + 1), header.size()));
}

/// The numbers of a tuple such as "(3, 2)"; nothing if it is none of counts.
std::optional<std::vector<std::uint64_t>> countsOf(std::string_view tuple) {
    const auto close = tuple.find(')');
    if (tuple.empty() || tuple.front() != '(' || close == std::string_view::npos)
        return std::nullopt;
    std::vector<std::uint64_t> counts;
    for (std::size_t at = 1; at < close;) {
        const auto end = std::min(tuple.find(',', at), close);
        const auto word = trimmed(tuple.substr(at, end - at));
        at = end + 1;
        if (word.empty()) continue;
        std::int64_t count = 0;
        if (!parseNumber(word, count) || count < 0) return std::nullopt;
        counts.push_back(static_cast<std::uint64_t>(count));
    }
    return counts;
}

/// Whether so many elements of a number of bytes are just `room`.
bool fill(const std::vector<std::uint64_t>& shape, std::size_t bytes, std::uint64_t room) {
    std::uint64_t elements = 1;
    for (const std::uint64_t count : shape) {
        // No product overflows.
        if (bytes > 0 && count > 0 && elements > room / count) return false;
        elements *= count;
    }
    return elements * bytes == room;
}

void require(bool sound, const std::string& where, const char* part) {
    if (!sound)
        throw InputError(where + part + " does not fit into the file; it is damaged or cut short");
}

}  // namespace

bool NpyArray::takeType(const std::string& descr) {
    std::int64_t width = 0;
    if (descr.size() < 3 || !parseNumber(std::string_view(descr).substr(2), width) || width < 0)
        return false;
    kind_ = descr[1];
    bytes_ = static_cast<std::size_t>(std::min(width, kWidestText + 1)) * (kind_ == 'U' ? 4 : 1);
    swap_ = (descr[0] == '<' || descr[0] == '>') && (descr[0] == '>') != hostIsBigEndian();
    if (isText()) return true;
    const auto type = numberType(kind_, bytes_);
    if (type) type_ = *type;
    return type.has_value();
}

std::uint64_t NpyArray::headerBytes(const std::string& preamble, const std::string& where) {
    if (preamble.compare(0, 6, kNpyMagic) != 0)
        throw InputError(where + " is not a .npy array; save it with numpy");
    require(preamble.size() >= kPreamble, where, "");
    const bool swap = hostIsBigEndian();
    if (preamble[6] >= 2)  // the version
        return 12 + std::uint64_t{loadAs<std::uint32_t>(preamble.data() + 8, swap)};
    return 10 + std::uint64_t{loadAs<std::uint16_t>(preamble.data() + 8, swap)};
}

std::optional<NpyArray> NpyArray::describe(const std::string& text, std::uint64_t bytes,
                                           const std::string& name, const std::string& where) {
    require(text.size() <= bytes, where, " (its header)");
    const std::size_t before = text.size() > 6 && text[6] >= 2 ? 12 : 10;
    const auto header = std::string_view(text).substr(std::min(before, text.size()));
    const auto type = entryOf(header, "'descr'");
    const auto fortran = entryOf(header, "'fortran_order'");
    const auto shape = entryOf(header, "'shape'");
    require(type && fortran && shape, where, " (its header)");

    NpyArray a;
    a.name_ = name;
    if (type->empty() || type->front() != '\'') return std::nullopt;  // records
    if (!a.takeType(std::string(type->substr(1, type->find('\'', 1) - 1)))) return std::nullopt;
    require(a.bytes_ <= static_cast<std::size_t>(kWidestText) * (a.kind_ == 'U' ? 4 : 1), where,
            "");
    a.fortran_ = fortran->substr(0, 4) == "True";
    auto counts = countsOf(*shape);
    require(counts.has_value(), where, " (its shape)");
    require(fill(*counts, a.bytes_, bytes - text.size()), where, "");
    if (counts->size() > 2) return std::nullopt;
    a.shape_ = std::move(*counts);
    a.begin_ = text.size();
    return a;
}

std::string NpyArray::text(std::uint64_t row) const {
    std::string out;
    const char* const begin = at(row, 0);
    if (kind_ == 'S')
        out.assign(begin, bytes_);
    else
        for (std::size_t b = 0; b < bytes_; b += 4)
            appendUtf8(out,
                       std::min<std::uint32_t>(loadAs<std::uint32_t>(begin + b, swap_), 0x10ffff));
    while (!out.empty() && out.back() == '\0') out.pop_back();
    return out;
}

}  // namespace vdbpack
