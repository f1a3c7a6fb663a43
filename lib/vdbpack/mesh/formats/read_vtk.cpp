// Legacy VTK files (.vtk), text or binary: polygon data, and unstructured grids of faces.
#include "vdbpack/io/vtk_legacy.h"
#include "vdbpack/mesh/formats/mesh_reader.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

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
    explicit VtkMesh(MeshReader& reader) : reader_(reader), file_(reader.file.path(), 0) {
        if (file_.dataSet() == "structured_points")
            file_.fail(
                "is an image (STRUCTURED_POINTS); save it as .nrrd or .mha, and set `threshold` or "
                "`label`");
        if (file_.dataSet() != "polydata" && file_.dataSet() != "unstructured_grid")
            file_.fail("DATASET POLYDATA expected, found " + quotedExcerpt(file_.dataSet()) +
                       "; extract the surface and save it as .stl");
    }

    void read() {
        std::string keyword;
        // Data of points and cells come last, and are of no use here.
        while (file_.nextStatement(keyword) && keyword != "point_data" && keyword != "cell_data") {
            if (keyword == "points") {
                readPoints();
            } else if (keyword == "polygons" || keyword == "triangle_strips") {
                const VtkCells faces = file_.cells();
                for (std::size_t i = 0; i < faces.ends.size(); ++i)
                    addFace(faces, i, keyword == "polygons" ? Cell::polygon : Cell::strip);
            } else if (keyword == "vertices" || keyword == "lines") {
                file_.cells();
            } else if (keyword == "cells") {
                cells_ = file_.cells();
            } else if (keyword == "cell_types") {
                addCells();
            } else if (keyword == "field") {
                file_.forFieldArrays([](const VtkArray&, const VtkTuples&) {});
            } else if (keyword == "metadata") {
                file_.skipMetadata();
            } else {
                file_.fail("a statement such as POINTS or POLYGONS expected, found " +
                           quotedExcerpt(keyword));
            }
        }
        if (reader_.mesh.triangles.empty())
            throw InputError(file_.path() + ": holds no polygons; a closed surface is needed");
    }

private:
    void readPoints() {
        const std::uint64_t count = file_.count("a number of points");
        reader_.checkVertexTotal(count);
        if (!reader_.mesh.vertices.empty()) file_.fail("POINTS come twice");
        const VtkNumbers numbers = file_.numbers(file_.typed("Points", 3), 3 * count);
        reader_.mesh.vertices.reserve(count);
        for (std::uint64_t i = 0; i < count; ++i) {
            Vec<3> p;
            for (int d = 0; d < 3; ++d)
                numbers.at(3 * i + static_cast<std::uint64_t>(d), [&](auto value) {
                    p[d] = static_cast<double>(value) + 0.0;
                    return true;
                });
            if (!reader_.isUsable(p))
                file_.fail(fmt::format("point {} {}", i, reader_.complaint(p)));
            reader_.mesh.vertices.push_back(p);
        }
    }

    void addCells() {
        const std::uint64_t count = file_.count("a number of cells");
        if (count != cells_.ends.size())
            file_.fail(fmt::format("{} types for {} cells", count, cells_.ends.size()));
        const auto types = file_.integers(NumberType::i32, count);
        for (std::size_t i = 0; i < count; ++i) {
            if (types[i] >= Cell::vertex && types[i] <= Cell::polyline) continue;
            if (types[i] < Cell::triangle || types[i] > Cell::quad)
                file_.fail(
                    fmt::format("cell {} is of type {}, which is no face; extract the surface "
                                "and save it as .stl",
                                i, types[i]));
            addFace(cells_, i, static_cast<Cell>(types[i]));
        }
    }

    void addFace(const VtkCells& cells, std::size_t i, Cell type) {
        const std::size_t begin = i == 0 ? 0 : cells.ends[i - 1], end = cells.ends[i];
        if (end - begin < 3)
            file_.fail(fmt::format("cell {} has {} corners; 3 or more are needed", i, end - begin));
        std::vector<std::uint32_t> corners;
        for (std::size_t k = begin; k < end; ++k) {
            const std::int64_t index = cells.corners[k];
            const std::size_t points = reader_.mesh.vertices.size();
            if (index < 0 || static_cast<std::uint64_t>(index) >= points)
                file_.fail(
                    fmt::format("cell {} names point {}, but the file has {}, counted from 0", i,
                                index, points));
            corners.push_back(static_cast<std::uint32_t>(index));
        }
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

    MeshReader& reader_;
    VtkLegacy file_;
    VtkCells cells_;  ///< of an unstructured grid, until their types are known
};

}  // namespace

void readVtkMesh(MeshReader& reader) {
    VtkMesh(reader).read();
}

}  // namespace vdbpack
