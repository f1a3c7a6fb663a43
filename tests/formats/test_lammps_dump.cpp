// Dumps of LAMMPS and LIGGGHTS.
#include "formats/lammps_text.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/io/numbers.h"

namespace {

/// Edges of the box of a dump, upright (`tilt` 0), tilted (1) or any (2), and its text.
struct DumpBox {
    Vec<3> origin;
    std::array<Vec<3>, 3> edge;
    std::string bounds;

    DumpBox(RandomStream& random, int tilt) {
        const auto number = [&random] { return 20 * random.uniform() - 10; };
        for (int d = 0; d < 3; ++d) origin[d] = number();
        for (std::size_t i = 0; i < 3; ++i)
            for (int d = 0; d < 3; ++d) {
                const int row = static_cast<int>(i);
                if (d == row) edge[i][d] = 10 + number() / 2;
                if (d != row && (tilt == 2 || (tilt == 1 && d < row))) edge[i][d] += number() / 3;
            }
        bounds = tilt == 2 ? "abc origin" : tilt == 1 ? "xy xz yz pp pp pp" : "pp pp pp";
        // The corners of the box span its bounds.
        Vec<3> lo = origin, hi = origin;
        for (int corner = 1; corner < 8; ++corner) {
            Vec<3> x = origin;
            for (std::size_t i = 0; i < 3; ++i)
                if ((corner >> i & 1) != 0) x += edge[i];
            for (int d = 0; d < 3; ++d) {
                lo[d] = std::min(lo[d], x[d]);
                hi[d] = std::max(hi[d], x[d]);
            }
        }
        const double tilts[] = {edge[1][0], edge[2][0], edge[2][1]};
        for (int d = 0; d < 3; ++d) {
            std::vector<double> row{lo[d], hi[d]};
            if (tilt == 1) row.push_back(tilts[d]);
            const Vec<3>& e = edge[static_cast<std::size_t>(d)];
            if (tilt == 2) row = {e[0], e[1], e[2], origin[d]};
            bounds += '\n';
            for (const double value : row) appendNumber(bounds += ' ', value);
        }
    }
};

}  // namespace

TEST_CASE("a dump is read with its columns in any order") {
    for (const std::string name : {"p.dump", "p.lammpstrj"}) {
        const auto pack = readText(name, kDump);
        REQUIRE(pack.spheres == kTwo);
        REQUIRE(pack.id == std::vector<std::int64_t>{7, 4});
        REQUIRE(pack.columns.at(0).name == "type");
    }
    const auto pack = readText("p.dump", frame("z c_stress[1] diameter element y xs x",
                                               {"3 nan 1 Ca 2 0.1 1 \r", "-6 2 2 P 5 0.2 4\t"}));
    REQUIRE(pack.spheres == kTwo);
    REQUIRE(pack.columns.at(1).texts == std::vector<std::string>{"Ca", "P"});
    REQUIRE(pack.columns.at(2).name == "xs");
    REQUIRE(
        readText("p.dump", frame("id xu yu zu radius", {"0 1 2 3 0.5", "1 4 5 -6 1"})).spheres ==
        kTwo);
    // LIGGGHTS names its dumps so; the prefix says what they are.
    const TemporaryFolder scratch;
    putContent(scratch.file("dump100.liggghts"),
               replaced(kDump, "ITEM: NUMBER", "ITEM: LABEL\nx\nITEM: NUMBER"));
    REQUIRE(readPack("dump:" + (scratch.file("dump100.liggghts"))).spheres == kTwo);
    REQUIRE_THROWS_AS(readPack(scratch.file("dump100.liggghts")), ParameterError);
}

TEST_CASE("of several frames the last one is read") {
    const std::string other = frame("x y z radius", {"9 9 9 9", "8 8 8 8", "7 7 7 7"});
    REQUIRE(readText("p.dump", other + other + kDump).spheres == kTwo);
    REQUIRE(readText("p.dump", kDump + other).spheres.size() == 3);
    REQUIRE(readText("p.dump", kDump + frame("x y z radius", {})).spheres.empty());
    REQUIRE_THAT(errorOf("p.dump", other + "ITEM: TIMESTEP\n200\n"), Contains("line 13"));
    REQUIRE_THAT(errorOf("p.dump", other + kDump.substr(0, kDump.size() - 15)),
                 Contains("1 of its 2"));
}

