#include "vdbpack/mesh/formats/mesh_io.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/io/file_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <set>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

/// Coordinates beyond this are no bone in any unit, and their squares lose the digits, mm.
constexpr double kLargest = 1e9;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
/// Sides of triangles are numbered in 32 bits (edge_table.h).
constexpr std::size_t kMostTriangles = kNone / 3 - 1;

/// Gives every distinct point one index. Open addressing with linear probing, half full at most;
/// a small table of recent points in front of it answers most questions without a cache miss, as
/// the triangles of a file mostly lie next to those before them (STL, 10M triangles: 2.6 s,
/// not 3.3).
class Welder {
public:
    std::uint32_t add(const Vec<3>& point) {
        const std::uint64_t h = hash(point);
        std::uint32_t& recent = recent_[h % kRecent];
        if (recent < vertices_.size() && vertices_[recent] == point) return recent;
        return recent = find(point, h);
    }
    std::size_t size() const { return vertices_.size(); }
    std::vector<Vec<3>> takeVertices() { return std::move(vertices_); }

private:
    static constexpr std::size_t kRecent = 8192;

    static std::uint64_t hash(const Vec<3>& point) {
        std::uint64_t h = 0;
        for (const double x : point.c) {
            const double noSign = x + 0.0;  // -0 becomes 0
            std::uint64_t bits = 0;
            std::memcpy(&bits, &noSign, sizeof bits);
            h = mix64(h ^ bits) + 0x9e3779b97f4a7c15ull;
        }
        return h;
    }
    std::uint32_t find(const Vec<3>& point, std::uint64_t h) {
        if (2 * (vertices_.size() + 1) > slots_.size()) grow();
        for (std::size_t slot = h & (slots_.size() - 1);; slot = (slot + 1) & (slots_.size() - 1)) {
            const std::uint32_t at = slots_[slot];
            if (at == kNone) {
                const auto index = static_cast<std::uint32_t>(vertices_.size());
                vertices_.push_back(point);
                slots_[slot] = index;
                return index;
            }
            if (vertices_[at] == point) return at;
        }
    }
    void grow() {
        slots_.assign(std::max<std::size_t>(64, 2 * slots_.size()), kNone);
        for (std::uint32_t i = 0; i < vertices_.size(); ++i) {
            std::size_t slot = hash(vertices_[i]) & (slots_.size() - 1);
            while (slots_[slot] != kNone) slot = (slot + 1) & (slots_.size() - 1);
            slots_[slot] = i;
        }
    }

    std::vector<Vec<3>> vertices_;
    std::vector<std::uint32_t> slots_;
    std::vector<std::uint32_t> recent_ = std::vector<std::uint32_t>(kRecent, kNone);
};

/// Words of a text file, across its lines.
class TextWords {
public:
    explicit TextWords(FileSource& source) : source_(source) {}
    /// Empty at the end of the file. Valid until the next call.
    std::string_view next() {
        for (;;) {
            const std::string_view word = words_.next();
            if (!word.empty()) return word;
            std::string_view line;
            if (!source_.takeLine(line)) return {};
            words_ = Words(line);
        }
    }
    void dropLine() { words_ = Words({}); }

private:
    FileSource& source_;
    Words words_{{}};
};

/// True if `word` is `lower` (small letters) in any case.
bool equalsNoCase(std::string_view word, std::string_view lower) {
    if (word.size() != lower.size()) return false;
    for (std::size_t i = 0; i < word.size(); ++i)
        if (static_cast<char>(word[i] | 0x20) != lower[i]) return false;
    return true;
}

/// What all readers share: the file, what is read from it, and the checks of points and counts.
struct Reader {
    FileSource& source;
    double largest;  ///< coordinate allowed, in the unit of the file
    MeshFileFacts& facts;
    TriangleMesh mesh;

