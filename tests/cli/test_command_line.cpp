#include "support/test.h"
#include "support/tool.h"
#include "support/well_formed.h"

#include <cstdlib>

TEST_CASE("pack prints a summary and writes its files and report") {
    const TemporaryFolder folder;
    const auto out =
        vdbPack("pack ball:10 --radius uniform:1,2 --seed 3 -o " + folder.file("p.csv") + " -o " +
                folder.file("p.vtp") + " --report " + folder.file("p.json"));
    CAPTURE(out.text);
    REQUIRE(out.code == 0);
    CHECK_THAT(out.text, Contains("spheres") && Contains("p.csv"));
    std::ifstream file(folder.file("p.json"));
    const auto report = nlohmann::json::parse(file);
    CHECK(report["seed"] == 3);
    CHECK(report["overlap"]["pairs"] == 0);
    CHECK(report["protrusion"]["spheres"] == 0);
    CHECK(report["solidFraction"]["total"] > 0.45);
    CHECK(report["spheres"]["requested"] == "uniform:1,2");
    CHECK(report["domain"]["kind"] == "ball");
    std::ifstream csv(folder.file("p.csv"));
    std::string header;
    std::getline(csv, header);
    CHECK(header == "id,x,y,z,radius,region,order,depth,contacts");
    const auto verified = vdbPack("verify " + folder.file("p.vtp") + " --domain ball:10 --json");
    CHECK(verified.code == 0);
    CHECK(nlohmann::json::parse(verified.text)["hash"] == report["hash"]);
}

TEST_CASE("a report is a page for the browser if its name says so") {
    const TemporaryFolder folder;
    const auto pageOf = [&](const std::string& name) {
        const std::string page = contentOf(folder.file(name));
        CHECK(flawIn(page) == "");
        return page;
    };
    const std::string odd = folder.file("a <b> & 'c'.csv"), quoted = "\"" + odd + "\"";
    const auto out = vdbPack("pack ball:10 --radius uniform:1,2 -o " + quoted + " --report " +
                             folder.file("p.html"));
    CAPTURE(out.text);
    REQUIRE(out.code == 0);
    CHECK_THAT(out.text, Contains("p.html"));
    CHECK_THAT(pageOf("p.html"), Contains("ball:10") && Contains("chart-profile") &&
                                     Contains("uniform:1,2") &&
                                     Contains("a &lt;b&gt; &amp; &#39;c&#39;.csv"));
    REQUIRE(vdbPack("measure " + quoted + " --report " + folder.file("m.html")).code == 0);
    CHECK_THAT(pageOf("m.html"), Contains("&#39;c&#39;.csv") && Contains("--domain"));
    REQUIRE(vdbPack("pack rect:30,30 --radius uniform:1,2 --seed 4..5 --report " +
                    folder.file("'s{seed}.html'"))
                .code == 0);
    CHECK_THAT(pageOf("s4.html"), Contains("circles"));
    CHECK(pageOf("s5.html") != pageOf("s4.html"));
    const auto text = vdbPack("pack ball:10 --report " + folder.file("p.txt"));
    CHECK(text.code == 2);
    CHECK_THAT(text.text, Contains(".json") && Contains(".html"));
}

TEST_CASE("the command in a report can be run again") {
    const TemporaryFolder folder;
    const std::string arguments =
        "pack ball:8 --radius uniform:1,2 --seed 3 -o '" + folder.file("it'\\''s a; b.csv") + "'";
    const auto first = nlohmann::json::parse(vdbPack(arguments + " --json").text);
    const auto second = nlohmann::json::parse(vdbPack(first["command"]).text);
    CHECK(first["hash"] == second["hash"]);
    CHECK(first["command"] == second["command"]);
}

TEST_CASE("a recipe sets options and the command line wins") {
    const TemporaryFolder folder;
    std::ofstream(folder.file("r.toml")) << "radius = \"uniform:1,2\"\nseed = 9\n";
    const auto out = vdbPack("pack ball:8 --config " + folder.file("r.toml") + " --seed 4 --json");
    CAPTURE(out.text);
    REQUIRE(out.code == 0);
    const auto report = nlohmann::json::parse(out.text);
    CHECK(report["seed"] == 4);
    CHECK(report["spheres"]["requested"] == "uniform:1,2");
    std::ofstream(folder.file("bad.toml")) << "raduis = \"uniform:1,2\"\n";
    CHECK(vdbPack("pack ball:8 --config " + folder.file("bad.toml")).code == 2);
}

TEST_CASE("every kind of failure has its exit code") {
    const TemporaryFolder folder;
    CHECK(vdbPack("").code == 2);
    CHECK(vdbPack("pack").code == 2);
    CHECK(vdbPack("pack ball:8 --nonsense").code == 2);
    CHECK(vdbPack("pack ball:8 --radius uniform:2 --json").code == 2);
    CHECK(vdbPack("pack ball:8 --unit parsec").code == 2);
    CHECK(vdbPack("pack ball:8 --radius ''").code == 2);
    CHECK_THAT(vdbPack("pack ball:8 --order bogus").text,
               Contains("waves, sweep, wall, centre, center, fifo"));
    CHECK_THAT(vdbPack("pack ball:8 --unit inch").text, Contains("m, cm, mm, um"));
    CHECK(vdbPack("pack ball:8 --gap abc").text.size() < 200);
    CHECK(vdbPack("pack ball:1 --radius uniform:4,5 --json").code == 3);
    CHECK(vdbPack("pack --json " + folder.file("none.stl")).code == 4);
    CHECK(vdbPack("pack ball:8 --radius uniform:1,2 -o " + folder.file("no/p.csv")).code == 4);
    CHECK(vdbPack("pack box:1000,1000,1000 --radius uniform:0.001,0.002 --json").code == 5);
    CHECK(vdbPack("--help").code == 0);
    CHECK(vdbPack("--version").code == 0);
    std::ofstream(folder.file("p.csv")) << "x,y,z,radius\n0,0,0,1\n1,0,0,1\n";
    const auto out = vdbPack("verify " + folder.file("p.csv"));
    CHECK(out.code == 1);
    CHECK_THAT(out.text, Contains("FAILED"));
    std::ofstream(folder.file("g.csv")) << "x,y,z,radius\n0,0,0,1\n2.5,0,0,1\n";
    CHECK(vdbPack("verify " + folder.file("g.csv") + " --gap 0.4").code == 0);
    CHECK(vdbPack("verify " + folder.file("g.csv") + " --gap 0.6").code == 1);
}

