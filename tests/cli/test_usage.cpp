// The command line: help, misuse, recipes, completion, progress.
#include "cli/progress_line.h"
#include "support/requests.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/core/version.h"
#include "vdbpack/field/vdb_init.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/made_mesh.h"

#include <cstdio>
#include <iterator>

TEST_CASE("help fits the page and names every option once") {
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
    CHECK(vdbPack("help pack").text == text);
    CHECK(vdbPack("help").text == vdbPack("--help").text);
}

TEST_CASE("lines break between words, and a long word stands alone") {
    CHECK(wrapped("one two three", 80, 4, 0) == "one two three");
    CHECK(wrapped("one two three", 8, 2, 0) == "one two\n  three");
    CHECK(wrapped("one two", 8, 2, 5) == "one\n  two");
    CHECK(wrapped("a muchtoolongword b", 6, 1, 0) == "a\n muchtoolongword\n b");
    CHECK(wrapped("a\nb", 80, 2, 0) == "a\n  b");
    CHECK(wrapped("", 80, 2, 0) == "");
}

TEST_CASE("misuse is reported with what was meant") {
    struct Misuse {
        const char* arguments;
        std::vector<const char*> names;  ///< what the message must name
    };
    const std::vector<Misuse> misuses{
        {"pak ball:3", {"'pak'", "pack?"}},
        {"fill ball:3", {"'fill'", "pack, voids"}},
        {"--config r.toml", {"pack, voids"}},
        {"", {"pack, voids, carve"}},
        {"pack ball:3 --raduis constant:1", {"--raduis", "--radius?"}},
        {"pack ball:3 --raduis=constant:1", {"--raduis", "--radius?"}},
        {"verify p.csv --effort fast", {"--effort", "verify", "pack"}},
        {"pack ball:3 --effort quick", {"--effort", "'quick'", "fast, normal, dense"}},
        {"pack ball:3 --report a.json --report b.json", {"--report", "2 times"}},
        {"pack ball:3 rest", {"pack", "rest", "--parts FILE.toml"}},
        {"pack ball:3 --boundary p", {"--boundary", "periodic:LX,LY,LZ"}},
        {"pack ball:3 --material=bone", {"--material", "region", "--density"}},
        {"pack ball:3 --porosity 0.4", {"--densify F", "--target-bvtv F"}},
        {"pack ball:3 --diameter 1", {"--diameter", "--radius SPEC", "half"}},
        {"pack ball:3 --radius uniform:0,5,1", {"'uniform:0,5,1'", "uniform:A,B", "point"}},
        {"pack ball:3 --gap 0,1", {"--gap", "'0,1'", "point: 0.1"}},
        {"verify p.csv --gap 0,5", {"--gap", "'0,5'", "point: 0.5"}},
        {"measure p.csv --contact-tol 0,01", {"--contact-tol", "'0,01'", "point: 0.01"}},
        {"stiffness p.csv --bond-modulus 1,5", {"--bond-modulus", "'1,5'", "point: 1.5"}},
        {"mesh m.stl --scale 1,5", {"--scale", "'1,5'", "point: 1.5"}},
        {"mesh", {"FILE", "vdb_pack mesh --help"}}};
    for (const Misuse& misuse : misuses) {
        CAPTURE(misuse.arguments);
        const auto out = vdbPack(misuse.arguments);
        CHECK(out.code == 2);
        for (const char* name : misuse.names) CHECK_THAT(out.text, Contains(name));
    }
}

TEST_CASE("a file that is not there is reported with the one that was meant") {
    const TemporaryFolder folder;
    putContent(folder.file("femur.ply"), "");
    putContent(folder.file("p.toml"), "[[part]]\nname = 'leg'\ndomain = 'femr.ply'\n");
    for (const std::string words : {"pack @femr.ply", "pack @femur.stl", "pack @femur.nrrd",
                                    "pack --parts @femur.toml", "pack ball:9 --existing @femur.vdb",
                                    "pack ball:9 --radius uniform:1,2 --size-field @femur.csv",
                                    "pack --parts @p.toml", "pack ball:9 --config @femur.toml"}) {
        CAPTURE(words);
        const auto run = asked(wordsIn(words, folder.path()));
        CHECK(run.code == (words.find("--config") == std::string::npos ? 4 : 2));
        CHECK_THAT(run.text, Contains("did you mean ") && Contains("femur.ply?"));
    }
    CHECK_THAT(asked(wordsIn("pack --parts @p.toml", folder.path())).text,
               Contains("p.toml: part 'leg': "));
    CHECK_THAT(asked(wordsIn("pack @tibia.obj", folder.path())).text, !Contains("mean"));
}

