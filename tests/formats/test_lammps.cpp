// Data files of LAMMPS and LIGGGHTS.
#include "formats/lammps_text.h"
#include "formats/lattice_pack.h"
#include "support/test.h"

#include "vdbpack/formats/materials.h"

TEST_CASE("a LAMMPS data file keeps ids, types and densities") {
    const auto pack = readText("p.data", std::string(kHeader) + kAtoms);
    REQUIRE(pack.spheres == kTwo);
    REQUIRE(pack.id == std::vector<std::int64_t>{7, 4});
    REQUIRE(pack.region.empty());
    REQUIRE(pack.columns.size() == 5);
    REQUIRE(columnOfNumbers(pack, "type")->numbers == std::vector<double>{1, 3});
    REQUIRE(columnOfNumbers(pack, "density")->numbers == std::vector<double>{2500, 1000});
    REQUIRE(columnOfNumbers(pack, "iz")->numbers == std::vector<double>{0, -1});
}

TEST_CASE("velocities of a data file are left out with a warning") {
    const auto heard = [](const char* speed) {
        std::vector<std::string> warnings;
        readText("p.data",
                 std::string(kHeader) + kAtoms + "\nVelocities\n\n7 0 0 0 0 0 0\n4 " + speed +
                     " 0 0 0 0 0\n",
                 warnings);
        return warnings;
    };
    REQUIRE(heard("0.1").size() == 1);
    CHECK_THAT(heard("0.1")[0], Contains("Velocities"));
    CHECK(heard("0").empty());
}

TEST_CASE("data files may order and comment their lines as LAMMPS allows") {
    const std::string atoms =
        GENERATE(as<std::string>{}, "Atoms", "Atoms  # granular", "  Atoms # sphere");
    const std::string end = GENERATE(as<std::string>{}, "\n", "\r\n");
    const std::string prefix = GENERATE(as<std::string>{}, "lammps:", "liggghts:", "LAMMPS:");
    CAPTURE(atoms, end, prefix);
    std::istringstream lines(
        "5 atoms 3 in the title\n # no, fewer:\n1 bonds # one\n0 0 0 xy xz yz\n  2   atom types\n"
        "-10 10 zlo zhi\n2 atoms\n-10 10 xlo xhi\n1 bond types\n4 extra bond per atom\n\n"
        "Masses\n\n1 1.0 # bone\n2 2.0\n\nPair Coeffs # gran\n\n1 1 2\n2 3 4\n"
        "PairIJ Coeffs\n\n1 1 5\n1 2 5\n2 2 5\nBond Coeffs\n\n1 harmonic 3\n\n"
        "Velocities\n\n7 0 0 0 0 0 0\n4 0 0 0 0 0 0\n\n@\n\n"
        "7 1 1.0 2500 1 2 3 # first\n# between\n\t4 2\t2 1e3 4 5 -6\n\nBonds\n\n1 1 7 4\n");
    std::string content;
    for (std::string line; std::getline(lines, line);)
        content += (line == "@" ? atoms : line) + end;
    const TextFile file(content);
    const auto pack = readPack(prefix + file.path());
    REQUIRE(pack.spheres == kTwo);
    REQUIRE(pack.columns.size() == 2);
}

TEST_CASE("bonded particles and type labels are read from data files") {
    const auto bonded = readText("p.data",
                                 "t\n1 atoms\n1 atom types\nAtoms # bpm/sphere\n\n"
                                 "1 9 1 2.0 1.5 4 5 -6\n");
    REQUIRE(bonded.spheres == std::vector<Sphere<3>>{kTwo[1]});
    REQUIRE(columnOfNumbers(bonded, "molecule")->numbers == std::vector<double>{9});
    const auto labels = readText("p.data",
                                 "t\n2 atoms\n2 atom types\nAtom Type Labels\n\n1 soft\n2 hard\n\n"
                                 "Masses\n\nsoft 1\nhard 2\n\nAtoms # sphere\n\n"
                                 "1 soft 1 1 1 2 3\n2 hard 2 1 4 5 -6\n");
    REQUIRE(labels.spheres == kTwo);
    REQUIRE(labels.columns.at(0).texts == std::vector<std::string>{"soft", "hard"});
}

TEST_CASE("units that a LAMMPS file names are taken") {
    const auto data = [](const std::string& style) {
        return readText("p.data", "LAMMPS data file via write_data, units = " + style +
                                      "\n1 atoms\n\nAtoms\n\n1 1 2 1 3 0 0\n")
            .spheres.at(0);
    };
    REQUIRE(data("si") == Sphere<3>{{{3000, 0, 0}}, 1000});
    REQUIRE(data("cgs") == Sphere<3>{{{30, 0, 0}}, 10});
    REQUIRE(data("micro") == Sphere<3>{{{0.003, 0, 0}}, 0.001});
    REQUIRE(data("lj") == Sphere<3>{{{3, 0, 0}}, 1});
    // Written once, before the first frame.
    const auto pack = readText("p.dump", "ITEM: UNITS\nsi\nITEM: TIME\n0\n" + kDump + kDump);
    REQUIRE(pack.spheres.at(0) == Sphere<3>{{{1000, 2000, 3000}}, 500});
}

