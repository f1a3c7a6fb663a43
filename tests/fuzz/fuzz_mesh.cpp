// Meshes: .ply, .obj, .off, .gts, .vtp, .vtk and .stl, told apart as they begin.
#include "fuzz_file.h"

#include "vdbpack/mesh/formats/mesh_io.h"

using namespace vdbpack;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static fuzz::InputAsFile ply("m.ply"), obj("m.obj"), off("m.off"), vtp("m.vtp"), vtk("m.vtk"),
        gts("m.gts"), stl("m.stl");
    fuzz::InputAsFile* file = &stl;
    if (size > 0) {
        const char first = static_cast<char>(data[0]);
        if (first == 'p') file = &ply;
        if (first == 'v' || first == '#' || first == 'f' || first == 'o') file = &obj;
        if (first == 'O' || first == 'C' || first == 'N' || (first >= '0' && first <= '9'))
            file = &off;
        if (first == '<') file = &vtp;
        if (first == '!') file = &gts;
        if (size > 2 && first == '#' && data[2] == 'v') file = &vtk;
    }
    const std::string& path = file->write(data, size);
    fuzz::readOrRefuse(path, [&] {
        const TriangleMesh mesh = readMesh(path);
        if (mesh.triangles.empty()) fuzz::report("a mesh without triangles");
        for (const auto& v : mesh.vertices)
            if (!isFinite(v)) fuzz::report("a vertex is not finite");
        for (const auto& t : mesh.triangles)
            for (const auto v : t)
                if (v >= mesh.vertices.size()) fuzz::report("a vertex that does not exist");
    });
    return 0;
}
