#include "vdbpack/io/vtk_arrays.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>

namespace vdbpack {

namespace {

/// Deflate expands by less than this factor.
constexpr std::uint64_t kMostDeflated = 1032;

bool isXmlBlank(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

std::string_view nextWord(std::string_view text, std::size_t& at) {
    while (at < text.size() && isXmlBlank(text[at])) ++at;
    const std::size_t begin = at;
    while (at < text.size() && !isXmlBlank(text[at])) ++at;
    return text.substr(begin, at - begin);
}

/// The six bits of a base64 character; -1 for any other.
int base64Value(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+') return 62;
    return c == '/' ? 63 : -1;
}

}  // namespace

/// Bytes in order, from the file or from base64 text.
class VtkArrays::ByteSource {
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
            if (isXmlBlank(c)) continue;
            const int value = base64Value(c);
            if (c == '=')
                ++padding;
            else if (value < 0)
                fail("holds a character that is not base64");
            bits = bits << 6 | static_cast<std::uint32_t>(std::max(value, 0));
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

void VtkArrays::fail(const VtkArray& array, const std::string& what) const {
    const std::string which = array.name.empty() ? "the array in <" + array.tag + ">"
                                                 : "array " + quotedExcerpt(array.name);
    throw InputError(fmt::format("{}: {} {}", file_.path(), which, what));
}

void VtkArrays::appendBase64(std::uint64_t offset) {
    appended_ = offset;
    base64_ = true;
    appendedText_.resize(static_cast<std::size_t>(file_.size() - offset));
    file_.readAt(offset, appendedText_.data(), appendedText_.size());
    const auto end = appendedText_.find('<');
    if (end != std::string::npos) appendedText_.resize(end);
}

VtkArrays::ByteSource VtkArrays::sourceOf(const VtkArray& array) const {
    if (array.format != VtkArray::Format::appended) return ByteSource(file_, array.text);
    if (appended_ == 0) fail(array, "is appended, but nothing is; the file is cut short");
    // An offset near 2^63 must not wrap around into the file.
    const std::uint64_t end = base64_ ? appendedText_.size() : file_.size();
    if (array.offset > end) fail(array, "begins behind the end of the file; it is cut short");
    if (!base64_) return ByteSource(file_, appended_ + array.offset);
    return ByteSource(file_, std::string_view(appendedText_).substr(array.offset));
}

std::uint64_t VtkArrays::headerWord(ByteSource& source) const {
    char bytes[8];
    source.read(bytes, encoding_.wideHeader ? 8 : 4);
    return encoding_.wideHeader ? loadAs<std::uint64_t>(bytes, encoding_.swap)
                                : loadAs<std::uint32_t>(bytes, encoding_.swap);
}

template <class Check>
std::vector<char> VtkArrays::bytesOfArray(const VtkArray& array, const Check& isSound) {
    // ASCII arrays are plain whatever the file says, so this is not asked before.
    const bool zlib = encoding_.compressor == "vtkZLibDataCompressor";
    if (!zlib && !encoding_.compressor.empty())
        fail(array, fmt::format("is packed by {}, which is not supported; save with zlib or "
                                "without compression",
                                quotedExcerpt(encoding_.compressor)));
    ByteSource source = sourceOf(array);
    const std::uint64_t before = source.bound();
    Blocks blocks;
    if (zlib)
        blocks = blocksOf(array, source);
    else
        blocks.last = headerWord(source);
    if (!zlib && blocks.last > source.bound())
        fail(array, fmt::format("announces {} bytes, more than the file holds; the file is cut "
                                "short",
                                blocks.last));
    const std::uint64_t others = blocks.packed.empty() ? 0 : blocks.packed.size() - 1;
    const std::uint64_t bytes =
        zlib && blocks.packed.empty() ? 0 : others * blocks.full + blocks.last;
    isSound(bytes);
    requireMemoryToRead(file_.path(), static_cast<double>(bytes), memoryLimit_);
    std::vector<char> data(static_cast<std::size_t>(bytes));
    if (zlib)
        inflate(array, blocks, source, data);
    else
        source.read(data.data(), data.size());
    // Arrays that share their bytes would add up to any size.
    taken_ += before - source.bound();
    if (taken_ > file_.size())
        fail(array, "shares its bytes with other arrays; save the file again");
    return data;
}

VtkArrays::Blocks VtkArrays::blocksOf(const VtkArray& array, ByteSource& source) const {
    Blocks blocks;
    const std::uint64_t count = headerWord(source);
    blocks.full = headerWord(source);
    blocks.last = headerWord(source);
    if (blocks.last == 0) blocks.last = blocks.full;
    if (count > source.bound() / (encoding_.wideHeader ? 8 : 4))
        fail(array, "announces more blocks than the file holds; the file is cut short");
    blocks.packed.resize(static_cast<std::size_t>(count));
    for (auto& s : blocks.packed) s = headerWord(source);
    // Larger claims are made up. What the file holds bounds the sum, so that it cannot overflow.
    std::uint64_t left = source.bound();
    for (std::size_t b = 0; b < blocks.packed.size(); ++b) {
        const std::uint64_t packed = blocks.packed[b];
        if (packed > left || blocks.size(b) > (packed + 16) * kMostDeflated)
            fail(array, fmt::format("has an impossible block {}; the file is damaged", b));
        left -= packed;
    }
    return blocks;
}

void VtkArrays::inflate(const VtkArray& array, const Blocks& blocks, ByteSource& source,
                        std::vector<char>& data) const {
    std::vector<char> packed;
    std::size_t at = 0;
    for (std::size_t b = 0; b < blocks.packed.size(); ++b) {
        packed.resize(static_cast<std::size_t>(blocks.packed[b]));
        source.read(packed.data(), packed.size());
        const auto full = static_cast<uLongf>(blocks.size(b));
        uLongf got = full;
        Bytef nothing = 0;
        const int status = ::uncompress(
            full > 0 ? reinterpret_cast<Bytef*>(data.data() + at) : &nothing, &got,
            reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
        if (status == Z_MEM_ERROR) throw std::bad_alloc();
        if (status != Z_OK || got != full)
            fail(array,
                 fmt::format("has a block {} that does not inflate; the file is damaged", b));
        at += static_cast<std::size_t>(full);
    }
}

VtkNumbers VtkArrays::numbers(const VtkArray& array, std::uint64_t count) {
    if (array.format == VtkArray::Format::ascii) return asciiNumbers(array, count);
    const std::size_t tuple = array.components * bytesOf(array.type);
    const auto isSound = [&](std::uint64_t bytes) {
        if (bytes % tuple != 0 || bytes / tuple != count)
            fail(array,
                 fmt::format("has {} bytes where {} tuples of {} bytes are expected; the file "
                             "is damaged",
                             bytes, count, tuple));
    };
    return {bytesOfArray(array, isSound), array.type, encoding_.swap};
}

VtkNumbers VtkArrays::asciiNumbers(const VtkArray& array, std::uint64_t count) const {
    // Two characters a number at least.
    if (count > array.text.size() / (2 * array.components) + 1)
        fail(array, fmt::format("holds fewer than {} tuples; the file is cut short", count));
    const bool real = isReal(array.type);
    const auto n = static_cast<std::size_t>(count * array.components);
    VtkNumbers numbers{std::vector<char>(8 * n), real ? NumberType::f64 : NumberType::i64, false};
    std::size_t at = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const auto word = nextWord(array.text, at);
        double value = 0;
        std::int64_t whole = 0;
        if (!(real ? parseNumber(word, value) : parseNumber(word, whole)))
            fail(array, word.empty()
                            ? fmt::format("ends after {} numbers; the file is cut short", i)
                            : fmt::format("has {} as number {}; a {}number is needed",
                                          quotedExcerpt(word), i, real ? "" : "whole "));
        char* const to = numbers.bytes.data() + 8 * i;
        if (real)
            std::memcpy(to, &value, 8);
        else
            std::memcpy(to, &whole, 8);
    }
    if (!nextWord(array.text, at).empty())
        fail(array, fmt::format("holds more than {} tuples; the file is damaged", count));
    return numbers;
}

std::vector<std::string> VtkArrays::texts(const VtkArray& array, std::uint64_t count,
                                          std::uint64_t longest) {
    if (array.format != VtkArray::Format::ascii) {
        const auto isSound = [&](std::uint64_t bytes) {
            if (bytes / (longest + 1) > count)
                fail(array, fmt::format("has {} bytes for {} texts; shorten them", bytes, count));
        };
        return splitTexts(array, bytesOfArray(array, isSound), count);
    }
    std::vector<char> data;
    std::size_t at = 0;
    for (auto word = nextWord(array.text, at); !word.empty(); word = nextWord(array.text, at)) {
        std::int64_t code = 0;
        if (!parseNumber(word, code) || code < 0 || code > 255)
            fail(array, "holds a character code beyond 0 to 255; the file is damaged");
        data.push_back(static_cast<char>(static_cast<unsigned char>(code)));
    }
    return splitTexts(array, data, count);
}

std::vector<std::string> VtkArrays::splitTexts(const VtkArray& array, const std::vector<char>& data,
                                               std::uint64_t count) const {
    if (!data.empty() && data.back() != '\0')
        fail(array, "has a last text that is not ended; the file is cut short");
    const auto found = static_cast<std::uint64_t>(std::count(data.begin(), data.end(), '\0'));
    if (found != count)
        fail(array, fmt::format("holds {} texts where {} are expected; the file is damaged", found,
                                count));
    requireMemoryToRead(file_.path(), static_cast<double>(count * sizeof(std::string)),
                        memoryLimit_);
    std::vector<std::string> out;
    out.reserve(static_cast<std::size_t>(count));
    for (auto begin = data.begin(); begin != data.end();) {
        const auto end = std::find(begin, data.end(), '\0');
        out.emplace_back(begin, end);
        begin = end + 1;
    }
    return out;
}

}  // namespace vdbpack