TEST_CASE("unusable LAMMPS data is refused with the reason") {
    const std::string whole = std::string(kHeader) + kAtoms;
    const auto error = [&whole](const std::string& from, const std::string& to) {
        return errorOf("p.data", replaced(whole, from, to));
    };
    REQUIRE_THAT(errorOf("p.data", ""), Contains("p.data"));
    REQUIRE_THAT(errorOf("p.data", "title\n"), Contains("LAMMPS"));
    REQUIRE_THAT(errorOf("p.data", "title\nAtoms\n\n1 1 1 1 1 1 1\n"), Contains("'N atoms'"));
    REQUIRE_THAT(errorOf("p.data", kHeader), Contains("section Atoms"));
    for (const std::string style : {"atomic", "hybrid sphere bond", "full", "ellipsoid"}) {
        REQUIRE_THAT(error("sphere", style), Contains("atom style '" + style.substr(0, 4)) &&
                                                 Contains("line 10") && Contains("granular"));
    }
    REQUIRE_THAT(error("2 atoms", "-2 atoms"), Contains("'-2'"));
    REQUIRE_THAT(error("2 atoms", "1.5 atoms"), Contains("line 3"));
    REQUIRE_THAT(error("2 atoms", "1 atoms"), Contains("line 13"));
    REQUIRE_THAT(error("2 atoms", "3 atoms"), Contains("2 of 3"));
    REQUIRE_THAT(error("2 atoms", "9000000000000000000 atoms"), Contains("2 of"));
    REQUIRE_THAT(error("2 atoms", "1000000000000000000000 atoms"),
                 Contains("'1000000000000000000000'"));
    REQUIRE_THAT(error("4 3 2 1e3 4 5 -6 0 0 -1", "Velocities"),
                 Contains("line 13") && Contains("1 words"));
    REQUIRE_THAT(error("4 3 2", "4 4 2"), Contains("type 4"));
    REQUIRE_THAT(error("4 3 2", "4 0 2"), Contains("type 0"));
    REQUIRE_THAT(error("1e3", "-0.8"), Contains("density") && Contains("'-0.8'"));
    REQUIRE_THAT(error("1e3", "nan"), Contains("density"));
    REQUIRE_THAT(error(" 1.0 ", " 0 "), Contains("radius") && Contains("line 12"));
    REQUIRE_THAT(error(" 1.0 ", " inf "), Contains("radius") && Contains("inf"));
    REQUIRE_THAT(error(" -6 ", " nan "), Contains("line 13"));
    REQUIRE_THAT(error(" -6 ", " 1e999 "), Contains("1e999"));
    REQUIRE_THAT(error("4 3 2", "4.5 3 2"), Contains("4.5"));
    // Atom style atomic without saying so, and an ellipsoid's flag where the diameter would be.
    REQUIRE_THAT(errorOf("p.data", "t\n1 atoms\nAtoms\n\n1 1 1 2 3\n"), Contains("5 words"));
    REQUIRE_THAT(errorOf("p.data", "t\n1 atoms\n1 ellipsoids\nAtoms\n\n1 1 1 2 3 4 5\n"),
                 Contains("1 ellipsoids"));
    REQUIRE(readText("p.data", "t\n0 atoms\n").spheres.empty());
}

TEST_CASE("a LAMMPS file cut short at any byte is an error") {
    const std::string data =
        std::string(kHeader) + "Velocities\n\n1 0 0 0 0 0 0\n2 0 0 0 0 0 0\n\n" + kAtoms;
    const auto [name, whole, frames] = GENERATE_COPY(table<std::string, std::string, int>(
        {{"p.data", data, 0}, {"p.dump", kDump, 1}, {"p.dump", kDump + kDump, 2}}));
    REQUIRE(reads(name, whole));
    // A cut within the last number of the last line cannot be told.
    const auto lastNumber = whole.find_last_of(' ') + 2;
    for (std::size_t size = 0; size < lastNumber; ++size) {
        CAPTURE(name, frames, size);
        // A dump may end after any frame, with or without the end of the line.
        const bool between = frames == 2 && (size == kDump.size() || size == kDump.size() - 1);
        REQUIRE(reads(name, whole.substr(0, size)) == between);
    }
}

