// Packs that several processes share, started by mpirun.
#include "support/process.h"
#include "support/test.h"
#include "support/tool.h"

#include <unistd.h>

#include <cstdlib>
#include <sstream>

namespace {

/// mpirun with so many processes on this machine; a process that waits for ever is ended.
std::string mpirun(int processes, const std::string& program = kTool) {
    return "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 timeout 200 mpirun "
           "--oversubscribe -n " +
           std::to_string(processes) + " " + program + " ";
}

nlohmann::json reportOf(const std::string& command, const TemporaryFolder& folder) {
    const std::string file = folder.file("report.json");
    const Output output = shell(command + " --quiet --report " + file);
    CAPTURE(command, output.text);
    REQUIRE(output.code == 0);
    return nlohmann::json::parse(contentOf(file));
}

/// Processes of vdb_pack with a text among their arguments.
std::vector<pid_t> processesWith(const std::string& text) {
    std::vector<pid_t> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
        const std::string name = entry.path().filename().string();
        if (name.find_first_not_of("0123456789") != std::string::npos) continue;
        const std::string command = contentOf("/proc/" + name + "/cmdline");
        if (command.rfind(kTool, 0) == 0 && command.find(text) != std::string::npos)
            found.push_back(std::stoi(name));
    }
    return found;
}

/// What a process has taken of processors as a user.
double secondsOf(pid_t process) {
    const std::string stat = contentOf("/proc/" + std::to_string(process) + "/stat");
    std::istringstream fields(stat.substr(std::min(stat.size(), stat.rfind(')') + 1)));
    std::string field;
    for (int k = 0; k < 12; ++k) fields >> field;
    return std::strtod(field.c_str(), nullptr) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

/// Processes, and threads of each.
using Counts = std::vector<std::pair<int, int>>;

/// @param job  arguments of `pack`; EXISTING stands for a file of spheres, FIELD for one of factors
///             on radii, MESH for a bone.
void checkAlike(std::string job, const Counts& counts) {
    const TemporaryFolder folder;
    if (const auto at = job.find("EXISTING"); at != std::string::npos) {
        const std::string file = folder.file("existing.csv");
        REQUIRE(vdbPack("pack box:60,60,40 --radius uniform:3,5 -o " + file).code == 0);
        job.replace(at, 8, file);
    }
    if (const auto at = job.find("FIELD"); at != std::string::npos) {
        putContent(folder.file("field.csv"),
                   "x,y,z,factor\n-40,-40,-40,1\n40,-40,-40,2\n-40,40,-40,1\n40,40,-40,2\n"
                   "-40,-40,40,1\n40,-40,40,2\n-40,40,40,1\n40,40,40,2\n");
        job.replace(at, 5, folder.file("field.csv"));
    }
    if (const auto at = job.find("MESH"); at != std::string::npos)
        job.replace(at, 4, kMeshes + "/femur.ply");
    job = "pack " + job + " -o " + folder.file("p.csv");
    const auto one = reportOf(kTool + " " + job, folder);
    const std::string rows = contentOf(folder.file("p.csv"));
    for (const auto& [processes, threads] : counts) {
        CAPTURE(job, processes, threads);
        const auto several =
            reportOf(mpirun(processes) + job + " --threads " + std::to_string(threads), folder);
        CHECK(several["ranks"] == processes);
        CHECK(several["hash"] == one["hash"]);
        CHECK(several["spheres"]["count"] == one["spheres"]["count"]);
        CHECK(several["spheres"]["requested"] == one["spheres"]["requested"]);
        for (const char* key :
             {"pairs", "wall", "histogram", "components", "largestComponent", "fabric", "modulus"})
            CHECK(several["contacts"][key] == one["contacts"][key]);
        CHECK(several["massOffset"] == one["massOffset"]);
        CHECK(several["overlap"] == one["overlap"]);
        CHECK(several["protrusion"] == one["protrusion"]);
        CHECK(several["voids"]["culled"] == one["voids"]["culled"]);
        if (const auto& densified = one["densified"]; !densified.is_null())
            CHECK(several["densified"]["solidLike"] == densified["solidLike"]);
        for (const auto& [key, value] : one["solidFraction"].items())
            if (value.is_number())
                CHECK(several["solidFraction"][key].get<double>() ==
                      Approx(value.get<double>()).epsilon(1e-12));
        if (!one["spheres"]["ks"].is_null())
            CHECK(several["spheres"]["ks"].get<double>() ==
                  Approx(one["spheres"]["ks"].get<double>()).margin(1e-4));
        const auto none = nlohmann::json::array();
        const auto local = several["spheres"].value("local", none),
                   alone = one["spheres"].value("local", none);
        REQUIRE(local.size() == alone.size());
        for (std::size_t g = 0; g < local.size(); ++g) {
            for (const char* key : {"name", "requested", "count", "factors"})
                CHECK(local[g][key] == alone[g][key]);
            for (const char* key : {"ks", "ksByVolume"})
                CHECK(local[g][key].get<double>() ==
                      Approx(alone[g][key].get<double>()).margin(1e-4));
        }
        CHECK(contentOf(folder.file("p.csv")) == rows);
    }
}

}  // namespace

