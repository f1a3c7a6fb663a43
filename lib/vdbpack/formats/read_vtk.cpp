// VTK's files of points with arrays of attributes: polygon data and unstructured grids, in XML
// (.vtp .vtu, and .pvtp .pvtu of several pieces) and in the legacy format (.vtk).
#include "vdbpack/core/memory.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_builder.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/io/text.h"
#include "vdbpack/io/vtk_legacy.h"
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
constexpr std::uint64_t kLongestName = 1000;     ///< bytes on average
constexpr std::uint64_t kLongestText = 1 << 20;  ///< bytes on average

/// An array of a value, or of some numbers, for each point.
struct PointArray {
    VtkArray described;
    VtkTuples values;
};

/// The columns of points with these attributes.
std::unique_ptr<PackBuilder> builderOf(const std::string& path,
                                       const std::vector<VtkArray>& attributes,
                                       const PackReadOptions& options) {
    std::vector<std::string> columns = {"x", "y", "z"};
    for (const VtkArray& a : attributes) addNames(columns, a.name, a.components);
    auto builder = std::make_unique<PackBuilder>(path, columns, options);
    std::size_t column = 3;
    for (const VtkArray& a : attributes) {
        if (a.string && a.components != 1)
            throw InputError(fmt::format("{}: array {} holds {} texts a point; one is needed", path,
                                         quotedExcerpt(a.name), a.components));
        if (a.string) builder->makeText(column);
        column += a.components;
    }
    return builder;
}

/// @param arrays  positions first, then the attributes.
void addPoints(PackBuilder& builder, std::uint64_t points, const std::vector<PointArray>& arrays) {
    std::vector<PackBuilder::Put> puts;
    for (const PointArray& array : arrays) {
        if (array.described.string) {
            puts.push_back(builder.textsFrom(array.values.texts));
            continue;
        }
        const VtkNumbers& numbers = array.values.numbers;
        const std::size_t size = bytesOf(numbers.type), stride = array.described.components * size;
        for (std::size_t c = 0; c < array.described.components; ++c)
            puts.push_back(builder.numbersFrom(numbers.bytes.data() + c * size, stride,
                                               numbers.type, numbers.swap));
    }
    builder.addRows(points, puts, "point");
}

struct Piece {
    std::uint64_t points = 0;
    VtkArray positions;
    std::vector<VtkArray> attributes;
};

class XmlPoints {
public:
    /// @param type  of the data: "PolyData".
    XmlPoints(const std::string& path, const std::string& type, const PackReadOptions& options)
        : xml_(path, type, options.memoryLimit), options_(options) {}

    /// Adds the points to those that `builder` has; makes it if it is null.
    void read(std::unique_ptr<PackBuilder>& builder) {
        if (const auto texts = noted(kUnitKey, kLongestUnit); !texts.empty())
            options_.unit = unitNamed(texts[0], xml_.path());
        if (const auto texts = noted(kCellKey, kLongestCell); !texts.empty())
            cell_ = cellIn(texts[0], options_.unit, xml_.path());
        partNames_ = noted(kPartNamesKey, kLongestName);
        if (const auto texts = noted(kGeneratorKey, kLongestText); !texts.empty())
            origin_ = originIn(texts[0]);
        const auto pieces = piecesOf();
        const auto filled = std::find_if(pieces.begin(), pieces.end(),
                                         [](const Piece& piece) { return piece.points > 0; });
        // A piece without points may have no arrays, either.
        if (filled == pieces.end() && pieces.front().attributes.empty()) return;
        const Piece& first = filled == pieces.end() ? pieces.front() : *filled;
        auto own = builderOf(xml_.path(), first.attributes, options_);
        if (!builder)
            builder = std::move(own);
        else if (own->names() != builder->names() || own->unit() != builder->unit())
            xml_.fail("has other arrays, or another unit, than the pieces before it");
        // One piece at a time is enough in memory.
        for (const Piece& piece : pieces) {
            if (piece.points == 0) continue;
            requireAlike(first, piece);
            append(piece, *builder, pieces.size() == 1 && builder->rows() == 0);
        }
    }