namespace {

Pack<3> touchingRow() {
    Pack<3> pack;
    for (int i = 0; i < 4; ++i) {
        pack.spheres.push_back({{{2.0 * i + 0.1, 1.0 / 3, -7}}, 1});
        pack.region.push_back(i % 2);
    }
    return pack;
}

std::string written(const Pack<3>& pack, const PackWriteOptions& options = {},
                    const std::string& prefix = "lammps:") {
    return writtenText(pack, prefix + "p.txt", options);
}

}  // namespace

TEST_CASE("a LAMMPS data file holds whole spheres and says what its numbers mean") {
    PackWriteOptions options;
    options.particleDensity = 1900;
    const auto text = written(touchingRow(), options);
    CAPTURE(text);
    REQUIRE(text.substr(0, text.find('\n')) ==
            "atom_style sphere or granular; atom = id + 1; type = region + 1; density in t/mm3; "
            "unit of length: mm");
    REQUIRE_THAT(text, Contains("\n4 atoms\n2 atom types\n"));
    REQUIRE_THAT(text, Contains("\n-0.9") && Contains(" 7.0999999999999996 xlo xhi\n"));
    REQUIRE_THAT(text, Contains("\n-8.0 -6.0 zlo zhi\n"));
    // No hint: LIGGGHTS wants the bare word.
    REQUIRE_THAT(text, Contains("\n\nAtoms\n\n1 1 2.0 1.9000000000000001e-09 "));
}

TEST_CASE("densities go with the unit of length") {
    const auto [unit, name, number] = GENERATE(table<Unit, std::string, std::string>(
        {{Unit::meter, "kg/m3", " 1900.0 "},
         {Unit::centimeter, "g/cm3", " 1.8999999999999999 "},
         {Unit::millimeter, "t/mm3", " 1.9000000000000001e-09 "},
         {Unit::micrometer, "pg/um3", " 1.8999999999999999 "}}));
    PackWriteOptions options;
    options.particleDensity = 1900;
    options.unit = unit;
    const auto text = written(touchingRow(), options);
    CAPTURE(text);
    REQUIRE_THAT(text, Contains("density in " + name + ";") && Contains(number));
}

TEST_CASE("densities may go by region") {
    PackWriteOptions options;
    options.unit = Unit::meter;
    options.materialDensity = {{0, 1900}, {1, 1100}};
    auto pack = touchingRow();
    pack.region = {0, 1, 0, 2};
    pack.columns.push_back({"density", {7, 7, 7, 7}, {}});
    const auto read = readText("p.data", written(pack, options));
    REQUIRE(columnOfNumbers(read, kDensityColumn)->numbers ==
            std::vector<double>{1900, 1100, 1900, kDefaultDensity});
    options.materialDensity = {{0, -1}};
    REQUIRE_THROWS_AS(written(pack, options), ParameterError);
}

TEST_CASE("LAMMPS data files give back spheres, ids and regions, with bonds or without") {
    const std::string prefix = GENERATE(as<std::string>{}, "lammps:", "liggghts:", "lammps-bonds:");
    const Unit unit = GENERATE(Unit::millimeter, Unit::meter);
    const bool named = GENERATE(false, true);
    CAPTURE(prefix, unitName(unit), named);
    auto pack = latticePack<3>(200, {{30, -20, 500}}, 40, 3);
    if (named)
        for (std::size_t i = 0; i < pack.spheres.size(); ++i)
            pack.id.push_back(static_cast<std::int64_t>(7 + 3 * i));
    PackWriteOptions options;
    options.unit = unit;
    const auto read = readBack(pack, prefix + "p.txt", options);
    REQUIRE(read.id == pack.id);
    REQUIRE(read.region == pack.region);
    REQUIRE(read.spheres.size() == pack.spheres.size());
    REQUIRE(read.columns.size() == 1);
    REQUIRE(read.columns[0].name == kDensityColumn);
    for (std::size_t i = 0; i < read.spheres.size(); ++i) {
        if (unit == Unit::millimeter) {
            REQUIRE(read.spheres[i] == pack.spheres[i]);
        } else {
            REQUIRE(length(read.spheres[i].center - pack.spheres[i].center) < 1e-12 * 600);
        }
    }
}

