// Tables of other programs.
#include "formats/file_text.h"
#include "support/test.h"

TEST_CASE("CSV columns are found by name in any order and case") {
    const auto pack = readText("p.csv",
                               "\xef\xbb\xbf Z, \"Radius\",material,X,y,Region\r\n"
                               "3,+0.5,steel,1,2,1\r\n\r\n"
                               "-6 , 1e0,\"bone, \"\"wet\"\"\",4,5.0,0\r\n"
                               "9,2,7,7,8,1.0");
    REQUIRE(pack.spheres ==
            std::vector<Sphere<3>>{{{{1, 2, 3}}, 0.5}, {{{4, 5, -6}}, 1}, {{{7, 8, 9}}, 2}});
    REQUIRE(pack.region == std::vector<std::int32_t>{1, 0, 1});
    REQUIRE(pack.columns.size() == 1);
    REQUIRE(pack.columns[0].name == "material");
    REQUIRE(pack.columns[0].numbers.empty());
    REQUIRE(pack.columns[0].texts == std::vector<std::string>{"steel", "bone, \"wet\"", "7"});
}

TEST_CASE("CSV from ParaView, with semicolons, tabs or diameters") {
    REQUIRE(
        readText("p.csv", "\"radius\",\"Points:0\",\"Points:1\",\"Points:2\"\n2,1,2,3\n").spheres ==
        std::vector<Sphere<3>>{{{{1, 2, 3}}, 2}});
    REQUIRE(readText("p.csv", "#x;y;z;diameter\n1;2;3;4\n").spheres ==
            std::vector<Sphere<3>>{{{{1, 2, 3}}, 2}});
    REQUIRE(readText("p.csv", "x\ty\tz\tr\n1\t2\t3\t2\n").spheres ==
            std::vector<Sphere<3>>{{{{1, 2, 3}}, 2}});
}

TEST_CASE("CSV is read with any separator, line end, quotes and comments") {
    const std::string separator = GENERATE(as<std::string>{}, ",", ";", "\t", " ", ", ", "  ");
    const std::string end = GENERATE(as<std::string>{}, "\n", "\r\n", "\r");
    const bool quoted = GENERATE(false, true);
    const bool mark = GENERATE(false, true);
    const std::string above = GENERATE(as<std::string>{}, "", "# a, b; c,", "sep=;");
    const bool hidden = GENERATE(false, true);
    CAPTURE(separator, end, quoted, mark, above, hidden);
    const auto row = [&](const std::vector<std::string>& cells, bool quotes) {
        std::string text;
        for (const auto& cell : cells) {
            if (!text.empty()) text += separator;
            text += quotes ? "\"" + cell + "\"" : cell;
        }
        return text + end;
    };
    std::string content = mark ? "\xef\xbb\xbf" : "";
    if (!above.empty()) content += above + end;
    content += (hidden ? "# " : "") + row({"z", "Radius", "material", "x", "Y"}, quoted);
    content += "# lengths in mm" + end;
    content += row({"3", "0.5", "7", "1", "2"}, false) + end + "#" +
               row({"9", "9", "9", "9", "9"}, false) + row({"-6", "1e0", "8", "4", "+5"}, quoted);
    const auto pack = readText("p.csv", content);
    REQUIRE(pack.spheres == std::vector<Sphere<3>>{{{{1, 2, 3}}, 0.5}, {{{4, 5, -6}}, 1}});
    REQUIRE(pack.columns.at(0).name == "material");
    REQUIRE(pack.columns[0].numbers == std::vector<double>{7, 8});
}

TEST_CASE("a CSV column may have no name, as the index that pandas writes") {
    const std::string separator = GENERATE(as<std::string>{}, ",", "\t", ";");
    CAPTURE(separator);
    const auto read = [&separator](std::string content) {
        for (std::size_t at = 0; (at = content.find('|', at)) != std::string::npos;)
            content.replace(at, 1, separator);
        return errorOf("p.csv", content).empty() ? readText("p.csv", content) : Pack<3>{};
    };
    const auto first = read("|x|y|z|radius\n5|1|2|3|4\n");
    const auto last = read("x|y|z|radius|\n1|2|3|4|5\n");
    REQUIRE(first.spheres == std::vector<Sphere<3>>{{{{1, 2, 3}}, 4}});
    REQUIRE(last.spheres == first.spheres);
    REQUIRE(first.columns.at(0).numbers == std::vector<double>{5});
    REQUIRE(last.columns.at(0).numbers == std::vector<double>{5});
    // Two columns without a name are one too many.
    REQUIRE(read("|x|y|z|radius|\n0|1|2|3|4|5\n").spheres.empty());
}

TEST_CASE("a row that may be a comment is not dropped in silence") {
    REQUIRE_THAT(errorOf("p.csv", "name,x,y,z,r\na,1,2,3,1\n#b,4,5,6,1\n"), Contains("line 3"));
    REQUIRE(readText("p.csv", "name,x,y,z,r\n# two\na,1,2,3,1\n\"#b\",4,5,6,1\n").spheres.size() ==
            2);
}

TEST_CASE("a text that looks like a number stays as it was written") {
    const auto pack = readText("p.csv", "x,y,z,r,name\n1,2,3,1,007\n1,2,9,1,1e3\n5,5,5,1,x\n");
    REQUIRE(pack.columns[0].texts == std::vector<std::string>{"007", "1e3", "x"});
}

TEST_CASE("unusable CSV is refused with line and column") {
    REQUIRE_THAT(errorOf("p.csv", ""), Contains("p.csv"));
    REQUIRE_THAT(errorOf("p.csv", "1,2,3,4\n5,6,7,8\n"), Contains("yade:FILE"));
    REQUIRE_THAT(errorOf("p.csv", "# made in 2019\n1,2,3,4\n"), Contains("line 2"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z\n1,2,3\n"), Contains("radius") && Contains("x, y, z"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,X,z,r\n"), Contains("'x'"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r\n1,2,3,1\n1,2,3\n"),
                 Contains("line 3") && Contains("3 cells"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r\n\n1,2,oops,1\n"),
                 Contains("line 3") && Contains("'z'") && Contains("'oops'"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r\n1,nan,3,1\n"), Contains("line 2"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r\n1,2,3,-1\n"), Contains("line 2") && Contains("-1"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r\n1,2,3,1e999\n"), Contains("1e999"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r,id\n1,2,3,1,1.5\n"),
                 Contains("line 2") && Contains("1.5"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r,region\n1,2,3,1,5000000000\n"), Contains("region"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r,\"n\n1,2,3,1,1\n"), Contains("quote"));
}
