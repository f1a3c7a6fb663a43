// VTK's XML polygon data, as ParaView and `writePack` save it: points with arrays of attributes.
#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/vtp_arrays.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>
#include <pugixml.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::string_view kAppended = "<AppendedData";
constexpr std::int64_t kMostComponents = 16;
constexpr std::ptrdiff_t kMostTags = 1'000'000;

struct Piece {
    std::uint64_t points = 0;
    VtpArray positions;
    std::vector<VtpArray> attributes;
};

std::string_view attribute(const pugi::xml_node& node, const char* name) {
    return node.attribute(name).value();
}

bool isArray(const pugi::xml_node& node) {
    const std::string_view name = node.name();
    return name == "DataArray" || name == "Array";
}

bool parseType(std::string_view name, NumberType& type) {
    static constexpr struct {
        std::string_view name;
        NumberType type;
    } kTypes[] = {{"Int8", NumberType::i8},     {"UInt8", NumberType::u8},
                  {"Int16", NumberType::i16},   {"UInt16", NumberType::u16},
                  {"Int32", NumberType::i32},   {"UInt32", NumberType::u32},
                  {"Int64", NumberType::i64},   {"UInt64", NumberType::u64},
                  {"Float32", NumberType::f32}, {"Float64", NumberType::f64}};
    for (const auto& t : kTypes) {
        if (name != t.name) continue;
        type = t.type;
        return true;
    }
    return false;
}

class VtpFile {
public:
    VtpFile(const std::string& path, const PackReadOptions& options)
        : file_(path), unit_(options.unit) {}

    Pack<3> read() {
        readXml();
        const pugi::xml_node root = rootOf();
        VtpArrays arrays(file_, encodingOf(root));
        takeAppended(root, arrays);
        takeUnit(root, arrays);
        const auto pieces = piecesOf(root);
        const Piece& first = pieces.front();
        PackBuilder builder(file_.path(), columnsOf(first), unit_);
        std::size_t column = 3;
        for (const VtpArray& a : first.attributes) {
            if (a.string) builder.makeText(column);
            column += a.components;
        }
        // One piece at a time is enough in memory.
        for (const Piece& piece : pieces) {
            if (piece.points == 0) continue;
            requireAlike(first, piece);
            append(piece, arrays, builder, pieces.size() == 1);
        }
        return builder.finish();
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(file_.path() + ": " + what);
    }
    [[noreturn]] void failAt(std::ptrdiff_t byte, const std::string& what) const {
        fail(fmt::format("byte {}: {}; the file is damaged or not a .vtp file", byte, what));
    }

    /// Parses everything up to the appended bytes, which are not XML, or else the whole file.
    void readXml() {
        constexpr std::uint64_t kChunk = 1 << 16;
        std::size_t searched = 0;
        while (xml_.size() < file_.size() && appended_ == 0) {
            const std::size_t before = xml_.size();
            const auto more = static_cast<std::size_t>(std::min<std::uint64_t>(
                std::max<std::uint64_t>(kChunk, before), file_.size() - before));
            xml_.resize(before + more);
            file_.readAt(before, xml_.data() + before, more);
            const auto found = xml_.find(kAppended, searched);
            if (found == std::string::npos) {
                searched = xml_.size() - std::min(xml_.size(), kAppended.size());
                continue;
            }
            searched = found;
            const auto marker = xml_.find('_', found + kAppended.size());
            if (marker == std::string::npos) continue;
            appended_ = marker + 1;
            xml_.resize(marker);
            xml_ += "</AppendedData></VTKFile>";
        }
        // Each takes some 60 bytes of memory.
        if (std::count_if(xml_.begin(), xml_.end(), [](char c) { return c == '<' || c == '='; }) >
            kMostTags)
            fail(fmt::format("has more than {} tags and attributes; save the points as one piece",
                             kMostTags));
        const auto parsed = document_.load_buffer_inplace(xml_.data(), xml_.size());
        if (parsed.status == pugi::status_out_of_memory) throw std::bad_alloc();
        if (!parsed) failAt(parsed.offset, parsed.description());
    }

    pugi::xml_node rootOf() const {
        const pugi::xml_node root = document_.child("VTKFile");
        if (attribute(root, "type") != "PolyData")
            fail("is not a .vtp file: VTKFile of type PolyData is expected");
        return root;
    }

    static VtpEncoding encodingOf(const pugi::xml_node& root) {
        VtpEncoding encoding;
        encoding.swap = (attribute(root, "byte_order") == "BigEndian") != hostIsBigEndian();
        encoding.wideHeader = attribute(root, "header_type") == "UInt64";
        encoding.compressor = attribute(root, "compressor");
        return encoding;
    }

    void takeAppended(const pugi::xml_node& root, VtpArrays& arrays) const {
        const pugi::xml_node section = root.child("AppendedData");
        if (section.empty() != (appended_ == 0)) fail("the appended section is malformed");
        if (section.empty()) return;
        if (attribute(section, "encoding") == "base64")
            arrays.appendBase64(appended_);
        else
            arrays.appendRaw(appended_);
    }

    /// The unit in the field data, where there is one.
    void takeUnit(const pugi::xml_node& root, VtpArrays& arrays) {
        for (const pugi::xml_node& node : root.child("PolyData").child("FieldData")) {
            if (!isArray(node) || attribute(node, "Name") != kUnitKey ||
                attribute(node, "type") != "String")
                continue;
            const auto found = arrays.texts(described(node));
            if (!found.empty() && !parseUnitComment(kUnitComment + found[0], unit_))
                fail(fmt::format("unknown unit '{}'; use m, cm, mm or um", found[0].substr(0, 40)));
        }
    }