TEST_CASE("verify says what has passed") {
    const TemporaryFolder folder;
    const std::string file = folder.file("p.csv");
    REQUIRE(vdbPack("pack ball:5 --radius constant:1 -o " + file).code == 0);
    CHECK_THAT(vdbPack("verify " + file + " --domain ball:5").text,
               Contains("passed: overlap and protrusion"));
    CHECK_THAT(vdbPack("verify " + file).text,
               Contains("passed: overlap") && Contains("protrusion is not checked"));
    CHECK_THAT(vdbPack("verify " + file + " --domain ball:4").text,
               Contains("FAILED") && !Contains("passed") && !Contains("--pack-unit"));
    CHECK_THAT(vdbPack("verify " + file + " --domain box:90,90,90,99,99,99").text,
               Contains("--unit and --pack-unit") && Contains("--space"));
}

TEST_CASE("a recipe that cannot be read is reported by line and name") {
    const TemporaryFolder folder;
    const std::string file = folder.file("r.toml");
    const auto refusal = [&](const std::string& text) {
        std::ofstream(file) << text;
        const auto out = vdbPack("pack ball:3 --dry-run --config " + file);
        CHECK(out.code == 2);
        return out.text;
    };
    CHECK_THAT(refusal("seed = 1\nraduis = \"constant:1\"\n"),
               Contains("r.toml: line 2") && Contains("'raduis'") && Contains("'radius'"));
    CHECK_THAT(refusal("[pack]\nradius = constant:1\n"), Contains("r.toml: line 2"));
    CHECK_THAT(refusal("[pick]\nseed = 1\n"), Contains("[pick]"));
    CHECK_THAT(refusal("radius = 2020-01-01\n"), Contains("line 1") && Contains("radius"));
    CHECK_THAT(refusal("effort = \"quick\"\n"), Contains("fast, normal, dense"));
    // The remedy is that of the line.
    CHECK_THAT(refusal("seed = 1\nradius = uniform:1,2 # mm\n"),
               Contains("line 2") && Contains("radius = \"uniform:1,2\""));
    for (const char* other : {"seed = 1\nseed = 2\n", "radius = \"constant:1\n",
                              "[pack\nseed = 1\n", "= 3\n", "seed = \n", "repair = true 1\n"})
        CHECK_THAT(refusal(other), Contains("line ") && !Contains("quotes"));
    CHECK_THAT(refusal("output = \"a.csv\\u0000.vdb\"\n"),
               Contains("line 1") && Contains("output") && Contains("U+0000"));
    CHECK_THAT(refusal("output = [\"b.csv\", \"a.csv\\u0000.vdb\"]\n"), Contains("U+0000"));
    // Keys and values may nest without end.
    std::string dots = "a", tables, brackets = "radius = ";
    for (int i = 0; i < 100000; ++i) {
        dots += ".a";
        tables += "[a.b.c]\n";
        brackets += i % 2 == 0 ? "[" : "{x = ";
    }
    for (const std::string& text : {dots + " = 1\n", "[" + dots + "]\n", tables, brackets})
        CHECK_THAT(refusal(text), Contains("r.toml"));
    // Those of other commands are no concern of this one.
    std::ofstream(file) << "[measure]\nshell = 2\n[pack]\nradius = \"constant:1\" # 1 mm\n";
    CHECK(vdbPack("pack ball:3 --quiet --json --config " + file).code == 0);
}