TEST_CASE("a dry run tells what to expect and writes nothing") {
    const TemporaryFolder folder;
    const auto out =
        vdbPack("pack ball:10 --radius uniform:1,2 --dry-run -o " + folder.file("p.csv"));
    CHECK(out.code == 0);
    CHECK_THAT(out.text, Contains("dry run") && Contains("memory"));
    CHECK_FALSE(std::ifstream(folder.file("p.csv")).good());
    const auto json = vdbPack("pack ball:10 --radius uniform:1,2 --dry-run --json");
    CHECK(nlohmann::json::parse(json.text)["dryRun"] == true);
}

TEST_CASE("voids and carve end with the code that fits") {
    const TemporaryFolder folder;
    const std::string solid = folder.file("v.vdb"), list = folder.file("v.csv");
    const auto voids = vdbPack(
        "voids box:12,12,12 --voids boolean --void-radius uniform:0.6,1 "
        "--target-bvtv 0.3 --shell 1.5 -o " +
        solid + " -o list:" + list + " --json");
    CAPTURE(voids.text);
    REQUIRE(voids.code == 0);
    CHECK(nlohmann::json::parse(voids.text)["voids"]["bvtv"] == Approx(0.3).margin(0.005));
    std::ofstream(folder.file("p.csv")) << "x,y,z,radius\n0,0,0,1\n0.5,0,0,1\n5.5,0,0,0.4\n";
    const auto carve = [&](const std::string& options) {
        return vdbPack("carve " + folder.file("p.csv") + " --domain box:12,12,12 " + options);
    };
    const auto carved = carve("--shell 1.5 --voids list:" + list + " -o " + folder.file("c.csv"));
    CAPTURE(carved.text);
    CHECK(carved.code == 0);
    CHECK(std::ifstream(folder.file("c.csv")).good());
    CHECK(carve("--voids mixed --json").code == 2);
    CHECK(carve("--voids boolean --void-radius constant:1 --void-probability 0.2 --json").code ==
          2);
    CHECK(carve("--shell 7 --json").code == 3);
    CHECK(carve("--json --voids list:" + folder.file("none.csv")).code == 4);
    std::ofstream(folder.file("bad.csv")) << "x,y,z,a,b\n0,0,0,-1,1\n";
    CHECK(carve("--json --voids list:" + folder.file("bad.csv")).code == 3);
    const auto far = vdbPack("voids box:12,12,12 --voids grid --void-cell 2 --target-bvtv 0.1 -o " +
                             folder.file("far.vdb"));
    CHECK(far.code == 2);
    CHECK_THAT(far.text, Contains("--target-bvtv") && Contains("0.4"));
    CHECK_FALSE(std::ifstream(folder.file("far.vdb")).good());
}

TEST_CASE("another run by a recipe keeps the page and the picture of the first") {
    const TemporaryFolder folder;
    const std::string page = folder.file("p.json"), picture = folder.file("p.png"),
                      again = "pack --quiet --config " + folder.file("p.recipe.toml");
    vdbPack("pack ball:4 --radius constant:0.8 --report " + page + " --preview " + picture +
            " --preview-size 160 -o " + folder.file("p.csv"));
    const std::string first = contentOf(page), drawn = contentOf(picture);
    REQUIRE(drawn.size() > 1000);
    const std::string other = again + " --seed 7 -o " + folder.file("q.csv");
    const auto refused = vdbPack(other);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.text, Contains("p.json") && Contains("--report"));
    CHECK(vdbPack(other + " --report " + folder.file("q.json")).code == 2);
    CHECK(
        vdbPack(other + " --report " + folder.file("q.json") + " --preview " + folder.file("q.png"))
            .code == 0);
    CHECK(contentOf(folder.file("q.json")) != first);
    CHECK(contentOf(page) == first);
    CHECK(contentOf(picture) == drawn);
    CHECK(vdbPack(again).code == 0);
    std::remove(page.c_str());
    CHECK(vdbPack(other + " --preview " + folder.file("q.png")).code ==
          0);  // a template's first use
    CHECK(!contentOf(page).empty());
}

TEST_CASE("a run beside another of the same name keeps that one's recipe") {
    const TemporaryFolder folder;
    const std::string first = folder.file("p.recipe.toml"),
                      second = folder.file("p.csv.recipe.toml");
    vdbPack("pack ball:4 --radius constant:0.8 -o " + folder.file("p.vtp"));
    const std::string kept = contentOf(first);
    vdbPack("pack ball:5 --radius constant:0.8 -o " + folder.file("p.csv"));
    CHECK(contentOf(first) == kept);
    CHECK_THAT(contentOf(second), Contains("ball:5"));
    vdbPack("pack --config " + second);
    CHECK(contentOf(first) == kept);
    vdbPack("pack ball:6 --radius constant:0.8 -o " + folder.file("p.vtp"));
    CHECK_THAT(contentOf(first), Contains("ball:6"));
}
