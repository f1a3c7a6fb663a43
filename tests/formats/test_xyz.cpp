// Extended XYZ: what we write, and what other programs do.
#include "formats/file_text.h"
#include "formats/lattice_pack.h"
#include "support/test.h"

namespace {

const char* const kTwo =
    "2\nLattice=\"10 0 0 0 10 0 0 0 10\" Properties=species:S:1:pos:R:3:radius:R:1:mass:R:1 "
    "Time=0.5\nC 1 2 3 0.5 7\nO 4 5 -6 1 8\n";

}  // namespace

TEST_CASE("an .xyz file begins as ASE and OVITO expect") {
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 0}}, 1}, {{{2, 0, 0}}, 1}};
    pack.region = {0, 1};
    REQUIRE(writtenText(pack, "p.xyz") ==
            "2\nLattice=\"4.0 0.0 0.0 0.0 2.0 0.0 0.0 0.0 2.0\" Origin=\"-1.0 -1.0 -1.0\" "
            "Properties=species:S:1:pos:R:3:radius:R:1:id:I:1:region:I:1 pbc=\"F F F\" "
            "unit_of_length=mm\nX 0.0 0.0 0.0 1.0 0 0\nX 2.0 0.0 0.0 1.0 1 1\n");
}

TEST_CASE("an .xyz file gives back the same pack") {
    auto pack = packWithColumns(500, "Young's modulus", "species", {"P", "Ca"});
    pack.columns.push_back(textColumn("id", {"", "one two"}, pack.spheres.size()));
    const auto read = readText("p.xyz", writtenText(pack, "p.xyz"));
    REQUIRE(read.spheres == pack.spheres);
    requireSameAttributes(read, pack);
    REQUIRE(read.columns.size() == 3);
    REQUIRE(read.columns[0].name == "species");
    REQUIRE(read.columns[0].texts == pack.columns[1].texts);
    REQUIRE(read.columns[1].name == "Young's_modulus");
    REQUIRE(read.columns[1].numbers == pack.columns[0].numbers);
    REQUIRE(read.columns[2].name == "id_2");
    REQUIRE(read.columns[2].texts[1] == "one_two");
    REQUIRE(read.columns[2].texts[0] == "_");
}

TEST_CASE("the unit of an .xyz file is recorded and counts") {
    Pack<3> pack;
    pack.spheres = {{{{1, 2, 3}}, 0.5}};
    PackWriteOptions options;
    options.unit = Unit::meter;
    const auto text = writtenText(pack, "p.xyz", options);
    REQUIRE_THAT(text, Contains("\nX 0.001") && Contains("=m\n"));
    REQUIRE(readText("p.xyz", text).spheres == pack.spheres);
    REQUIRE_THAT(
        errorOf("p.xyz", "1\nProperties=pos:R:3:radius:R:1 unit_of_length=inch\n1 2 3 4\n"),
        Contains("inch") && Contains("line 2"));
}

TEST_CASE("an .xyz file of another program is read, of several frames the last") {
    const auto one = readText("p.xyz", kTwo);
    REQUIRE(one.spheres == std::vector<Sphere<3>>{{{{1, 2, 3}}, 0.5}, {{{4, 5, -6}}, 1}});
    REQUIRE(one.columns.size() == 2);
    REQUIRE(one.columns[0].texts == std::vector<std::string>{"C", "O"});
    REQUIRE(one.columns[1].numbers == std::vector<double>{7, 8});
    const auto last = readText(
        "p.xyz", std::string(kTwo) + "1\nProperties=pos:R:3:radius:R:1:velo:R:3\n9 8 7 6 1 2 3\n");
    REQUIRE(last.spheres == std::vector<Sphere<3>>{{{{9, 8, 7}}, 6}});
    REQUIRE(last.columns.size() == 3);
    REQUIRE(last.columns[2].name == "velo_2");
    REQUIRE(readText("p.xyz", "0\nproperties=\"pos:R:3:radius:R:1\"\n").spheres.empty());
}

TEST_CASE("a broken .xyz file is refused with line and remedy") {
    const auto [content, word] = GENERATE(table<std::string, std::string>({
        {"", "empty"},
        {"two\n", "number of particles"},
        {"-1\nProperties=pos:R:3:radius:R:1\n", "number of particles"},
        {"2\n", "cut short"},
        {"1\nwater\nC 1 2 3\n", "extended XYZ"},
        {"1\nProperties=pos:R\n1 2 3\n", "extended XYZ"},
        {"1\nProperties=pos:R:3:radius:Q:1\n1 2 3 4\n", "radius:Q:1"},
        {"1\nProperties=pos:R:3:radius:R:9999999999\n1 2 3 4\n", "no column"},
        {"1\nProperties=pos:R:3\n1 2 3\n", "radius"},
        {"1\nProperties=pos:R:3:radius:R:1\n1 2 3\n", "line 3: has 3 words"},
        {"1\nProperties=pos:R:3:radius:R:1\n1 2 3 x\n", "line 3: column 'radius'"},
        {"1\nProperties=pos:R:3:radius:R:1\n1 2 3 -4\n", "radius is -4"},
        {"2\nProperties=pos:R:3:radius:R:1\n1 2 3 4\n", "1 of 2"},
        {"9000000000000000000\nProperties=pos:R:3:radius:R:1\n1 2 3 4\n", "cut short"},
    }));
    CAPTURE(content);
    REQUIRE_THAT(errorOf("p.xyz", content), Contains(word));
}