TEST_CASE("a file of parts that cannot be read is reported by line, with what to write") {
    const TemporaryFolder folder;
    const std::string file = folder.file("p.toml");
    const auto refusal = [&](const std::string& text) {
        putContent(file, text);
        return vdbPack("pack --radius constant:1 --dry-run --parts " + file).text;
    };
    CHECK_THAT(refusal("[[part]]\ndomain = \"ball:9\"\nlabel = vertebrae_L3\n"),
               Contains("p.toml: line 3") && Contains("label = \"vertebrae_L3\""));
    CHECK_THAT(refusal("[[part]]\nlabel = 49+50 # body\n"), Contains("label = \"49+50\""));
    CHECK_THAT(refusal("[part]\nname = \"a\"\n[part]\n"), Contains("[[part]]"));
    std::string dots = "a";
    for (int i = 0; i < 3000; ++i) dots += ".a";
    CHECK_THAT(refusal(dots + " = 1\n"), Contains("p.toml") && Contains("dots"));
}

TEST_CASE("progress states rate and remaining time once they can be estimated") {
    CHECK_THAT(progressLine({"pack", 0.001, 900}, 0.1), Contains("900 spheres") && !Contains("/s"));
    const std::string half = progressLine({"pack", 0.5, 1234567}, 2);
    CHECK_THAT(half, Contains("50 %") && Contains("1,234,567 spheres") && Contains("617,284/s") &&
                         Contains("0:02 left"));
    CHECK_THAT(progressLine({"domain", 0.25, 0}, 1800), Contains("1:30:00 left"));
    CHECK_THAT(progressLine({"pack", 1, 10}, 2), !Contains("left"));
}

TEST_CASE("the shell completes commands, options and their words") {
    const auto completed = [](const std::string& words, const std::string& word) {
        return shell("bash -c 'source <(" + kTool + " completion bash); COMP_WORDS=(vdb_pack " +
                     words + " \"" + word +
                     "\"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _vdb_pack; echo "
                     "\"${COMPREPLY[*]}\"'");
    };
    CHECK(completed("", "me").text == "measure mesh\n");
    CHECK(completed("pack ball:3", "--eff").text == "--effort\n");
    CHECK(completed("pack ball:3 --effort", "").text == "fast normal dense\n");
    CHECK(completed("pack ball:3 --out-unit", "m").text == "m mm\n");
    CHECK(completed("verify p.csv", "--eff").text == "\n");
    CHECK(completed("completion", "").text == "bash zsh fish\n");
    CHECK(completed("carve p.csv --voids", "b").text == "boolean\n");
    CHECK(vdbPack("completion zsh").code == 0);
    CHECK_THAT(vdbPack("completion fish").text, Contains("-l effort") && Contains("fast normal"));
    CHECK_THAT(vdbPack("completion tcsh").text, Contains("bash, zsh, fish"));
}

TEST_CASE("the version names what it is made with") {
    const auto out = vdbPack("--version");
    CHECK(out.code == 0);
    // The rest is that of no commit, or of one.
    CHECK_THAT(version(), Catch::Matches(R"(0\.[0-9.]+(\+[0-9a-f]{8,}(\.changed)?)?)"));
    CHECK_THAT(out.text, Contains(std::string("vdb_pack ") + version() + '\n') &&
                             Contains(std::string("OpenVDB ") + openVdbVersion() + ",") &&
                             Contains("TBB 20"));
}

namespace {

std::string hashOf(const Output& run) {
    return jsonOf(run)["hash"].get<std::string>();
}

}  // namespace