TEST_CASE("several processes make the pack of one, and measure it alike") {
    checkAlike(
        GENERATE(as<std::string>{}, "ball:28 --radius uniform:1,2 --gap 0.05 --block-side 17",
                 "box:60,50,45 --target-count 9000 --voids boolean --void-radius constant:6 "
                 "--target-bvtv 0.5 --shell 3",
                 "box:30,28,26 --radius uniform:1,2 --densify 0.6 --gap 0.01",
                 "box:60,50,45 --radius uniform:0.6,1.2 --size-field FIELD --shell 4 "
                 "--shell-radius uniform:0.8,1 --block-side 22",
                 "box:34,30,30 --radius uniform:0.6,1.2 --size-field FIELD --densify 0.6",
                 "periodic:30,26,28 --radius uniform:1,2 --densify 0.65 --block-side 13",
                 "periodic:60,50,45 --radius uniform:1,2 --block-side 17 --voids boolean "
                 "--void-radius constant:5 --target-bvtv 0.5"),
        {{3, 2}});
}

TEST_CASE("any number of processes make the pack of one", "[.slow]") {
    checkAlike(GENERATE(as<std::string>{}, "rect:300,250 --radius uniform:1,2",
                        "box:90,80,70 --radius uniform:0.8,4",
                        "box:90,80,70 --radius uniform:1,2 --voids boolean --shell 5",
                        "box:90,80,70 --target-count 9000 --existing EXISTING --max-count 8000",
                        "box:60,50,45 --radius uniform:1,2 --densify 0.65",
                        "ball:16 --radius constant:1 --densify 0.63",
                        "rect:90,80 --radius uniform:0.5,3 --densify 0.85",
                        "box:50,45,40 --target-count 4000 --densify 0.64 --voids boolean "
                        "--void-radius constant:6",
                        "MESH --target-count 20000 --seed 3"),
               {{2, 1}, {3, 2}, {4, 1}, {8, 2}});
}

TEST_CASE("processes write the files of one") {
    const TemporaryFolder one, several;
    const auto job = [](const TemporaryFolder& folder) {
        std::string text = "pack box:70,60,50 --radius uniform:1,2 --voids boolean --shell 3";
        for (const char* name : {"p.csv", "p.data", "p.vtkhdf", "q.pvtp", "p.vdb", "p.stl"})
            text += " -o " + folder.file(name);
        return text + " -o yade:" + folder.file("p.txt") + " -o list:" + folder.file("voids.csv");
    };
    const auto alone = reportOf(kTool + " " + job(one), one);
    const auto together = reportOf(mpirun(3) + job(several), several);
    for (const char* name : {"p.csv", "p.data", "p.txt", "voids.csv", "p.stl"}) {
        CAPTURE(name);
        CHECK(contentOf(several.file(name)) == contentOf(one.file(name)));
    }
    for (const char* name : {"p.vtkhdf", "q.pvtp"}) {
        CAPTURE(name);
        const Output verified = vdbPack("verify --json " + several.file(name));
        REQUIRE(verified.code == 0);
        CHECK(nlohmann::json::parse(verified.text)["hash"] == alone["hash"]);
    }
    std::uint64_t points = 0;
    for (const std::string& name : several.names()) {
        CHECK_THAT(name, !Catch::Matchers::EndsWith(".tmp"));
        if (name.rfind("p_", 0) == 0)
            points += nlohmann::json::parse(
                          vdbPack("verify --json " + several.file(name)).text)["spheres"]["count"]
                          .get<std::uint64_t>();
    }
    CHECK(points == together["spheres"]["count"]);
}

