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

/// The body of a file, entry by entry and property by property.
class Body {
public:
    Body(InputFile& file, PlyFormat format)
        : file_(file),
          isText_(format == PlyFormat::ascii),
          swap_((format == PlyFormat::bigEndian) != hostIsBigEndian()) {}

    bool isText() const { return isText_; }

    /// Begins an entry: in text, a line.
    void begin(const PlyElement& element, std::uint64_t entry) {
        start_ = file_.offset();
        word_ = 0;
        std::string_view line;
        words_.clear();
        while (isText_ && words_.empty()) {
            if (!file_.nextLine(line))
                file_.fail(
                    fmt::format("ends after {} of {} entries of element {}; the file is cut short",
                                entry, element.count, quotedExcerpt(element.name)));
            splitAtBlanks(line, words_);
        }
    }
    std::string where() const {
        return isText_ ? fmt::format("line {}", file_.lineNumber())
                       : fmt::format("byte {}", start_);
    }

    /// Hands the next number to `use`, as int64 or double.
    /// @return what `use` returns; false for a text that is no number.
    template <class Use>
    bool number(NumberType type, const Use& use) {
        if (!isText_) return loadNumber(type, take(bytesOf(type)), swap_, use);
        if (word_ == words_.size())
            file_.failAtLine(fmt::format("has {} numbers, too few for an entry", word_));
        const std::string_view word = words_[word_++];
        std::int64_t whole = 0;
        double real = 0;
        return parseInteger(word, whole) ? use(whole) : parseNumber(word, real) && use(real);
    }
    /// The last number, for messages.
    std::string_view last() const { return isText_ ? words_[word_ - 1] : "out of range"; }

    void skip(const PlyProperty& property) {
        std::int64_t length = property.isList ? -1 : 1;
        if (property.isList)
            number(property.countType, [&length](auto value) {
                return wholeNumber(static_cast<double>(value), length);
            });
        const std::size_t bytes = bytesOf(property.type);
        const std::uint64_t rest = isText_ ? words_.size() - word_ : file_.remaining() / bytes;
        if (length < 0 || static_cast<std::uint64_t>(length) > rest)
            file_.fail(fmt::format(
                "{}: property {} is longer than what follows; the file is damaged or cut short",
                where(), quotedExcerpt(property.name)));
        if (isText_)
            word_ += static_cast<std::size_t>(length);
        else
            skipBytes(static_cast<std::uint64_t>(length) * bytes);
    }
    void skip(const PlyElement& element) {
        if (element.properties.empty()) return;
        if (!isText_ && !element.hasLists()) {
            const std::size_t stride = element.bytes();
            if (element.count > file_.remaining() / stride)
                file_.failAtByte(
                    file_.offset(),
                    fmt::format(
                        "{} entries of element {} pass the end of the file; it is cut short",
                        element.count, quotedExcerpt(element.name)));
            skipBytes(element.count * stride);
            return;
        }
        for (std::uint64_t i = 0; i < element.count; ++i) {
            begin(element, i);
            for (const PlyProperty& property : element.properties) skip(property);
        }
    }

private:
    const char* take(std::size_t bytes) {
        const std::uint64_t at = file_.offset();
        const char* const data = file_.take(bytes);
        if (data == nullptr)
            file_.failAtByte(at, fmt::format("{} bytes were expected, but the file ends at byte "
                                             "{}; it is cut short or damaged",
                                             bytes, file_.size()));
        return data;
    }
    void skipBytes(std::uint64_t bytes) { file_.seek(file_.offset() + bytes, file_.lineNumber()); }

    InputFile& file_;
    bool isText_, swap_;
    std::uint64_t start_ = 0;  ///< of the entry
    std::vector<std::string_view> words_;
    std::size_t word_ = 0;
};

}  // namespace

Pack<3> readPly(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    const PlyHeader header = readPlyHeader(file);
    const auto vertex = std::find_if(header.elements.begin(), header.elements.end(),
                                     [](const PlyElement& e) { return e.name == "vertex"; });
    if (vertex == header.elements.end())
        file.fail("has no element 'vertex'; spheres are expected there");

    Body body(file, header.format);
    // Lists (none of ours) have no data of spheres and are skipped.
    std::vector<std::string> names;
    std::size_t least = 0;  // bytes of a vertex
    for (const auto& p : vertex->properties) {
        if (!p.isList) names.push_back(p.name);
        least += body.isText() ? 2 : bytesOf(p.isList ? p.countType : p.type);
    }
    PackReadOptions stated = options;
    for (const auto& comment : header.comments) stated.unit = unitIn(comment, stated.unit, file);
    PackBuilder builder(path, names, stated);
    for (auto element = header.elements.begin(); element != vertex; ++element) body.skip(*element);
    // The last number of a text needs no end.
    if (vertex->count > (file.remaining() + (body.isText() ? 1 : 0)) / least)
        file.fail(fmt::format(
            "holds fewer than the {} vertices that its header announces; the file is cut short",
            vertex->count));
    builder.reserve(static_cast<std::size_t>(vertex->count));
    for (std::uint64_t i = 0; i < vertex->count; ++i) {
        const auto where = [&] { return fmt::format("vertex {}, {}", i, body.where()); };
        body.begin(*vertex, i);
        builder.addRow();
        std::size_t column = 0;
        for (const auto& p : vertex->properties) {
            if (p.isList) {
                body.skip(p);
                continue;
            }
            if (!body.number(p.type, [&](auto value) { return builder.set(column, value); }))
                builder.failCell(where(), column, body.last());
            ++column;
        }
        builder.checkRow(where);
    }
    return builder.finish();
}

}  // namespace vdbpack
