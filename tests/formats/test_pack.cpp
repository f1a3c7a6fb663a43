#include "formats/file_text.h"
#include "formats/lattice_pack.h"
#include "support/test.h"

#include "vdbpack/formats/material_file.h"
#include "vdbpack/formats/materials.h"

namespace {

Pack<3> asSpheres(const Pack<3>& pack) {
    return pack;
}
Pack<3> asSpheres(const Pack<2>& pack) {
    Pack<3> out;
    for (const auto& s : pack.spheres)
        out.spheres.push_back({{{s.center[0], s.center[1], pack.sliceHeight}}, s.radius});
    static_cast<PackAttributes&>(out) = pack;
    return out;
}

}  // namespace

DIM_TEST_CASE("exact formats give back the pack bit for bit") {
    const auto file = GENERATE(as<std::string>{}, "p.vdb", "p.vtp", "p.pvtp", "p.csv", "p.npz");
    const double away = GENERATE(0.0, 730.0, -730.0, 1e4, -1e4);
    const auto seed = GENERATE(range(1u, 4u));
    CAPTURE(Dim, file, away, seed);
    Vec<Dim> center;
    for (int d = 0; d < Dim; ++d) center[d] = away * (d == 1 ? -0.7 : 1.0);
    auto pack = latticePack<Dim>(3000, center, 25, seed);
    pack.sliceHeight = Dim == 2 ? 12.375 : 0;
    pack.columns.push_back({"material", {}, {}});
    pack.columns.push_back({"clump", {}, {}});
    pack.columns.push_back({"stiffness", {}, {}});
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        // No ids, small ones and large ones.
        if (seed > 1)
            pack.id.push_back(static_cast<std::int64_t>(i * (seed == 2 ? 2 : 5'000'000'000) + 11));
        pack.columns[0].numbers.push_back(static_cast<double>(i % 5));
        pack.columns[1].texts.push_back(i % 7 == 0 ? "" : "clump, \"no\" " + std::to_string(i % 7));
        pack.columns[2].numbers.push_back(0.1 * static_cast<double>(i));
    }

    const TemporaryFolder scratch;
    PackWriteOptions options;
    options.generator = "a <test> & \"more\"";
    writePack(pack, scratch.file(file), options);
    REQUIRE(scratch.files() == (file == "p.pvtp" ? 2 : 1));
    const auto read = readPack(scratch.file(file));
    const auto written = asSpheres(pack);
    REQUIRE(read.spheres == written.spheres);
    requireSameAttributes(read, written);
    requireSameColumns(read, pack);
    if (Dim == 2) {
        const auto circles = asCircles(read);
        REQUIRE(circles.sliceHeight == pack.sliceHeight);
        REQUIRE(asSpheres(circles).spheres == written.spheres);
    }
}

DIM_TEST_CASE("YADE text keeps positions, radii and regions exactly") {
    auto pack = latticePack<Dim>(2000, Vec<Dim>{}, 900, 3);
    SECTION("with regions") {}
    SECTION("without regions") {
        pack.region.clear();
    }
    const auto text = writtenText(pack, "yade:p.txt");
    REQUIRE(text.substr(0, text.find('\n')) ==
            (pack.region.empty() ? "#format x_y_z_r" : "#format x_y_z_r_matId"));
    REQUIRE(text.find("\n\n") == std::string::npos);
    const auto read = readText("p.txt", text);
    REQUIRE(read.spheres == asSpheres(pack).spheres);
    REQUIRE(read.region == pack.region);
}

TEST_CASE("PLY keeps every digit, far from the origin too") {
    const double far = GENERATE(0.0, 1e4, 1e6);
    auto pack = latticePack<3>(2000, {{730 + far, -40, far}}, 60, 4);
    pack.id.resize(pack.spheres.size());
    for (std::size_t i = 0; i < pack.id.size(); ++i)
        pack.id[i] = static_cast<std::int64_t>(3 * i + 1);
    const auto read = readBack(pack, "p.ply");
    REQUIRE(read.id == pack.id);
    REQUIRE((read.spheres == pack.spheres));
}

TEST_CASE("the unit that was written is the unit that is read") {
    const auto file = GENERATE(as<std::string>{}, "p.vdb", "p.vtp", "p.csv", "p.ply", "yade:p.txt");
    const auto unit = GENERATE(Unit::meter, Unit::centimeter, Unit::millimeter, Unit::micrometer);
    CAPTURE(file, unitName(unit));
    const auto pack = latticePack<3>(500, {{-120, 30, 1000}}, 40, 5);
    PackWriteOptions options;
    options.unit = unit;
    PackReadOptions reading;
    // Only .csv has no place for its unit; the others must not listen to a wrong one.
    reading.unit = file == "p.csv" ? unit : Unit::centimeter;
    const auto read = readBack(pack, file, options, reading);
    REQUIRE(read.spheres.size() == pack.spheres.size());
    if (file != "p.vdb") REQUIRE((read.spheres == pack.spheres));
    const double tolerance = 1e-6;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        REQUIRE(length(read.spheres[i].center - pack.spheres[i].center) < tolerance);
        REQUIRE(read.spheres[i].radius == Approx(pack.spheres[i].radius).epsilon(1e-6));
    }
    for (std::size_t i = 0; i < read.depth.size(); ++i)
        REQUIRE(read.depth[i] == Approx(pack.depth[i]).epsilon(1e-6));
}

TEST_CASE("a pack without attributes or without spheres survives every format") {
    const auto file = GENERATE(as<std::string>{}, "p.vdb", "p.vtp", "p.csv", "p.ply", "yade:p.txt");
    const std::size_t count = GENERATE(0u, 1u, 40u);
    CAPTURE(file, count);
    Pack<3> pack;
    pack.spheres = latticePack<3>(count, {}, 4, 6).spheres;
    const auto read = readBack(pack, file);
    REQUIRE(read.spheres.size() == count);
    requireSameAttributes(read, pack);
    REQUIRE(read.columns.empty());
}

TEST_CASE("names and texts of columns come back whatever they hold") {
    const auto file = GENERATE(as<std::string>{}, "p.vdb", "p.vtp", "p.csv", "p.npz");
    CAPTURE(file);
    const std::vector<std::string> odd{"a<b> & \"c\" 'd'", "&amp; &#65; &lt;", "]]> <!-- --> ?>",
                                       "h\xc3\xb6he \xe9\xaa\xa8 \xf0\x9f\xa6\xb4",
                                       "a,b;c\\n%s{0}"};
    Pack<3> pack;
    for (std::size_t i = 0; i < odd.size(); ++i)
        pack.spheres.push_back({{{3.0 * static_cast<double>(i), 0, 0}}, 1.0});
    for (const auto& name : odd) {
        pack.columns.push_back({name, {}, odd});
        pack.columns.push_back({"number " + name, {1, 2, 3, 4, 5}, {}});
    }
    const auto read = readBack(pack, file);
    // OpenVDB allows letters, digits and _ in names.
    requireSameColumns(read, pack, file != "p.vdb");
}

TEST_CASE("names of parts come back from every format that keeps their column") {
    auto pack = latticePack<3>(50, {}, 60, 4);
    pack.region.clear();
    pack.columns = {{kPartColumn, {}, {}, {"vertebrae L3", "f\u00e9mur, <left>", "none\nof it"}}};
    for (std::size_t i = 0; i < pack.spheres.size(); ++i)
        pack.columns[0].numbers.push_back(static_cast<double>(i % 2));
    const TemporaryFolder folder;
    for (const char* name :
         {"p.vtp", "p.pvtp", "p.hdf", "p.vdb", "p.data", "lammps-bonds:b.data", "yade:p.txt"}) {
        CAPTURE(name);
        const Pack<3> read = readBack(pack, name);
        CHECK(columnOfNumbers(read, kPartColumn)->numbers == pack.columns[0].numbers);
        CHECK(partNames(read) ==
              std::vector<std::string>{"vertebrae L3", "f\u00e9mur, <left>", "none of it"});
    }
    CHECK(partNames(readBack(pack, "p.npz")) == pack.columns[0].names);
    // As ParaView lists them: one text a row.
    CHECK_THAT(writtenText(pack, "p.vtp"), Contains("\"part_names\" NumberOfTuples=\"3\""));
    writeMaterials(pack, folder.file("m.csv"), {});
    CHECK(contentOf(folder.file("m.csv")) ==
          "material,part,region,density_class,spheres,density_kg_m3,part_name\n"
          "0,0,0,0,25,1000,vertebrae L3\n1,1,0,0,25,1000,\"f\u00e9mur, <left>\"\n");
}

TEST_CASE("names in XML are UTF-8, and references in them are read") {
    Pack<3> pack;
    pack.spheres.push_back({{{0, 0, 0}}, 1.0});
    pack.columns.push_back({"h\xf6he", {1}, {}});  // Latin-1
    pack.columns.push_back({"line\nbreak", {2}, {}});
    std::string text = writtenText(pack, "p.vtp");
    auto read = readText("p.vtp", text);
    REQUIRE(read.columns.size() == 2);
    CHECK(read.columns[0].name == "h\xef\xbf\xbdhe");  // U+FFFD
    CHECK(read.columns[1].name == "line break");
    const std::string name = "line break";
    text.replace(text.find(name), name.size(), "h&#246;he &#x9aa8;&#x1F9B4; &#9 &#; &#x");
    read = readText("p.vtp", text);
    REQUIRE(read.columns.size() == 2);
    CHECK(read.columns[1].name == "h\xc3\xb6he \xe9\xaa\xa8\xf0\x9f\xa6\xb4 &#9 &#; &#x");
}

TEST_CASE("CSV numbers keep their decimal point") {
    Pack<3> pack;
    pack.spheres = {{{{1e-5, -3, 0.1}}, 2}, {{{1e22, 1.5e-300, -0.0}}, 1e-7}};
    pack.region = {1, 0};
    REQUIRE(writtenText(pack, "p.csv") ==
            "id,x,y,z,radius,region\n"
            "0,1.0000000000000001e-05,-3.0,0.10000000000000001,2.0,1\n"
            "1,1.0e+22,1.5000000000000001e-300,-0.0,9.9999999999999995e-08,0\n");
}

TEST_CASE("an unknown format is refused before anything is written") {
    const TemporaryFolder scratch;
    for (const char* file : {"pack.odt", "pack", "dump:p.data", "p.yade", "dir.csv/pack", "csv:"}) {
        CAPTURE(file);
        REQUIRE_THROWS_AS(checkPackFormat(file), ParameterError);
        REQUIRE_THROWS_WITH(writePack(Pack<3>{}, file, {}), Contains("csv"));
    }
    REQUIRE_NOTHROW(checkPackFormat("P.VDB"));
    REQUIRE_NOTHROW(checkPackFormat("csv:table.txt"));
    REQUIRE_NOTHROW(checkPackFormat("a:b.csv"));
    REQUIRE(scratch.files() == 0);
}

TEST_CASE("spheres that no file can hold are the caller's mistake") {
    const TemporaryFolder scratch;
    const std::pair<const char*, void (*)(Pack<3>&)> mistakes[] = {
        {"radius", [](auto& pack) { pack.spheres[3].radius = 0; }},
        {"position", [](auto& pack) { pack.spheres[3].center[1] = std::nan(""); }},
        {"far", [](auto& pack) { pack.spheres[3].center[1] = 1e31; }},
        {"attribute", [](auto& pack) { pack.region.pop_back(); }},
        {"column", [](auto& pack) {
             pack.columns.push_back({"c", {1, 2}, {}});
         }}};
    for (const auto& [name, make] : mistakes) {
        CAPTURE(name);
        auto pack = latticePack<3>(5, {}, 4, 9);
        make(pack);
        CHECK_THROWS_AS(writePack(pack, scratch.file("p.csv"), {}), ParameterError);
    }
    REQUIRE(scratch.files() == 0);
}

TEST_CASE("spheres at different heights are no circles") {
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 1}}, 1}, {{{3, 0, 1.01}}, 1}};
    REQUIRE_THROWS_WITH(asCircles(pack), Contains("sphere 1"));
    REQUIRE_THROWS_AS(asCircles(pack), InputError);
    pack.spheres[1].center[2] = 1;
    REQUIRE(asCircles(pack).sliceHeight == 1);
}