    /// Why a point cannot be used; empty if it can.
    std::string complaint(const Vec<3>& p) const {
        if (!isFinite(p))
            return fmt::format("is not finite: ({}, {}, {}); export the mesh again", p[0], p[1],
                               p[2]);
        for (const double x : p.c)
            if (!(std::fabs(x) <= largest))
                return fmt::format(
                    "lies more than 1e9 mm from the origin: ({}, {}, {}); check the unit", p[0],
                    p[1], p[2]);
        return {};
    }
    void checkAtLine(const Vec<3>& p) const {
        if (auto why = complaint(p); !why.empty()) source.failAtLine("vertex " + why);
    }
    double real(std::string_view word, const char* what) const {
        double value = 0;
        if (!parseReal(word, value)) failNumber(word, what);
        return value;
    }
    std::int64_t integer(std::string_view word, const char* what) const {
        std::int64_t value = 0;
        if (!parseInteger(word, value)) failNumber(word, what);
        return value;
    }
    [[noreturn]] void failNumber(std::string_view word, const char* what) const {
        if (word.empty())
            source.failAtLine(std::string(what) +
                              " expected, but nothing is left; the file may be truncated");
        source.failAtLine(std::string(what) + " expected, found " + quoted(word));
    }
    /// Refuses a count that a file of this size cannot hold at `least` bytes each.
    void checkCount(std::uint64_t count, std::uint64_t least, const char* what) const {
        if (least > 0 && count > (source.size() + 1) / least)
            source.fail(
                fmt::format("{} {} are announced, too many for a file of {} bytes; it is "
                            "truncated or its header is wrong",
                            count, what, source.size()));
    }
    void addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (mesh.triangles.size() >= kMostTriangles)
            throw ResourceError(fmt::format("{}: more than {} triangles; simplify the mesh",
                                            source.path(), kMostTriangles));
        mesh.triangles.push_back({a, b, c});
    }
    void checkVertexTotal(std::uint64_t count) const {
        if (count >= kNone)
            throw ResourceError(fmt::format("{}: more than {} vertices; simplify the mesh",
                                            source.path(), kNone - 1));
    }
};

/// Cuts polygons into fans while their corners come in.
struct Fan {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    std::uint64_t corners = 0;
    void add(Reader& reader, std::uint32_t corner) {
        if (corners == 0) first = corner;
        if (corners >= 2) reader.addTriangle(first, last, corner);
        last = corner;
        ++corners;
    }
};

// STL -------------------------------------------------------------------------------------------

constexpr std::uint64_t kStlHeader = 84;
constexpr std::uint64_t kStlTriangle = 50;

template <typename T>
T littleEndian(const char* bytes) {
    static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "files are read as they lie");
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

void readBinaryStl(Reader& reader, Welder& welder) {
    FileSource& source = reader.source;
    const char* const header = source.take(kStlHeader);
    const std::uint64_t count =
        header != nullptr ? littleEndian<std::uint32_t>(header + kStlHeader - 4) : 0;
    if (header == nullptr || kStlHeader + kStlTriangle * count != source.size())
        source.fail(fmt::format(
            "is no whole STL file: {} bytes, where a binary one with the {} triangles announced "
            "has {}, and an ASCII one begins with 'solid'; it may be truncated, export it again",
            source.size(), count, kStlHeader + kStlTriangle * count));
    reader.facts.format = "binary STL";
    reader.facts.singlePrecision = true;
    reader.mesh.triangles.reserve(count);
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t offset = source.offset();
        const char* const record = source.take(kStlTriangle);
        if (record == nullptr) source.failAtByte(offset, "the file became shorter while reading");
        std::array<std::uint32_t, 3> corner{};
        for (std::size_t k = 0; k < 3; ++k) {
            Vec<3> p;
            // The normal comes first and is not needed.
            for (int d = 0; d < 3; ++d)
                p[d] = static_cast<double>(littleEndian<float>(record + 12 + 12 * k +
                                                               4 * static_cast<std::size_t>(d))) +
                       0.0;
            if (auto why = reader.complaint(p); !why.empty())
                source.failAtByte(offset + 12 + 12 * k,
                                  fmt::format("vertex {} of triangle {} {}", k, i, why));
            corner[k] = welder.add(p);
        }
        reader.addTriangle(corner[0], corner[1], corner[2]);
    }
}

