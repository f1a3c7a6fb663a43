// Files of programs whose formats are only read, against numbers written by hand.
#include "formats/file_text.h"
#include "support/test.h"

namespace {

/// Centers (1, 2, 3) and (4, 5, 6.5), radii 0.5 and 1.25.
const std::vector<Sphere<3>> kTwo{{{{1, 2, 3}}, 0.5}, {{{4, 5, 6.5}}, 1.25}};

/// In mm, of lengths in micrometers.
std::vector<Sphere<3>> fromMicrometers(std::vector<Sphere<3>> spheres) {
    for (auto& s : spheres) {
        for (double& c : s.center.c) c /= 1000;
        s.radius /= 1000;
    }
    return spheres;
}

/// The lines above the first variable in a file of MFiX.
std::string mfixHeader(const char* dimension, const char* particles) {
    std::string text = "Version 2.0\n";
    for (int i = 0; i < 17; ++i) text += i % 2 ? "Dimension: text\n\n" : "=====\n";
    return text + "Dimension: " + dimension + "\nParticles: " + particles +
           "\n=====\nVariable\n=====\n";
}

const std::string kMfixEnd =
    "Temperature: T (ignored)\nSpecies: F 1 0\nUser_Scalar: T\n===\n| x | y |\n===\n";

const std::string kMercury =
    "MercuryDPM 0.14 name x\nWalls 0\nBoundaries 1\n"
    "PeriodicBoundary id 0 normal 0 -1 0 scaleFactor 1 distanceLeft -9 distanceRight 1 shift 0 1 "
    "0\n"
    "Particles 2\n"
    "SphericalParticle id 5 indSpecies 1 position 1 2 3 orientation 1 0 0 0 velocity 0 0 -1 "
    "angularVelocity 0 0 0 force 0 0 0 torque 0 0 0 radius 0.5 invMass 1\n"
    "SphericalParticle id 7 groupID 3 indSpecies 0 position 4 5 6.5 orientation 1 0 0 0 velocity 0 "
    "0 -2 angularVelocity 0 0 0 force 0 0 0 torque 0 0 0 radius 1.25 invMass 0\nInteractions 0\n";

const std::string kGeo =
    "LSMGeometry 1.2\nBoundingBox 0 -10 -10 8 10 10\nPeriodicBoundaries 1 0 0\nDimension 3D\n"
    "BeginParticles\nSimple\n2\n1 2 3 0.5 4 1\n4 5 6.5 1.25 3 2\nEndParticles\nBeginConnect\n0\n"
    "EndConnect\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
}

}  // namespace

TEST_CASE("particle_input.dat of MFiX has columns and values for all") {
    const std::string columns =
        mfixHeader("3", "2") +
        "Coordinates: T\nPhase_ID: T\nDiameter: T\nDensity: T\nVelocity: F 0 0 0\n" + kMfixEnd;
    const auto pack = readText("p.dat", columns + "1 2 3 1 1.0 2000 300\n4 5 6.5 2 2.5 1900 310\n");
    CHECK(pack.spheres == kTwo);
    REQUIRE(pack.columns.size() == 3);
    CHECK(pack.columns[0].name == "Phase_ID");
    CHECK(pack.columns[1].numbers == std::vector<double>{2000, 1900});
    CHECK(pack.columns[2].numbers == std::vector<double>{300, 310});
    // In the plane, with one diameter for all.
    const auto circles = readText(
        "p.dat",
        mfixHeader("2", "1") +
            "Coordinates: T\nPhase_ID: F 3\nDiameter: F 1.0\nDensity: F 1000\nVelocity: T\n" +
            kMfixEnd + "0.1E1 2 -.5 0.25\n");
    CHECK(circles.spheres == std::vector<Sphere<3>>{{{{1, 2, 0}}, 0.5}});
    CHECK(circles.columns[0].numbers == std::vector<double>{-0.5});  // u
    CHECK_THAT(errorOf("p.dat", "Version 4.0\n"), Contains("Version 2.0"));
    CHECK_THAT(errorOf("p.dat", columns + "1 2 3 1 1.0 2000\n"), Contains("1 of 2"));
    CHECK_THAT(errorOf("p.dat", replaced(columns, "Phase_ID: T", "Phase_ID: X")),
               Contains("phase_id"));
    CHECK_THAT(errorOf("p.dat", replaced(columns, "Diameter", "Density")), Contains("diameter"));
}