TEST_CASE("a run leaves the recipe that repeats it, of voids and carved packs too") {
    const TemporaryFolder folder;
    const std::string out = folder.file("a pack.csv"), recipe = folder.file("a pack.recipe.toml");
    const std::string hash = hashOf(vdbPack(
        "pack ball:8 --radius uniform:0.5,1 --clip plane:1,0,0,5 --clip plane:0,1,0,6 --shell 0.5 "
        "--voids boolean --target-bvtv .6 --void-radius constant:1 "
        "--void-angles \"tz=uniform:0,3;tx=0.2\" --seed 4 --json -o \"" +
        out + "\" -o " + folder.file("p.vdb")));
    const std::string first = contentOf(recipe);
    CHECK_THAT(first, Contains(hash) && Contains("--config \"" + recipe + "\"") &&
                          Contains("shell = 0.5") && Contains("effort = 'normal'"));
    for (const char* more : {"", " --threads 1"}) {
        std::remove(out.c_str());
        CHECK(hashOf(vdbPack("pack --json --config \"" + recipe + "\"" + more)) == hash);
        CHECK(contentOf(out).size() > 1000);
        CHECK(contentOf(recipe) == first);
    }
    const std::string list = folder.file("v.csv"), carved = folder.file("c.csv");
    vdbPack("voids ball:8 --voids boolean --void-count 40 --void-radius constant:1 -o list:" +
            list);
    const std::string before = contentOf(list);
    CHECK(vdbPack("voids --quiet --config " + folder.file("v.recipe.toml")).code == 0);
    CHECK(contentOf(list) == before);
    const std::string cut = hashOf(vdbPack(
        "carve \"" + out + "\" --domain ball:8 --voids list:" + list + " --json -o " + carved));
    CHECK(hashOf(vdbPack("carve --json --config " + folder.file("c.recipe.toml"))) == cut);
}

TEST_CASE("a repeated run that gives another pack says so") {
    const TemporaryFolder folder;
    const std::string bone = folder.file("b.stl"),
                      again = "pack --json --config " + folder.file("p.recipe.toml");
    const auto write = [&](double side) {
        writeStl(boxMesh({{{0, 0, 0}}, {{side, 6, 6}}}), bone, Unit::millimeter, "test");
    };
    write(6);
    const std::string hash = hashOf(
        vdbPack("pack " + bone + " --radius constant:0.8 --json -o " + folder.file("p.csv")));
    CHECK_THAT(vdbPack(again).text, !Contains("was repeated") && Contains(hash));
    write(6.5);
    CHECK_THAT(vdbPack(again + " --radius constant:0.9 -o " + folder.file("q.csv")).text,
               !Contains("was repeated"));
    CHECK_THAT(vdbPack(again).text, Contains(hash + ": the pack is another one"));
    CHECK_THAT(contentOf(folder.file("p.recipe.toml")), Contains("another one: " + hash));
    putContent(folder.file("parts.toml"), "[[part]]\nname = 'leg'\ndomain = 'b.stl'\n");
    vdbPack("pack --parts " + folder.file("parts.toml") + " --radius constant:0.8 -o " +
            folder.file("q.csv"));
    CHECK_THAT(contentOf(folder.file("q.recipe.toml")), Contains("\n#   name = 'leg'\n"));
}

TEST_CASE("a recipe repeats a run whatever the names of its files") {
    const TemporaryFolder folder;
    for (const std::string name :
         {"it's \"one\" \\ $HOME %s", "-\xc3\xbc \xe9\xaa\xa8 # a=b [c]", "new\nline\ttab"}) {
        CAPTURE(name);
        const std::string pack = folder.file(name + ".csv");
        std::string quoted;
        for (const char c : pack) quoted += c == '\'' ? "'\\''" : std::string(1, c);
        const std::string run = "pack ball:4 --radius constant:0.8 --json ";
        const std::string given = hashOf(vdbPack(run + "-o '" + quoted + "'"));
        const std::string content = contentOf(pack);
        REQUIRE(content.size() > 500);
        const std::string left = contentOf(folder.file(name + ".recipe.toml"));
        // As its second line says, by a shell that knows $'...'.
        const auto from = left.find("--config ");
        REQUIRE(from != std::string::npos);
        const std::string word = left.substr(from, left.find('\n', from) - from);
        std::remove(pack.c_str());
        std::ofstream(folder.file("again")) << kTool + " pack --json " << word << '\n';
        CHECK(hashOf(shell("bash " + folder.file("again"))) == given);
        CHECK(contentOf(pack) == content);
    }
    const auto bytes =
        vdbPack("pack ball:4 --radius constant:0.8 --quiet -o '" + folder.file("\xff.csv") + "'");
    CHECK(bytes.code == 0);
    CHECK_THAT(bytes.text, Contains("recipe") && Contains("UTF-8"));
    CHECK(contentOf(folder.file("\xff.recipe.toml")).empty());
}