void readAsciiStl(Reader& reader, Welder& welder) {
    FileSource& source = reader.source;
    reader.facts.format = "ASCII STL";
    TextWords words(source);
    const auto expect = [&](std::string_view keyword) {
        const auto word = words.next();
        if (equalsNoCase(word, keyword)) return;
        if (word.empty())
            source.failAtLine(
                fmt::format("the file ends where '{}' is expected; it is truncated, "
                            "export it again",
                            keyword));
        source.failAtLine(fmt::format("'{}' expected, found {}", keyword, quoted(word)));
    };
    expect("solid");
    words.dropLine();
    for (bool inSolid = true;;) {
        const auto word = words.next();
        if (word.empty()) {
            if (inSolid) source.failAtLine("the file ends before 'endsolid'; it is truncated");
            return;
        }
        if (!inSolid) {
            if (!equalsNoCase(word, "solid"))
                source.failAtLine("'solid' expected, found " + quoted(word));
            words.dropLine();
            inSolid = true;
        } else if (equalsNoCase(word, "endsolid")) {
            words.dropLine();
            inSolid = false;
        } else if (equalsNoCase(word, "facet")) {
            // The normal may be anything, nan included: it is not needed.
            expect("normal");
            for (int i = 0; i < 3; ++i) words.next();
            expect("outer");
            expect("loop");
            std::array<std::uint32_t, 3> corner{};
            for (auto& c : corner) {
                expect("vertex");
                Vec<3> p;
                for (int d = 0; d < 3; ++d) p[d] = reader.real(words.next(), "a coordinate") + 0.0;
                reader.checkAtLine(p);
                c = welder.add(p);
            }
            expect("endloop");
            expect("endfacet");
            reader.addTriangle(corner[0], corner[1], corner[2]);
            reader.checkVertexTotal(welder.size());
        } else {
            source.failAtLine("'facet' or 'endsolid' expected, found " + quoted(word));
        }
    }
}

/// True for a file that says "solid" and is not exactly as long as the triangle count of a binary
/// file asks: programs write binary files whose header begins with "solid".
bool isAsciiStl(FileSource& source) {
    const std::string_view head = source.peek(1024);
    if (head.size() >= kStlHeader &&
        kStlHeader + kStlTriangle * littleEndian<std::uint32_t>(head.data() + kStlHeader - 4) ==
            source.size())
        return false;
    if (head.find('\0') != std::string_view::npos) return false;
    const std::size_t begin = head.find_first_not_of(" \t\r\n");
    return begin != std::string_view::npos && equalsNoCase(head.substr(begin, 5), "solid");
}

void readStl(Reader& reader) {
    Welder welder;
    if (isAsciiStl(reader.source))
        readAsciiStl(reader, welder);
    else
        readBinaryStl(reader, welder);
    reader.facts.faces = reader.mesh.triangles.size();
    reader.facts.vertices = 3 * reader.facts.faces;
    reader.facts.mergedVertices = reader.facts.vertices - welder.size();
    reader.mesh.vertices = welder.takeVertices();
}

// OBJ -------------------------------------------------------------------------------------------

/// A line with those appended that a backslash at its end continues it with.
bool takeObjLine(FileSource& source, std::string_view& line, std::string& joined) {
    if (!source.takeLine(line)) return false;
    if (line.empty() || line.back() != '\\') return true;
    joined.clear();
    while (!line.empty() && line.back() == '\\') {
        joined.append(line.substr(0, line.size() - 1)).push_back(' ');
        if (!source.takeLine(line)) line = {};
    }
    joined.append(line);
    line = joined;
    return true;
}

