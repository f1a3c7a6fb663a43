// VTK's XML polygon data: one vertex cell a point, for ParaView.
#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace vdbpack {

namespace {

// ---- writing -----------------------------------------------------------------------------------

/// A text as VTK writes strings in ASCII: character codes, ended by 0.
std::string asCodes(const std::string& text) {
    std::string out;
    for (const char c : text) out += fmt::format("{} ", static_cast<unsigned char>(c));
    return out + "0";
}

/// An array of the appended section.
struct Block {
    std::uint64_t bytes = 0;
    std::function<void(OutputFile&)> write;
};

/// `count` numbers, made one by one.
template <typename T, typename Get>
Block block(std::size_t count, const Get& get) {
    return {count * sizeof(T), [count, get](OutputFile& out) {
                std::vector<T> part;
                part.reserve(std::min<std::size_t>(count, 1 << 15));
                for (std::size_t i = 0; i < count; ++i) {
                    part.push_back(static_cast<T>(get(i)));
                    if (part.size() < part.capacity() && i + 1 < count) continue;
                    out.write(part.data(), part.size() * sizeof(T));
                    part.clear();
                }
            }};
}

class Writer {
public:
    explicit Writer(OutputFile& out) : out_(out) {}

    void line(const std::string& text) { out_.write(text + "\n"); }
    void array(const std::string& element, const std::string& attributes, Block data) {
        line(fmt::format("        <{} {} format=\"appended\" offset=\"{}\"/>", element, attributes,
                         offset_));
        offset_ += sizeof(std::uint64_t) + data.bytes;
        blocks_.push_back(std::move(data));
    }
    template <typename T, typename Get>
    void numbers(std::string_view name, std::size_t count, const Get& get) {
        constexpr const char* kType = std::is_floating_point_v<T> ? "Float" : "Int";
        array("DataArray",
              fmt::format("type=\"{}{}\" Name=\"{}\"", kType, 8 * sizeof(T), escapedXml(name)),
              block<T>(count, get));
    }
    void texts(std::string_view name, const std::vector<std::string>& list) {
        // Each text ends with a 0, so it holds none itself.
        Block data;
        for (const auto& t : list) data.bytes += oneLine(t).size() + 1;
        data.write = [&list](OutputFile& file) {
            for (const auto& t : list) {
                const std::string clean = oneLine(t);
                file.write(clean.c_str(), clean.size() + 1);
            }
        };
        array("Array", fmt::format("type=\"String\" Name=\"{}\"", escapedXml(name)),
              std::move(data));
    }
    void finish() {
        out_.write(std::string("  <AppendedData encoding=\"raw\">\n   _"));
        for (const auto& b : blocks_) {
            out_.write(&b.bytes, sizeof b.bytes);
            b.write(out_);
        }
        out_.write(std::string("\n  </AppendedData>\n</VTKFile>\n"));
    }

private:
    OutputFile& out_;
    std::vector<Block> blocks_;
    std::uint64_t offset_ = 0;
};

// ---- reading: XML ------------------------------------------------------------------------------

/// One tag: <name attributes>, </name> or <name attributes/>.
struct Tag {
    std::string_view name;
    std::map<std::string_view, std::string_view> attributes;
    bool closing = false;
    bool selfClosing = false;

