// Outputs of the program where disks are full, folders are read-only and processes are killed: each
// is whole, or as it was before.
#include "support/process.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/verify/verify.h"

#include <sys/stat.h>
#include <unistd.h>

#include <random>

namespace fs = std::filesystem;

namespace {

const std::string kBall = "ball:20";

/// What `convert` writes of a pack with its domain, by the files that each output leaves.
struct Written {
    std::string output;  ///< with FOLDER for where it goes
    std::vector<std::string> files;
};
const std::vector<Written> kOutputs{
    {"FOLDER/p.vdb", {"p.vdb"}},
    {"FOLDER/p.vtp", {"p.vtp"}},
    {"FOLDER/p.pvtp", {"p.pvtp", "p_0000.vtp"}},
    {"FOLDER/p.vtkhdf", {"p.vtkhdf"}},
    {"FOLDER/p.ply", {"p.ply"}},
    {"FOLDER/p.csv", {"p.csv"}},
    {"FOLDER/p.xyz", {"p.xyz"}},
    {"FOLDER/p.npz", {"p.npz"}},
    {"FOLDER/p.data", {"p.data"}},
    {"FOLDER/p.stl", {"p.stl"}},
    {"yade:FOLDER/p.txt", {"p.txt"}},
    {"lammps-bonds:FOLDER/p.bonds", {"p.bonds"}},
    {"contacts:FOLDER/p.csv", {"p.csv"}},
    {"points:FOLDER/p.vdb", {"p.vdb"}},
    {"fog:FOLDER/p.vdb", {"p.vdb"}},
    {"levelsets:FOLDER/p.vdb", {"p.vdb"}},
    {"blender:FOLDER/p.py", {"p.py", "p.points.npz"}},
};

std::string inFolder(std::string output, const std::string& folder) {
    return output.replace(output.find("FOLDER"), 6, folder);
}

/// Whether a file is as `convert` writes it: byte for byte, or (a .vdb has a number of its own) as
/// long and with the pack that was given.
bool isWhole(const std::string& file, const std::string& reference, std::uint64_t hash) {
    const std::string content = contentOf(file), expected = contentOf(reference);
    if (content == expected) return true;
    if (file.size() < 4 || file.substr(file.size() - 4) != ".vdb") return false;
    if (content.size() != expected.size()) return false;
    try {
        return packHash(readPack(file)) == hash;
    } catch (const std::exception&) {
        return true;  // without points: the size says it
    }
}

struct Given {
    TemporaryFolder scratch;
    std::string pack = scratch.file("given.csv");
    std::uint64_t hash = 0;

    explicit Given(const std::string& domain = kBall, const std::string& radius = "uniform:1,2") {
        REQUIRE(vdbPack("pack " + domain + " --radius " + radius + " --quiet -o " + pack).code ==
                0);
        hash = packHash(readPack(pack));
        fs::create_directory(scratch.file("reference"));
        fs::create_directory(scratch.file("out"));
    }
    void clear() const {
        for (const std::string& folder : {reference(), out()}) {
            fs::remove_all(folder);
            fs::create_directory(folder);
        }
    }
    std::string reference() const { return scratch.file("reference"); }
    std::string out() const { return scratch.file("out"); }
    std::string arguments(const Written& w, const std::string& folder) const {
        return "convert " + pack + " --domain " + kBall + " -o " + inFolder(w.output, folder);
    }
};

bool isAllowed(const std::string& how) {
    if (shell(how + " true").code == 0) return true;
    WARN("skipped: '" << how << "' is not permitted here");
    return false;
}

/// As a namespace of its own, where even a user may mount.
const std::string kApart = "unshare -rm sh -c";

}  // namespace