TEST_CASE("a study leaves one recipe a seed, and nothing in place of what others wrote") {
    const TemporaryFolder folder;
    REQUIRE(vdbPack("pack ball:5 --radius constant:1 --seed 1..2 --quiet -o " +
                    folder.file("s{seed}.csv"))
                .code == 0);
    const std::string second = contentOf(folder.file("s2.csv"));
    std::remove(folder.file("s2.csv").c_str());
    REQUIRE(vdbPack("pack --quiet --config " + folder.file("s2.recipe.toml")).code == 0);
    CHECK(contentOf(folder.file("s2.csv")) == second);
    const std::string recipe = folder.file("a pack.recipe.toml");
    std::ofstream(recipe) << "# mine\n";
    const auto run =
        vdbPack("pack ball:5 --radius constant:1 --quiet -o '" + folder.file("a pack.csv") + "'");
    CHECK(run.code == 0);
    CHECK_THAT(run.text, Contains(recipe));
    CHECK(contentOf(recipe) == "# mine\n");
}

TEST_CASE("options without effect are reported") {
    CHECK_THAT(vdbPack("pack ball:5 --radius constant:1 --json --unit m").text,
               Contains("--unit has no effect"));
    CHECK_THAT(vdbPack("pack ball:5 --radius constant:1 --json --grid solid").text,
               Contains("--grid solid has no effect"));
    CHECK_THAT(vdbPack("pack ball:5 --radius constant:1 --json --voxel 0.5").text,
               Contains("--voxel 0.5 has no effect") && Contains("ball:5"));
    const TemporaryFolder folder;
    std::ofstream(folder.file("p.csv")) << "x,y,z,radius\n0,0,0,1\n2.5,0,0,1\n";
    CHECK_THAT(
        vdbPack("densify " + folder.file("p.csv") + " --domain ball:5 --json --voxel 0.5").text,
        Contains("--voxel 0.5 has no effect"));
    CHECK_THAT(vdbPack("pack ball:5 --radius constant:1 --threshold 9 --dry-run").text,
               Contains("--threshold 9 has no effect"));
    CHECK_THAT(vdbPack("pack ball:5 --radius constant:1 --json").text, !Contains("no effect"));
}

TEST_CASE("a failed check names the spheres in JSON") {
    const TemporaryFolder folder;
    std::ofstream(folder.file("p.csv")) << "x,y,z,radius\n0,0,0,1\n1.5,0,0,1\n4.5,0,0,1\n";
    const auto out = vdbPack("verify " + folder.file("p.csv") + " --domain ball:5 --json");
    CHECK(out.code == 1);
    const auto report = nlohmann::json::parse(
        out.text.substr(out.text.find('{'), out.text.rfind("\n}") + 2 - out.text.find('{')));
    CHECK(report["overlap"]["worst"].size() == 1);
    CHECK(report["overlap"]["worst"][0]["overlap"].get<double>() == Approx(0.5));
    CHECK(report["protrusion"]["worst"].size() == 1);
    CHECK(report["protrusion"]["worst"][0]["protrusion"].get<double>() == Approx(0.5));
}

TEST_CASE(
    "a run that would leave nothing is refused at once, with the command that leaves a file") {
    const TemporaryFolder folder;
    struct Run {
        std::string words;
        const char* offered;
    };
    const Run runs[] = {
        {"pack ball:300 --radius uniform:1,2 --seed 5", "-o ball.vdb"},
        {"pack ball:300 --seed 1..9", "-o ball_{seed}.vdb"},
        {"pack rect:9,9", "-o rect.csv"},
        {"pack '" + folder.file("no bone.stl") + "' --unit cm", "--unit cm -o 'no bone.vdb'"},
        {"pack " + folder.file("bone.vdb"), "-o bone_pack.vdb"},
        {"voids ball:9 --voids boolean", "-o ball_voids.vdb"},
        {"carve " + folder.file("p.csv") + " --domain ball:9 --voids boolean", "-o p_carved.vdb"},
        {"densify " + folder.file("p.csv") + " --domain ball:9", "-o p_denser.vdb"}};
    for (const Run& run : runs) {
        CAPTURE(run.words);
        const auto out = vdbPack(run.words);
        CHECK(out.code == 2);
        CHECK_THAT(out.text, Contains("vdb_pack " + run.words + " -o") && Contains(run.offered));
    }
    const std::string pack = "pack ball:4 --radius constant:1 ";
    for (const std::string& result :
         {std::string("--json"), std::string("--dry-run"), "--report " + folder.file("r.json"),
          "--preview " + folder.file("p.png"), "-o contacts:" + folder.file("c.csv"),
          "--seed 1..2 --table " + folder.file("t.csv")}) {
        CAPTURE(result);
        CHECK(vdbPack(pack + result).code == 0);
    }
}