void readObj(Reader& reader) {
    FileSource& source = reader.source;
    reader.facts.format = "OBJ";
    auto& vertices = reader.mesh.vertices;
    std::int64_t largestIndex = 0;
    std::size_t lineOfLargest = 0;
    std::string_view line;
    std::string joined;
    while (takeObjLine(source, line, joined)) {
        Words words(line);
        const std::string_view keyword = words.next();
        if (keyword == "v") {
            Vec<3> p;
            for (int d = 0; d < 3; ++d) p[d] = reader.real(words.next(), "a coordinate") + 0.0;
            reader.checkAtLine(p);
            reader.checkVertexTotal(vertices.size());
            vertices.push_back(p);
        } else if (keyword == "f") {
            Fan fan;
            for (auto word = words.next(); !word.empty(); word = words.next()) {
                // Vertex, texture and normal: v, v/t, v//n or v/t/n. Only v is needed.
                const std::size_t slash = word.find('/');
                if (slash != std::string_view::npos &&
                    word.find_first_not_of("0123456789-+/", slash) != std::string_view::npos)
                    source.failAtLine("a corner of a face expected, found " + quoted(word));
                std::int64_t index = reader.integer(word.substr(0, slash), "a vertex index");
                const auto count = static_cast<std::int64_t>(vertices.size());
                if (index < 0) {
                    if (index < -count)
                        source.failAtLine(
                            fmt::format("face names vertex {} counted back, but only "
                                        "{} stand before it",
                                        index, count));
                    index += count + 1;
                } else if (index == 0 || index >= static_cast<std::int64_t>(kNone)) {
                    source.failAtLine(
                        fmt::format("face names vertex {}; OBJ counts from 1", index));
                }
                // A face may stand before its vertices: judged at the end.
                if (index > largestIndex) {
                    largestIndex = index;
                    lineOfLargest = source.line();
                }
                fan.add(reader, static_cast<std::uint32_t>(index - 1));
            }
            if (fan.corners < 3)
                source.failAtLine(
                    fmt::format("face with {} corners; 3 or more are needed, the "
                                "file may be truncated",
                                fan.corners));
            ++reader.facts.faces;
        } else if (!keyword.empty() && keyword.front() != '#' &&
                   std::isalpha(static_cast<unsigned char>(keyword.front())) == 0) {
            source.failAtLine("is no OBJ statement: " + quoted(keyword));
        }
    }
    if (largestIndex > static_cast<std::int64_t>(vertices.size()))
        source.fail(
            fmt::format("line {}: face names vertex {}, but the file has {}; it may be "
                        "truncated",
                        lineOfLargest, largestIndex, vertices.size()));
    reader.facts.vertices = vertices.size();
}

// OFF -------------------------------------------------------------------------------------------

/// The next line that holds something besides a comment.
bool takeOffLine(FileSource& source, std::string_view& line) {
    while (source.takeLine(line)) {
        line = line.substr(0, line.find('#'));
        if (!Words(line).next().empty()) return true;
    }
    return false;
}

void readOff(Reader& reader) {
    FileSource& source = reader.source;
    reader.facts.format = "OFF";
    std::string_view line;
    if (!takeOffLine(source, line)) source.fail("is empty; an OFF file begins with 'OFF'");
    Words words(line);
    std::string_view word = words.next();
    std::int64_t probe = 0;
    if (!parseInteger(word, probe)) {
        // ST, C and N say what follows the three coordinates of a vertex, which is not needed.
        const std::size_t off = word.find("OFF");
        std::string_view prefix = word.substr(0, std::min(off, word.size()));
        if (prefix.substr(0, 2) == "ST") prefix.remove_prefix(2);
        if (prefix.substr(0, 1) == "C") prefix.remove_prefix(1);
        if (prefix.substr(0, 1) == "N") prefix.remove_prefix(1);
        if (off == std::string_view::npos || off + 3 != word.size() || !prefix.empty())
            source.failAtLine("'OFF', 'COFF', 'NOFF' or 'STOFF' expected, found " + quoted(word));
        word = words.next();
        if (equalsNoCase(word, "binary"))
            source.failAtLine("binary OFF is not read; save it as ASCII OFF or as PLY");
        if (word.empty()) {
            if (!takeOffLine(source, line)) source.fail("ends before its counts; it is truncated");
            words = Words(line);
            word = words.next();
        }
    }
    const std::int64_t vertexCount = reader.integer(word, "the number of vertices");
    const std::int64_t faceCount = reader.integer(words.next(), "the number of faces");
    if (vertexCount < 0 || faceCount < 0)
        source.failAtLine(
            fmt::format("negative count: {} vertices, {} faces", vertexCount, faceCount));
    // The shortest lines are "0 0 0" and "3 0 1 2".
    reader.checkCount(static_cast<std::uint64_t>(vertexCount), 6, "vertices");
    reader.checkCount(static_cast<std::uint64_t>(faceCount), 8, "faces");
    reader.checkVertexTotal(static_cast<std::uint64_t>(vertexCount));
    auto& vertices = reader.mesh.vertices;
    vertices.reserve(static_cast<std::size_t>(vertexCount));
    reader.mesh.triangles.reserve(static_cast<std::size_t>(faceCount));
    for (std::int64_t i = 0; i < vertexCount; ++i) {
        if (!takeOffLine(source, line))
            source.failAtLine(fmt::format("the file ends after {} of {} vertices; it is truncated",
                                          i, vertexCount));
        words = Words(line);
        Vec<3> p;
        for (int d = 0; d < 3; ++d) p[d] = reader.real(words.next(), "a coordinate") + 0.0;
        reader.checkAtLine(p);
        vertices.push_back(p);
    }
    for (std::int64_t i = 0; i < faceCount; ++i) {
        if (!takeOffLine(source, line))
            source.failAtLine(
                fmt::format("the file ends after {} of {} faces; it is truncated", i, faceCount));
        words = Words(line);
        const std::int64_t corners = reader.integer(words.next(), "the number of corners");
        if (corners < 3)
            source.failAtLine(
                fmt::format("face {} has {} corners; 3 or more are needed", i, corners));
        Fan fan;
        for (std::int64_t k = 0; k < corners; ++k) {
            const std::int64_t index = reader.integer(words.next(), "a vertex index");
            if (index < 0 || index >= vertexCount)
                source.failAtLine(
                    fmt::format("face {} names vertex {}, but the file has {}, "
                                "counted from 0",
                                i, index, vertexCount));
            fan.add(reader, static_cast<std::uint32_t>(index));
        }
    }
    if (takeOffLine(source, line))
        source.failAtLine(
            fmt::format("the file goes on after the {} vertices and {} faces "
                        "announced; its counts are wrong",
                        vertexCount, faceCount));
    reader.facts.vertices = vertices.size();
    reader.facts.faces = static_cast<std::size_t>(faceCount);
}

