// Requests that cannot be met: refused soon, without much memory, with what is wrong and a remedy.
#include "support/generators.h"
#include "support/limited_tool.h"
#include "support/mesh_file.h"
#include "support/temporary_folder.h"

#include <catch2/catch.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;
using test::vdbPackWithin;
using Words = std::vector<std::string>;

namespace {

constexpr unsigned kSoon = 10;  // seconds, on a busy machine; most take a twentieth
constexpr double kLittle = 1e9;

struct Request {
    const char* words;  ///< parted by blanks; @ is the test's folder
    int code;
    const char* says;
};

Words wordsOf(const std::string& line, const std::string& folder) {
    Words words;
    std::istringstream in(line);
    for (std::string word; in >> word;) {
        const auto at = word.find('@');
        if (at != std::string::npos) word.replace(at, 1, folder + '/');
        words.push_back(word);
    }
    return words;
}

void check(const std::vector<Request>& requests, const std::string& folder) {
    for (const Request& request : requests) {
        CAPTURE(request.words);
        const auto run = vdbPackWithin(kSoon, wordsOf(request.words, folder));
        CHECK(run.code == request.code);
        CHECK_THAT(run.text, Contains(request.says));
        CHECK(run.peakBytes < kLittle);
    }
}

/// A ball of triangles, one triangle alone, a needle and a plate without thickness.
void writeMeshes(const TemporaryFolder& folder) {
    test::writeObj(test::ballMesh(10, 3), folder.file("ball.obj"));
    std::ofstream(folder.file("one.obj")) << "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n";
    std::ofstream(folder.file("needle.obj"))
        << "v 0 0 0\nv 1e6 0 0\nv 0 1e-3 0\nv 0 0 1e-3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::ofstream flat(folder.file("flat.obj"));
    flat << "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nf 1 2 3\nf 1 3 4\nf 1 3 2\nf 1 4 3\n";
}

}  // namespace

TEST_CASE("radii that cannot be are refused", "[cli][bad]") {
    check({{"pack ball:9 --radius constant:0", 2, "bounds 0 and 0 must be positive and in order"},
           {"pack ball:9 --radius constant:-1", 2, "bounds -1 and -1 must be positive"},
           {"pack ball:9 --radius constant:nan", 2, "'constant:nan' is malformed; write it as"},
           {"pack ball:9 --radius constant:inf", 2, "'constant:inf' is malformed"},
           {"pack ball:9 --radius uniform:2,1", 2, "bounds 2 and 1 must be positive and in order"},
           {"pack ball:9 --radius normal:1,0.1,2,1", 2, "bounds 2 and 1"},
           {"pack ball:9 --radius normal:1,-1,1,2", 2, "the standard deviation"},
           {"pack ball:9 --radius constant:1e300", 2, "absurd; lengths are in mm"},
           {"pack ball:9 --radius 1", 2, "'1' is not known; use constant:R"},
           {"pack ball:9 --radius constant:50", 3, "no sphere of radius 50 mm or more fits"},
           {"pack ball:9 --radius uniform:0.001,1", 2, "the limit is 200: raise the smallest"}},
          "");
}

