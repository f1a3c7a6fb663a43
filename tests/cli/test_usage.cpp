// What the command line says and understands, by its parts.
#include "cli/help.h"
#include "cli/progress_line.h"
#include "cli/suggest.h"
#include "support/temporary_folder.h"
#include "support/tool.h"

#include <catch2/catch.hpp>

#include <fstream>
#include <sstream>

using Catch::Matchers::Contains;
using vdbpack::test::vdbPack;

TEST_CASE("help fits the page and names every option once", "[cli]") {
    for (const char* command : {"", "pack", "voids", "carve", "verify", "measure", "mesh"}) {
        CAPTURE(command);
        const auto help = vdbPack(std::string(command) + " --help");
        REQUIRE(help.code == 0);
        std::istringstream lines(help.text);
        for (std::string line; std::getline(lines, line);) {
            CAPTURE(line);
            CHECK(line.size() <= 80);
            CHECK_THAT(line, !Contains("\x1b"));
        }
    }
    const std::string text = vdbPack("pack --help").text;
    CHECK(text.find("\nUnits\n") < text.find("\nSpheres\n"));
    CHECK(text.find("\nSpheres\n") < text.find("\nVoids\n"));
    const auto first = text.find("--radius");
    CHECK(text.find("\n  --radius", first + 1) == std::string::npos);
}

TEST_CASE("lines break between words, and a long word stands alone", "[cli]") {
    CHECK(wrapped("one two three", 80, 4, 0) == "one two three");
    CHECK(wrapped("one two three", 8, 2, 0) == "one two\n  three");
    CHECK(wrapped("one two", 8, 2, 5) == "one\n  two");
    CHECK(wrapped("a muchtoolongword b", 6, 1, 0) == "a\n muchtoolongword\n b");
    CHECK(wrapped("a\nb", 80, 2, 0) == "a\n  b");
    CHECK(wrapped("", 80, 2, 0) == "");
}

TEST_CASE("distances of words are those of their letters", "[cli]") {
    CHECK(editDistance("", "") == 0);
    CHECK(editDistance("", "abc") == 3);
    CHECK(editDistance("radius", "radius") == 0);
    CHECK(editDistance("raduis", "radius") == 1);  // neighbors swapped
    CHECK(editDistance("kitten", "sitting") == 3);
    CHECK(editDistance("sitting", "kitten") == 3);
    CHECK(mostLike("--raduis", {"--seed", "--radius"}) == "--radius");
    CHECK(mostLike("--vox", {"--seed", "--voxel"}) == "--voxel");
    CHECK(mostLike("--thickness", {"--seed", "--radius"}) == "");
}

TEST_CASE("misuse is told with what was meant", "[cli]") {
    const auto told = [](const std::string& arguments) {
        const auto out = vdbPack(arguments);
        CHECK(out.code == 2);
        return out.text;
    };
    CHECK_THAT(told("pak ball:3"), Contains("'pak' is no command; did you mean pack?"));
    CHECK_THAT(told("fill ball:3"), Contains("'fill' is no command; there are pack, voids"));
    CHECK_THAT(told(""), Contains("say what to do: pack, voids, carve"));
    CHECK_THAT(told("pack ball:3 --raduis constant:1"), Contains("did you mean --radius?"));
    CHECK_THAT(told("pack ball:3 --raduis=constant:1"), Contains("did you mean --radius?"));
    CHECK_THAT(told("verify p.csv --effort fast"), Contains("no option of verify, but of pack"));
    CHECK_THAT(told("pack ball:3 --effort quick"),
               Contains("'quick' is none of fast, normal, dense"));
    CHECK_THAT(told("pack ball:3 --report a.json --report b.json"),
               Contains("--report is given 2 times, but takes one value"));
    CHECK_THAT(told("pack ball:3 rest"), Contains("pack has no use for rest"));
    CHECK_THAT(told("mesh"), Contains("FILE is required") && Contains("vdb_pack mesh --help"));
}

TEST_CASE("a recipe that cannot be read is told by line and name", "[cli]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("r.toml");
    const auto told = [&](const std::string& text) {
        std::ofstream(file) << text;
        const auto out = vdbPack("pack ball:3 --dry-run --config " + file);
        CHECK(out.code == 2);
        return out.text;
    };
    CHECK_THAT(told("seed = 1\nraduis = \"constant:1\"\n"),
               Contains("r.toml: line 2: 'raduis' is no option of pack; did you mean 'radius'?"));
    CHECK_THAT(told("[pack]\nradius = constant:1\n"),
               Contains("r.toml: line 2") && Contains("texts stand in quotes"));
    CHECK_THAT(told("[pick]\nseed = 1\n"), Contains("[pick] is no command"));
    CHECK_THAT(told("radius = 2020-01-01\n"), Contains("line 1") && Contains("radius"));
    CHECK_THAT(told("effort = \"quick\"\n"), Contains("none of fast, normal, dense"));
    // Those of other commands are no concern of this one.
    std::ofstream(file) << "[measure]\nshell = 2\n[pack]\nradius = \"constant:1\" # 1 mm\n";
    CHECK(vdbPack("pack ball:3 --quiet --config " + file).code == 0);
}

TEST_CASE("progress tells rate and time left once there is something to tell", "[cli]") {
    CHECK_THAT(progressLine({"pack", 0.001, 900}, 0.1), Contains("900 spheres") && !Contains("/s"));
    const std::string half = progressLine({"pack", 0.5, 1234567}, 2);
    CHECK_THAT(half, Contains("50 %") && Contains("1,234,567 spheres") && Contains("617,284/s") &&
                         Contains("0:02 left"));
    CHECK_THAT(progressLine({"domain", 0.25, 0}, 1800), Contains("1:30:00 left"));
    CHECK_THAT(progressLine({"pack", 1, 10}, 2), !Contains("left"));
}

TEST_CASE("the shell completes commands, options and their words", "[cli]") {
    const auto completed = [](const std::string& words, const std::string& word) {
        return vdbpack::test::shell("bash -c 'source <(" + std::string(VDBPACK_TOOL) +
                                    " completion bash); COMP_WORDS=(vdb_pack " + words + " \"" +
                                    word +
                                    "\"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _vdb_pack; echo "
                                    "\"${COMPREPLY[*]}\"'");
    };
    CHECK(completed("", "me").text == "measure mesh\n");
    CHECK(completed("pack ball:3", "--eff").text == "--effort\n");
    CHECK(completed("pack ball:3 --effort", "").text == "fast normal dense\n");
    CHECK(completed("pack ball:3 --out-unit", "m").text == "m mm\n");
    CHECK(completed("verify p.csv", "--eff").text == "\n");
    CHECK(vdbPack("completion zsh").code == 0);
    CHECK_THAT(vdbPack("completion fish").text, Contains("-l effort") && Contains("fast normal"));
    CHECK_THAT(vdbPack("completion tcsh").text, Contains("none of bash, zsh, fish"));
}

TEST_CASE("the version names what it is made with", "[cli]") {
    const auto out = vdbPack("--version");
    CHECK(out.code == 0);
    CHECK_THAT(out.text, Contains("vdb_pack 0.") && Contains("OpenVDB 10.") && Contains("TBB 20"));
}
