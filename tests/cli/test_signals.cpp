// The program, interrupted and killed: what is complete is kept, verified, and soon.
#include "support/process.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/io/text.h"

#include <random>

namespace {

double uniform(std::mt19937& random, double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random);
}

bool isVerified(const std::string& file, const std::string& domain) {
    return vdbPack("verify " + file + " --domain " + domain).code == 0;
}

}  // namespace

TEST_CASE("an interrupt of the paper's cube stops the packing within half a second", "[.slow]") {
    const TemporaryFolder folder;
    const std::string cube = "box:370,370,370";
    std::mt19937 random(20);
    int kept = 0;
    for (int moment = 0; moment < 20; ++moment) {
        for (const auto& name : namesIn(folder.path())) std::filesystem::remove(folder.file(name));
        const double delay = uniform(random, 0.15, 3.5);
        const int number = moment % 2 == 0 ? SIGINT : SIGTERM;
        Process run({"pack", cube, "--radius", "uniform:1,2", "-o", folder.file("p.vdb"),
                     "--preview", folder.file("p.png"), "--report", folder.file("p.json")});
        sleepFor(delay);
        const double asked = run.seconds();
        run.signal(number);
        REQUIRE(run.wait() == 130);
        const double ended = run.seconds();
        const std::string reportFile = folder.file("p.interrupted.json");
        if (!std::filesystem::exists(reportFile)) {  // before the first sphere stood
            CHECK(ended - asked < 0.5);
            CHECK(namesIn(folder.path()).empty());
            continue;
        }
        nlohmann::json report;
        std::ifstream(reportFile) >> report;
        if (report["spheres"]["count"] == 0) {  // it alone tells of the run
            CHECK(namesIn(folder.path()).size() == 1);
            continue;
        }
        ++kept;
        const auto& s = report["seconds"];
        const double packed =
            s["mesh"].get<double>() + s["domain"].get<double>() + s["pack"].get<double>();
        CAPTURE(moment, delay, asked, packed, ended);
        CHECK(report["interrupted"] == true);
        CHECK(packed - asked < 0.5);
        // With checking and writing of up to two million spheres.
        CHECK(ended - asked < 5);
        CHECK(isVerified(folder.file("p.interrupted.vdb"), cube));
        CHECK(namesIn(folder.path()).size() == 3);  // and the recipe
    }
    CHECK(kept > 10);
}

TEST_CASE("a second interrupt ends the run at once and leaves no debris", "[.slow]") {
    const TemporaryFolder folder;
    std::mt19937 random(21);
    for (int moment = 0; moment < 20; ++moment) {
        Process run({"pack", "box:150,150,150", "--radius", "uniform:1,2", "-o",
                     folder.file("p.csv"), "-o", folder.file("p.vdb"), "--preview",
                     folder.file("p.png")});
        sleepFor(uniform(random, 0.05, 1));
        run.signal(SIGINT);
        sleepFor(uniform(random, 0, 0.05));
        const double asked = run.seconds();
        run.signal(SIGINT);
        CHECK(run.wait() == 130);
        CHECK(run.seconds() - asked < 1);
        for (const auto& name : namesIn(folder.path())) {
            CAPTURE(name);
            CHECK(name.find(".tmp") == std::string::npos);
            if (extensionOf(name) == ".csv" || extensionOf(name) == ".vdb")
                CHECK(isVerified(folder.file(name), "box:150,150,150"));
            std::filesystem::remove(folder.file(name));
        }
    }
}

TEST_CASE("interrupts of other commands on a bone end them at once, with nothing half written",
          "[.slow]") {
    const TemporaryFolder folder;
    const std::string bone = kMeshes + "/femur.ply", given = folder.file("given.vdb");
    REQUIRE(vdbPack("pack " + bone + " -o " + given + " --quiet").code == 0);
    std::filesystem::remove(folder.file("given.recipe.toml"));
    const std::vector<std::vector<std::string>> commands{
        {"voids", bone, "--voids", "boolean", "--void-radius", "uniform:0.5,1", "--target-bvtv",
         "0.3", "-o", folder.file("v.vdb")},
        {"carve", given, "--domain", bone, "--voids", "boolean", "--void-radius", "constant:1",
         "--target-bvtv", "0.4", "-o", folder.file("v.vdb")},
        {"pack", bone, "--target-count", "200000", "--voids", "boolean", "--void-radius",
         "constant:1", "-o", folder.file("v.vdb"), "--report", folder.file("v.html")},
        {"verify", given, "--domain", bone},
        {"measure", given, "--domain", bone, "--report", folder.file("v.html")},
        {"convert", given, "--domain", bone, "-o", folder.file("v.csv"), "-o",
         "surface:" + folder.file("v.stl"), "--preview", folder.file("v.png")}};
    std::mt19937 random(22);
    for (const auto& command : commands)
        for (int moment = 0; moment < 8; ++moment) {
            Process run(command);
            const double delay = uniform(random, 0.03, 1.5);
            sleepFor(delay);
            const double asked = run.seconds();
            const int number = moment % 2 == 0 ? SIGINT : SIGTERM;
            run.signal(number);
            const int code = run.wait();
            CAPTURE(command[0], delay, code);
            // Stopped, done, or ended before the program had begun.
            CHECK((code == 130 || code == 0 || code == 128 + number));
            CHECK(run.seconds() - asked < (command[0] == "pack" ? 3.0 : 1.0));
            for (const auto& name : namesIn(folder.path())) {
                CAPTURE(name);
                CHECK(name.find(".tmp") == std::string::npos);
                if (name == "v.vdb" && command[0] == "pack")
                    CHECK(isVerified(folder.file(name), bone));
                if (name != "given.vdb") std::filesystem::remove(folder.file(name));
            }
        }
}
