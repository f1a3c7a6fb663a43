// Studies over options: lists of values, a table, and the numbers of solids in it.
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/io/text.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace {

/// The cells of a table under the names of its first line.
std::vector<std::map<std::string, std::string>> studyRows(const std::string& file) {
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    const auto names = splitAt(line, ',');
    std::vector<std::map<std::string, std::string>> rows;
    while (std::getline(in, line)) {
        rows.emplace_back();
        const auto cells = splitAt(line, ',');
        for (std::size_t k = 0; k < names.size(); ++k) rows.back()[names[k]] = cells.at(k);
    }
    return rows;
}

}  // namespace

TEST_CASE("a study varies options that are numbers, a run for each combination and seed") {
    const TemporaryFolder folder;
    const std::string table = folder.file("t.csv");
    const auto run = vdbPack(
        "pack box:8,8,8 --radius constant:0.5 --gap 0,0.05 --shell 1,2 --seed "
        "3,4 --table " +
        table + " -o " + folder.file("p_{gap}_{shell}_{seed}.csv"));
    REQUIRE(run.code == 0);
    CHECK_THAT(run.text, Contains("gap") && Contains("shell"));
    const auto rows = studyRows(table);
    REQUIRE(rows.size() == 8);
    std::set<std::string> files;
    for (const auto& row : rows) {
        const std::string file = folder.file("p_" + row.at("gap") + "_" + row.at("shell") + "_" +
                                             row.at("seed") + ".csv");
        CAPTURE(file);
        files.insert(file);
        CHECK_THAT(vdbPack("verify " + file).text, Contains(row.at("hash")));
        CHECK(std::stod(row.at("gap_min")) >= std::stod(row.at("gap")) - 1e-9);
    }
    CHECK(files.size() == 8);
    // The recipe of a run repeats that run alone.
    const std::string again = folder.file("p_0.05_1_4.recipe.toml");
    const auto repeated = vdbPack("pack --config " + again + " -o " + folder.file("again.csv"));
    REQUIRE(repeated.code == 0);
    for (const auto& row : rows)
        if (row.at("gap") == "0.05" && row.at("shell") == "1" && row.at("seed") == "4")
            CHECK_THAT(repeated.text, Contains(row.at("hash")));
}

TEST_CASE("lists of values are refused where runs would replace files, or no table is asked for") {
    const TemporaryFolder folder;
    const std::string pack = "pack ball:3 --radius constant:0.5 --gap 0,0.1 ";
    const auto refused = [&](const std::string& words) {
        const auto run = vdbPack(pack + words);
        CHECK(run.code == 2);
        return run.text;
    };
    CHECK_THAT(refused("--table " + folder.file("t.csv") + " -o " + folder.file("p.csv")),
               Contains("{gap}"));
    CHECK_THAT(refused("-o " + folder.file("p.csv")), Contains("--gap") && Contains("--table"));
    CHECK_THAT(refused("--dry-run --table " + folder.file("t.csv")),
               Contains("one value of --gap"));
    CHECK_THAT(vdbPack("carve " + folder.file("p.csv") + " --shell 1,2").text, Contains("1,2"));
}

TEST_CASE("the table has the numbers of each solid that was measured") {
    const TemporaryFolder folder;
    const std::string table = folder.file("t.csv"), file = folder.file("v_{target-bvtv}.vdb");
    REQUIRE(vdbPack("voids box:10,10,10 --voids boolean --void-radius constant:1 --target-bvtv "
                    "0.4,0.6 --shell 1 --measure-solid --table " +
                    table + " -o " + file)
                .code == 0);
    const auto rows = studyRows(table);
    REQUIRE(rows.size() == 2);
    for (const auto& row : rows) {
        const std::string solid = folder.file("v_" + row.at("target-bvtv") + ".vdb");
        const auto measured =
            nlohmann::json::parse(
                vdbPack("measure " + solid + " --grid solid --domain box:10,10,10 --shell 1 --json")
                    .text)
                .at("morphometry");
        const auto& core = measured.at("regions").back();
        CHECK(std::stod(row.at("bvtv")) == Approx(std::stod(row.at("target-bvtv"))).margin(0.01));
        CHECK(std::stod(row.at("tbth")) == Approx(core.at("Tb.Th").at("mean").get<double>()));
        CHECK(std::stod(row.at("tbsp")) == Approx(core.at("Tb.Sp").at("mean").get<double>()));
        CHECK(std::stod(row.at("da")) == Approx(core.at("DA").at("degree").get<double>()));
        CHECK(std::stod(row.at("connd")) == Approx(core.at("Conn.D").get<double>()));
    }
}