TEST_CASE("each touching pair is a bond between its atoms") {
    auto pack = touchingRow();
    pack.id = {10, 20, 30, 40};
    pack.spheres[3].center[0] += 0.1;
    const auto text = written(pack, {}, "lammps-bonds:");
    CAPTURE(text);
    REQUIRE_THAT(text, Contains("\n2 bonds\n1 bond types\n"));
    REQUIRE_THAT(text, Contains("\nAtoms # hybrid\n\n10 1 0.1"));
    REQUIRE(text.substr(text.find("Bonds\n")) == "Bonds\n\n1 1 10 20\n2 1 20 30\n");
    PackWriteOptions options;
    options.bonds.tolerance = 0.2;
    REQUIRE_THAT(written(pack, options, "lammps-bonds:"), Contains("\n3 1 30 40\n"));
    options.bonds.classes = 0;
    const auto each = written(pack, options, "lammps-bonds:");
    REQUIRE_THAT(each, Contains("\n3 bonds\n3 bond types\n"));
    REQUIRE_THAT(each, Contains("\n3 3 30 40\n"));
    options.bonds.classes = 5;
    const auto bpm = written(pack, options, "lammps-bonds:");
    REQUIRE_THAT(bpm, Contains("\n5 bond types\n"));
    REQUIRE_THAT(bpm, Contains("\nAtoms # bpm/sphere\n\n10 0 1 "));
    const TextFile file(bpm);
    REQUIRE(readPack("lammps:" + file.path()).spheres == pack.spheres);
}

TEST_CASE("the title of a file of bonds states the tolerance of the bonds") {
    PackWriteOptions options;
    options.generator = "vdb_pack 1; axes RAS; contact tolerance 0.01";
    options.bonds.tolerance = 0.05;
    const TemporaryFolder folder;
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 0}}, 1}, {{{2.04, 0, 0}}, 1}};
    writePack(pack, "lammps-bonds:" + folder.file("b.data"), options);
    writePack(pack, "lammps:" + folder.file("a.data"), options);
    CHECK_THAT(contentOf(folder.file("b.data")),
               Contains("axes RAS; contact tolerance 0.05;") && Contains("1 bonds"));
    CHECK_THAT(contentOf(folder.file("a.data")), Contains("contact tolerance 0.01;"));
}

TEST_CASE("ids that LAMMPS cannot take are counted from one") {
    auto pack = touchingRow();
    pack.id =
        GENERATE(std::vector<std::int64_t>{-1, 2, 3, 4}, std::vector<std::int64_t>{1, 1, 2, 3},
                 std::vector<std::int64_t>{1, 2, 3, 0x80000000});
    const auto text = written(pack);
    REQUIRE_THAT(text,
                 Contains("atoms are counted") && Contains("\n1 1 2.0 ") && Contains("\n4 2 2.0 "));
}

TEST_CASE("types and densities of a data file are written again, negative regions are refused") {
    const auto pack = readText("p.data", std::string(kHeader) + kAtoms);
    const auto text = written(pack);
    CAPTURE(text);
    REQUIRE_THAT(text, Contains("\n3 atom types\n") && Contains("\n7 1 1.0 2500.0 ") &&
                           Contains("\n4 3 2.0 1000.0 ") && Contains("density as it was given"));
    PackWriteOptions options;
    options.particleDensity = 1;
    REQUIRE_THAT(written(pack, options), Contains("\n7 1 1.0 9.9999999999999998e-13 "));
    REQUIRE(readText("p.data", written(Pack<3>{})).spheres.empty());
    auto negative = touchingRow();
    negative.region[2] = -1;
    REQUIRE_THROWS_AS(written(negative), ParameterError);
}

TEST_CASE("densities whose unit is known are kg/m3 and go with the unit that is written") {
    const std::string atoms = "\n\n1 atoms\n1 atom types\n\nAtoms\n\n1 1 1 2500 0 0 0\n";
    PackWriteOptions meters;
    meters.unit = Unit::meter;
    const auto [units, density, written] = GENERATE(table<std::string, double, std::string>(
        {{"units = si", 2500, " 2500.0 "},
         {"units = cgs", 2.5e6, " 2500000.0 "},
         {"units = micro", 2.5e6, " 2500000.0 "},
         {"; density in t/mm3; unit of length: mm", 2.5e15, " 2500000000000000.0 "}}));
    CAPTURE(units);
    const auto pack = readText("p.data", "x, " + units + atoms);
    CHECK(columnOfNumbers(pack, kDensityColumn)->numbers == std::vector<double>{density});
    CHECK_THAT(writtenText(pack, "p.data", meters), Contains(written) && Contains("in kg/m3"));
}

TEST_CASE("added spheres leave types and densities of a file as they are") {
    auto pack = touchingRow();
    pack.region = {0, 0, 1, 1};
    pack.columns = {{"type", {2, 1, 0, 0}, {}}, {kDensityColumn, {7800, 1900, 0, 0}, {}}};
    PackWriteOptions options;
    options.unit = Unit::meter;
    const auto read = readText("p.data", written(pack, options));
    // The largest type is 2; the new spheres are of material 1.
    CHECK(columnOfNumbers(read, "type")->numbers == std::vector<double>{2, 1, 4, 4});
    CHECK(columnOfNumbers(read, kDensityColumn)->numbers ==
          std::vector<double>{7800, 1900, kDefaultDensity, kDefaultDensity});
}