TEST_CASE("a restart file of MercuryDPM has spheres, species and periods") {
    const auto pack = readText("p.restart", kMercury);
    CHECK(pack.spheres == kTwo);
    CHECK(pack.id == std::vector<std::int64_t>{5, 7});
    CHECK(pack.columns.at(0).name == "indSpecies");
    CHECK(pack.columns[0].numbers == std::vector<double>{1, 0});
    CHECK(pack.columns.at(3).numbers == std::vector<double>{-1, -2});
    CHECK(pack.cell.wraps == std::array<bool, 3>{false, true, false});
    CHECK(pack.cell.box.lo[1] == -1);
    CHECK(pack.cell.box.hi[1] == 9);
    std::vector<std::string> warnings;
    CHECK_FALSE(readText("p.restart", replaced(kMercury, "PeriodicB", "AngledPeriodicB"), warnings)
                    .cell.any());
    CHECK_THAT(warnings.at(0), Contains("tilted"));
    CHECK_THAT(errorOf("p.restart", replaced(kMercury, "SphericalP", "SuperQuadricP")),
               Contains("line 6") && Contains("SuperQuadric"));
    CHECK_THAT(errorOf("p.restart", replaced(kMercury, "Particles 2", "Particles 3")),
               Contains("line 8"));
    CHECK_THAT(errorOf("p.restart", "\x03LammpS RestartT"), Contains("write_data"));
}

TEST_CASE("a .geo of GenGeo has spheres, tags and periods") {
    const auto pack = readText("p.geo", kGeo);
    CHECK(pack.spheres == kTwo);
    CHECK(pack.id == std::vector<std::int64_t>{4, 3});
    CHECK(pack.columns.at(0).numbers == std::vector<double>{1, 2});
    CHECK(pack.cell.wraps == std::array<bool, 3>{true, false, false});
    CHECK(pack.cell.length(0) == 8);
    CHECK_THAT(errorOf("p.geo", "Point(1) = {0, 0, 0};\n"), Contains("gmsh"));
    CHECK_THAT(errorOf("p.geo", replaced(kGeo, "Simple", "Rotated")), Contains("line 6"));
    CHECK_THAT(errorOf("p.geo", kGeo.substr(0, 30)), Contains("BeginParticles"));
}

TEST_CASE("files of YADE's SpherePack come and go with their clumps and period") {
    const auto saved = readText("p.txt", "1 2 3 0.5 -1\n4 5 6.5 1.25 -1\n");
    CHECK(saved.spheres == kTwo);
    CHECK(saved.columns.empty());
    const auto clumps = readText("p.txt", "##PERIODIC:: 10 20 30\n1 2 3 0.5 7\n4 5 6.5 1.25 -1\n");
    CHECK(clumps.columns.at(0).name == "clumpId");
    // SpherePack.load takes four or five columns and no other line with #.
    CHECK(writtenText(clumps, "spherepack:p.txt") ==
          "##PERIODIC:: 10.0 20.0 30.0\n1.0 2.0 3.0 0.5 7\n4.0 5.0 6.5 1.25 -1\n");
    const auto back = readBack(clumps, "spherepack:p.txt");
    CHECK(back.spheres == kTwo);
    CHECK(back.columns.at(0).numbers == std::vector<double>{7, -1});
    CHECK(back.cell.length(2) == 30);
}

