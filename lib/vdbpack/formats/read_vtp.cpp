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
        if (const auto text = noted(kUnitKey, kLongestUnit)) unit_ = unitNamed(*text, xml_.path());
        if (const auto text = noted(kCellKey, kLongestCell))
            cell_ = cellIn(*text, unit_, xml_.path());
        const auto pieces = piecesOf();
        const Piece& first = pieces.front();
        std::vector<std::string> columns = {"x", "y", "z"};
        for (const VtkArray& a : first.attributes) addNames(columns, a.name, a.components);
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

    void append(const Piece& piece, PackBuilder& builder, bool only) {
        std::vector<VtkArray> arrays = {piece.positions};
        arrays.insert(arrays.end(), piece.attributes.begin(), piece.attributes.end());
        std::vector<VtkNumbers> numbers(arrays.size());
        std::vector<std::vector<std::string>> texts(arrays.size());
        std::vector<PackBuilder::Put> puts;
        for (std::size_t k = 0; k < arrays.size(); ++k) {
            const VtkArray& array = arrays[k];
            if (array.string) {
                if (array.components != 1)
                    xml_.fail(fmt::format("array {} holds {} texts a point; one is needed",
                                          quotedExcerpt(array.name), array.components));
                texts[k] = xml_.arrays().texts(array, piece.points, kLongestText);
                puts.push_back(builder.textsFrom(texts[k]));
                continue;
            }
            numbers[k] = xml_.arrays().numbers(array, piece.points);
            const std::size_t size = bytesOf(numbers[k].type);
            for (std::size_t c = 0; c < array.components; ++c)
                puts.push_back(builder.numbersFrom(numbers[k].bytes.data() + c * size,
                                                   array.components * size, numbers[k].type,
                                                   numbers[k].swap));
        }
        requireMemoryToRead(xml_.path(), builder.bytesOf(piece.points), memoryLimit_);
        if (only) builder.reserve(static_cast<std::size_t>(piece.points));
        builder.addRows(piece.points, puts, "point");
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
