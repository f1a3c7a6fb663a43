// numpy's .npz: a zip archive with one .npy array a member. Sources: numpy.lib.format, versions 1
// to 3; PKWARE's APPNOTE 6.3, with the 64-bit extension, as Python's zipfile writes it.
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
#include <cstdint>
#include <cstring>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::uint32_t kLocal = 0x04034b50, kCentral = 0x02014b50, kEnd = 0x06054b50,
                        kEnd64 = 0x06064b50, kLocator64 = 0x07064b50;
constexpr std::uint64_t kIn64 = 0xffffffff;  // the number stands in the 64-bit extension
constexpr std::uint16_t kExtra64 = 1;
constexpr std::size_t kEndBytes = 22, kCentralBytes = 46, kLocalBytes = 30;
constexpr const char* kMagic = "\x93NUMPY";
/// zlib makes at most this many bytes of one.
constexpr std::uint64_t kMostDeflated = 1032;

template <typename T>
void put(std::string& bytes, T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (hostIsBigEndian()) std::reverse(raw, raw + sizeof value);
    bytes.append(raw, sizeof value);
}
void put16(std::string& bytes, std::uint64_t value) {
    put(bytes, static_cast<std::uint16_t>(value));
}
void put32(std::string& bytes, std::uint64_t value) {
    put(bytes, static_cast<std::uint32_t>(value));
}