TEST_CASE("counts that cannot be are refused", "[cli][bad]") {
    check(
        {{"pack ball:9 --max-count 0", 2, "--max-count: '0' must be a whole number from 1"},
         {"pack ball:9 --max-count -1", 2, "--max-count: '-1' must be a whole number"},
         {"pack ball:9 --max-count 5.5", 2, "'5.5' must be a whole number"},
         {"pack ball:9 --max-count 99999999999999999999", 2, "must be a whole number from 1 to 9"},
         {"pack ball:9 --max-count 1e300", 2, "'1e300' must be a whole number"},
         {"pack ball:9 --target-count 0", 2, "--target-count: '0' must be a positive number"},
         {"pack ball:9 --target-count nan", 2, "'nan' must be a positive number"},
         {"pack ball:9 --target-count inf", 2, "'inf' must be a positive number"},
         {"pack ball:9 --target-count 5x", 2, "'5x' must be a positive number"},
         {"pack ball:9 --target-count 0.5", 2, "target count 0.5: must be a number of spheres"},
         {"pack ball:9 --threads 0", 2,
          "--threads: '0' must be a whole number from 1 to 4096; leave it out to use all cores"},
         {"pack ball:9 --threads -1", 2, "'-1' must be a whole number from 1 to 4096"},
         {"pack ball:9 --threads 10000", 2, "'10000' must be a whole number from 1 to 4096"},
         {"pack ball:9 --threads many", 2, "'many' must be a whole number"},
         {"pack ball:9 --seed 18446744073709551616", 2, "is no seed"},
         {"pack ball:9 --seed -1", 2, "is no seed; write a whole number from 0 on"},
         {"pack ball:9 --seed 1..18446744073709551615", 2, "more than a million seeds"},
         {"voids ball:9 --voids boolean --void-radius constant:1 --seed 18446744073709551616", 2,
          "must be a whole number from 0 to 18446744073709551615"},
         {"voids ball:9 --voids boolean --void-radius constant:1 --seed -1", 2,
          "'-1' must be a whole number"},
         {"verify p.csv --domain ball:9 --places -5", 2, "--places: '-5' must be a whole number"},
         {"verify p.csv --domain ball:9 --places 1e12", 2, "a whole number from 1 to 10000000000"},
         {"voids ball:9 --voids boolean --void-radius constant:1 --void-count 1e12", 2,
          "--void-count 1000000000000: must be a number of voids from 1 to 4e9"},
         {"voids ball:9 --voids boolean --void-radius constant:1 --void-count x", 2,
          "--void-count: 'x' is no number"}},
        "");
}

TEST_CASE("lengths and shares that cannot be are refused", "[cli][bad]") {
    const TemporaryFolder folder;
    writeMeshes(folder);
    check({{"pack ball:9 --gap -1", 2, "--gap: '-1' must be a number of 0 or more"},
           {"pack ball:9 --gap nan", 2, "'nan' must be a number of 0 or more"},
           {"pack ball:9 --radius constant:1 --gap 100", 3, "no sphere fits with a gap of 100 mm"},
           {"pack ball:9 --voxel 0", 2, "--voxel: '0' must be a positive number"},
           {"pack ball:9 --voxel inf", 2, "--voxel: 'inf' must be a positive number"},
           {"pack ball:9 --voxel 1x", 2, "--voxel: '1x' must be a positive number"},
           {"pack @ball.obj --voxel 1e300", 2, "are larger than all of it, which is 20 mm across"},
           {"pack @ball.obj --voxel 1e-6", 5, "--voxel"},
           {"pack @ball.obj --scale 0", 2, "--scale 0 must be positive"},
           {"pack @ball.obj --scale nan", 2, "--scale nan must be positive"},
           {"pack @ball.obj --scale 1e-30", 3, "too small to be computed with"},
           {"pack @ball.obj --scale 1e30", 3, "check the unit"},
           {"pack @ball.obj --shell 12", 3, "everything is cortical, the domain is 20 mm thick"},
           {"measure @ball.obj --domain @ball.obj --shell nan", 2, "'nan' must be a number"},
           {"pack ball:9 --shell 20", 3, "everything is cortical"},
           {"pack ball:9 --contact-tol 5", 2, "is not a share of a radius from 0 to 1"},
           {"pack ball:9 --density 0", 2, "--density '0': is no density"},
           {"pack ball:9 --slice z=50", 3, "the plane misses the domain, which spans z = -9 to 9"},
           {"pack ball:9 --slice z=nan", 2, "'z=nan' is malformed; write z=V"},
           {"pack ball:9 --clip plane:1,0,0,-50", 3, "nothing is left of the domain"},
           {"pack @ball.obj --clip plane:1,0,0,-50", 3, "nothing is left of the domain"},
           {"pack ball:9 --clip plane:0,0,0,1", 2, "a plane needs a finite normal"},
           {"pack ball:9 --clip plane:nan,0,0,1", 2, "is malformed; write box:"},
           {"pack ball:nan", 2, "malformed"},
           {"pack ball:-3", 2, "give a positive length in mm"},
           {"pack box:0,1,1", 2, "give finite bounds in mm"},
           {"pack ball:9 --preview p.png --preview-size 1e9x1e9", 2, "write WxH in pixels"},
           {"pack ball:9 --preview p.png --preview-size 99999x99999", 2, "16 to 16384 pixels"}},
          folder.path());
}