TEST_CASE("every output survives a limit on the size of files, and its former file does") {
    const Given given;
    for (const Written& w : kOutputs) {
        given.clear();
        REQUIRE(vdbPack(given.arguments(w, given.reference())).code == 0);
        std::uintmax_t largest = 0;
        for (const auto& name : w.files)
            largest = std::max(largest, fs::file_size(given.reference() + "/" + name));
        // In units of 512 bytes, as sh counts.
        for (const std::uintmax_t limit : {std::uintmax_t{0}, largest / 1024, largest / 512 + 1}) {
            CAPTURE(w.output, largest, limit);
            for (const auto& name : w.files) putContent(given.out() + "/" + name, "former");
            const auto run = shell("ulimit -f " + std::to_string(limit) + "; " + kTool + " " +
                                   given.arguments(w, given.out()));
            CAPTURE(run.text);
            auto names = w.files;
            std::sort(names.begin(), names.end());
            CHECK(namesIn(given.out()) == names);
            const bool fits = limit > largest / 512;
            CHECK(run.code == (fits ? 0 : 4));
            const std::string main = given.out() + "/" + w.files[0];
            if (fits)
                CHECK(isWhole(main, given.reference() + "/" + w.files[0], given.hash));
            else if (w.files.size() == 1)
                CHECK(contentOf(main) == "former");
            for (const auto& name : w.files) {
                const std::string file = given.out() + "/" + name;
                CHECK((contentOf(file) == "former" ||
                       isWhole(file, given.reference() + "/" + name, given.hash)));
            }
        }
    }
}

TEST_CASE("every output survives a full disk", "[.slow]") {
    if (!isAllowed(kApart)) return;
    const Given given;
    for (const Written& w : kOutputs) {
        given.clear();
        REQUIRE(vdbPack(given.arguments(w, given.reference())).code == 0);
        std::uintmax_t all = 0;
        for (const auto& name : w.files) all += fs::file_size(given.reference() + "/" + name);
        for (const std::uintmax_t kilobytes :
             {std::uintmax_t{8}, all / 4096, all / 2048, all * 9 / 10240, 2 * all / 1024 + 100}) {
            CAPTURE(w.output, all, kilobytes);
            // The former files, then what is left after the run, are copied out of the mount.
            const std::string script =
                "mkdir -p " + given.out() + "/disk && mount -t tmpfs -o size=" +
                std::to_string(std::max<std::uintmax_t>(8, kilobytes)) + "k none " + given.out() +
                "/disk && cd " + given.out() + "/disk && for f in " +
                [&] {
                    std::string names;
                    for (const auto& name : w.files) names += name + " ";
                    return names;
                }() +
                "; do printf former > $f; done; " + kTool + " " +
                given.arguments(w, given.out() + "/disk") + "; code=$?; mkdir " + given.out() +
                "/left; cp -r . " + given.out() + "/left/; exit $code";
            fs::remove_all(given.out() + "/left");
            const auto run = shell(kApart + " '" + script + "'");
            CAPTURE(run.text);
            // 5: what is clearly too large is refused before it is begun.
            REQUIRE((run.code == 0 || run.code == 4 || run.code == 5));
            auto names = w.files;
            std::sort(names.begin(), names.end());
            CHECK(namesIn(given.out() + "/left") == names);
            for (const auto& name : w.files) {
                const std::string file = given.out() + "/left/" + name;
                const bool whole = isWhole(file, given.reference() + "/" + name, given.hash);
                CHECK((whole || (run.code != 0 && contentOf(file) == "former")));
            }
        }
    }
}

TEST_CASE("a read-only folder is reported before the work, and nothing changes") {
    if (!isAllowed(kApart)) return;
    const Given given;
    putContent(given.out() + "/p.csv", "former");
    const auto run = shell(kApart + " 'mount --bind " + given.out() + " " + given.out() +
                           " && mount -o remount,bind,ro " + given.out() + " && " + kTool +
                           " convert " + given.pack + " -o " + given.out() + "/p.csv'");
    CAPTURE(run.text);
    CHECK(run.code == 4);
    CHECK(contentOf(given.out() + "/p.csv") == "former");
    CHECK(namesIn(given.out()).size() == 1);
}

