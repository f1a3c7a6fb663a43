// YADE's text formats.
#include "formats/file_text.h"
#include "support/test.h"

TEST_CASE("YADE text is read with and without its format line") {
    const std::vector<Sphere<3>> spheres = {{{{1, 2, 3}}, 0.5}, {{{4, 5, 6}}, 1}};
    REQUIRE(readText("p.txt", "1 2 3 0.5\n\n4\t5  6 1").spheres == spheres);
    REQUIRE(
        readText("p.txt", "\n# made by hand\r\n1 2 3 0.5\r\n# the second\r\n4 5 6 1\r\n").spheres ==
        spheres);
    const auto pack = readText("p.txt", "#format x_y_z_r_matId\n# hello\n1 2 3 .5 4\n4 5 6 1 0\n");
    REQUIRE(pack.spheres == spheres);
    REQUIRE(pack.region == std::vector<std::int32_t>{4, 0});
    REQUIRE(readText("p.txt", "").spheres.empty());
    REQUIRE_THAT(errorOf("p.txt", "#format x1_y1_z1_x2_y2_z2_x3_y3_z3\n"), Contains("x1_y1_z1"));
    REQUIRE_THAT(errorOf("p.txt", "#format x_y_z_r_mass\n"), Contains("x_y_z_r_mass"));
    REQUIRE_THAT(errorOf("p.txt", "#format\n1 2 3 4\n"), Contains("''"));
    REQUIRE_THAT(errorOf("p.txt", "1 2 3 4\n#format x_y_z_r\n"), Contains("line 2"));
    REQUIRE_THAT(errorOf("p.txt", "1 2 3 4\n1 2 3 4 5\n"),
                 Contains("line 2") && Contains("5 words"));
    REQUIRE_THAT(errorOf("p.txt", "1 2 3 4\n1 2 x 4\n"), Contains("line 2") && Contains("'x'"));
    REQUIRE_THAT(errorOf("p.txt", "# unit of length: furlong\n1 2 3 4\n"), Contains("furlong"));
    REQUIRE_THAT(errorOf("p.txt", "1 2 nan 4\n"), Contains("line 1"));
}

TEST_CASE("every format of YADE's textExt and textClumps is read") {
    const std::vector<Sphere<3>> spheres = {{{{1e-05, -2, 3}}, 0.5}, {{{4, 5, 6}}, 1}};
    const auto ids = readText("p.txt",
                              "#format id_x_y_z_r_matId\n7\t1e-05\t-2\t3\t0.5\t2\n"
                              "9\t4\t5\t6\t1\t0\n");
    REQUIRE(ids.spheres == spheres);
    REQUIRE(ids.id == std::vector<std::int64_t>{7, 9});
    REQUIRE(ids.region == std::vector<std::int32_t>{2, 0});

    const auto clumps = readText("p.txt",
                                 "#format x_y_z_r_clumpId\n1e-05\t-2\t3\t0.5\t12\n"
                                 "4\t5\t6\t1\t12\n");
    REQUIRE(clumps.spheres == spheres);
    REQUIRE(clumps.columns.at(0).name == "clumpId");
    REQUIRE(clumps.columns[0].numbers == std::vector<double>{12, 12});

    const std::string rows = "1e-05\t-2\t3\t0.5\t7.5\tbone\n4\t5\t6\t1\t8\t1\n";
    const auto named = readText("p.txt", "#format x_y_z_r_attrs\n# x y z r distance kind\n" + rows);
    REQUIRE(named.spheres == spheres);
    REQUIRE(named.columns.at(0).name == "distance");
    REQUIRE(named.columns[0].numbers == std::vector<double>{7.5, 8});
    REQUIRE(named.columns.at(1).name == "kind");
    REQUIRE(named.columns[1].texts == std::vector<std::string>{"bone", "1"});

    const auto unnamed = readText("p.txt", "#format x_y_z_r_attrs\n# of a run\n" + rows);
    REQUIRE(unnamed.spheres == spheres);
    REQUIRE(unnamed.columns.at(1).name == "attribute2");
    REQUIRE_THAT(errorOf("p.txt", "#format x_y_z_r_attrs\n1 2 3 4 5\n1 2 3 4\n"),
                 Contains("line 3") && Contains("4 words"));
}