TEST_CASE("voids that cannot be are refused", "[cli][bad]") {
    const TemporaryFolder folder;
    writeMeshes(folder);
    std::ofstream(folder.file("thin.csv")) << "x,y,z,a,b,ux,uy,uz\n0,0,0,5,0.0001,1,0,0\n";
    std::ofstream(folder.file("control.csv"))
        << "x,y,z,a,b,ux,uy,uz\n0,0,0,\x1b[2Jtwo" << '\0' << ",0.5,1,0,0\n";
    check(
        {{"pack ball:9 --target-bvtv 0.5", 2, "--target-bvtv is given, but no voids are requested"},
         {"pack ball:9 --voids boolean --target-bvtv 2", 2, "--target-bvtv 2: must lie in (0, 1)"},
         {"pack ball:9 --voids boolean --target-bvtv nan", 2, "must lie in (0, 1)"},
         {"pack ball:9 --voids mixed --void-probability 2", 2, "must lie in [0, 1)"},
         {"pack ball:9 --voids concentric --delete-fraction 2", 2, "must lie in (0, 1]"},
         {"voids ball:9 --voids grid --void-cell 0", 2, "--void-cell 0: write the side of a box"},
         {"voids ball:9 --voids grid --void-cell 1e-9", 5, "--void-voxel"},
         {"voids ball:9 --voids list:@control.csv", 3, "?[2Jtwo"},
         {"voids ball:9 --voids list:@thin.csv", 5, "voids in voxels of 2.5e-05 mm"},
         {"pack ball:9 --radius constant:1 --voids list:@thin.csv", 5,
          "voids in voxels of 2.5e-05 mm"},
         {"pack ball:9 --radius constant:1 --voids list:@thin.csv --dry-run", 5, "--void-voxel"},
         {"voids ball:9 --voids boolean --void-radius constant:50 --void-count 2", 2,
          "are larger than the domain"},
         {"voids ball:9 --voids boolean --void-radius constant:1 --void-voxel 1e300", 2,
          "--void-voxel 1e+300: larger than the domain, which is 18 mm long"},
         {"voids ball:9 --voids boolean --void-radius constant:1 --void-count 5 --void-voxel 1e-6",
          5, "--void-voxel"}},
        folder.path());
}

TEST_CASE("meshes without an inside are refused", "[cli][bad]") {
    const TemporaryFolder folder;
    writeMeshes(folder);
    check({{"pack @one.obj", 3, "the mesh is not closed: 3 boundary edges"},
           {"pack @flat.obj", 3, "inside and outside are ambiguous"},
           {"measure @one.obj", 3, "not closed"},
           {"pack @needle.obj --target-count 200", 3, "the mesh is about 0.0002 mm thick"},
           {"voids @flat.obj --voids boolean --void-radius constant:1 --void-count 3", 3,
            "inside and outside"}},
          folder.path());
}

TEST_CASE("spheres that are too large for a thin domain are refused at once", "[cli][bad]") {
    check({{"pack box:1e12,1,1 --target-count 20", 3, "has radius 0.5 mm"},
           {"pack box:1e300,1,1 --target-count 20", 3, "has radius 0.5 mm"},
           {"pack cylinder:1e6,1e-6 --target-count 20", 3, "has radius 5e-07 mm"}},
          {});
}

TEST_CASE("devices that never end are not read", "[cli][bad]") {
    const TemporaryFolder folder;
    check({{"pack ball:9 --radius table:/dev/zero", 4, "is a device"},
           {"pack ball:9 --radius psd:/dev/zero", 4, "is a device"},
           {"pack --config /dev/zero", 2, "is a device"},
           {"verify /dev/zero.csv", 4, "cannot be read"},
           {"pack /dev/zero", 3, ""}},
          folder.path());
}

