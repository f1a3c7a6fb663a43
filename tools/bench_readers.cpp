// Compares mesh readers on one file: seconds, peak memory and digits kept.
//
//   bench_readers READER FILE
//
// READER is vdbpack, cgal, tinyobj, assimp or vtk, if it was found when configuring. One reader per
// process, since the peak of memory is that of the process. Meshes with unwelded vertices are
// welded by `vdbpack::welded`, which is part of the measured time.

#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/welding.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

#ifdef VDBPACK_BENCH_CGAL
#include <CGAL/IO/OBJ.h>
#include <CGAL/IO/OFF.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/IO/STL.h>
#include <CGAL/Simple_cartesian.h>
#endif
#ifdef VDBPACK_BENCH_TINYOBJ
#define TINYOBJLOADER_USE_DOUBLE
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>
#endif
#ifdef VDBPACK_BENCH_ASSIMP
#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#endif
#ifdef VDBPACK_BENCH_VTK
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkSmartPointer.h>
#endif

namespace {

using vdbpack::TriangleMesh;

bool endsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

#ifdef VDBPACK_BENCH_CGAL
TriangleMesh readWithCgal(const std::string& path) {
    std::vector<CGAL::Simple_cartesian<double>::Point_3> points;
    std::vector<std::vector<std::size_t>> polygons;
    bool ok = false;
    if (endsWith(path, ".stl")) ok = CGAL::IO::read_STL(path, points, polygons);
    if (endsWith(path, ".obj")) ok = CGAL::IO::read_OBJ(path, points, polygons);
    if (endsWith(path, ".ply")) ok = CGAL::IO::read_PLY(path, points, polygons);
    if (endsWith(path, ".off")) ok = CGAL::IO::read_OFF(path, points, polygons);
    if (!ok) throw std::runtime_error("refused without a reason");
    TriangleMesh mesh;
    for (const auto& p : points) mesh.vertices.push_back({{p.x(), p.y(), p.z()}});
    for (const auto& f : polygons)
        for (std::size_t k = 2; k < f.size(); ++k)
            mesh.triangles.push_back({static_cast<std::uint32_t>(f[0]),
                                      static_cast<std::uint32_t>(f[k - 1]),
                                      static_cast<std::uint32_t>(f[k])});
    return mesh;
}
#endif

#ifdef VDBPACK_BENCH_TINYOBJ
TriangleMesh readWithTinyobj(const std::string& path) {
    tinyobj::ObjReader reader;
    if (!reader.ParseFromFile(path)) throw std::runtime_error("refused: " + reader.Error());
    TriangleMesh mesh;
    const auto& v = reader.GetAttrib().vertices;
    for (std::size_t i = 0; i + 2 < v.size(); i += 3)
        mesh.vertices.push_back({{v[i], v[i + 1], v[i + 2]}});
    for (const auto& shape : reader.GetShapes()) {
        const auto& corners = shape.mesh.indices;
        for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
            mesh.triangles.push_back({static_cast<std::uint32_t>(corners[i].vertex_index),
                                      static_cast<std::uint32_t>(corners[i + 1].vertex_index),
                                      static_cast<std::uint32_t>(corners[i + 2].vertex_index)});
    }
    return mesh;
}
#endif

#ifdef VDBPACK_BENCH_ASSIMP
TriangleMesh readWithAssimp(const std::string& path) {
    Assimp::Importer importer;
    const aiScene* const scene = importer.ReadFile(path, aiProcess_Triangulate);
    if (scene == nullptr)
        throw std::runtime_error(std::string("refused: ") + importer.GetErrorString());
    TriangleMesh mesh;
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        const aiMesh& part = *scene->mMeshes[m];
        const auto shift = static_cast<std::uint32_t>(mesh.vertices.size());
        for (unsigned i = 0; i < part.mNumVertices; ++i) {
            const auto& v = part.mVertices[i];
            mesh.vertices.push_back(
                {{static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)}});
        }
        for (unsigned i = 0; i < part.mNumFaces; ++i) {
            const aiFace& f = part.mFaces[i];
            if (f.mNumIndices == 3)
                mesh.triangles.push_back(
                    {f.mIndices[0] + shift, f.mIndices[1] + shift, f.mIndices[2] + shift});
        }
    }
    return mesh;
}
#endif