// PLY -------------------------------------------------------------------------------------------

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::size_t bytesOf(PlyType type) {
    switch (type) {
        case PlyType::int8:
        case PlyType::uint8:
            return 1;
        case PlyType::int16:
        case PlyType::uint16:
            return 2;
        case PlyType::int32:
        case PlyType::uint32:
        case PlyType::float32:
            return 4;
        case PlyType::float64:
            return 8;
    }
    return 0;
}

bool isReal(PlyType type) {
    return type == PlyType::float32 || type == PlyType::float64;
}

struct PlyProperty {
    std::string name;
    bool isList = false;
    PlyType countType = PlyType::uint8;  ///< of lists
    PlyType type = PlyType::float32;
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
};

enum class PlyFormat { ascii, littleEndian, bigEndian };

struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
};

PlyType parsePlyType(const FileSource& source, std::string_view name) {
    constexpr std::array<std::pair<std::string_view, PlyType>, 16> kNames{{
        {"char", PlyType::int8},
        {"int8", PlyType::int8},
        {"uchar", PlyType::uint8},
        {"uint8", PlyType::uint8},
        {"short", PlyType::int16},
        {"int16", PlyType::int16},
        {"ushort", PlyType::uint16},
        {"uint16", PlyType::uint16},
        {"int", PlyType::int32},
        {"int32", PlyType::int32},
        {"uint", PlyType::uint32},
        {"uint32", PlyType::uint32},
        {"float", PlyType::float32},
        {"float32", PlyType::float32},
        {"double", PlyType::float64},
        {"float64", PlyType::float64},
    }};
    for (const auto& [known, type] : kNames)
        if (name == known) return type;
    source.failAtLine("type of a property expected, found " + quoted(name));
}

