// What a new user meets: the program without words, the demo, manual pages.
#include "cli/first_steps.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/options/command_line.h"

#include <variant>

TEST_CASE("without words a terminal is shown commands that can be run") {
    const auto shown = shell("TERM=dumb script -qec '" + kTool + "' /dev/null");
    CHECK(shown.code == 0);
    for (const FirstStep& step : firstSteps()) {
        CHECK_THAT(shown.text, Contains(kTool + " " + step.words));
        const auto words = wordsOf(step.words);
        if (words.front() == "demo") continue;
        CAPTURE(step.words);
        CHECK(std::holds_alternative<vdbpack::PackJob>(vdbpack::jobOf(words)));
    }
    const auto elsewhere = vdbPack("");
    CHECK(elsewhere.code == 2);
    CHECK_THAT(elsewhere.text, Contains("--help"));
}

TEST_CASE("the demo packs the bundled femur into a folder that it makes") {
    const TemporaryFolder scratch;
    const std::string folder = scratch.file("a/b");
    const PackJob job = demoJob(folder);
    CHECK(std::filesystem::is_directory(folder));
    CHECK(std::filesystem::is_regular_file(job.domain.source));
    CHECK(job.preview.file == folder + "/femur.png");
    // The files that it tells how to open are those that it writes.
    const std::string text = demoText(folder, "vdb_pack");
    for (const char* file : {"femur.vdb", "femur.vtp", "femur.csv", "femur.py"})
        CHECK_THAT(text, Contains(folder + "/" + file));
    putContent(scratch.file("file"), "");
    CHECK_THAT(vdbPack("demo " + scratch.file("file")).text, Contains(scratch.file("file")));
    CHECK(vdbPack("demo " + scratch.file("file")).code == 4);
}

TEST_CASE("the demo ends with a picture", "[.slow]") {
    const TemporaryFolder scratch;
    const auto out = vdbPack("demo " + scratch.file("out"));
    CHECK(out.code == 0);
    CHECK(contentOf(scratch.file("out/femur.png")).substr(1, 3) == "PNG");
    CHECK_THAT(out.text, Contains("Picture    " + scratch.file("out/femur.png")));
}

TEST_CASE("manual pages have every command and every option") {
    const TemporaryFolder scratch;
    REQUIRE(vdbPack("--man-pages " + scratch.file("man")).code == 0);
    const std::string program = contentOf(scratch.file("man/vdb_pack.1"));
    CHECK_THAT(program, Contains("\n.SH NAME\nvdb_pack \\- "));
    std::size_t pages = 0;
    for (const auto& entry : std::filesystem::directory_iterator(scratch.file("man"))) {
        const std::string name = entry.path().stem().string();
        ++pages;
        if (name == "vdb_pack") continue;
        const std::string command = name.substr(std::string("vdb_pack-").size());
        CAPTURE(command);
        CHECK_THAT(program, Contains("\\fB" + command + "\\fR"));
        const std::string page = contentOf(entry.path().string());
        std::istringstream help(vdbPack(command + " --help").text);
        for (std::string line; std::getline(help, line);) {
            const auto words = wordsOf(line);
            if (line.rfind("  --", 0) != 0 || words.empty()) continue;
            std::string option = words.front();
            for (std::size_t at = 0; (at = option.find('-', at)) != std::string::npos; at += 2)
                option.insert(at, 1, '\\');
            CAPTURE(option);
            CHECK_THAT(page, Contains("\n\\fB" + option + "\\fR"));
        }
    }
    std::size_t named = 0;
    for (std::size_t at = 0; (at = program.find(".BR vdb_pack", at)) != std::string::npos; ++at)
        ++named;
    CHECK(pages == named + 1);
}
