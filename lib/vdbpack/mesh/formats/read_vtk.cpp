// Legacy VTK files (.vtk), text or binary: polygon data, and unstructured grids of faces.
#include "vdbpack/mesh/formats/mesh_values.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// The types of numbers by their names.
std::optional<NumberType> typeNamed(std::string_view name) {
    static constexpr std::array<std::pair<std::string_view, NumberType>, 13> kTypes{
        {{"char", NumberType::i8},
         {"unsigned_char", NumberType::u8},
         {"short", NumberType::i16},
         {"unsigned_short", NumberType::u16},
         {"int", NumberType::i32},
         {"unsigned_int", NumberType::u32},
         {"long", NumberType::i64},
         {"unsigned_long", NumberType::u64},
         {"vtktypeint32", NumberType::i32},
         {"vtktypeint64", NumberType::i64},
         {"vtkidtype", NumberType::i32},
         {"float", NumberType::f32},
         {"double", NumberType::f64}}};
    for (const auto& [known, type] : kTypes)
        if (equalsNoCase(name, known)) return type;
    return std::nullopt;
}

/// Types of cells of an unstructured grid.
enum Cell : std::int64_t {
    vertex = 1,
    polyline = 4,
    triangle = 5,
    strip = 6,
    polygon = 7,
    pixel = 8,
    quad = 9
};

class VtkMesh {
public:
    explicit VtkMesh(MeshReader& reader) : reader_(reader), file_(reader.file) {}

    void read() {
        readHeader();
        std::string keyword;
        while (nextStatement(keyword)) {
            if (keyword == "points") {
                readPoints();
            } else if (keyword == "polygons") {
                addFaces(readCells(), Cell::polygon);
            } else if (keyword == "triangle_strips") {
                addFaces(readCells(), Cell::strip);
            } else if (keyword == "vertices" || keyword == "lines") {
                readCells();
            } else if (keyword == "cells") {
                cells_ = readCells();
            } else if (keyword == "cell_types") {
                addCells();
            } else if (keyword == "field") {
                skipField();
            } else if (keyword == "metadata") {
                skipMetadata();
            } else if (keyword == "point_data" || keyword == "cell_data") {
                break;  // of no use here, and the last there is
            } else {
                file_.failAtLine("a statement such as POINTS or POLYGONS expected, found " +
                                 quotedExcerpt(keyword));
            }
        }
        if (reader_.mesh.triangles.empty())
            file_.fail("holds no polygons; a closed surface is needed");
    }

private:
    /// Lists of vertices.
    struct Cells {
        std::vector<std::uint32_t> corners;
        std::vector<std::uint64_t> ends;
    };

    std::string_view takeLine(const char* what) {
        std::string_view line;
        if (!file_.nextLine(line))
            file_.fail(fmt::format("ends where {} is expected; it is truncated", what));
        return line;
    }

    void readHeader() {
        if (!startsWith(lowered(takeLine("its first line")), "# vtk datafile"))
            file_.failAtLine("'# vtk DataFile Version ...' expected; this is no legacy VTK file");
        takeLine("a title");
        const std::string encoding = lowered(trimmed(takeLine("ASCII or BINARY")));
        if (encoding != "ascii" && encoding != "binary")
            file_.failAtLine("ASCII or BINARY expected, found " + quotedExcerpt(encoding));
        const bool isText = encoding == "ascii";
        values_.emplace(reader_, isText, /*isBigEndian=*/true);
        std::string keyword;
        const std::string set = nextStatement(keyword) ? lowered(nextWord()) : "";
        if (keyword != "dataset" || (set != "polydata" && set != "unstructured_grid"))
            file_.failAtLine(fmt::format(
                "DATASET POLYDATA expected, found {} {}; extract the surface and save it as .stl",
                quotedExcerpt(keyword), quotedExcerpt(set)));
    }

    /// Takes the next line that is not blank. @return false at the end.
    bool nextStatement(std::string& keyword) {
        values_->dropLine();
        std::string_view line;
        while (file_.nextLine(line)) {
            statement_ = line;
            words_ = Words(statement_);
            keyword = lowered(words_.next());
            if (!keyword.empty()) return true;
        }
        return false;
    }
    std::string_view nextWord() { return words_.next(); }
    std::uint64_t nextCount(const char* what, std::uint64_t least) {
        const std::int64_t count = reader_.integer(nextWord(), what);
        if (count < 0) file_.failAtLine(fmt::format("{} {}, below 0", what, count));
        reader_.checkCount(static_cast<std::uint64_t>(count), least, what);
        return static_cast<std::uint64_t>(count);
    }
    NumberType nextType() {
        const std::string_view name = nextWord();
        const auto type = typeNamed(name);
        if (!type)
            file_.failAtLine("a type such as float or int expected, found " + quotedExcerpt(name));
        return *type;
    }
    /// Bytes of a number at least.
    std::uint64_t bytesEach(NumberType type) const { return values_->isText() ? 2 : bytesOf(type); }

    void readPoints() {
        const std::uint64_t count = nextCount("a number of points", 6);
        const NumberType type = nextType();
        reader_.checkCount(count, 3 * bytesEach(type), "points");
        reader_.checkVertexTotal(count);
        if (!reader_.mesh.vertices.empty()) file_.failAtLine("POINTS come twice");
        reader_.mesh.vertices.reserve(count);
        for (std::uint64_t i = 0; i < count; ++i) {
            Vec<3> p;
            for (int d = 0; d < 3; ++d) p[d] = values_->real(type) + 0.0;
            if (!reader_.isUsable(p))
                values_->fail(fmt::format("point {} {}", i, reader_.complaint(p)));
            reader_.mesh.vertices.push_back(p);
        }
    }