TEST_CASE("what is not done by several processes is refused by all, once") {
    const TemporaryFolder folder;
    const std::string pack = "pack box:40,40,40 --radius uniform:1,2 -o " + folder.file("p.csv");
    for (const std::string& options :
         {pack + " --keep-connected --voids boolean", pack + " -o " + folder.file("p.npz"),
          pack + " --no-such", "verify " + folder.file("p.csv")}) {
        CAPTURE(options);
        const Output refused = shell(mpirun(3) + options);
        CHECK(refused.code == 2);
        const auto first = refused.text.find("vdb_pack: ");
        REQUIRE(first != std::string::npos);
        CHECK(refused.text.find("vdb_pack: ", first + 1) == std::string::npos);
        CHECK(folder.files() == 0);
    }
    // As of a loop over bones that was started by mpirun.
    const Output different =
        shell("tool=" + kTool + " " + mpirun(2, "sh -c") +
              "'$tool pack ball:$((5 + OMPI_COMM_WORLD_RANK)) --radius constant:1 -o " +
              folder.file("p.csv") + "'");
    CHECK(different.code == 2);
    CHECK_THAT(different.text, Contains("different arguments"));
    CHECK(folder.files() == 0);
    const Output missing = shell(mpirun(2) + "pack none.stl -o " + folder.file("p.csv"));
    CHECK(missing.code == 4);
}

TEST_CASE("where one process is killed, the others end and leave no file") {
    const double seconds = GENERATE(0.3, 1.2);
    const TemporaryFolder folder;
    const std::string job = mpirun(3) +
                            "pack box:420,420,420 --radius uniform:1,2 --threads 1 -o " +
                            folder.file("p.csv") + " -o " + folder.file("p.vtkhdf");
    Output ended{0, {}};
    std::thread running([&] { ended = shell(job); });
    for (int k = 0; processesWith(folder.file("p.csv")).size() < 3 && k < 500; ++k) sleepFor(0.02);
    sleepFor(seconds);
    const auto processes = processesWith(folder.file("p.csv"));
    REQUIRE(processes.size() == 3);
    ::kill(processes[1], SIGKILL);
    const auto killed = std::chrono::steady_clock::now();
    running.join();
    CHECK(std::chrono::steady_clock::now() - killed < std::chrono::seconds(10));
    CHECK(ended.code != 0);
    CHECK_THAT(ended.text, Contains("signal 9"));
    CHECK(processesWith(folder.file("p.csv")).empty());
    for (const std::string& name : folder.names())
        CHECK_THAT(name, Catch::Matchers::EndsWith(".tmp"));
}

TEST_CASE("processes that are asked to stop end together, with what is complete") {
    const TemporaryFolder folder;
    const std::string job = mpirun(3) +
                            "pack box:420,420,420 --radius uniform:1,2 --threads 1 -o " +
                            folder.file("p.vtkhdf");
    Output ended{0, {}};
    std::thread running([&] { ended = shell(job); });
    for (int k = 0; processesWith(folder.file("p.vtkhdf")).size() < 3 && k < 500; ++k)
        sleepFor(0.02);
    const auto processes = processesWith(folder.file("p.vtkhdf"));
    REQUIRE(processes.size() == 3);
    // Well into the packing, however busy the machine is.
    for (int k = 0; secondsOf(processes[2]) < 1.5 && k < 3000; ++k) sleepFor(0.02);
    ::kill(processes[2], SIGINT);
    running.join();
    CHECK(ended.code == 130);
    const Output verified = vdbPack("verify --json " + folder.file("p.interrupted.vtkhdf"));
    CAPTURE(ended.text, verified.text);
    REQUIRE(verified.code == 0);
    CHECK(nlohmann::json::parse(verified.text)["spheres"]["count"] > 1000);
    CHECK_FALSE(std::filesystem::exists(folder.file("p.vtkhdf")));
}