TEST_CASE("what cannot be written is reported before the work") {
    const Given given;
    fs::create_directory(given.out() + "/folder.vtp");
    REQUIRE(::mkfifo((given.out() + "/pipe.csv").c_str(), 0600) == 0);
    const std::string tooLong = given.out() + "/" + std::string(260, 'x') + ".csv";
    for (const auto& [output, message] : std::vector<std::pair<std::string, std::string>>{
             {given.out() + "/folder.vtp", "is a folder"},
             {given.out() + "/pipe.csv", "device or a pipe"},
             {"yade:/dev/full", "device or a pipe"},
             {"yade:/dev/stdout", "is a stream"},
             {"yade:/proc/self/fd/1", "is a stream"},
             {tooLong, "longer than 255 bytes"}}) {
        CAPTURE(output);
        const auto run = vdbPack("convert " + given.pack + " -o " + given.out() + "/a.csv -o " +
                                 output + " -o " + given.out() + "/b.csv");
        CHECK(run.code == 4);
        CHECK_THAT(run.text, Contains(message));
        CHECK(namesIn(given.out()).size() == 2);
    }
}

TEST_CASE("a file that standard output goes to is no output") {
    const Given given;
    const std::string file = given.out() + "/log.txt";
    putContent(file, "former\n");
    const auto run = shell("bash -c '" + kTool + " convert " + given.pack +
                           " -o yade:/dev/stdout --json >> " + file + " 2> /dev/null'");
    CHECK(run.code == 4);
    CHECK(contentOf(file) == "former\n");
}

TEST_CASE("of several outputs the first that fails ends the run, and those before it stay") {
    const Given given;
    const std::string convert = kTool + " convert " + given.pack + " -o " + given.out() +
                                "/a.npz -o " + given.out() + "/b.csv -o " + given.out() + "/c.npz";
    REQUIRE(shell(convert).code == 0);
    const std::string whole = contentOf(given.out() + "/a.npz");
    const auto limit = whole.size() / 1024 + 1;
    REQUIRE(contentOf(given.out() + "/b.csv").size() > 1024 * limit);
    for (const auto& name : namesIn(given.out())) fs::remove(given.out() + "/" + name);
    const auto run = shell("bash -c 'ulimit -f " + std::to_string(limit) + "; " + convert + "'");
    CHECK(run.code == 4);
    CHECK(contentOf(given.out() + "/a.npz") == whole);
    CHECK(namesIn(given.out()) == std::vector<std::string>{"a.npz"});
}

TEST_CASE("files that options and radii are read from are inputs as well") {
    const Given given;
    const std::string table = given.out() + "/t.csv", recipe = given.out() + "/r.json";
    putContent(table, "1 0.5\n2 0.5\n");
    putContent(recipe, "[pack]\nDOMAIN = 'ball:9'\nradius = 'constant:2'\n");
    const std::string voids = " --voids boolean --void-count 2 --void-radius ";
    for (const std::string& command :
         {"measure " + given.pack + " --radius table:" + table + " -o contacts:" + table,
          "carve " + given.pack + " --domain " + kBall + voids +
              "constant:1 --radius table:" + table + " -o " + table,
          "voids " + kBall + voids + "table:" + table + " -o list:" + table,
          "pack ball:9 --radius constant:2" + voids + "table:" + table + " -o " + table,
          "pack --config " + recipe + " -o yade:" + recipe,
          "pack --config " + recipe + " --report " + recipe,
          "pack --config " + recipe + " --seed 1,2 --table " + recipe}) {
        CAPTURE(command);
        const auto run = vdbPack(command);
        CHECK(run.code == 2);
        CHECK_THAT(run.text, Contains("input itself"));
    }
    CHECK(contentOf(table) == "1 0.5\n2 0.5\n");
    CHECK(namesIn(given.out()).size() == 2);
    CHECK(vdbPack("pack --config " + recipe + " --report " + given.out() + "/other.json").code ==
          0);
}

