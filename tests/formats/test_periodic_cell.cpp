// Periodic cells in files.
#include "formats/file_text.h"
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