PlyHeader readPlyHeader(Reader& reader) {
    FileSource& source = reader.source;
    PlyHeader header;
    std::set<std::string> names;  // of the elements: a header may hold any number of them
    std::string_view line;
    if (!source.takeLine(line) || Words(line).next() != "ply")
        source.fail("is no PLY file: it does not begin with 'ply'");
    bool hasFormat = false;
    for (;;) {
        if (!source.takeLine(line))
            source.failAtLine("the file ends before 'end_header'; it is truncated");
        Words words(line);
        const std::string_view keyword = words.next();
        if (keyword == "end_header") break;
        if (keyword.empty() || keyword == "comment" || keyword == "obj_info") continue;
        if (keyword == "format") {
            const auto name = words.next();
            if (name == "ascii")
                header.format = PlyFormat::ascii;
            else if (name == "binary_little_endian")
                header.format = PlyFormat::littleEndian;
            else if (name == "binary_big_endian")
                header.format = PlyFormat::bigEndian;
            else
                source.failAtLine(
                    "format 'ascii', 'binary_little_endian' or 'binary_big_endian' "
                    "expected, found " +
                    quoted(name));
            hasFormat = true;
        } else if (keyword == "element") {
            PlyElement element;
            element.name = words.next();
            if (!names.insert(element.name).second)
                source.failAtLine("element " + quoted(element.name) + " is declared twice");
            const std::int64_t count = reader.integer(words.next(), "the number of elements");
            if (count < 0) source.failAtLine(fmt::format("negative count: {}", count));
            element.count = static_cast<std::uint64_t>(count);
            header.elements.push_back(std::move(element));
        } else if (keyword == "property") {
            if (header.elements.empty()) source.failAtLine("property before any element");
            PlyProperty property;
            std::string_view word = words.next();
            if (word == "list") {
                property.isList = true;
                property.countType = parsePlyType(source, words.next());
                if (isReal(property.countType))
                    source.failAtLine("the length of a list must have an integer type");
                word = words.next();
            }
            property.type = parsePlyType(source, word);
            property.name = words.next();
            header.elements.back().properties.push_back(std::move(property));
        } else {
            source.failAtLine("is no statement of a PLY header: " + quoted(keyword));
        }
    }
    if (!hasFormat) source.failAtLine("the header names no format");
    return header;
}

/// Values of a PLY body, whatever their encoding.
class PlyValues {
public:
    PlyValues(Reader& reader, PlyFormat format)
        : reader_(reader), words_(reader.source), format_(format) {}

    double real(PlyType type) {
        if (format_ == PlyFormat::ascii) return reader_.real(words_.next(), "a number");
        switch (type) {
            case PlyType::float32:
                return static_cast<double>(binary<float>());
            case PlyType::float64:
                return binary<double>();
            default:
                return static_cast<double>(integer(type));
        }
    }
    std::int64_t integer(PlyType type) {
        if (format_ == PlyFormat::ascii) return reader_.integer(words_.next(), "an integer");
        switch (type) {
            case PlyType::int8:
                return binary<std::int8_t>();
            case PlyType::uint8:
                return binary<std::uint8_t>();
            case PlyType::int16:
                return binary<std::int16_t>();
            case PlyType::uint16:
                return binary<std::uint16_t>();
            case PlyType::int32:
                return binary<std::int32_t>();
            default:
                return binary<std::uint32_t>();
        }
    }
    /// The length of a list, checked against what is left of the file.
    std::uint64_t listLength(const PlyProperty& property) {
        const std::int64_t n = integer(property.countType);
        // A list in text ends with the words that are there.
        if (n < 0 ||
            (format_ != PlyFormat::ascii &&
             static_cast<std::uint64_t>(n) > reader_.source.remaining() / bytesOf(property.type)))
            fail(
                fmt::format("list of {} values, more than the file holds; it is truncated or "
                            "broken",
                            n));
        return static_cast<std::uint64_t>(n);
    }
    void skip(const PlyProperty& property) {
        const std::uint64_t n = property.isList ? listLength(property) : 1;
        for (std::uint64_t i = 0; i < n; ++i) {
            if (format_ == PlyFormat::ascii) {
                if (words_.next().empty()) truncated();
            } else {
                if (reader_.source.take(bytesOf(property.type)) == nullptr) truncated();
            }
        }
    }
    /// Where the reader stands, for a message.
    [[noreturn]] void fail(const std::string& what) const {
        if (format_ == PlyFormat::ascii) reader_.source.failAtLine(what);
        reader_.source.failAtByte(reader_.source.offset(), what);
    }
    /// True if only blanks follow.
    bool atEnd() {
        if (format_ == PlyFormat::ascii) return words_.next().empty();
        while (const char* c = reader_.source.take(1))
            if (std::isspace(static_cast<unsigned char>(*c)) == 0) return false;
        return true;
    }

private:
    template <typename T>
    T binary() {
        const char* const from = reader_.source.take(sizeof(T));
        if (from == nullptr) truncated();
        std::array<char, sizeof(T)> bytes{};
        std::copy_n(from, sizeof(T), bytes.begin());
        if (format_ == PlyFormat::bigEndian) std::reverse(bytes.begin(), bytes.end());
        return littleEndian<T>(bytes.data());
    }
    [[noreturn]] void truncated() const { fail("the file ends too early; it is truncated"); }