    const PeriodicCell<3>& cell() const { return cell_; }
    /// What the file notes about parts and axes.
    void note(Pack<3>& pack) const {
        setPartNames(pack, partNames_);
        pack.origin = origin_;
    }

private:
    /// The texts of that name in the field data, where there are some.
    std::vector<std::string> noted(std::string_view name, std::uint64_t longest) {
        std::vector<std::string> texts;
        for (const pugi::xml_node& node : xml_.data().child("FieldData"))
            if (VtkXml::isArray(node) && VtkXml::attribute(node, "Name") == name &&
                VtkXml::attribute(node, "type") == "String")
                texts = xml_.arrays().texts(
                    xml_.described(node),
                    node.attribute("NumberOfTuples") ? xml_.countOf(node, "NumberOfTuples") : 1,
                    longest);
        return texts;
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
        std::vector<VtkArray> described = {piece.positions};
        described.insert(described.end(), piece.attributes.begin(), piece.attributes.end());
        std::vector<PointArray> arrays;
        for (const VtkArray& array : described) {
            arrays.emplace_back().described = array;
            if (array.string)
                arrays.back().values.texts = xml_.arrays().texts(array, piece.points, kLongestText);
            else
                arrays.back().values.numbers = xml_.arrays().numbers(array, piece.points);
        }
        requireMemoryToRead(xml_.path(), builder.bytesOf(piece.points), options_.memoryLimit);
        if (only) builder.reserve(static_cast<std::size_t>(piece.points));
        addPoints(builder, piece.points, arrays);
    }

    VtkXml xml_;
    PackReadOptions options_;
    PeriodicCell<3> cell_;
    std::vector<std::string> partNames_;
    PackOrigin origin_;
};

class LegacyPoints {
public:
    LegacyPoints(const std::string& path, const PackReadOptions& options)
        : file_(path, options.memoryLimit), options_(options) {
        if (file_.dataSet() != "polydata" && file_.dataSet() != "unstructured_grid")
            file_.fail("DATASET POLYDATA or UNSTRUCTURED_GRID expected, found " +
                       quotedExcerpt(file_.dataSet()) + "; save the points as one of these");
    }

    Pack<3> read() {
        std::string keyword;
        while (file_.nextStatement(keyword)) takeStatement(keyword);
        if (!hasPoints_) file_.fail("holds no POINTS");
        std::vector<VtkArray> attributes;
        for (std::size_t a = 1; a < arrays_.size(); ++a) attributes.push_back(arrays_[a].described);
        const auto builder = builderOf(file_.path(), attributes, options_);
        requireMemoryToRead(file_.path(), builder->bytesOf(points_), options_.memoryLimit);
        builder->reserve(static_cast<std::size_t>(points_));
        addPoints(*builder, points_, arrays_);
        Pack<3> pack = builder->finish();
        if (!cell_.empty()) pack.cell = cellIn(cell_, options_.unit, file_.path());
        setPartNames(pack, std::move(partNames_));
        pack.origin = origin_;
        return pack;
    }

private:
    void takeStatement(const std::string& keyword) {
        if (keyword == "points") {
            if (hasPoints_) file_.fail("POINTS come twice");
            hasPoints_ = true;
            points_ = file_.count("a number of points");
            const VtkArray array = file_.typed("Points", 3);
            arrays_.push_back({array, file_.tuples(array, points_)});
        } else if (keyword == "cells" || keyword == "vertices" || keyword == "lines" ||
                   keyword == "polygons" || keyword == "triangle_strips") {
            file_.cells();
        } else if (keyword == "cell_types") {
            file_.integers(NumberType::i32, file_.count("a number of cells"));
        } else if (keyword == "metadata") {
            file_.skipMetadata();
        } else if (keyword == "point_data" || keyword == "cell_data") {
            ofPoints_ = keyword == "point_data";
            rows_ = file_.count("a number of points or cells");
            if (ofPoints_ && (!hasPoints_ || *rows_ != points_))
                file_.fail(
                    fmt::format("POINT_DATA is of {} points, POINTS are {}", *rows_, points_));
        } else if (keyword == "field") {
            file_.forFieldArrays(
                [this](const VtkArray& array, const VtkTuples& values) { keep(array, values); });
        } else {
            takeAttribute(keyword);
        }
    }