TEST_CASE("the voxel of the point grid is a power of two with about 8 points") {
    for (const int dim : {2, 3})
        for (const double count : {1.0, 1e3, 5e7})
            for (const double measure : {1e-6, 3.0, 1e9}) {
                const double voxel = pointVoxelSize(count, measure, dim);
                int exponent = 0;
                REQUIRE(std::frexp(voxel, &exponent) == 0.5);
                const double points = count / measure * std::pow(voxel, dim);
                REQUIRE(points > 8 / std::pow(2.0, 0.51 * dim));
                REQUIRE(points < 8 * std::pow(2.0, 0.51 * dim));
            }
    REQUIRE(pointVoxelSize(0, 1, 3) == 1);
    REQUIRE(pointVoxelSize(1, 0, 3) == 1);
}

TEST_CASE("radii are found under the names of other programs") {
    for (const char* name : {"radius", "Radii", "scalar_radius", "r", "pscale"})
        CHECK(readText("p.csv", std::string("x,y,z,") + name + "\n0,0,0,1.5\n").spheres[0].radius ==
              1.5);
    CHECK(readText("p.csv", "x,y,z,scalar_diameter\n0,0,0,3\n").spheres[0].radius == 1.5);
    const Pack<3> both = readText("p.csv", "x,y,z,radius,diameter\n0,0,0,1.5,3\n");
    CHECK(both.spheres[0].radius == 1.5);
    CHECK(both.columns.empty());  // or it would keep the unit of the file
}

TEST_CASE("particles that are no spheres, and two different sizes, are refused") {
    const auto [columns, row, words] = GENERATE(table<std::string, std::string, std::string>({
        {"diameter", "4", "'diameter' is 4"},
        {"sqp_a,sqp_b,sqp_c,sqp_m,sqp_n", "1,1,2,2,2", "'sqp_c' is 2"},
        {"sqp_a,sqp_b,sqp_c,sqp_m,sqp_n", "1,1,1,8,2", "'sqp_m' is 8"},
        {"shapex,shapey,shapez", "1,1.2,1", "'shapey' is 1.2"},
        {"blockiness1,blockiness2", "2,4", "'blockiness2' is 4"},
        {"sqp_a,sqp_b,sqp_c,sqp_m,sqp_n", "1,1,1,2,2", ""},
    }));
    CAPTURE(columns, row);
    const std::string error =
        errorOf("p.csv", "x,y,z,radius," + columns + "\n0,0,0,1," + row + "\n");
    CHECK(error.empty() == words.empty());
    CHECK_THAT(error, Contains(words));
}
