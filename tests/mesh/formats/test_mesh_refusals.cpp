#include "mesh/formats/mesh_files.h"
#include "support/test.h"

#include "vdbpack/mesh/formats/mesh_io.h"

namespace {

/// Writes files that must be refused. @return the message of the refusal, which names the file.
class RefusedFiles : public Folder {
public:
    std::string refusal(const std::string& name, const std::string& content) const {
        const auto path = write(name, content);
        CHECK_THROWS_AS(readMesh(path), InputError);
        const auto message = messageOf<Error>([&] { readMesh(path); });
        CHECK_THAT(message, Contains(path));
        return message;
    }
};

}  // namespace

TEST_CASE("an index of an OBJ beyond all vertices that can be read is out of range") {
    const Folder folder;
    const std::string file = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 4294967299\n");
    const std::string message = messageOf<InputError>([&] { readMesh(file); });
    CHECK_THAT(message, Contains(file) && Contains("line 4") && Contains("4294967299") &&
                            Contains("range") && !Contains("from 1"));
}

TEST_CASE("files of an unknown format or without triangles are refused") {
    const RefusedFiles folder;
    CHECK_THAT(folder.refusal("skull.3mf", "x"), Contains("'.3mf'") && Contains(".stl"));
    CHECK_THAT(folder.refusal("noextension", "x"), Contains(".stl"));
    CHECK_THAT(folder.refusal("C0001.ISQ;1", "CTDATA-HEADER_V1"),
               Contains("SCANCO") && Contains(".nrrd"));
    CHECK_THAT(folder.refusal("n.mgz", "x"), Contains("image") && Contains(".nii.gz"));
    CHECK_THAT(folder.refusal("n.vtk",
                              "# vtk DataFile Version 3.0\nn\nASCII\nDATASET STRUCTURED_POINTS\n"),
               Contains("image") && Contains(".nrrd"));
    CHECK_THAT(folder.refusal("n.stl", "solid x\nendsolid x\n"), Contains("n.stl"));
    CHECK_THAT(folder.refusal("n.stl", binaryStl({})), Contains("n.stl"));
    CHECK_THAT(folder.refusal("n.obj", "v 0 0 0\n"), Contains("n.obj"));
    CHECK_THAT(folder.refusal("n.off", "OFF\n1 0 0\n0 0 0\n"), Contains("n.off"));
    CHECK_THAT(folder.refusal("n.ply",
                              "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                              "property float y\nproperty float z\nend_header\n0 0 0\n"),
               Contains("faces"));
}

TEST_CASE("a .gts whose edges do not fit its faces is refused with the line") {
    const RefusedFiles folder;
    const std::string vertices = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
    CHECK_THAT(folder.refusal("a.gts", "4 3 1\n" + vertices + "1 2\n2 3\n3 4\n1 2 3\n"),
               Contains("line 9") && Contains("meet"));
    CHECK_THAT(folder.refusal("a.gts", "4 3 1\n" + vertices + "1 2\n2 3\n3 5\n1 2 3\n"),
               Contains("line 8") && Contains("vertex 5"));
    CHECK_THAT(folder.refusal("a.gts", "4 3 1\n" + vertices + "1 2\n2 3\n3 1\n1 2 4\n"),
               Contains("line 9") && Contains("edge 4"));
    CHECK_THAT(folder.refusal("a.gts", "4 3 1 GtsSurface GtsFace GtsEdge GtsVertexBinary\n"),
               Contains("binary"));
    CHECK_THAT(folder.refusal("a.gts", "4 3 1\n" + vertices), Contains("truncated"));
}

TEST_CASE("images are refused as meshes, with what takes them") {
    const RefusedFiles folder;
    for (const auto* name : {"a.nii", "a.nii.gz", "a.seg.nrrd", "a.MHA", "a.mhd", "a.dcm"})
        CHECK_THAT(folder.refusal(name, "x"),
                   Contains("image") && Contains("threshold") && Contains(".stl"));
    std::filesystem::create_directory(folder.file("dicom"));
    CHECK_THAT(messageOf<InputError>([&] { readMesh(folder.file("dicom")); }),
               Contains("dicom") && Contains("folder") && Contains(".stl"));
}

TEST_CASE("coordinates that are not finite or too large are refused with line or byte") {
    const RefusedFiles folder;
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nv 0 nan 0\n"), Contains("line 2"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 1e999 0\n"), Contains("line 1"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 2e9\n"), Contains("line 1") && Contains("unit"));
    CHECK_THAT(folder.refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n"),
               Contains("line 4"));
    auto mesh = tetrahedron();
    mesh.vertices[2][1] = std::numeric_limits<double>::quiet_NaN();
    CHECK_THAT(folder.refusal("a.stl", binaryStl(mesh)),
               Contains("byte 108") && Contains("triangle 0"));
    CHECK_THAT(folder.refusal("a.ply", ply(mesh, "binary_big_endian")), Contains("vertex 2"));
    MeshReadOptions meters;
    meters.unit = Unit::meter;
    const auto path = folder.write("m.obj", "v 0 0 0\nv 2e6 0 0\nv 0 1 0\nf 1 2 3\n");
    CHECK(readMesh(path).vertices.size() == 3);
    CHECK_THROWS_AS(readMesh(path, meters), InputError);
}

TEST_CASE("indices of vertices out of range are refused with line or face") {
    const RefusedFiles folder;
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n"),
               Contains("line 5") && Contains("vertex 4"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nf 1 0 1\n"), Contains("line 2"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nf 1 -2 1\n"), Contains("line 2"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nf 1 99999999999999 1\n"), Contains("line 2"));
    CHECK_THAT(folder.refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
               Contains("line 6") && Contains("vertex 3"));
    auto mesh = tetrahedron();
    mesh.triangles[3][1] = 4;
    CHECK_THAT(folder.refusal("a.ply", ply(mesh, "binary_little_endian")),
               Contains("face 3") && Contains("vertex 4"));
    CHECK_THAT(folder.refusal("b.ply", ply(mesh, "ascii")), Contains("face 3") && Contains("line"));
}

TEST_CASE("wrong counts are refused") {
    const RefusedFiles folder;
    auto stl = binaryStl(tetrahedron());
    stl.replace(80, 4, rawBytes(std::uint32_t{0xffffffff}));
    CHECK_THAT(folder.refusal("a.stl", stl), Contains("4294967295"));
    stl.replace(80, 4, rawBytes(std::uint32_t{3}));
    CHECK_THAT(folder.refusal("b.stl", stl), Contains("3 triangles"));
    CHECK_THAT(folder.refusal("c.stl", "hello"), Contains("c.stl"));
    CHECK_THAT(folder.refusal("a.off", "OFF\n4000000000000000000 1 0\n0 0 0\n"),
               Contains("4000000000000000000"));
    CHECK_THAT(folder.refusal("b.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n"),
               Contains("line 7"));
    CHECK_THAT(folder.refusal("c.off", "OFF\n-3 1 0\n"), Contains("-3"));
    const std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex ";
    const std::string xyz = "\nproperty float x\nproperty float y\nproperty float z\n";
    CHECK_THAT(
        folder.refusal("a.ply", head + "4000000000" + xyz +
                                    "element face 1\nproperty list uchar int vertex_indices\n"
                                    "end_header\n"),
        Contains("too many"));
    CHECK_THAT(
        folder.refusal("b.ply", head + "1" + xyz +
                                    "element face 1\nproperty list int int vertex_indices\n"
                                    "end_header\n" +
                                    std::string(12, '\0') + rawBytes(std::int32_t{2000000000})),
        Contains("2000000000"));
    CHECK_THAT(folder.refusal("c.ply", ply(tetrahedron(), "binary_little_endian") + "more"),
               Contains("c.ply"));
}

TEST_CASE("text that is not of the format is refused with its line") {
    const RefusedFiles folder;
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 zero\n"), Contains("line 1") && Contains("'zero'"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0\n"), Contains("line 1"));
    CHECK_THAT(folder.refusal("a.obj", "v 0 0 0\nf 1 1\n"), Contains("2 corners"));
    CHECK_THAT(folder.refusal("a.obj", "v 0,5 0 0\n"), Contains("'0,5'"));
    CHECK_THAT(folder.refusal("a.obj", std::string("\x01\x02\x03", 3)), Contains("line 1"));
    CHECK_THAT(folder.refusal("a.off", "OFF BINARY\n"), Contains("binary"));
    CHECK_THAT(folder.refusal("a.off", "4OFF\n3 1 0\n"), Contains("'4OFF'"));
    CHECK_THAT(folder.refusal("a.ply", "plyx\n"), Contains("'ply'"));
    CHECK_THAT(
        folder.refusal("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n"),
        Contains("line 4") && Contains("'half'"));
}

TEST_CASE("a PLY header of any length is read in proportion") {
    const Folder folder;
    std::string text = "ply\nformat ascii 1.0\n";
    for (int i = 0; i < 200'000; ++i) text += fmt::format("element e{} 0\n", i);
    CHECK_THROWS_AS(readMesh(folder.write("a.ply", text + "element e7 0\nend_header\n")),
                    InputError);
}