    std::string_view attribute(std::string_view key) const {
        const auto at = attributes.find(key);
        return at == attributes.end() ? std::string_view() : at->second;
    }
};

bool isBlank(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

void appendUtf8(std::string& out, std::uint32_t code) {
    const auto put = [&](std::uint32_t byte) { out += static_cast<char>(byte); };
    const auto rest = [&](int shift) { put(0x80 | (code >> shift & 0x3f)); };
    if (code < 0x80) {
        put(code);
    } else if (code < 0x800) {
        put(0xc0 | code >> 6);
        rest(0);
    } else if (code < 0x10000) {
        put(0xe0 | code >> 12);
        rest(6);
        rest(0);
    } else {
        put(0xf0 | code >> 18);
        rest(12);
        rest(6);
        rest(0);
    }
}

/// The length of a reference as "&#233;" or "&#xe9;" at the start of `text`, with its character.
/// @return 0 if there is none, or none that XML allows.
std::size_t characterReference(std::string_view text, std::uint32_t& code) {
    if (text.substr(0, 2) != "&#") return 0;
    const bool hex = text.substr(2, 1) == "x";
    const char* const first = text.data() + (hex ? 3 : 2);
    const char* const end = text.data() + text.size();
    if (first >= end) return 0;
    const auto [last, error] = std::from_chars(first, end, code, hex ? 16 : 10);
    const bool allowed = code >= 0x20 && code <= 0x10ffff && (code < 0xd800 || code > 0xdfff);
    if (error != std::errc() || last == end || *last != ';' || !allowed) return 0;
    return static_cast<std::size_t>(last + 1 - text.data());
}

std::string unescaped(std::string_view text) {
    static constexpr struct {
        std::string_view entity;
        char c;
    } kEntities[] = {
        {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
    std::string out;
    for (std::size_t i = 0; i < text.size();) {
        bool replaced = false;
        for (const auto& e : kEntities) {
            if (text.substr(i, e.entity.size()) != e.entity) continue;
            out += e.c;
            i += e.entity.size();
            replaced = true;
            break;
        }
        if (replaced) continue;
        std::uint32_t code = 0;
        if (const std::size_t length = characterReference(text.substr(i), code)) {
            appendUtf8(out, code);
            i += length;
        } else {
            out += text[i++];
        }
    }
    return out;
}

/// Walks through the tags of the little XML that VTK writes.
class TagReader {
public:
    TagReader(const std::string& path, std::string_view text) : path_(path), text_(text) {}

    std::size_t position() const { return at_; }
    /// The text up to the next tag.
    std::string_view textAhead() const {
        return text_.substr(at_, std::min(text_.find('<', at_), text_.size()) - at_);
    }
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(fmt::format("{}: byte {}: {}; the file is damaged or not a .vtp file",
                                     path_, at_, what));
    }
    /// @return false at the end of the text.
    bool next(Tag& tag) {
        for (;;) {
            at_ = text_.find('<', at_);
            if (at_ == std::string_view::npos) return at_ = text_.size(), false;
            if (text_.substr(at_, 4) == "<!--") {
                skipPast("-->");
            } else if (text_.substr(at_, 2) == "<?" || text_.substr(at_, 2) == "<!") {
                skipPast(">");
            } else {
                break;
            }
        }
        tag = {};
        ++at_;
        if (peek() == '/') {
            tag.closing = true;
            ++at_;
        }
        tag.name = word();
        if (tag.name.empty()) fail("a tag has no name");
        for (;;) {
            blanks();
            const char c = peek();
            if (c == '\0') fail("a tag is not closed");
            if (c == '>') return ++at_, true;
            if (c == '/') {
                tag.selfClosing = true;
                ++at_;
                continue;
            }
            const auto key = word();
            blanks();
            if (key.empty() || peek() != '=') fail("malformed attribute");
            ++at_;
            blanks();
            const char quote = peek();
            if (quote != '"' && quote != '\'') fail("an attribute has no quotes");
            const auto end = text_.find(quote, at_ + 1);
            if (end == std::string_view::npos) fail("an attribute is not closed");
            tag.attributes[key] = text_.substr(at_ + 1, end - at_ - 1);
            at_ = end + 1;
        }
    }

private:
    char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
    void blanks() {
        while (at_ < text_.size() && isBlank(text_[at_])) ++at_;
    }
    std::string_view word() {
        const std::size_t begin = at_;
        while (at_ < text_.size() && !isBlank(text_[at_]) && text_[at_] != '=' &&
               text_[at_] != '>' && text_[at_] != '/')
            ++at_;
        return text_.substr(begin, at_ - begin);
    }
    void skipPast(std::string_view end) {
        const auto found = text_.find(end, at_);
        if (found == std::string_view::npos) fail("a comment is not closed");
        at_ = found + end.size();
    }

    const std::string& path_;
    std::string_view text_;
    std::size_t at_ = 0;
};

// ---- reading: arrays ---------------------------------------------------------------------------

/// Bytes in order, from the file or from base64 text.
class ByteSource {
public:
    ByteSource(const InputFile& file, std::uint64_t offset) : file_(file), offset_(offset) {}
    ByteSource(const InputFile& file, std::string_view base64)
        : file_(file), text_(base64), encoded_(true) {}

    /// No more bytes than these can follow.
    std::uint64_t bound() const {
        if (encoded_) return text_.size() - at_ + 3;
        return offset_ < file_.size() ? file_.size() - offset_ : 0;
    }
    void read(char* target, std::size_t bytes) {
        if (!encoded_) {
            file_.readAt(offset_, target, bytes);
            offset_ += bytes;
            return;
        }
        for (std::size_t done = 0; done < bytes;) {
            if (carried_ == 0) decodeGroup();
            const std::size_t n = std::min(bytes - done, carried_);
            std::memcpy(target + done, carry_.data(), n);
            std::memmove(carry_.data(), carry_.data() + n, carried_ - n);
            carried_ -= n;
            done += n;
        }
    }

private:
    [[noreturn]] void fail(const char* what) const {
        throw InputError(fmt::format("{}: a base64 array {}; the file is damaged or cut short",
                                     file_.path(), what));
    }
    /// The next four characters. Padding may stand in mid-stream: VTK encodes the header of
    /// compressed blocks on its own.
    void decodeGroup() {
        std::uint32_t bits = 0;
        std::size_t characters = 0;
        std::size_t padding = 0;
        while (characters < 4) {
            if (at_ >= text_.size()) fail("ends too early");
            const char c = text_[at_++];
            if (isBlank(c)) continue;
            std::uint32_t value = 0;
            if (c >= 'A' && c <= 'Z')
                value = static_cast<std::uint32_t>(c - 'A');
            else if (c >= 'a' && c <= 'z')
                value = static_cast<std::uint32_t>(c - 'a' + 26);
            else if (c >= '0' && c <= '9')
                value = static_cast<std::uint32_t>(c - '0' + 52);
            else if (c == '+')
                value = 62;
            else if (c == '/')
                value = 63;
            else if (c == '=')
                ++padding;
            else
                fail("holds a character that is not base64");
            bits = bits << 6 | value;
            ++characters;
        }
        if (padding > 2) fail("is malformed");
        for (std::size_t i = 0; i < 3; ++i)
            carry_[i] = static_cast<char>(static_cast<unsigned char>(bits >> (16 - 8 * i)));
        carried_ = 3 - padding;
    }

    const InputFile& file_;
    std::uint64_t offset_ = 0;
    std::string_view text_;
    std::size_t at_ = 0;
    bool encoded_ = false;
    std::array<char, 3> carry_{};
    std::size_t carried_ = 0;
};

/// An array as its tag describes it; `data` once it is loaded.
struct Array {
    std::string name;
    NumberType type = NumberType::f64;
    bool string = false;
    std::uint64_t components = 1;
    std::string_view format;
    std::string_view text;     ///< between the tags
    std::uint64_t offset = 0;  ///< into the appended section
    std::vector<char> data;
};

struct Piece {
    std::uint64_t points = 0;
    Array positions;
    std::vector<Array> attributes;
};

class VtpReader {
public:
    VtpReader(const std::string& path, const PackReadOptions& options)
        : file_(path), unit_(options.unit) {}

    Pack<3> read() {
        loadXml();
        parse();
        applyUnit();
        if (pieces_.empty()) throw InputError(file_.path() + ": holds no piece with points");
        std::vector<std::string> names = {"x", "y", "z"};
        const auto& first = pieces_.front().attributes;
        for (const auto& a : first)
            for (std::uint64_t c = 0; c < a.components; ++c)
                names.push_back(a.components == 1 ? a.name : fmt::format("{}_{}", a.name, c));
        PackBuilder builder(file_.path(), names, unit_);
        std::size_t column = 3;
        for (const auto& a : first) {
            if (a.string) {
                if (!builder.isFurther(column))
                    throw InputError(fmt::format("{}: array '{}' holds texts; numbers are needed",
                                                 file_.path(), a.name));
                builder.makeText(column);
            }
            column += a.components;
        }
        for (auto& piece : pieces_) append(piece, builder);
        return builder.finish();
    }

private:
    [[noreturn]] void fail(const std::string& name, const std::string& what) const {
        throw InputError(fmt::format("{}: array '{}' {}", file_.path(), name.substr(0, 40), what));
    }

    /// Everything up to the appended bytes, where there are some; else the whole file.
    void loadXml() {
        constexpr std::string_view kAppended = "<AppendedData";
        constexpr std::uint64_t kChunk = 1 << 16;
        std::size_t searched = 0;
        while (xml_.size() < file_.size()) {
            const std::size_t before = xml_.size();
            const auto more = static_cast<std::size_t>(std::min<std::uint64_t>(
                std::max<std::uint64_t>(kChunk, before), file_.size() - before));
            xml_.resize(before + more);
            file_.readAt(before, xml_.data() + before, more);
            const auto found = xml_.find(kAppended, searched);
            if (found != std::string::npos) {
                const auto marker = xml_.find('_', found + kAppended.size());
                if (marker != std::string::npos) {
                    appended_ = marker + 1;
                    xml_.resize(marker);
                    return;
                }
                searched = found;
            } else {
                searched = xml_.size() - std::min(xml_.size(), kAppended.size());
            }
        }
    }

    void parse() {
        TagReader tags(file_.path(), xml_);
        Tag tag;
        if (!tags.next(tag) || tag.name != "VTKFile" || tag.attribute("type") != "PolyData")
            throw InputError(file_.path() +
                             ": is not a .vtp file: VTKFile of type PolyData is expected");
        swap_ = (tag.attribute("byte_order") == "BigEndian") != hostIsBigEndian();
        wideHeader_ = tag.attribute("header_type") == "UInt64";
        compressor_ = tag.attribute("compressor");

        std::string_view section;
        while (tags.next(tag)) {
            if (tag.closing) {
                if (tag.name == section) section = {};
                if (tag.name == "VTKFile") return;
                continue;
            }
            if (tag.name == "Piece") {
                pieces_.emplace_back();
                std::int64_t n = 0;
                if (!parseNumber(tag.attribute("NumberOfPoints"), n) || n < 0)
                    tags.fail("a piece has no usable NumberOfPoints");
                pieces_.back().points = static_cast<std::uint64_t>(n);
            } else if (tag.name == "FieldData" || tag.name == "PointData" || tag.name == "Points") {
                if (!tag.selfClosing) section = tag.name;
            } else if (tag.name == "AppendedData") {
                encoded_ = tag.attribute("encoding") == "base64";
                if (encoded_) loadAppendedText();
                if (appended_ == 0) tags.fail("the appended section has no data");
                return;
            } else if (tag.name == "DataArray" || tag.name == "Array") {
                Array array = described(tag, tags);
                if (section == "FieldData")
                    field_.push_back(std::move(array));
                else if (section == "PointData" && !pieces_.empty())
                    pieces_.back().attributes.push_back(std::move(array));
                else if (section == "Points" && !pieces_.empty())
                    pieces_.back().positions = std::move(array);
            }
        }
        if (appended_ != 0) tags.fail("the appended section is malformed");
    }

    void loadAppendedText() {
        appendedText_.resize(static_cast<std::size_t>(file_.size() - appended_));
        file_.readAt(appended_, appendedText_.data(), appendedText_.size());
        const auto end = appendedText_.find('<');
        if (end != std::string::npos) appendedText_.resize(end);
    }

    static Array described(const Tag& tag, const TagReader& tags) {
        static const std::map<std::string_view, NumberType> kTypes = {
            {"Int8", NumberType::i8},    {"UInt8", NumberType::u8},   {"Int16", NumberType::i16},
            {"UInt16", NumberType::u16}, {"Int32", NumberType::i32},  {"UInt32", NumberType::u32},
            {"Int64", NumberType::i64},  {"UInt64", NumberType::u64}, {"Float32", NumberType::f32},
            {"Float64", NumberType::f64}};
        Array a;
        a.name = unescaped(tag.attribute("Name"));
        const auto type = tag.attribute("type");
        a.string = type == "String";
        if (!a.string) {
            const auto known = kTypes.find(type);
            if (known == kTypes.end()) tags.fail("an array has an unknown type");
            a.type = known->second;
        }
        std::int64_t components = 1;
        if (!tag.attribute("NumberOfComponents").empty() &&
            (!parseNumber(tag.attribute("NumberOfComponents"), components) || components < 1 ||
             components > 16))
            tags.fail("an array has an unusable number of components");
        a.components = static_cast<std::uint64_t>(components);
        a.format = tag.attribute("format");
        if (a.format == "appended") {
            std::int64_t offset = 0;
            if (!parseNumber(tag.attribute("offset"), offset) || offset < 0)
                tags.fail("an appended array has no usable offset");
            a.offset = static_cast<std::uint64_t>(offset);
        } else if (!tag.selfClosing) {
            a.text = tags.textAhead();
        }
        return a;
    }

    std::uint64_t readHeaderWord(ByteSource& source) const {
        char bytes[8];
        source.read(bytes, wideHeader_ ? 8 : 4);
        return wideHeader_ ? loadAs<std::uint64_t>(bytes, swap_)
                           : loadAs<std::uint32_t>(bytes, swap_);
    }

    ByteSource sourceOf(const Array& a) const {
        if (a.format != "appended") return ByteSource(file_, a.text);
        if (appended_ == 0) fail(a.name, "is appended, but nothing is; the file is cut short");
        // An offset near 2^63 must not wrap around into the file.
        const std::uint64_t end = encoded_ ? appendedText_.size() : file_.size();
        if (a.offset > end) fail(a.name, "begins behind the end of the file; it is cut short");
        if (!encoded_) return ByteSource(file_, appended_ + a.offset);
        return ByteSource(file_, std::string_view(appendedText_).substr(a.offset));
    }

    /// The bytes of an array that is not ASCII.
    std::vector<char> bytesOfArray(const Array& a) {
        // ASCII arrays are plain whatever the file says, so this is not asked before.
        const bool zlib = compressor_ == "vtkZLibDataCompressor";
        if (!zlib && !compressor_.empty())
            fail(a.name, fmt::format("is packed by '{}', which is not supported; save with zlib or "
                                     "without compression",
                                     compressor_.substr(0, 40)));
        ByteSource source = sourceOf(a);
        const std::uint64_t before = source.bound();
        std::vector<char> data = unpacked(a, source, zlib);
        // Arrays that share their bytes would add up to any size.
        taken_ += before - source.bound();
        if (taken_ > file_.size())
            fail(a.name, "shares its bytes with other arrays; save the file again");
        return data;
    }

    std::vector<char> unpacked(const Array& a, ByteSource& source, bool zlib) const {
        std::vector<char> data;
        if (!zlib) {
            const std::uint64_t bytes = readHeaderWord(source);
            if (bytes > source.bound())
                fail(a.name, fmt::format("announces {} bytes, more than the file holds; the file "
                                         "is cut short",
                                         bytes));
            data.resize(static_cast<std::size_t>(bytes));
            source.read(data.data(), data.size());
            return data;
        }
        const std::uint64_t blocks = readHeaderWord(source);
        const std::uint64_t blockBytes = readHeaderWord(source);
        const std::uint64_t lastBytes = readHeaderWord(source);
        if (blocks > source.bound() / (wideHeader_ ? 8 : 4))
            fail(a.name, "announces more blocks than the file holds; the file is cut short");
        std::vector<std::uint64_t> sizes(static_cast<std::size_t>(blocks));
        for (auto& s : sizes) s = readHeaderWord(source);
        std::vector<char> packed;
        for (std::size_t b = 0; b < sizes.size(); ++b) {
            const std::uint64_t full =
                b + 1 == sizes.size() && lastBytes != 0 ? lastBytes : blockBytes;
            // Deflate expands by less than 1032: larger claims are made up.
            if (sizes[b] > source.bound() || full > (sizes[b] + 16) * 1032)
                fail(a.name, fmt::format("has an impossible block {}; the file is damaged", b));
            packed.resize(static_cast<std::size_t>(sizes[b]));
            source.read(packed.data(), packed.size());
            const std::size_t before = data.size();
            data.resize(before + static_cast<std::size_t>(full));
            uLongf got = static_cast<uLongf>(full);
            Bytef nothing = 0;
            const int status = ::uncompress(
                full > 0 ? reinterpret_cast<Bytef*>(data.data() + before) : &nothing, &got,
                reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
            if (status == Z_MEM_ERROR) throw std::bad_alloc();
            if (status != Z_OK || got != full)
                fail(a.name,
                     fmt::format("has a block {} that does not inflate; the file is damaged", b));
        }
        return data;
    }

    /// Loads `count` tuples as bytes of the array's type.
    void load(Array& a, std::uint64_t count) {
        const std::size_t size = bytesOf(a.type);
        if (a.format == "ascii" || a.format.empty()) {
            // Two characters a number at least.
            if (count > a.text.size() / (2 * a.components) + 1)
                fail(a.name,
                     fmt::format("holds fewer than {} tuples; the file is cut short", count));
            a.data.resize(static_cast<std::size_t>(count * a.components) * size);
            std::size_t at = 0;
            for (std::size_t i = 0; i < count * a.components; ++i)
                storeWord(a, nextWord(a.text, at), i);
            if (!nextWord(a.text, at).empty())
                fail(a.name, fmt::format("holds more than {} tuples; the file is damaged", count));
            a.text = {};
            return;
        }
        a.data = bytesOfArray(a);
        if (a.data.size() % (a.components * size) != 0 ||
            a.data.size() / (a.components * size) != count)
            fail(a.name, fmt::format("has {} bytes where {} tuples of {} bytes are expected; the "
                                     "file is damaged",
                                     a.data.size(), count, a.components * size));
    }

    static std::string_view nextWord(std::string_view text, std::size_t& at) {
        while (at < text.size() && isBlank(text[at])) ++at;
        const std::size_t begin = at;
        while (at < text.size() && !isBlank(text[at])) ++at;
        return text.substr(begin, at - begin);
    }

    /// Number `index` of an ASCII array, as bytes of its type, in the byte order of the file.
    void storeWord(Array& a, std::string_view word, std::size_t index) const {
        const auto bad = [&] {
            fail(a.name, word.empty()
                             ? fmt::format("ends after {} numbers; the file is cut short", index)
                             : fmt::format("has '{}' as number {}; a number of its type is needed",
                                           word.substr(0, 40), index));
        };
        char bytes[8];
        const auto keep = [&](auto value) {
            std::memcpy(bytes, &value, sizeof value);
            if (swap_) std::reverse(bytes, bytes + sizeof value);
        };
        if (isReal(a.type)) {
            double value = 0;
            if (!parseNumber(word, value)) bad();
            if (a.type == NumberType::f64) {
                keep(value);
            } else {
                // Beyond its range the conversion is undefined; infinities do convert.
                if (std::isfinite(value) &&
                    std::abs(value) > static_cast<double>(std::numeric_limits<float>::max()))
                    bad();
                keep(static_cast<float>(value));
            }
        } else {
            std::int64_t value = 0;
            if (!parseNumber(word, value)) bad();
            const std::size_t bits = 8 * bytesOf(a.type);
            const bool isSigned = a.type == NumberType::i8 || a.type == NumberType::i16 ||
                                  a.type == NumberType::i32 || a.type == NumberType::i64;
            if (bits < 64) {
                const std::int64_t top = std::int64_t{1} << (isSigned ? bits - 1 : bits);
                if (value >= top || value < (isSigned ? -top : 0)) bad();
            } else if (!isSigned && value < 0) {
                bad();
            }
            if (bits == 8)
                keep(static_cast<std::uint8_t>(value));
            else if (bits == 16)
                keep(static_cast<std::uint16_t>(value));
            else if (bits == 32)
                keep(static_cast<std::uint32_t>(value));
            else
                keep(static_cast<std::uint64_t>(value));
        }
        std::memcpy(a.data.data() + index * bytesOf(a.type), bytes, bytesOf(a.type));
    }

    std::vector<std::string> texts(const Array& a) {
        std::vector<char> data;
        if (a.format == "ascii" || a.format.empty()) {
            std::size_t at = 0;
            for (auto word = nextWord(a.text, at); !word.empty(); word = nextWord(a.text, at)) {
                std::int64_t code = 0;
                if (!parseNumber(word, code) || code < 0 || code > 255)
                    fail(a.name, "holds a character code beyond 0 to 255; the file is damaged");
                data.push_back(static_cast<char>(static_cast<unsigned char>(code)));
            }
        } else {
            data = bytesOfArray(a);
        }
        if (!data.empty() && data.back() != '\0')
            fail(a.name, "has a last text that is not ended; the file is cut short");
        std::vector<std::string> out;
        for (auto begin = data.begin(); begin != data.end();) {
            const auto end = std::find(begin, data.end(), '\0');
            out.emplace_back(begin, end);
            begin = end + 1;
        }
        return out;
    }

    /// Takes the unit from the field data.
    void applyUnit() {
        for (const auto& a : field_) {
            if (a.name != kUnitKey || !a.string) continue;
            const auto found = texts(a);
            if (!found.empty() && !parseUnitComment(kUnitComment + found[0], unit_))
                throw InputError(fmt::format("{}: unknown unit '{}'; use m, cm, mm or um",
                                             file_.path(), found[0].substr(0, 40)));
        }
    }

    void append(Piece& piece, PackBuilder& builder) {
        if (piece.points == 0) return;
        Array& p = piece.positions;
        if (p.components != 3 || p.string)
            throw InputError(file_.path() + ": a piece has no points with three coordinates");
        const auto& first = pieces_.front().attributes;
        bool alike = first.size() == piece.attributes.size();
        for (std::size_t a = 0; alike && a < first.size(); ++a)
            alike = first[a].name == piece.attributes[a].name &&
                    first[a].string == piece.attributes[a].string &&
                    first[a].components == piece.attributes[a].components;
        if (!alike)
            throw InputError(file_.path() +
                             ": its pieces have different arrays; save it as one piece");

        load(p, piece.points);
        std::vector<std::vector<std::string>> strings(piece.attributes.size());
        for (std::size_t a = 0; a < piece.attributes.size(); ++a) {
            auto& array = piece.attributes[a];
            if (!array.string) {
                load(array, piece.points);
                continue;
            }
            strings[a] = texts(array);
            if (array.components != 1 || strings[a].size() != piece.points)
                fail(array.name, fmt::format("holds {} texts for {} points; the file is damaged",
                                             strings[a].size(), piece.points));
        }
        if (pieces_.size() == 1) builder.reserve(static_cast<std::size_t>(piece.points));
        for (std::size_t i = 0; i < piece.points; ++i) {
            const auto where = [&] { return fmt::format("point {}", i); };
            builder.addRow();
            std::size_t column = 0;
            const auto put = [&](const Array& a) {
                const std::size_t size = bytesOf(a.type);
                for (std::size_t c = 0; c < a.components; ++c, ++column) {
                    const char* bytes = a.data.data() + (i * a.components + c) * size;
                    const bool sound = loadNumber(a.type, bytes, swap_, [&](auto value) {
                        return builder.set(column, value);
                    });
                    if (!sound) builder.failCell(where(), column, "out of range");
                }
            };
            put(p);
            for (std::size_t a = 0; a < piece.attributes.size(); ++a) {
                if (piece.attributes[a].string)
                    builder.setText(column++, strings[a][i]);
                else
                    put(piece.attributes[a]);
            }
            if (!builder.problem().empty()) builder.failRow(where());
        }
        // One piece at a time is enough in memory; what the first one looks like stays known.
        p.data = {};
        for (auto& a : piece.attributes) a.data = {};
    }

    InputFile file_;
    Unit unit_;
    std::string xml_;
    std::uint64_t appended_ = 0;  ///< offset of the first appended byte, 0: none
    bool encoded_ = false;        ///< the appended section is base64
    std::string appendedText_;
    bool swap_ = false;
    bool wideHeader_ = false;
    std::string_view compressor_;  ///< empty: none
    std::uint64_t taken_ = 0;      ///< bytes of the file that arrays took
    std::vector<Piece> pieces_;
    std::vector<Array> field_;
};

}  // namespace

void writeVtp(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    const std::size_t n = pack.size();
    Writer xml(out);
    xml.line("<?xml version=\"1.0\"?>");
    xml.line(
        fmt::format("<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{}\" "
                    "header_type=\"UInt64\">",
                    hostIsBigEndian() ? "BigEndian" : "LittleEndian"));
    xml.line("  <PolyData>");
    xml.line("    <FieldData>");
    const auto note = [&xml](const char* name, const std::string& text) {
        xml.line(
            fmt::format("      <Array type=\"String\" Name=\"{}\" NumberOfTuples=\"1\" "
                        "format=\"ascii\">{}</Array>",
                        name, asCodes(text)));
    };
    note(kUnitKey, unitName(options.unit));
    if (!options.generator.empty()) note(kGeneratorKey, oneLine(options.generator));
    xml.line("    </FieldData>");
    xml.line(
        fmt::format("    <Piece NumberOfPoints=\"{0}\" NumberOfVerts=\"{0}\" "
                    "NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">",
                    n));

    xml.line("      <PointData Scalars=\"radius\">");
    xml.numbers<double>("radius", n, [&pack](std::size_t i) { return pack.radius(i); });
    xml.numbers<std::int64_t>("id", n, [&pack](std::size_t i) { return pack.id(i); });
    pack.forEachAttribute(
        [&](std::string_view name, const auto& numbers) {
            xml.numbers<ValueOf<decltype(numbers)>>(
                name, n, [&pack, &numbers](std::size_t i) { return pack.value(numbers, i); });
        },
        [&](std::string_view name, const auto& texts) { xml.texts(name, texts); });
    xml.line("      </PointData>");

    xml.line("      <Points>");
    xml.array("DataArray", "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"",
              block<std::array<double, 3>>(n, [&pack](std::size_t i) { return pack.position(i); }));
    xml.line("      </Points>");
    xml.line("      <Verts>");
    xml.numbers<std::int64_t>("connectivity", n,
                              [](std::size_t i) { return static_cast<std::int64_t>(i); });
    xml.numbers<std::int64_t>("offsets", n,
                              [](std::size_t i) { return static_cast<std::int64_t>(i + 1); });
    xml.line("      </Verts>");
    xml.line("    </Piece>");
    xml.line("  </PolyData>");
    xml.finish();
}

Pack<3> readVtp(const std::string& path, const PackReadOptions& options) {
    return VtpReader(path, options).read();
}

}  // namespace vdbpack