#ifdef VDBPACK_BENCH_VTK
template <typename Source>
TriangleMesh readWithVtkSource(const std::string& path) {
    const auto reader = vtkSmartPointer<Source>::New();
    reader->SetFileName(path.c_str());
    reader->Update();
    vtkPolyData* const data = reader->GetOutput();
    TriangleMesh mesh;
    for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
        vdbpack::Vec<3> p;
        data->GetPoint(i, p.c.data());
        mesh.vertices.push_back(p);
    }
    vtkCellArray* const cells = data->GetPolys();
    vtkIdType n = 0;
    const vtkIdType* ids = nullptr;
    for (cells->InitTraversal(); cells->GetNextCell(n, ids) != 0;)
        for (vtkIdType k = 2; k < n; ++k)
            mesh.triangles.push_back({static_cast<std::uint32_t>(ids[0]),
                                      static_cast<std::uint32_t>(ids[k - 1]),
                                      static_cast<std::uint32_t>(ids[k])});
    return mesh;
}
TriangleMesh readWithVtk(const std::string& path) {
    if (endsWith(path, ".stl")) return readWithVtkSource<vtkSTLReader>(path);
    if (endsWith(path, ".obj")) return readWithVtkSource<vtkOBJReader>(path);
    if (endsWith(path, ".ply")) return readWithVtkSource<vtkPLYReader>(path);
    throw std::runtime_error("format not read");
}
#endif

/// Welds a mesh that a library read; some return the indices of a broken file unchecked.
TriangleMesh checkedAndWelded(TriangleMesh mesh) {
    for (const auto& t : mesh.triangles)
        for (const auto v : t)
            if (v >= mesh.vertices.size())
                throw std::runtime_error("accepted a vertex index out of range");
    return vdbpack::welded(std::move(mesh));
}

TriangleMesh readWith(const std::string& reader, const std::string& path) {
    if (reader == "vdbpack") return vdbpack::readMesh(path);
#ifdef VDBPACK_BENCH_CGAL
    if (reader == "cgal") return checkedAndWelded(readWithCgal(path));
#endif
#ifdef VDBPACK_BENCH_TINYOBJ
    if (reader == "tinyobj") return checkedAndWelded(readWithTinyobj(path));
#endif
#ifdef VDBPACK_BENCH_ASSIMP
    if (reader == "assimp") return checkedAndWelded(readWithAssimp(path));
#endif
#ifdef VDBPACK_BENCH_VTK
    if (reader == "vtk") return checkedAndWelded(readWithVtk(path));
#endif
    throw std::runtime_error("reader '" + reader + "' is not built in");
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        fmt::print(stderr, "usage: bench_readers vdbpack|cgal|tinyobj|assimp|vtk FILE\n");
        return 2;
    }
    try {
        const auto start = std::chrono::steady_clock::now();
        const TriangleMesh mesh = readWith(argv[1], argv[2]);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        fmt::print("{:8} {:6.2f} s {:6.0f} MB {:10} triangles {:10} vertices", argv[1],
                   seconds.count(), static_cast<double>(usage.ru_maxrss) / 1024,
                   mesh.triangles.size(), mesh.vertices.size());
        if (!mesh.vertices.empty()) fmt::print("  last x {:.17g}", mesh.vertices.back()[0]);
        fmt::print("\n");
    } catch (const std::exception& e) {
        fmt::print("{:8} {}\n", argv[1], e.what());
        return 1;
    }
    return 0;
}