    Reader& reader_;
    TextWords words_;
    PlyFormat format_;
};

void readPlyVertices(Reader& reader, PlyValues& values, const PlyElement& element, bool isBinary) {
    std::vector<int> axisOf(element.properties.size(), -1);
    std::array<int, 3> found{};
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
        const auto& property = element.properties[k];
        for (int d = 0; d < 3; ++d)
            if (!property.isList && property.name == std::string(1, static_cast<char>('x' + d))) {
                axisOf[k] = d;
                ++found[static_cast<std::size_t>(d)];
                reader.facts.singlePrecision |= isBinary && property.type == PlyType::float32;
            }
    }
    if (found != std::array<int, 3>{1, 1, 1})
        reader.source.fail("its vertices do not have one property each named x, y and z");
    reader.checkVertexTotal(element.count);
    reader.mesh.vertices.reserve(element.count);
    for (std::uint64_t i = 0; i < element.count; ++i) {
        Vec<3> p;
        for (std::size_t k = 0; k < element.properties.size(); ++k) {
            const auto& property = element.properties[k];
            if (axisOf[k] >= 0)
                p[axisOf[k]] = values.real(property.type) + 0.0;
            else
                values.skip(property);
        }
        if (auto why = reader.complaint(p); !why.empty())
            values.fail(fmt::format("vertex {} {}", i, why));
        reader.mesh.vertices.push_back(p);
    }
}

void readPlyFaces(Reader& reader, PlyValues& values, const PlyElement& element,
                  std::uint64_t vertexCount) {
    const auto isCorners = [](const PlyProperty& property) {
        return property.isList &&
               (property.name == "vertex_indices" || property.name == "vertex_index");
    };
    if (std::count_if(element.properties.begin(), element.properties.end(), isCorners) != 1)
        reader.source.fail("its faces do not have one list named vertex_indices (or vertex_index)");
    for (const auto& property : element.properties)
        if (isCorners(property) && isReal(property.type))
            reader.source.fail("the vertex indices of its faces are not integers");
    reader.mesh.triangles.reserve(element.count);
    for (std::uint64_t i = 0; i < element.count; ++i)
        for (const auto& property : element.properties) {
            if (!isCorners(property)) {
                values.skip(property);
                continue;
            }
            const std::uint64_t corners = values.listLength(property);
            if (corners < 3)
                values.fail(
                    fmt::format("face {} has {} corners; 3 or more are needed", i, corners));
            Fan fan;
            for (std::uint64_t k = 0; k < corners; ++k) {
                const std::int64_t index = values.integer(property.type);
                if (index < 0 || static_cast<std::uint64_t>(index) >= vertexCount)
                    values.fail(
                        fmt::format("face {} names vertex {}, but the file has {}, counted from 0",
                                    i, index, vertexCount));
                fan.add(reader, static_cast<std::uint32_t>(index));
            }
        }
}

void readPly(Reader& reader) {
    const PlyHeader header = readPlyHeader(reader);
    constexpr std::array<const char*, 3> kFormats{"ASCII PLY", "binary PLY (little endian)",
                                                  "binary PLY (big endian)"};
    reader.facts.format = kFormats[static_cast<std::size_t>(header.format)];
    std::uint64_t vertexCount = 0;
    bool hasFaces = false;
    for (const auto& element : header.elements) {
        if (element.name == "vertex") vertexCount = element.count;
        if (element.name == "face") hasFaces = element.count > 0;
    }
    if (!hasFaces)
        reader.source.fail("holds no faces; a closed surface is needed, not a cloud of points");
    PlyValues values(reader, header.format);
    for (const auto& element : header.elements) {
        std::uint64_t least = 0;
        for (const auto& property : element.properties)
            least += header.format == PlyFormat::ascii
                         ? 2
                         : bytesOf(property.isList ? property.countType : property.type);
        reader.checkCount(element.count, least, element.name == "face" ? "faces" : "vertices");
        if (element.name == "vertex") {
            readPlyVertices(reader, values, element, header.format != PlyFormat::ascii);
        } else if (element.name == "face") {
            readPlyFaces(reader, values, element, vertexCount);
            reader.facts.faces = element.count;
        } else if (!element.properties.empty()) {
            for (std::uint64_t i = 0; i < element.count; ++i)
                for (const auto& property : element.properties) values.skip(property);
        }
    }
    if (!values.atEnd())
        values.fail("the file goes on after what its header announces; its counts are wrong");
    reader.facts.vertices = reader.mesh.vertices.size();
}