TEST_CASE("one radius for files that have none, and names for those that have others") {
    struct Case {
        std::string name, text;
        PackColumns columns;
        double radius;
    };
    const std::string dump =
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 9\n0 9\n0 9\n"
        "ITEM: ATOMS id x y z c_size\n0 1 2 3 0.5\n";
    const PackColumns inOrder{{"x", "y", "z", "r"}, {}};
    const Case cases[] = {
        {"p.xyz", "1\nplain\nC 1 2 3\n", {}, 0.5},
        {"p.xyz", "1\nplain\n1 2 3 0.5\n", inOrder, 0},
        {"p.dump", dump, {}, 0.5},
        {"p.dump", dump, {{}, {{"radius", "c_size"}}}, 0},
        {"p.txt", dump, {{}, {{"diameter_um", "C_SIZE"}}}, 0},
        {"csv:p.txt", "1 2 3 0.5\n", inOrder, 0},
        {"p.input", "East North Up size\n1 2 3 0.5\n", inOrder, 0},
        {"p.dat", "# made by hand\n 1\t2\t3\n", {{"x", "y", "z"}, {}}, 0.5},
        {"p.csv",
         "a [m],b/um,c,d\n0.001,2000,3,1\n",
         {{}, {{"x", "a [m]"}, {"y", "b/um"}, {"z", "c"}, {"diameter", "d"}}},
         0},
        {"p.vtk",
         "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n1 2 3\n",
         {},
         0.5},
    };
    for (const Case& c : cases) {
        CAPTURE(c.name, c.text);
        const TemporaryFolder scratch;
        putContent(scratch.file(c.name.substr(c.name.find(':') + 1)), c.text);
        PackReadOptions options;
        options.columns = c.columns;
        options.radius = c.radius;
        const auto pack = readPack(inFolder(scratch, c.name), options);
        const double radius =
            c.columns.renamed.empty() || c.columns.renamed[0].first != "diameter_um" ? 0.5
                                                                                     : 0.00025;
        CHECK(pack.spheres == std::vector<Sphere<3>>{{{{1, 2, 3}}, radius}});
    }
    std::vector<std::string> warnings;
    PackReadOptions options;
    options.radius = 2;
    options.callbacks = keepingWarnings({}, warnings);
    const TemporaryFolder scratch;
    putContent(scratch.file("p.csv"), "x,y,z,r\n1,2,3,0.5\n");
    CHECK(readPack(scratch.file("p.csv"), options).spheres[0].radius == 0.5);
    CHECK_THAT(warnings.at(0), Contains("packRadius"));
    options.columns = {{"x", "y", "z"}, {}};
    CHECK_THAT(messageOf<InputError>([&] { readPack(scratch.file("p.csv"), options); }),
               Contains("4 cells") && Contains("names 3"));
    options.columns = {{}, {{"x", "East"}}};
    CHECK_THAT(messageOf<InputError>([&] { readPack(scratch.file("p.csv"), options); }),
               Contains("'East'") && Contains("x, y, z, r"));
}

TEST_CASE("a dump or a YADE file under the name .txt is known by its first line") {
    CHECK(readText("csv.txt", "#format x_y_z_r\n1 2 3 0.5\n4 5 6.5 1.25\n").spheres == kTwo);
    CHECK_THAT(errorOf("n.txt", "1 2 3 4\n"), Contains("columns") && Contains("yade:"));
}

TEST_CASE("names and units of columns of other programs") {
    for (const char* header :
         {"X,Y,Z,RADIUS", "PosX,PosY,PosZ,Rad", "p_x,p_y,p_z,r",
          "position_x,position_y,position_z,radii",
          "x_position,y_position,z_position,Particle Radius", "Center.X,Center.Y,Center.Z,radius",
          "Points[0],Points[1],Points[2],radius", "\"x [mm]\",y (mm),z_mm,r/mm"}) {
        CAPTURE(header);
        CHECK(readText("p.csv", std::string(header) + "\n1,2,3,0.5\n4,5,6.5,1.25\n").spheres ==
              kTwo);
    }
    CHECK(readText("p.csv", "x [m],y [m],z [m],diameter_um\n.001,.002,.003,1000\n").spheres ==
          std::vector<Sphere<3>>{kTwo[0]});
    CHECK(readText("p.csv",
                   "x [\u00b5m],y (micron),z/um,r_um,mass [kg]\n1,2,3,.5,1\n4,5,6.5,1.25,2\n")
              .spheres == fromMicrometers(kTwo));
    // An exact name comes before one with signs and a unit.
    CHECK(readText("p.csv", "x,y,z,r,p_x,p_y,p_z,z/H\n1,2,3,.5,9,9,9,9\n").columns.size() == 4);
    for (const char* header : {"x [px],y,z,r", "x,y,z,radius_nm", "x,y,z,r/D"}) {
        CAPTURE(header);
        CHECK_THAT(errorOf("p.csv", std::string(header) + "\n1,2,3,1\n"),
                   Contains("unit") && Contains("not known"));
    }
    CHECK_THAT(errorOf("p.csv", "x [m],x_mm,y,z,r\n1,1,2,3,1\n"), Contains("x_mm"));
    CHECK_THAT(errorOf("p.csv", "x,y,z,radius,diameter_um\n1,2,3,1,2\n"), Contains("diameter_um"));
    CHECK(readText("p.csv", "x,y,z,radius,diameter_um\n1,2,3,1,2000\n").spheres.size() == 1);
}
