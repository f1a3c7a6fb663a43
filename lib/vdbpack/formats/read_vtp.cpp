// VTK's XML polygon data, as ParaView and `writePack` save it: points with arrays of attributes.
#include "vdbpack/core/memory.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/io/text.h"
#include "vdbpack/io/vtk_xml.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::uint64_t kLongestUnit = 100;      ///< bytes
constexpr std::uint64_t kLongestCell = 400;      ///< bytes
constexpr std::uint64_t kLongestText = 1 << 20;  ///< bytes on average

struct Piece {
    std::uint64_t points = 0;
    VtkArray positions;
    std::vector<VtkArray> attributes;
};

class VtpFile {
public:
    VtpFile(const std::string& path, const PackReadOptions& options)
        : xml_(path, "PolyData", options.memoryLimit),
          unit_(options.unit),
          memoryLimit_(options.memoryLimit) {}

    /// Adds the points to those that `builder` has; makes it if it is null.
    void read(std::unique_ptr<PackBuilder>& builder) {
        takeUnit();
        takeCell();
        const auto pieces = piecesOf();
        const Piece& first = pieces.front();
        const auto columns = columnsOf(first);
        if (!builder) {
            builder = std::make_unique<PackBuilder>(xml_.path(), columns, unit_);
            std::size_t column = 3;
            for (const VtkArray& a : first.attributes) {
                if (a.string) builder->makeText(column);
                column += a.components;
            }
        } else if (columns != builder->names() || unit_ != builder->unit()) {
            xml_.fail("has other arrays, or another unit, than the pieces before it");
        }
        // One piece at a time is enough in memory.
        for (const Piece& piece : pieces) {
            if (piece.points == 0) continue;
            requireAlike(first, piece);
            append(piece, *builder, pieces.size() == 1 && builder->rows() == 0);
        }
    }

    const PeriodicCell<3>& cell() const { return cell_; }

private:
    /// The text of that name in the field data, where there is one.
    std::optional<std::string> noted(std::string_view name, std::uint64_t longest) {
        std::optional<std::string> text;
        for (const pugi::xml_node& node : xml_.data().child("FieldData"))
            if (VtkXml::isArray(node) && VtkXml::attribute(node, "Name") == name &&
                VtkXml::attribute(node, "type") == "String")
                text = xml_.arrays().texts(xml_.described(node), 1, longest)[0];
        return text;
    }

    /// The periodic cell in the field data, where there is one.
    void takeCell() {
        const auto text = noted(kCellKey, kLongestCell);
        if (!text) return;
        const auto cell = parseCellText(*text, unit_);
        if (!cell)
            xml_.fail(
                fmt::format("{} is no periodic cell; remove that array", quotedExcerpt(*text)));
        cell_ = *cell;
    }

    /// The unit in the field data, where there is one.
    void takeUnit() {
        const auto text = noted(kUnitKey, kLongestUnit);
        if (text && !parseUnitComment(kUnitComment + *text, unit_))
            xml_.fail(fmt::format("unknown unit {}; use m, cm, mm or um", quotedExcerpt(*text)));
    }

    std::vector<Piece> piecesOf() const {
        std::vector<Piece> pieces;
        for (const pugi::xml_node& node : xml_.data().children("Piece")) {
            Piece piece;
            piece.points = xml_.countOf(node, "NumberOfPoints");
            for (const pugi::xml_node& array : node.child("PointData"))
                if (VtkXml::isArray(array)) piece.attributes.push_back(xml_.described(array));
            for (const pugi::xml_node& array : node.child("Points"))
                if (VtkXml::isArray(array)) piece.positions = xml_.described(array);
            pieces.push_back(std::move(piece));
        }
        if (pieces.empty()) xml_.fail("holds no piece with points");
        return pieces;
    }

    static std::vector<std::string> columnsOf(const Piece& piece) {
        std::vector<std::string> names = {"x", "y", "z"};
        for (const VtkArray& a : piece.attributes)
            for (std::uint64_t c = 0; c < a.components; ++c)
                names.push_back(a.components == 1 ? a.name : fmt::format("{}_{}", a.name, c));
        return names;
    }

    void requireAlike(const Piece& first, const Piece& piece) const {
        if (piece.positions.components != 3 || piece.positions.string)
            xml_.fail("a piece has no points with three coordinates");
        const bool alike = std::equal(
            first.attributes.begin(), first.attributes.end(), piece.attributes.begin(),
            piece.attributes.end(), [](const VtkArray& a, const VtkArray& b) {
                return a.name == b.name && a.string == b.string && a.components == b.components;
            });
        if (!alike) xml_.fail("its pieces have different arrays; save it as one piece");
    }

    /// The values of an array in one piece.
    struct Values {
        const VtkArray* array;
        std::vector<char> numbers;
        std::vector<std::string> texts;
    };

    Values valuesOf(const VtkArray& array, const Piece& piece) {
        Values values{&array, {}, {}};
        if (!array.string) {
            values.numbers = xml_.arrays().numbers(array, piece.points);
            return values;
        }
        if (array.components != 1)
            xml_.fail(fmt::format("array {} holds {} texts a point; one is needed",
                                  quotedExcerpt(array.name), array.components));
        values.texts = xml_.arrays().texts(array, piece.points, kLongestText);
        return values;
    }

    void append(const Piece& piece, PackBuilder& builder, bool only) {
        std::vector<Values> all;
        all.push_back(valuesOf(piece.positions, piece));
        for (const VtkArray& a : piece.attributes) all.push_back(valuesOf(a, piece));
        requireMemoryToRead(xml_.path(), builder.bytesOf(piece.points), memoryLimit_);
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
                    if (!loadNumber(values.array->type, bytes, xml_.arrays().swap(),
                                    [&](auto value) { return builder.set(column, value); }))
                        builder.failCell(where(), column, "out of range");
            }
            if (!builder.problem().empty()) builder.failRow(where());
        }
    }

    VtkXml xml_;
    Unit unit_;
    PeriodicCell<3> cell_;
    double memoryLimit_;
};

}  // namespace

Pack<3> readVtp(const std::string& path, const PackReadOptions& options) {
    std::unique_ptr<PackBuilder> builder;
    VtpFile file(path, options);
    file.read(builder);
    Pack<3> pack = builder->finish();
    pack.cell = file.cell();
    return pack;
}

Pack<3> readPvtp(const std::string& path, const PackReadOptions& options) {
    const VtkXml index(path, "PPolyData", options.memoryLimit);
    std::unique_ptr<PackBuilder> builder;
    for (const pugi::xml_node& piece : index.data().children("Piece")) {
        const std::filesystem::path source = VtkXml::attribute(piece, "Source");
        if (source.empty()) index.fail("a piece has no Source");
        VtpFile((std::filesystem::path(path).parent_path() / source).string(), options)
            .read(builder);
    }
    if (!builder) index.fail("names no pieces");
    return builder->finish();
}

}  // namespace vdbpack