    void takeAttribute(const std::string& keyword) {
        constexpr std::pair<std::string_view, std::uint64_t> kComponents[] = {
            {"scalars", 1},
            {"vectors", 3},
            {"normals", 3},
            {"tensors", 9},
            {"tensors6", 6},
            {"global_ids", 1},
            {"pedigree_ids", 1},
            {"edge_flags", 1},
            {"lookup_table", 4},
            {"color_scalars", 0},
            {"texture_coordinates", 0}};
        const auto* const known =
            std::find_if(std::begin(kComponents), std::end(kComponents),
                         [&](const auto& attribute) { return attribute.first == keyword; });
        if (known == std::end(kComponents) || !rows_)
            file_.fail("a statement such as POINTS or POINT_DATA expected, found " +
                       quotedExcerpt(keyword));
        const std::string name = file_.name();
        std::uint64_t components = known->second;
        if (components == 0) components = file_.count("a number of components");
        if (keyword == "lookup_table") {  // bytes, or in text numbers from 0 to 1
            file_.skipColors(4 * file_.count("a number of colors"));
            return;
        }
        if (keyword == "color_scalars") return file_.skipColors(components * *rows_);
        VtkArray array = file_.typed(name, components);
        if (keyword == "scalars") {
            if (const std::string_view stated = file_.rest(); !trimmed(stated).empty())
                array.components = file_.count("a number of components");
            if (array.components < 1 || array.components > 4)
                file_.fail("SCALARS have 1 to 4 components");
            std::string table;
            if (!file_.nextStatement(table) || table != "lookup_table")
                file_.fail("LOOKUP_TABLE expected after SCALARS, found " + quotedExcerpt(table));
        }
        keep(array, file_.tuples(array, *rows_));
    }

    /// Keeps the values of points, and what is noted about the whole file.
    void keep(const VtkArray& array, const VtkTuples& values) {
        if (!rows_ && !values.texts.empty()) {
            if (array.name == kUnitKey) options_.unit = unitNamed(values.texts[0], file_.path());
            if (array.name == kCellKey) cell_ = values.texts[0];
            if (array.name == kPartNamesKey) partNames_ = values.texts;
            if (array.name == kGeneratorKey) origin_ = originIn(values.texts[0]);
        }
        if (!rows_ || !ofPoints_) return;
        if (values.count != points_)
            file_.fail(fmt::format("array {} has {} rows for {} points", quotedExcerpt(array.name),
                                   values.count, points_));
        arrays_.push_back({array, values});
    }

    VtkLegacy file_;
    PackReadOptions options_;
    std::vector<PointArray> arrays_;  ///< positions first
    std::string cell_;
    std::vector<std::string> partNames_;
    PackOrigin origin_;
    std::uint64_t points_ = 0;
    std::optional<std::uint64_t> rows_;  ///< of the data that follow; none: about the whole file
    bool hasPoints_ = false, ofPoints_ = false;
};

Pack<3> readXml(const std::string& path, const char* type, const PackReadOptions& options) {
    std::unique_ptr<PackBuilder> builder;
    XmlPoints file(path, type, options);
    file.read(builder);
    if (!builder) throw InputError(path + ": holds no points");
    Pack<3> pack = builder->finish();
    pack.cell = file.cell();
    file.note(pack);
    return pack;
}

/// @param type  of the pieces that the file names.
Pack<3> readPieces(const std::string& path, const std::string& type,
                   const PackReadOptions& options) {
    const VtkXml index(path, "P" + type, options.memoryLimit);
    std::unique_ptr<PackBuilder> builder;
    std::optional<XmlPoints> last;
    for (const pugi::xml_node& piece : index.data().children("Piece")) {
        const std::filesystem::path source = VtkXml::attribute(piece, "Source");
        if (source.empty()) index.fail("a piece has no Source");
        last.emplace((std::filesystem::path(path).parent_path() / source).string(), type, options);
        last->read(builder);
    }
    if (!builder) index.fail("names no pieces with points");
    Pack<3> pack = builder->finish();
    last->note(pack);
    return pack;
}

}  // namespace

Pack<3> readVtp(const std::string& path, const PackReadOptions& options) {
    return readXml(path, "PolyData", options);
}

Pack<3> readVtu(const std::string& path, const PackReadOptions& options) {
    return readXml(path, "UnstructuredGrid", options);
}

Pack<3> readPvtp(const std::string& path, const PackReadOptions& options) {
    return readPieces(path, "PolyData", options);
}

Pack<3> readPvtu(const std::string& path, const PackReadOptions& options) {
    return readPieces(path, "UnstructuredGrid", options);
}

Pack<3> readVtk(const std::string& path, const PackReadOptions& options) {
    return LegacyPoints(path, options).read();
}

}  // namespace vdbpack