TEST_CASE("packs to go on from that are none are refused, copies are not", "[cli][bad]") {
    const TemporaryFolder folder;
    const auto put = [&](const char* name, int count, const char* id) {
        std::ofstream file(folder.file(name));
        file << "id,x,y,z,radius\n";
        for (int i = 0; i < count; ++i) file << (id ? id : std::to_string(i)) << ",0,0,0,1\n";
    };
    put("copies.csv", 1000, nullptr);
    put("heap.csv", 20000, nullptr);
    put("last.csv", 1, "9223372036854775807");
    check({{"pack box:20,20,20 --radius constant:1 --existing @copies.csv", 0, "499500"},
           {"pack box:20,20,20 --radius constant:1 --existing @heap.csv", 3,
            "pairs of its 20000 spheres overlap one another"},
           {"pack box:20,20,20 --radius constant:1 --existing @last.csv", 3,
            "leaves no numbers for what is added"},
           {"densify @last.csv --domain box:20,20,20 --densify 0.1", 3,
            "leaves no numbers for what is added"}},
          folder.path());
}

TEST_CASE("files that are empty, missing, folders or locked are distinguished", "[cli][bad]") {
    const TemporaryFolder folder;
    struct Kind {
        const char* command;    ///< what comes before the file
        const char* extension;  ///< of the file
        const char* after = "";
        const char* prefix = "";
        int empty = 3;
    };
    const std::vector<Kind> kinds{
        {"pack", "stl"},
        {"pack", "obj"},
        {"pack", "ply"},
        {"pack", "off"},
        {"mesh", "stl"},
        {"verify", "vdb"},
        {"verify", "csv"},
        {"verify", "vtp"},
        {"verify", "ply"},
        {"verify", "xyz"},
        {"verify", "npz"},
        {"verify", "data"},
        {"verify", "dump"},
        {"verify", "txt", "", "yade:"},
        {"measure", "csv"},
        {"carve", "csv", "--domain ball:9 --voids boolean"},
        {"convert", "csv", "-o @out.vtp"},
        {"pack ball:9 --existing", "csv"},
        {"pack ball:9 --radius", "txt", "", "table:"},
        {"pack ball:9 --radius", "txt", "", "psd:"},
        {"pack ball:9 --radius constant:1 --voids", "csv", "", "list:"},
        {"pack ball:9 --radius constant:1 --voids grid --void-matrix", "txt"},
        {"pack ball:9 --radius constant:1 --voids boolean --void-count 3 --void-field", "csv"}};
    const bool root = ::geteuid() == 0;  // may read anything
    for (const Kind& kind : kinds) {
        const std::string end = std::string(".") + kind.extension;
        std::ofstream(folder.file("empty" + end));
        std::ofstream(folder.file("locked" + end)) << "x";
        ::chmod(folder.file("locked" + end).c_str(), 0);
        std::filesystem::create_directories(folder.file("folder" + end));
        for (const char* state : {"empty", "folder", "missing", "locked"}) {
            if (root && std::string(state) == "locked") continue;
            const std::string line = std::string(kind.command) + ' ' + kind.prefix + '@' + state +
                                     end + ' ' + kind.after;
            CAPTURE(line);
            const auto run = vdbPackWithin(kSoon, wordsOf(line, folder.path()));
            CHECK(run.code == (std::string(state) == "empty" ? kind.empty : 4));
            CHECK_THAT(run.text, Contains(state + end));
        }
    }
    check({{"pack ball:9 --config @missing.toml", 2, "File does not exist"},
           {"pack ball:9 --config @folder.csv", 2, "is actually a directory"},
           {"pack ball:9 --radius constant:1 -o @folder.csv", 4, "is a folder; name a file"},
           {"pack ball:9 --radius constant:1 -o @none/p.csv", 4, "does not exist; create it first"},
           {"pack ball:9 --radius constant:1 --report @none/p.json", 4, "does not exist"}},
          folder.path());
}