TEST_CASE("what a file cannot take along is reported") {
    const Given given;
    putContent(given.out() + "/i.csv", "id,x,y,z,radius\n5000000000,0,0,0,1\n7,3,0,0,1\n");
    const auto run = vdbPack("convert " + given.out() + "/i.csv -o " + given.out() + "/i.ply");
    CHECK(run.code == 0);
    CHECK_THAT(run.text, Contains("5000000000"));
    // The name of the file may be as long as names can be, that of its recipe may not.
    const std::string name = std::string(251, 'x') + ".csv";
    const auto packed = vdbPack("pack ball:9 --radius constant:2 -o " + given.out() + "/" + name);
    CHECK(packed.code == 0);
    CHECK_THAT(packed.text, Contains("no recipe"));
    CHECK(fs::exists(given.out() + "/" + name));
}

TEST_CASE("names that are no UTF-8 are reported in JSON all the same") {
    const Given given;
    const std::string name = given.out() + "/n\xff.csv";
    putContent(name, contentOf(given.pack));
    const auto run = vdbPack("measure '" + name + "' --json");
    CAPTURE(run.text);
    CHECK(run.code == 0);
    CHECK_THAT(run.text, Contains("n\xef\xbf\xbd.csv"));
}

TEST_CASE("an output that is an input or another output by any name is refused") {
    const Given given;
    const std::string before = contentOf(given.pack);
    fs::create_symlink(given.pack, given.out() + "/soft.csv");
    fs::create_hard_link(given.pack, given.out() + "/hard.csv");
    fs::create_symlink("new.csv", given.out() + "/link.csv");
    for (const std::string& name : {given.pack, given.out() + "/../given.csv",
                                    given.out() + "/soft.csv", given.out() + "/hard.csv"}) {
        CAPTURE(name);
        const auto run = vdbPack("convert " + given.pack + " -o " + name);
        CHECK(run.code == 2);
        CHECK_THAT(run.text, Contains("input itself"));
        CHECK(vdbPack("pack ball:30 --radius uniform:1,2 --existing " + given.pack + " -o " + name)
                  .code == 2);
    }
    for (const std::string& name :
         {given.out() + "/new.csv", given.out() + "/./new.csv", given.out() + "/link.csv"}) {
        CAPTURE(name);
        const auto run =
            vdbPack("convert " + given.pack + " -o " + given.out() + "/new.csv -o yade:" + name);
        CHECK(run.code == 2);
        CHECK_THAT(run.text, Contains("twice"));
    }
    CHECK(contentOf(given.pack) == before);
    CHECK(namesIn(given.out()).size() == 3);
}

TEST_CASE("a broken pipe or a full one on standard output is reported, and files are complete") {
    const Given given;
    const std::string file = given.out() + "/p.csv";
    const std::string convert = kTool + " convert " + given.pack + " -o " + file;
    CHECK(shell(convert + " > /dev/full").code == 4);
    CHECK(contentOf(file) == contentOf(given.pack));
    fs::remove(file);
    CHECK(shell("(sleep 0.2; " + convert + "; echo $? > " + given.out() + "/code) | true; sleep 1")
              .code == 0);
    for (int i = 0; i < 50 && !fs::exists(given.out() + "/code"); ++i) sleepFor(0.1);
    CHECK(contentOf(given.out() + "/code") == "4\n");
    CHECK(contentOf(file) == contentOf(given.pack));
    // Nobody who hears warnings is no reason to stop.
    CHECK(shell(convert + " --pack-unit um 2> /dev/full").code == 0);
}