    /// The lists that a statement announces: `number size`, each list after its length, or, since
    /// version 5, the counts of OFFSETS and of CONNECTIVITY, which follow.
    Cells readCells() {
        const std::uint64_t first = nextCount("a number of cells", 1);
        const std::uint64_t second = nextCount("a number of entries", 2);
        std::string keyword;
        if (startsWith(lowered(file_.peek(8)), "offsets ") && nextStatement(keyword))
            return readOffsetCells(first, second);
        Cells cells;
        cells.ends.reserve(first);
        cells.corners.reserve(second);
        for (std::uint64_t i = 0; i < first; ++i) {
            const std::int64_t length = values_->integer(NumberType::i32);
            if (length < 0 ||
                static_cast<std::uint64_t>(length) + cells.corners.size() + i + 1 > second)
                values_->fail(
                    fmt::format("cell {} has {} corners, more than are announced", i, length));
            for (std::int64_t k = 0; k < length; ++k) addCorner(cells, NumberType::i32, i);
            cells.ends.push_back(cells.corners.size());
        }
        return cells;
    }

    Cells readOffsetCells(std::uint64_t offsets, std::uint64_t entries) {
        Cells cells;
        const NumberType type = nextType();
        reader_.checkCount(offsets, bytesEach(type), "offsets");
        cells.ends.reserve(offsets);
        std::uint64_t last = 0;
        for (std::uint64_t i = 0; i < offsets; ++i) {
            const std::int64_t end = values_->integer(type);
            if (end < static_cast<std::int64_t>(last) ||
                static_cast<std::uint64_t>(end) > entries || (i == 0 && end != 0))
                values_->fail(fmt::format("offset {} is {}, after {} and of {} entries", i, end,
                                          last, entries));
            last = static_cast<std::uint64_t>(end);
            if (i > 0) cells.ends.push_back(last);
        }
        std::string keyword;
        if (!nextStatement(keyword) || keyword != "connectivity")
            file_.failAtLine("CONNECTIVITY expected, found " + quotedExcerpt(keyword));
        const NumberType cornerType = nextType();
        reader_.checkCount(entries, bytesEach(cornerType), "corners");
        cells.corners.reserve(entries);
        std::uint64_t cell = 0;
        for (std::uint64_t k = 0; k < entries; ++k) {
            while (cell < cells.ends.size() && k >= cells.ends[cell]) ++cell;
            addCorner(cells, cornerType, cell);
        }
        return cells;
    }

    void addCorner(Cells& cells, NumberType type, std::uint64_t cell) {
        const std::int64_t index = values_->integer(type);
        const std::size_t points = reader_.mesh.vertices.size();
        if (index < 0 || static_cast<std::uint64_t>(index) >= points)
            values_->fail(fmt::format("cell {} names point {}, but the file has {}, counted from 0",
                                      cell, index, points));
        cells.corners.push_back(static_cast<std::uint32_t>(index));
    }

    void addFaces(const Cells& cells, Cell type) {
        for (std::size_t i = 0; i < cells.ends.size(); ++i) addFace(cells, i, type);
    }

    void addCells() {
        const std::uint64_t count = nextCount("a number of cells", 2);
        if (count != cells_.ends.size())
            file_.failAtLine(fmt::format("{} types for {} cells", count, cells_.ends.size()));
        for (std::size_t i = 0; i < count; ++i) {
            const std::int64_t type = values_->integer(NumberType::i32);
            if (type >= Cell::vertex && type <= Cell::polyline) continue;
            if (type < Cell::triangle || type > Cell::quad)
                values_->fail(fmt::format(
                    "cell {} is of type {}, which is no face; extract the surface and save it as "
                    ".stl",
                    i, type));
            addFace(cells_, i, static_cast<Cell>(type));
        }
    }

    void addFace(const Cells& cells, std::size_t i, Cell type) {
        const std::uint64_t begin = i == 0 ? 0 : cells.ends[i - 1], end = cells.ends[i];
        if (end - begin < 3)
            file_.fail(fmt::format("cell {} has {} corners; 3 or more are needed", i, end - begin));
        std::vector<std::uint32_t> corners(
            cells.corners.begin() + static_cast<std::ptrdiff_t>(begin),
            cells.corners.begin() + static_cast<std::ptrdiff_t>(end));
        // Of a pixel, rows of two.
        if (type == Cell::pixel && corners.size() == 4) std::swap(corners[2], corners[3]);
        PolygonFan fan;
        TriangleStrip triangles;
        for (const std::uint32_t corner : corners)
            if (type == Cell::strip)
                triangles.add(reader_, corner);
            else
                fan.add(reader_, corner);
        fan.end(reader_);
    }

    /// Arrays about the whole file.
    void skipField() {
        nextWord();
        const std::uint64_t arrays = nextCount("a number of arrays", 1);
        for (std::uint64_t i = 0; i < arrays; ++i) {
            std::string name;
            if (!nextStatement(name)) takeLine("an array");
            if (name == "metadata") {
                skipMetadata();
                if (!nextStatement(name)) takeLine("an array");
            }
            const std::uint64_t components = nextCount("a number of components", 1),
                                tuples = nextCount("a number of tuples", 1);
            values_->skip(nextType(), components * tuples);
        }
    }
    /// Up to a blank line.
    void skipMetadata() {
        std::string_view line;
        while (file_.nextLine(line) && !trimmed(line).empty()) {
        }
    }

    MeshReader& reader_;
    InputFile& file_;
    std::optional<MeshValues> values_;
    std::string statement_;  ///< the last line that was not numbers
    Words words_{{}};        ///< of it
    Cells cells_;            ///< of an unstructured grid, until their types are known
};

}  // namespace

void readVtkMesh(MeshReader& reader) {
    VtkMesh(reader).read();
}

}  // namespace vdbpack