TEST_CASE("a recipe runs from any folder") {
    const TemporaryFolder folder;
    const auto in = [&folder](const std::string& where, const std::string& command) {
        return shell("cd " + folder.file(where) + " && " + kTool + " " + command);
    };
    for (const char* name : {"given", "out", "elsewhere"})
        std::filesystem::create_directory(folder.file(name));
    std::ofstream(folder.file("given/sizes.txt")) << "1 0.5\n1.5 0.5\n";
    std::ofstream(folder.file("given/stand.csv")) << "x,y,z,radius\n0,0,0,2\n";
    std::ofstream(folder.file("given/holes.csv")) << "x,y,z,a,b\n4,0,0,1,1\n";
    vdbPack("voids ball:8 --voids boolean --void-count 1 --void-radius constant:1 -o surface:" +
            folder.file("given/ball.stl"));

    SECTION("one that somebody wrote") {
        std::ofstream(folder.file("given/r.toml"))
            << "DOMAIN = 'ball.stl'\nradius = 'table:sizes.txt'\nexisting = 'stand.csv'\n"
               "voids = 'list:holes.csv'\noutput = ['../out/p.csv', 'yade:../out/p.txt']\n";
        const std::string hash = hashOf(in("given", "pack --json --config r.toml"));
        for (const char* name : {"out/p.csv", "out/p.txt"})
            CHECK(std::filesystem::remove(folder.file(name)));
        CHECK(hashOf(in("elsewhere", "pack --json --config ../given/r.toml")) == hash);
        for (const char* name : {"out/p.csv", "out/p.txt"})
            CHECK(std::filesystem::exists(folder.file(name)));
        CHECK(std::filesystem::is_empty(folder.file("elsewhere")));
        // A name on the command line is that of the working folder.
        CHECK(hashOf(in("elsewhere", "pack --json --config ../given/r.toml -o q.csv")) == hash);
        CHECK(std::filesystem::exists(folder.file("elsewhere/q.csv")));
    }
    SECTION("the one that a run leaves") {
        const std::string run =
            "pack ball.stl --radius table:sizes.txt --existing csv:stand.csv --voids "
            "list:holes.csv --report ../out/p.json --json -o ../out/p.csv -o contacts:c.csv";
        const std::string hash = hashOf(in("given", run));
        CHECK(std::filesystem::remove(folder.file("out/p.csv")));
        CHECK(std::filesystem::remove(folder.file("given/c.csv")));
        CHECK(hashOf(in("elsewhere", "pack --json --config ../out/p.recipe.toml")) == hash);
        CHECK(std::filesystem::exists(folder.file("out/p.csv")));
        CHECK(std::filesystem::exists(folder.file("given/c.csv")));
        CHECK(std::filesystem::is_empty(folder.file("elsewhere")));
        CHECK(hashOf(in("elsewhere", "pack --json --config " + folder.file("out/p.recipe.toml"))) ==
              hash);
        // With its files, it may move.
        std::filesystem::create_directory(folder.file("elsewhere/deep"));
        for (const char* name : {"given", "out"})
            std::filesystem::rename(folder.file(name), folder.file("elsewhere/deep") + "/" + name);
        CHECK(hashOf(in("elsewhere", "pack --json --config deep/out/p.recipe.toml")) == hash);
    }
}