TEST_CASE("scaled positions of a dump are those in the box") {
    const auto seed = GENERATE(range(1u, 21u));
    const int tilt = GENERATE(0, 1, 2);
    const std::string suffix = GENERATE(as<std::string>{}, "s", "su");
    CAPTURE(seed, tilt, suffix);
    RandomStream random(seed, 40);
    const DumpBox box(random, tilt);
    std::vector<std::string> rows;
    std::vector<Vec<3>> expected;
    for (int k = 0; k < 10; ++k) {
        std::string row = "0.5";
        Vec<3> x = box.origin;
        for (const Vec<3>& edge : box.edge) {
            const double share = random.uniform();
            appendNumber(row += ' ', share);
            x += share * edge;
        }
        rows.push_back(row);
        expected.push_back(x);
    }
    const auto pack = readText(
        "p.dump", frame("radius x" + suffix + " y" + suffix + " z" + suffix, rows, box.bounds));
    REQUIRE(pack.spheres.size() == expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k) {
        REQUIRE(length(pack.spheres[k].center - expected[k]) < 1e-12 * 30);
        REQUIRE(pack.spheres[k].radius == 0.5);
    }
}

TEST_CASE("unusable dumps are refused with the reason") {
    const auto error = [](const std::string& from, const std::string& to) {
        return errorOf("p.dump", replaced(kDump, from, to));
    };
    REQUIRE_THAT(errorOf("p.dump", ""), Contains("p.dump"));
    REQUIRE_THAT(errorOf("p.dump", "x,y,z,r\n"), Contains("LAMMPS"));
    REQUIRE_THAT(errorOf("p.dump",
                         "ITEM: TIMESTEP\n1\nITEM: NUMBER OF ENTRIES\n1\n"
                         "ITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n"
                         "ITEM: ENTRIES c_1[1] c_1[2]\n1 2\n"),
                 Contains("p.dump"));
    REQUIRE_THAT(error("radius", "mass"), Contains("radius or diameter") && Contains("line 9"));
    REQUIRE_THAT(error("x y z", "x y zs"), Contains("x y z"));
    REQUIRE_THAT(error("x y z", "x y x"), Contains("x y z"));
    REQUIRE_THAT(error("x y z radius", "x y z radius radius"), Contains("'radius'"));
    REQUIRE_THAT(error("ATOMS\n2", "ATOMS\n-2"), Contains("'-2'"));
    REQUIRE_THAT(error("ATOMS\n2", "ATOMS\n1"), Contains("line 11") && Contains("NUMBER OF ATOMS"));
    REQUIRE_THAT(error("ATOMS\n2", "ATOMS\n3"), Contains("2 of its 3"));
    REQUIRE_THAT(error("ATOMS\n2", "ATOMS\n9000000000000000000"), Contains("2 of its 9"));
    REQUIRE_THAT(errorOf("p.dump", replaced(kDump, "ATOMS\n2", "ATOMS\n3") + kDump),
                 Contains("line 12") && Contains("2 of 3"));
    REQUIRE_THAT(error("ITEM: NUMBER OF ATOMS\n2\n", ""), Contains("missing before"));
    REQUIRE_THAT(error("4 3 4 5 -6 1", "4 3 4 5 -6"), Contains("line 11") && Contains("5 words"));
    REQUIRE_THAT(error(" -6 ", " inf "), Contains("not finite"));
    REQUIRE_THAT(error(" -6 ", " six "), Contains("'z' is 'six'"));
    REQUIRE_THAT(error(" 0.5", " -0.5"), Contains("radius") && Contains("-0.5"));
    REQUIRE_THAT(error("-1 1\n", "-1 one\n"), Contains("'one'"));
    const auto scaled = frame("xs ys zs radius", {"0.1 0.2 0.3 1"});
    REQUIRE_THAT(errorOf("p.dump", replaced(scaled, "-1 1\n", "-1\n")), Contains("BOX BOUNDS"));
    REQUIRE_THAT(errorOf("p.dump", replaced(scaled, "-1 1\n", "-1 inf\n")), Contains("not finite"));
}

TEST_CASE("dumps are not written") {
    for (const std::string file : {"p.dump", "dump:p"}) {
        CAPTURE(file);
        REQUIRE_THROWS_WITH(checkPackFormat(file), Contains(".csv"));
    }
    REQUIRE_THROWS_WITH(readPack("p.odt"), Contains(".lammpstrj") && Contains("lammps:FILE"));
}
