// Periodic cells in files.
#include "formats/file_text.h"
#include "formats/lammps_text.h"
#include "support/test.h"

#include "vdbpack/formats/pack_text.h"

namespace {

Pack<3> packIn(const std::string& axes) {
    Pack<3> pack;
    pack.spheres = {{{{-4.9, 0.25, 3}}, 1.5}, {{{2, 2.5, -3}}, 2}};
    pack.cell.box = {{{-5, -4.25, -6.5}}, {{5, 4.25, 6.5}}};
    for (const char c : axes) pack.cell.wraps[static_cast<std::size_t>(c - 'x')] = true;
    return pack;
}

}  // namespace

TEST_CASE("files keep the periodic cell of a pack") {
    const auto axes = GENERATE(as<std::string>{}, "xyz", "xy", "z", "");
    const auto file =
        GENERATE(as<std::string>{}, "p.vdb", "p.vtp", "p.xyz", "p.data", "yade:p.txt");
    const Unit unit = GENERATE(Unit::millimeter, Unit::meter);
    CAPTURE(axes, file);
    const Pack<3> pack = packIn(axes);
    PackWriteOptions write;
    write.unit = unit;
    const Pack<3> back = readBack(pack, file, write);
    CHECK(back.spheres.size() == 2);
    CHECK(back.cell.wraps == pack.cell.wraps);
    for (int d = 0; d < 3; ++d) {
        if (!pack.cell.isAlong(d)) continue;
        CHECK(back.cell.box.lo[d] == Approx(pack.cell.box.lo[d]).epsilon(1e-14));
        CHECK(back.cell.box.hi[d] == Approx(pack.cell.box.hi[d]).epsilon(1e-14));
    }
}

TEST_CASE("LAMMPS, YADE and ASE find the cell where they look for it") {
    const std::string data = writtenText(packIn("xy"), "p.data");
    CHECK_THAT(data, Contains("boundary p p f"));
    CHECK_THAT(data, Contains("\n-5.0 5.0 xlo xhi\n-4.25 4.25 ylo yhi\n-5.0 4.5 zlo zhi\n"));
    CHECK_THAT(writtenText(packIn("xy"), "p.xyz"),
               Contains("pbc=\"T T F\"") && Contains("Lattice=\"10.0 "));
    CHECK_THAT(writtenText(packIn("xyz"), "yade:p.txt"),
               Contains("\n##PERIODIC:: 10.0 8.5 13.0\n"));
    // YADE repeats along all axes or none.
    CHECK_THAT(writtenText(packIn("xy"), "yade:p.txt"), !Contains("##PERIODIC::"));
}

TEST_CASE("texts of cells are checked") {
    for (const char* text :
         {"xw 0 0 0 1 1 1", "x 0 0 0 0 1 1", "x 0 0 0 1 1", "x 0 0 0 inf 1 1", ""})
        CHECK_THAT(messageOf<InputError>([&] { cellIn(text, Unit::millimeter, "f"); }),
                   Contains("f: ") && Contains("cell"));
    CHECK(cellIn("y 0 -1 0 1 1 1", Unit::meter, "f").length(1) == 2000);
    CHECK(cellText(PeriodicCell<3>{}).empty());
}

TEST_CASE("periodic boxes of other programs become the cell, or are warned of") {
    const std::vector<std::string> rows = {"1 1 0.5 5 5 1", "2 1 9.5 5 5 1"};
    const auto dump = [&](const std::string& bounds) {
        return frame("id type x y z radius", rows, bounds);
    };
    const auto xyz = [](const std::string& keys) {
        return "2\n" + keys + " Properties=pos:R:3:radius:R:1\n0.5 5 5 1\n9.5 5 5 1\n";
    };
    const std::string flat = "\n0 10\n0 10\n0 10", tilted = "\n0 10 1\n0 10 0\n0 10 0",
                      cube = "Lattice=\"10 0 0 0 10 0 0 0 10\"",
                      atoms = "Atoms\n\n1 1 2 1 0.5 5 5\n2 1 2 1 9.5 5 5\n",
                      head =
                          "x\n\n2 atoms\n1 atom types\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n";
    struct Case {
        std::string file, text, axes, warning;
    };
    const auto c = GENERATE_COPY(from_range(std::vector<Case>{
        {"p.dump", dump("pp pp pp" + flat), "xyz", ""},
        {"p.dump", dump("pp ff pp" + flat), "xz", ""},
        {"p.dump", dump("ff ff ff" + flat), "", ""},
        {"p.dump", dump(flat.substr(0)), "", "2 spheres protrude"},
        {"p.dump", dump("xy xz yz pp pp pp" + tilted), "", "triclinic"},
        {"p.dump", dump("xy xz yz ff ff ff" + tilted), "", ""},
        {"p.data", head + "\n" + atoms, "", "2 spheres protrude"},
        {"p.data", head + "1 0 0 xy xz yz\n\n" + atoms, "", "triclinic"},
        {"p.xyz", xyz(cube + " pbc=\"T T T\""), "xyz", ""},
        {"p.xyz", xyz(cube + " pbc=\"true false 1\""), "xz", ""},
        {"p.xyz", xyz(cube), "", "protrude"},
        {"p.xyz", xyz("Lattice=\"10 0 0 1 10 0 0 0 10\" pbc=\"T T T\""), "", "triclinic"},
        {"p.xyz", xyz("Lattice=\"0 0 0 0 10 0 0 0 10\" pbc=\"T T T\""), "", "empty"},
        {"p.txt", "##PERIODIC:: 10 10 10\n0.5 5 5 1\n9.5 5 5 1\n", "xyz", ""}}));
    CAPTURE(c.file, c.text);
    std::vector<std::string> warnings;
    const Pack<3> pack = readText(c.file, c.text, warnings);
    std::string axes;
    for (int d = 0; d < 3; ++d)
        if (pack.cell.isAlong(d)) axes += "xyz"[d];
    CHECK(axes == c.axes);
    REQUIRE(warnings.size() == (c.warning.empty() ? 0u : 1u));
    if (!warnings.empty()) CHECK_THAT(warnings[0], Contains(c.warning));
    for (int d = 0; d < 3 && pack.cell.any(); ++d) CHECK(pack.cell.length(d) == 10);
    // Across the face they are 1 mm apart.
    CHECK(smallestGap(pack.spheres, 0, pack.cell) == Approx(pack.cell.isAlong(0) ? -1 : 7));
}