// -----------------------------------------------------------------------------------------------

/// Drops vertices that no triangle names; returns how many.
std::size_t dropUnused(TriangleMesh& mesh) {
    std::vector<std::uint32_t> newIndex(mesh.vertices.size(), kNone);
    for (const auto& t : mesh.triangles)
        for (const auto v : t) newIndex[v] = 0;
    std::uint32_t kept = 0;
    for (std::size_t v = 0; v < newIndex.size(); ++v) {
        if (newIndex[v] == kNone) continue;
        mesh.vertices[kept] = mesh.vertices[v];
        newIndex[v] = kept++;
    }
    const std::size_t dropped = mesh.vertices.size() - kept;
    if (dropped == 0) return 0;
    mesh.vertices.resize(kept);
    for (auto& t : mesh.triangles)
        for (auto& v : t) v = newIndex[v];
    return dropped;
}

std::string lowerExtension(const std::string& path) {
    const std::size_t slash = path.find_last_of('/');
    const std::size_t dot = path.find_last_of('.');
    if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) return "";
    std::string extension = path.substr(dot);
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

}  // namespace

TriangleMesh welded(TriangleMesh mesh, MeshFileFacts* facts) {
    std::size_t merged = 0;
    {
        Welder welder;
        std::vector<std::uint32_t> newIndex(mesh.vertices.size());
        for (std::size_t v = 0; v < newIndex.size(); ++v)
            newIndex[v] = welder.add(mesh.vertices[v]);
        merged = mesh.vertices.size() - welder.size();
        if (merged > 0) {
            mesh.vertices = welder.takeVertices();
            for (auto& t : mesh.triangles)
                for (auto& v : t) v = newIndex[v];
        }
    }
    const std::size_t unused = dropUnused(mesh);
    if (facts != nullptr) {
        facts->mergedVertices += merged;
        facts->unusedVertices += unused;
    }
    return mesh;
}

TriangleMesh readMesh(const std::string& path, const MeshReadOptions& options,
                      MeshFileFacts* facts) {
    if (!std::isfinite(options.scale) || options.scale <= 0)
        throw ParameterError(
            fmt::format("scale {} is not a positive number; use one such as 0.1", options.scale));
    const std::string extension = lowerExtension(path);
    void (*read)(Reader&) = nullptr;
    if (extension == ".stl") read = readStl;
    if (extension == ".obj") read = readObj;
    if (extension == ".ply") read = readPly;
    if (extension == ".off") read = readOff;
    if (read == nullptr)
        throw InputError(path + ": format " + quoted(extension) +
                         " is not read as a mesh; convert it to .stl, .obj, .ply or .off");
    const double factor = millimetersPer(options.unit) * options.scale;
    MeshFileFacts found;
    TriangleMesh mesh;
    try {
        FileSource source(path);
        found.bytes = static_cast<std::size_t>(source.size());
        if (source.size() == 0) source.fail("is empty; export the mesh again");
        if (source.peek(3) == "\xEF\xBB\xBF") source.take(3);  // byte order mark of UTF-8
        Reader reader{source, kLargest / factor, found, {}};
        read(reader);
        if (reader.mesh.triangles.empty())
            source.fail("holds no triangles; a closed surface is needed");
        mesh =
            extension == ".stl" ? std::move(reader.mesh) : welded(std::move(reader.mesh), &found);
    } catch (const std::bad_alloc&) {
        throw ResourceError(path + ": not enough memory to read it; simplify the mesh");
    }
    if (factor != 1.0)
        for (auto& v : mesh.vertices) v *= factor;
    if (facts != nullptr) *facts = found;
    return mesh;
}

}  // namespace vdbpack
