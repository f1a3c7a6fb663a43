// Surfaces in the files of VTK and ParaView.
#include "mesh/formats/vtk_files.h"
#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/mesh/formats/mesh_io.h"

namespace {

std::string written(const TemporaryFolder& folder, const std::string& name,
                    const std::string& text) {
    putContent(folder.file(name), text);
    return folder.file(name);
}

}  // namespace

TEST_CASE("a .vtp of polygons is a mesh in every encoding") {
    const TemporaryFolder folder;
    const Prism prism;
    const auto format = GENERATE(as<std::string>{}, "ascii", "binary", "raw");
    const bool zlib = GENERATE(false, true);
    CAPTURE(format, zlib);
    requirePrism(
        readMesh(written(folder, "a.vtp", vtpText(prism.vertices, prism.faces, format, zlib))));
}

TEST_CASE("a legacy .vtk of polygons or of flat cells is a mesh in every encoding") {
    const TemporaryFolder folder;
    const Prism prism;
    const bool binary = GENERATE(false, true);
    const bool offsets = GENERATE(false, true);
    const auto cells = GENERATE(as<std::string>{}, "POLYGONS", "CELLS");
    CAPTURE(binary, offsets, cells);
    requirePrism(readMesh(
        written(folder, "a.vtk", vtkText(prism.vertices, prism.faces, binary, offsets, cells))));
}

TEST_CASE("strips of triangles face one way") {
    const TemporaryFolder folder;
    // A tetrahedron in one strip of six corners.
    const std::vector<Vec<3>> vertices{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    const Polygons strip{{1, 0, 2, 3, 1, 0}};
    for (const auto& [name, text] :
         {std::pair{"a.vtp", vtpText(vertices, strip, "ascii", false, true)},
          {"a.vtk", vtkText(vertices, strip, true, false, "TRIANGLE_STRIPS")}}) {
        CAPTURE(name);
        const MeshHealth health = checkMesh(readMesh(written(folder, name, text)));
        CHECK(health.isWatertight());
        CHECK(health.inconsistentEdges == 0);
        CHECK(health.signedVolume == Approx(1.0 / 6));
    }
}

TEST_CASE("VTK files without faces, or with cells that are no faces, are refused with a reason") {
    const TemporaryFolder folder;
    const std::vector<Vec<3>> vertices{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    const auto messageFor = [&](const std::string& name, const std::string& text) {
        const std::string file = written(folder, name, text);
        return messageOf<InputError>([&] { readMesh(file); });
    };
    CHECK_THAT(messageFor("points.vtp", vtpText(vertices, {}, "ascii")),
               Contains("points.vtp") && Contains("polygons"));
    CHECK_THAT(messageFor("points.vtk", vtkText(vertices, {}, false)),
               Contains("points.vtk") && Contains("polygons"));
    std::string volume = vtkText(vertices, {{0, 1, 2, 3}}, false, false, "CELLS");
    volume.replace(volume.find("\n9 ") + 1, 1, "10");
    CHECK_THAT(messageFor("volume.vtk", volume), Contains("10") && Contains("surface"));
    CHECK_THAT(messageFor("far.vtp", vtpText(vertices, {{0, 1, 4}}, "raw")),
               Contains("far.vtp") && Contains("4"));
    CHECK_THAT(messageFor("far.vtk", vtkText(vertices, {{0, 1, 4}}, true)),
               Contains("far.vtk") && Contains("4"));
    CHECK_THAT(messageFor("image.vtk",
                          "# vtk DataFile Version 3.0\n\nASCII\nDATASET "
                          "STRUCTURED_POINTS\n"),
               Contains("line 4") && Contains("STRUCTURED_POINTS"));
}