std::uint32_t crcOf(const std::string& bytes) {
    return static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

// ---- writing -----------------------------------------------------------------------------------

/// An archive of members that are stored as they are. Sizes are always those of 64 bits, so that
/// large packs take no path of their own.
class Zip {
public:
    explicit Zip(OutputFile& out) : out_(out) {}

    void add(const std::string& name, const std::string& header, const std::string& data) {
        const std::string file = name + ".npy";
        const std::uint64_t size = header.size() + data.size();
        const auto crc = static_cast<std::uint32_t>(
            crc32_combine(crcOf(header), crcOf(data), static_cast<z_off_t>(data.size())));
        std::string common;       // of local and central header
        put16(common, 0x800);     // names in UTF-8
        put16(common, 0);         // stored
        put32(common, 0x210000);  // 1980-01-01: files do not depend on when they are written
        put32(common, crc);
        put32(common, kIn64);
        put32(common, kIn64);
        put16(common, file.size());
        std::string sizes;
        put(sizes, size);
        put(sizes, size);

        std::string local;
        put32(local, kLocal);
        put16(local, 45);
        local += common;
        put16(local, 20);
        local += file;
        put16(local, kExtra64);
        put16(local, 16);
        local += sizes;

        put32(directory_, kCentral);
        put16(directory_, 0x032d);  // made on Unix, by version 4.5
        put16(directory_, 45);
        directory_ += common;
        put16(directory_, 28);
        put16(directory_, 0);               // comment
        put16(directory_, 0);               // disk
        put16(directory_, 0);               // internal attributes
        put32(directory_, 0100644u << 16);  // an ordinary file
        put32(directory_, kIn64);
        directory_ += file;
        put16(directory_, kExtra64);
        put16(directory_, 24);
        directory_ += sizes;
        put(directory_, offset_);

        out_.write(local);
        out_.write(header);
        out_.write(data);
        offset_ += local.size() + size;
        ++members_;
    }

    void finish() {
        std::string end;
        put32(end, kEnd64);
        put(end, std::uint64_t{44});
        put16(end, 0x032d);
        put16(end, 45);
        put32(end, 0);
        put32(end, 0);
        put(end, members_);
        put(end, members_);
        put(end, static_cast<std::uint64_t>(directory_.size()));
        put(end, offset_);
        put32(end, kLocator64);
        put32(end, 0);
        put(end, offset_ + directory_.size());
        put32(end, 1);
        put32(end, kEnd);
        put32(end, 0);
        put16(end, 0xffff);
        put16(end, 0xffff);
        put32(end, kIn64);
        put32(end, kIn64);
        put16(end, 0);
        out_.write(directory_);
        out_.write(end);
    }

private:
    OutputFile& out_;
    std::string directory_;
    std::uint64_t offset_ = 0, members_ = 0;
};

/// The header of an array: `descr` as numpy writes it, `shape` such as "(3, 2)".
std::string arrayHeader(const std::string& descr, const std::string& shape) {
    std::string dict =
        fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", descr, shape);
    // Data begins at a multiple of 64 bytes.
    while ((10 + dict.size() + 1) % 64 != 0) dict += ' ';
    dict += '\n';
    std::string header = kMagic;
    header += '\x01';
    header += '\0';
    put16(header, dict.size());
    return header + dict;
}

template <typename T, typename Get>
std::string bytesOfAll(std::size_t n, const Get& get) {
    std::string bytes;
    bytes.reserve(n * sizeof(T));
    for (std::size_t i = 0; i < n; ++i) put(bytes, static_cast<T>(get(i)));
    return bytes;
}

/// The code points of UTF-8; bytes that are none stand for themselves.
std::vector<std::uint32_t> codePoints(const std::string& text) {
    std::vector<std::uint32_t> points;
    for (std::size_t i = 0; i < text.size();) {
        const auto byte = static_cast<unsigned char>(text[i]);
        const int more = byte >= 0xf0 && byte < 0xf8   ? 3
                         : byte >= 0xe0 && byte < 0xf0 ? 2
                         : byte >= 0xc0 && byte < 0xe0 ? 1
                                                       : 0;
        std::uint32_t point = more == 0 ? byte : byte & (0x3fu >> more);
        int k = 1;
        for (; k <= more && i + static_cast<std::size_t>(k) < text.size(); ++k) {
            const auto next = static_cast<unsigned char>(text[i + static_cast<std::size_t>(k)]);
            if ((next & 0xc0) != 0x80) break;
            point = point << 6 | (next & 0x3fu);
        }
        const bool sound = k == more + 1 && point <= 0x10ffff;
        points.push_back(sound ? point : byte);
        i += sound ? static_cast<std::size_t>(more) + 1 : 1;
    }
    return points;
}

void appendUtf8(std::string& text, std::uint32_t point) {
    const auto add = [&text](std::uint32_t byte) { text += static_cast<char>(byte); };
    if (point < 0x80) {
        add(point);
    } else if (point < 0x800) {
        add(0xc0 | point >> 6);
        add(0x80 | (point & 0x3f));
    } else if (point < 0x10000) {
        add(0xe0 | point >> 12);
        add(0x80 | (point >> 6 & 0x3f));
        add(0x80 | (point & 0x3f));
    } else {
        add(0xf0 | (point >> 18 & 7));
        add(0x80 | (point >> 12 & 0x3f));
        add(0x80 | (point >> 6 & 0x3f));
        add(0x80 | (point & 0x3f));
    }
}

void addTexts(Zip& zip, const std::string& name, const std::vector<std::string>& texts,
              const std::string& shape) {
    std::size_t longest = 1;
    for (const auto& t : texts) longest = std::max(longest, codePoints(t).size());
    std::string bytes;
    bytes.reserve(texts.size() * longest * 4);
    for (const auto& t : texts) {
        auto points = codePoints(t);
        points.resize(longest, 0);
        for (const std::uint32_t p : points) put(bytes, p);
    }
    zip.add(name, arrayHeader(fmt::format("<U{}", longest), shape), bytes);
}

/// A name for a member of the archive, which is a file to the programs that unpack it.
std::string memberName(std::string_view attribute) {
    std::string name = oneLine(std::string(attribute)).substr(0, 1000);
    std::replace(name.begin(), name.end(), '/', '_');
    return name;
}

// ---- reading -----------------------------------------------------------------------------------

/// Numbers of a header, which ends before none of them.
class Fields {
public:
    explicit Fields(std::string bytes) : bytes_(std::move(bytes)) {}
    /// Little-endian.
    std::uint64_t get(std::size_t at, std::size_t count) const {
        std::uint64_t value = 0;
        for (std::size_t k = 0; k < count && at + count <= bytes_.size(); ++k)
            value |= std::uint64_t{static_cast<unsigned char>(bytes_[at + k])} << (8 * k);
        return value;
    }
    std::uint64_t u16(std::size_t at) const { return get(at, 2); }
    std::uint64_t u32(std::size_t at) const { return get(at, 4); }
    std::uint64_t u64(std::size_t at) const { return get(at, 8); }

private:
    std::string bytes_;
};

struct Member {
    std::string name;
    std::uint64_t method = 0, packed = 0, size = 0, offset = 0;
    std::uint32_t crc = 0;
};

/// An array of numbers or texts, one or several a row.
struct Array {
    std::string name;
    char kind = 'f';        ///< f, i, u, b, U or S
    std::size_t bytes = 0;  ///< of an element
    bool swap = false, fortran = false;
    std::vector<std::uint64_t> shape;
    std::string data;

    std::uint64_t rows() const { return shape.empty() ? 1 : shape[0]; }
    std::uint64_t columns() const { return shape.size() > 1 ? shape[1] : 1; }
    const char* at(std::uint64_t row, std::uint64_t column) const {
        const std::uint64_t index = fortran ? column * rows() + row : row * columns() + column;
        return data.data() + index * bytes;
    }
};

class NpzFile {
public:
    NpzFile(const std::string& path, const PackReadOptions& options)
        : file_(path), unit_(options.unit) {}

    Pack<3> read() {
        std::uint64_t packed = 0;
        for (const Member& m : members()) {
            constexpr std::string_view kEnding = ".npy";
            if (m.name.size() <= kEnding.size() ||
                m.name.compare(m.name.size() - kEnding.size(), kEnding.size(), kEnding) != 0)
                continue;
            // Members that share their bytes would unpack to any size.
            if (m.packed > file_.size() - packed)
                failDamaged(fmt::format("member '{}', beside those before it,", shown(m)));
            packed += m.packed;
            Array a;
            a.name = m.name.substr(0, m.name.size() - kEnding.size());
            if (parse(content(m), a)) arrays_.push_back(std::move(a));
        }
        for (const Array& a : arrays_)
            if (a.name == kUnitKey && (a.kind == 'U' || a.kind == 'S') && a.shape.empty() &&
                !parseUnitComment(kUnitComment + text(a, 0), unit_))
                throw InputError(fmt::format("{}: unknown unit '{}'; use m, cm, mm or um",
                                             file_.path(), text(a, 0).substr(0, 40)));
        return pack();
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(file_.path() + ": " + what);
    }
    [[noreturn]] void failDamaged(const std::string& where) const {
        fail(where + " does not fit into the file; it is damaged or cut short");
    }

    std::string bytesAt(std::uint64_t offset, std::uint64_t count, const std::string& what) const {
        if (offset > file_.size() || count > file_.size() - offset) failDamaged(what);
        std::string bytes(static_cast<std::size_t>(count), '\0');
        file_.readAt(offset, bytes.data(), bytes.size());
        return bytes;
    }

    std::vector<Member> members() const {
        // The end may be followed by a comment of up to 64 KiB.
        const std::uint64_t size = file_.size();
        const std::uint64_t tail = std::min<std::uint64_t>(size, kEndBytes + 0xffff);
        const std::string last = bytesAt(size - tail, tail, "the end");
        std::string mark;
        put32(mark, kEnd);
        const auto at = last.rfind(mark);
        if (at == std::string::npos || at + kEndBytes > last.size())
            fail("is no .npz file, or cut short: it does not end as a zip archive");
        const Fields end(last.substr(at));
        std::uint64_t count = end.u16(10), length = end.u32(12), begin = end.u32(16);
        if (count == 0xffff || length == kIn64 || begin == kIn64) {
            if (at < 20) failDamaged("the 64-bit end of the archive");
            const Fields locator(last.substr(at - 20, 20));
            if (locator.u32(0) != kLocator64) failDamaged("the 64-bit end of the archive");
            const Fields end64(bytesAt(locator.u64(8), 56, "the 64-bit end of the archive"));
            if (end64.u32(0) != kEnd64) failDamaged("the 64-bit end of the archive");
            count = end64.u64(32);
            length = end64.u64(40);
            begin = end64.u64(48);
        }
        const std::string directory = bytesAt(begin, length, "the directory of the archive");
        if (count > length / kCentralBytes) failDamaged("the directory of the archive");
        std::vector<Member> list;
        std::size_t pos = 0;
        for (std::uint64_t i = 0; i < count; ++i) {
            const Fields entry(directory.substr(pos, kCentralBytes));
            if (pos + kCentralBytes > directory.size() || entry.u32(0) != kCentral)
                failDamaged("the directory of the archive");
            Member m;
            m.method = entry.u16(10);
            m.crc = static_cast<std::uint32_t>(entry.u32(16));
            m.packed = entry.u32(20);
            m.size = entry.u32(24);
            m.offset = entry.u32(42);
            const auto name = static_cast<std::size_t>(entry.u16(28));
            const auto extra = static_cast<std::size_t>(entry.u16(30));
            const auto comment = static_cast<std::size_t>(entry.u16(32));
            if (name + extra + comment > directory.size() - pos - kCentralBytes)
                failDamaged("the directory of the archive");
            m.name = directory.substr(pos + kCentralBytes, name);
            const Fields more(directory.substr(pos + kCentralBytes + name, extra));
            for (std::size_t e = 0; e + 4 <= extra;
                 e += 4 + static_cast<std::size_t>(more.u16(e + 2))) {
                if (more.u16(e) != kExtra64) continue;
                std::size_t value = e + 4;
                for (std::uint64_t* field : {&m.size, &m.packed, &m.offset})
                    if (*field == kIn64) {
                        *field = more.u64(value);
                        value += 8;
                    }
            }
            if (entry.u16(8) & 1) fail(fmt::format("'{}' is encrypted; save it without", shown(m)));
            list.push_back(std::move(m));
            pos += kCentralBytes + name + extra + comment;
        }
        return list;
    }

    static std::string shown(const Member& m) { return oneLine(m.name.substr(0, 80)); }

    std::string content(const Member& m) const {
        const std::string where = fmt::format("member '{}'", shown(m));
        const Fields local(bytesAt(m.offset, kLocalBytes, where));
        if (local.u32(0) != kLocal) failDamaged(where);
        const std::uint64_t begin = m.offset + kLocalBytes + local.u16(26) + local.u16(28);
        std::string packed = bytesAt(begin, m.packed, where);
        if (m.method == 0) {
            if (m.packed != m.size) failDamaged(where);
        } else if (m.method == 8) {
            if (m.size > (m.packed + 64) * kMostDeflated) failDamaged(where);
            std::string plain(static_cast<std::size_t>(m.size), '\0');
            inflateAll(packed, plain, where);
            packed = std::move(plain);
        } else {
            fail(
                fmt::format("{} is compressed by method {}; save it with savez or "
                            "savez_compressed",
                            where, m.method));
        }
        if (crcOf(packed) != m.crc)
            fail(where + " does not match its checksum; the file is damaged");
        return packed;
    }

    void inflateAll(const std::string& packed, std::string& plain, const std::string& where) const {
        z_stream stream{};
        if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) throw std::bad_alloc();
        // Counts of zlib have 32 bits.
        constexpr std::size_t kMost = 1u << 30;
        std::size_t in = 0, out = 0;
        int state = Z_OK;
        while (state == Z_OK) {
            const std::size_t give = std::min(kMost, packed.size() - in);
            const std::size_t room = std::min(kMost, plain.size() - out);
            unsigned char none = 0;
            stream.next_in =
                reinterpret_cast<unsigned char*>(const_cast<char*>(packed.data())) + in;
            stream.avail_in = static_cast<uInt>(give);
            stream.next_out =
                room > 0 ? reinterpret_cast<unsigned char*>(plain.data()) + out : &none;
            stream.avail_out = static_cast<uInt>(room);
            state = inflate(&stream, Z_NO_FLUSH);
            const std::size_t taken = give - stream.avail_in, made = room - stream.avail_out;
            in += taken;
            out += made;
            if (state == Z_OK && taken == 0 && made == 0) break;
        }
        inflateEnd(&stream);
        if (state != Z_STREAM_END || out != plain.size())
            fail(where + " cannot be decompressed; the file is damaged");
    }

    /// Reads the .npy `bytes`. @return false for an array that a pack has no use for (objects,
    /// records, more than two dimensions).
    bool parse(std::string bytes, Array& a) const {
        const std::string where = fmt::format("array '{}'", oneLine(a.name.substr(0, 80)));
        const Fields head(bytes.substr(0, 12));
        if (bytes.compare(0, 6, kMagic) != 0) fail(where + " is no .npy array; save it with numpy");
        const bool wide = head.get(6, 1) >= 2;
        const std::size_t before = wide ? 12 : 10;
        const std::uint64_t length = wide ? head.u32(8) : head.u16(8);
        if (bytes.size() < before || length > bytes.size() - before) failDamaged(where);
        const std::string dict = bytes.substr(before, static_cast<std::size_t>(length));
        const auto after = [&](const char* key) {
            const auto at = dict.find(key);
            if (at == std::string::npos) failDamaged(where + " (its header)");
            const auto colon = dict.find(':', at);
            return colon == std::string::npos
                       ? dict.size()
                       : std::min(dict.find_first_not_of(' ', colon + 1), dict.size());
        };
        const std::size_t type = after("'descr'");
        if (type >= dict.size() || dict[type] != '\'') return false;  // records
        const std::string descr = dict.substr(type + 1, dict.find('\'', type + 1) - type - 1);
        std::int64_t width = 0;
        if (descr.size() < 3 || !parseNumber(descr.substr(2), width) || width < 0) return false;
        a.kind = descr[1];
        if (std::string_view("fiubUS").find(a.kind) == std::string_view::npos) return false;
        if (width > (1 << 20)) failDamaged(where);
        a.bytes = static_cast<std::size_t>(width) * (a.kind == 'U' ? 4 : 1);
        a.swap = (descr[0] == '>') != hostIsBigEndian() && descr[0] != '|';
        if (descr[0] == '=') a.swap = false;
        if (a.kind != 'U' && a.kind != 'S' && !isNumberWidth(a)) return false;
        a.fortran = dict.compare(after("'fortran_order'"), 4, "True") == 0;
        std::size_t at = after("'shape'");
        const auto close = dict.find(')', at);
        if (at >= dict.size() || dict[at] != '(' || close == std::string::npos)
            failDamaged(where + " (its shape)");
        std::uint64_t elements = 1;
        while (++at < close) {
            const auto end = std::min(dict.find(',', at), close);
            const auto word = trimmed(std::string_view(dict).substr(at, end - at));
            at = end;
            std::int64_t count = 0;
            if (word.empty()) continue;
            if (!parseNumber(word, count) || count < 0) failDamaged(where + " (its shape)");
            a.shape.push_back(static_cast<std::uint64_t>(count));
            // No product overflows: the file holds all elements.
            if (count > 0 && elements > bytes.size() / static_cast<std::uint64_t>(count) &&
                a.bytes > 0)
                failDamaged(where);
            elements *= static_cast<std::uint64_t>(count);
        }
        if (a.bytes > 0 && elements > (bytes.size() - before - length) / a.bytes)
            failDamaged(where);
        if (a.shape.size() > 2) return false;
        a.data = bytes.substr(before + static_cast<std::size_t>(length));
        return true;
    }

    static bool isNumberWidth(const Array& a) {
        if (a.kind == 'f') return a.bytes == 4 || a.bytes == 8;
        if (a.kind == 'b') return a.bytes == 1;
        return a.bytes == 1 || a.bytes == 2 || a.bytes == 4 || a.bytes == 8;
    }

    static NumberType typeOf(const Array& a) {
        const auto pick = [&a](NumberType one, NumberType two, NumberType four, NumberType eight) {
            return a.bytes == 1 ? one : a.bytes == 2 ? two : a.bytes == 4 ? four : eight;
        };
        if (a.kind == 'f') return a.bytes == 4 ? NumberType::f32 : NumberType::f64;
        if (a.kind == 'i')
            return pick(NumberType::i8, NumberType::i16, NumberType::i32, NumberType::i64);
        return pick(NumberType::u8, NumberType::u16, NumberType::u32, NumberType::u64);
    }

    static std::string text(const Array& a, std::uint64_t row) {
        std::string out;
        const char* at = a.at(row, 0);
        if (a.kind == 'S') {
            out.assign(at, a.bytes);
        } else {
            for (std::size_t b = 0; b < a.bytes; b += 4)
                appendUtf8(
                    out, std::min<std::uint32_t>(loadAs<std::uint32_t>(at + b, a.swap), 0x10ffff));
        }
        while (!out.empty() && out.back() == '\0') out.pop_back();
        return out;
    }

    Pack<3> pack() const {
        struct From {
            const Array* array;
            std::uint64_t column;
        };
        const auto named = [&](std::initializer_list<const char*> names) -> const Array* {
            for (const char* name : names)
                for (const Array& a : arrays_) {
                    std::string low = a.name;
                    for (char& c : low)
                        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
                    if (low == name && a.kind != 'U' && a.kind != 'S') return &a;
                }
            return nullptr;
        };
        const Array* positions = named({"positions", "position", "centers", "points", "pos"});
        const Array* radii = named({"radii", "radius", "r", "pscale"});
        const Array* diameters = radii ? nullptr : named({"diameters", "diameter"});
        const Array* x = named({"x"});
        const Array* rowsOf = positions ? positions : x;
        if (!rowsOf || !(radii || diameters)) {
            std::string found;
            for (std::size_t i = 0; i < std::min<std::size_t>(arrays_.size(), 20); ++i)
                found += (i > 0 ? ", " : "") + oneLine(arrays_[i].name.substr(0, 40));
            fail(
                fmt::format("arrays positions (N, 3), or x, y and z, and radii (N) are needed, "
                            "found: {}; save them by these names",
                            found.empty() ? "none" : found));
        }
        const std::uint64_t n = rowsOf->rows();
        const auto isColumn = [n](const Array& a, std::uint64_t columns) {
            return !a.shape.empty() && a.rows() == n && a.columns() == columns;
        };
        if (positions && !isColumn(*positions, 3))
            fail(fmt::format("array '{}' has shape ({}); (N, 3) is needed", positions->name,
                             fmt::join(positions->shape, ", ")));
        const Array* size = radii ? radii : diameters;
        if (!isColumn(*size, 1))
            fail(
                fmt::format("array '{}' has shape ({}) beside {} positions; one number each is "
                            "needed",
                            size->name, fmt::join(size->shape, ", "), n));

        std::vector<std::string> names;
        std::vector<From> from;
        const auto take = [&](const std::string& name, const Array* a, std::uint64_t column) {
            names.push_back(name);
            from.push_back({a, column});
        };
        if (positions)
            for (std::uint64_t d = 0; d < 3; ++d) take(std::string(1, "xyz"[d]), positions, d);
        take(radii ? "radius" : "diameter", size, 0);
        const std::set<std::string> ours = {kUnitKey, kGeneratorKey};
        for (const Array& a : arrays_) {
            if (&a == positions || &a == size || ours.count(a.name) > 0 || a.shape.empty() ||
                a.rows() != n)
                continue;
            if (a.columns() == 1) {
                take(a.name, &a, 0);
            } else if (a.columns() <= 100 && a.kind != 'U' && a.kind != 'S') {
                for (std::uint64_t c = 0; c < a.columns(); ++c)
                    take(fmt::format("{}_{}", a.name, c), &a, c);
            }
        }
        PackBuilder builder(file_.path(), names, unit_);
        for (std::size_t c = 0; c < from.size(); ++c) {
            if (from[c].array->kind != 'U' && from[c].array->kind != 'S') continue;
            if (!builder.isFurther(c))
                fail(fmt::format("array '{}' holds texts; numbers are needed", names[c]));
            builder.makeText(c);
        }
        builder.reserve(static_cast<std::size_t>(n));
        for (std::uint64_t i = 0; i < n; ++i) {
            const auto where = [&] { return fmt::format("row {}", i); };
            builder.addRow();
            for (std::size_t c = 0; c < from.size(); ++c) {
                const Array& a = *from[c].array;
                if (builder.isText(c)) {
                    builder.setText(c, text(a, i));
                } else if (!loadNumber(typeOf(a), a.at(i, from[c].column), a.swap,
                                       [&](auto value) { return builder.set(c, value); })) {
                    builder.failCell(where(), c, "out of range");
                }
            }
            if (!builder.problem().empty()) builder.failRow(where());
        }
        return builder.finish();
    }

    InputFile file_;
    Unit unit_;
    std::vector<Array> arrays_;
};

}  // namespace

void writeNpz(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    Zip zip(out);
    const std::size_t n = pack.size();
    const std::string shape = fmt::format("({},)", n);
    std::string positions;
    positions.reserve(n * 24);
    for (std::size_t i = 0; i < n; ++i)
        for (const double c : pack.position(i)) put(positions, c);
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
    if (!options.generator.empty()) addTexts(zip, kGeneratorKey, {options.generator}, "()");
    zip.finish();
}

Pack<3> readNpz(const std::string& path, const PackReadOptions& options) {
    return NpzFile(path, options).read();
}

}  // namespace vdbpack