TEST_CASE("a process killed at any moment of writing leaves files whole or as they were",
          "[.slow]") {
    const Given given("box:150,150,150");
    std::mt19937 random(50);
    for (const Written& w : {kOutputs[0], kOutputs[1], kOutputs[3], kOutputs[5], kOutputs[14]}) {
        const std::string arguments = given.arguments(w, given.reference());
        std::vector<std::string> words;
        std::string command = given.arguments(w, given.out());
        for (std::size_t at = 0; at != std::string::npos;) {
            const auto end = command.find(' ', at);
            words.push_back(command.substr(at, end - at));
            at = end == std::string::npos ? end : end + 1;
        }
        REQUIRE(vdbPack(arguments).code == 0);
        double longest = 0;
        {
            Process run(words);
            REQUIRE(run.wait() == 0);
            longest = run.seconds();
        }
        int killed = 0, replaced = 0;
        for (int moment = 0; moment < 50; ++moment) {
            for (const auto& name : namesIn(given.out())) fs::remove(given.out() + "/" + name);
            const bool former = moment % 2 == 0;
            if (former)
                for (const auto& name : w.files) putContent(given.out() + "/" + name, "former");
            Process run(words);
            sleepFor(std::uniform_real_distribution<double>(0.3, 1)(random) * longest);
            run.signal(SIGKILL);
            const bool ended = run.wait() == 0;
            killed += !ended;
            if (ended) longest *= 0.97;  // the first run was slower
            for (const auto& name : w.files) {
                CAPTURE(w.output, name, moment);
                const std::string file = given.out() + "/" + name;
                if (!fs::exists(file)) {
                    CHECK_FALSE(former);
                    continue;
                }
                const bool whole = isWhole(file, given.reference() + "/" + name, given.hash);
                replaced += whole;
                CHECK((whole || (former && contentOf(file) == "former")));
            }
        }
        CAPTURE(w.output, killed, replaced);
        CHECK(killed > 5);
    }
}

TEST_CASE("a run with too little memory leaves nothing half written", "[.slow]") {
    const Given given;
    const std::vector<std::string> commands{
        "pack box:60,60,60 --radius uniform:0.5,1 -o " + given.out() + "/p.vdb",
        "pack " + kMeshes + "/irregular.ply --target-count 5000 -o " + given.out() + "/p.vtp",
        "voids box:20,20,20 --voids boolean --void-radius constant:1 -o " + given.out() + "/p.vdb",
        "verify " + given.pack + " --domain " + kMeshes + "/irregular.ply",
        "measure " + given.pack + " --domain " + kBall,
        "convert " + given.pack + " --domain " + kBall + " -o " + given.out() + "/p.stl"};
    for (const std::string& command : commands) {
        int refused = 0;
        // Kilobytes of addresses: from hardly enough to start with up to enough.
        for (int limit = 120000; limit < 800000; limit = limit * 21 / 20) {
            given.clear();
            CAPTURE(command, limit);
            const auto run = shell("ulimit -v " + std::to_string(limit) + "; timeout 60 " + kTool +
                                   " --help > /dev/null 2>&1 || "
                                   "exit 99; timeout 60 " +
                                   kTool + " " + command + " --threads 2");
            if (run.code == 99) continue;  // not even the libraries could be loaded
            CAPTURE(run.text);
            refused += run.code == 5;
            // 1: what was verified lies elsewhere. A destructor of OpenVDB or TBB that gets no
            // memory ends the process: 134, or 139 where one does not check for it.
            const bool ended = run.code == 134 || run.code == 139;
            CHECK((run.code == 0 || run.code == 5 || run.code == 1 || ended));
            if (run.code == 5) CHECK_THAT(run.text, Contains("memory"));
            if (run.code == 5) CHECK(namesIn(given.out()).empty());
            if (ended)
                for (const auto& name : namesIn(given.out()))
                    CHECK_THAT(name, Contains(".tmp"));  // nothing under a final name
        }
        CAPTURE(command);
        CHECK(refused > 0);
    }
}