    std::vector<Piece> piecesOf(const pugi::xml_node& root) const {
        std::vector<Piece> pieces;
        for (const pugi::xml_node& node : root.child("PolyData").children("Piece")) {
            Piece piece;
            std::int64_t points = 0;
            if (!parseNumber(attribute(node, "NumberOfPoints"), points) || points < 0)
                failAt(node.offset_debug(), "a piece has no usable NumberOfPoints");
            piece.points = static_cast<std::uint64_t>(points);
            for (const pugi::xml_node& array : node.child("PointData"))
                if (isArray(array)) piece.attributes.push_back(described(array));
            for (const pugi::xml_node& array : node.child("Points"))
                if (isArray(array)) piece.positions = described(array);
            pieces.push_back(std::move(piece));
        }
        if (pieces.empty()) fail("holds no piece with points");
        return pieces;
    }

    VtpArray described(const pugi::xml_node& node) const {
        VtpArray a;
        a.name = attribute(node, "Name");
        a.string = attribute(node, "type") == "String";
        if (!a.string && !parseType(attribute(node, "type"), a.type))
            failAt(node.offset_debug(), "an array has an unknown type");
        const auto components = attribute(node, "NumberOfComponents");
        std::int64_t count = 1;
        if (!components.empty() &&
            (!parseNumber(components, count) || count < 1 || count > kMostComponents))
            failAt(node.offset_debug(), "an array has an unusable number of components");
        a.components = static_cast<std::uint64_t>(count);
        const auto format = attribute(node, "format");
        if (format == "appended") {
            a.format = VtpArray::Format::appended;
            std::int64_t offset = 0;
            if (!parseNumber(attribute(node, "offset"), offset) || offset < 0)
                failAt(node.offset_debug(), "an appended array has no usable offset");
            a.offset = static_cast<std::uint64_t>(offset);
        } else {
            if (format != "ascii" && !format.empty()) a.format = VtpArray::Format::inlineBase64;
            a.text = node.child_value();
        }
        return a;
    }

    static std::vector<std::string> columnsOf(const Piece& piece) {
        std::vector<std::string> names = {"x", "y", "z"};
        for (const VtpArray& a : piece.attributes)
            for (std::uint64_t c = 0; c < a.components; ++c)
                names.push_back(a.components == 1 ? a.name : fmt::format("{}_{}", a.name, c));
        return names;
    }

    void requireAlike(const Piece& first, const Piece& piece) const {
        if (piece.positions.components != 3 || piece.positions.string)
            fail("a piece has no points with three coordinates");
        const bool alike = std::equal(
            first.attributes.begin(), first.attributes.end(), piece.attributes.begin(),
            piece.attributes.end(), [](const VtpArray& a, const VtpArray& b) {
                return a.name == b.name && a.string == b.string && a.components == b.components;
            });
        if (!alike) fail("its pieces have different arrays; save it as one piece");
    }

    /// The values of an array in one piece.
    struct Values {
        const VtpArray* array;
        std::vector<char> numbers;
        std::vector<std::string> texts;
    };

    Values valuesOf(const VtpArray& array, const Piece& piece, VtpArrays& arrays) const {
        Values values{&array, {}, {}};
        if (!array.string) {
            values.numbers = arrays.numbers(array, piece.points);
            return values;
        }
        values.texts = arrays.texts(array);
        if (array.components != 1 || values.texts.size() != piece.points)
            fail(fmt::format("array '{}' holds {} texts for {} points; the file is damaged",
                             array.name.substr(0, 40), values.texts.size(), piece.points));
        return values;
    }

    void append(const Piece& piece, VtpArrays& arrays, PackBuilder& builder, bool only) const {
        std::vector<Values> all;
        all.push_back(valuesOf(piece.positions, piece, arrays));
        for (const VtpArray& a : piece.attributes) all.push_back(valuesOf(a, piece, arrays));
        if (only) builder.reserve(static_cast<std::size_t>(piece.points));
        for (std::size_t i = 0; i < piece.points; ++i) {
            const auto where = [i] { return fmt::format("point {}", i); };
            builder.addRow();
            std::size_t column = 0;
            for (const Values& values : all) {
                if (values.array->string) {
                    builder.setText(column++, values.texts[i]);
                    continue;
                }
                const std::size_t size = bytesOf(values.array->type);
                const std::size_t components = values.array->components;
                const char* bytes = values.numbers.data() + i * components * size;
                for (std::size_t c = 0; c < components; ++c, ++column, bytes += size)
                    if (!loadNumber(values.array->type, bytes, arrays.swap(),
                                    [&](auto value) { return builder.set(column, value); }))
                        builder.failCell(where(), column, "out of range");
            }
            if (!builder.problem().empty()) builder.failRow(where());
        }
    }

    InputFile file_;
    Unit unit_;
    std::string xml_;  ///< holds the texts of `document_`
    pugi::xml_document document_;
    std::uint64_t appended_ = 0;  ///< offset of the first appended byte; 0: there is none
};

}  // namespace

Pack<3> readVtp(const std::string& path, const PackReadOptions& options) {
    return VtpFile(path, options).read();
}

}  // namespace vdbpack
