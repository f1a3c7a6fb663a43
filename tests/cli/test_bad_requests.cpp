// Requests that cannot be met: refused soon, without much memory, and the message names what is
// wrong.
#include "support/generators.h"
#include "support/image_file.h"
#include "support/mesh_file.h"
#include "support/requests.h"
#include "support/test.h"

#include <sys/stat.h>
#include <unistd.h>

#include <tuple>

namespace {

/// A ball of triangles, half of one, one triangle alone or of nothing, a needle and a flat plate.
void writeMeshes(const TemporaryFolder& folder) {
    writeObj(ballMesh(10, 3), folder.file("ball.obj"));
    auto open = ballMesh(10, 3);
    open.triangles.resize(open.triangles.size() / 2);
    writeObj(open, folder.file("open.obj"));
    std::ofstream(folder.file("nan.obj")) << "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::ofstream(folder.file("one.obj")) << "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n";
    std::ofstream(folder.file("needle.obj"))
        << "v 0 0 0\nv 1e6 0 0\nv 0 1e-3 0\nv 0 0 1e-3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::ofstream flat(folder.file("flat.obj"));
    flat << "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nf 1 2 3\nf 1 3 4\nf 1 3 2\nf 1 4 3\n";
}

}  // namespace

TEST_CASE("radii that cannot be are refused") {
    check({{"pack ball:9 --radius constant:0", 2, "'constant:0'"},
           {"pack ball:9 --radius constant:-1", 2, "'constant:-1' radius -1 positive"},
           {"pack ball:9 --radius constant:nan", 2, "'constant:nan' constant:R"},
           {"pack ball:9 --radius constant:inf", 2, "'constant:inf' constant:R"},
           {"pack ball:9 --radius uniform:2,1", 2, "'uniform:2,1' smaller first"},
           {"pack ball:9 --radius normal:1,0.1,2,1", 2, "'normal:1,0.1,2,1'"},
           {"pack ball:9 --radius normal:1,-1,1,2", 2, "'normal:1,-1,1,2' deviation"},
           {"pack ball:9 --radius constant:1e300", 2, "1e+300 mm"},
           {"pack ball:9 --radius 1", 2, "--radius '1' constant:R uniform:A,B psd:FILE"},
           {"pack ball:9 --radius constant:1 --shell 2 --shell-radius 1", 2, "--shell-radius '1'"},
           {"pack ball:9 --radius constant:50", 3, "50 9 mm"},
           {"pack ball:9 --radius uniform:0.001,1", 2, "'uniform:0.001,1' 200"}},
          {});
}

TEST_CASE("counts that cannot be are refused") {
    check({{"pack ball:9 --max-count 0", 2, "--max-count '0'"},
           {"pack ball:9 --max-count -1", 2, "--max-count '-1'"},
           {"pack ball:9 --target-count 5.000", 2, "--target-count '5.000' 5000"},
           {"pack ball:9 --max-count 12.345.678", 2, "--max-count '12.345.678'"},
           {"pack ball:9 --max-count 5.5", 2, "--max-count '5.5'"},
           {"pack ball:9 --max-count 99999999999999999999", 2,
            "--max-count '99999999999999999999' 9223372036854775807"},
           {"pack ball:9 --max-count 1e300", 2, "--max-count '1e300'"},
           {"pack ball:9 --target-count 0", 2, "--target-count '0'"},
           {"pack ball:9 --target-count nan", 2, "--target-count 'nan'"},
           {"pack ball:9 --target-count inf", 2, "--target-count 'inf'"},
           {"pack ball:9 --target-count 5x", 2, "--target-count '5x'"},
           {"pack ball:9 --target-count 0.5", 2, "--target-count 0.5"},
           {"pack ball:9 --threads 0", 2, "--threads '0' 4096"},
           {"pack ball:9 --threads -1", 2, "--threads '-1' 4096"},
           {"pack ball:9 --threads 10000", 2, "--threads '10000' 4096"},
           {"pack ball:9 --threads many", 2, "--threads 'many'"},
           {"pack ball:9 --seed 18446744073709551616", 2, "--seed '18446744073709551616'"},
           {"pack ball:9 --seed -1", 2, "--seed '-1' 1..50"},
           {"pack ball:9 --seed 1..18446744073709551615", 2, "--seed '1..18446744073709551615'"},
           {"voids ball:9 --voids boolean --void-radius constant:1 --seed 18446744073709551616", 2,
            "--seed '18446744073709551616'"},
           {"voids ball:9 --voids boolean --void-radius 3 --void-count 2", 2,
            "--void-radius constant:3"},
           {"voids ball:9 --voids boolean --void-radius constant:1 --seed -1", 2, "--seed '-1'"},
           {"verify p.csv --domain ball:9 --places -5", 2, "--places '-5'"},
           {"verify p.csv --domain ball:9 --places 1e12", 2, "--places 10000000000"},
           {"voids ball:9 --voids boolean --void-radius constant:1 --void-count 1e12", 2,
            "--void-count 1000000000000 4e9"},
           {"voids ball:9 --voids boolean --void-radius constant:1 --void-count x", 2,
            "--void-count 'x'"}},
          {});
}

TEST_CASE("lengths and shares that cannot be are refused") {
    const TemporaryFolder folder;
    writeMeshes(folder);
    check(
        {{"pack ball:9 --gap -1", 2, "--gap '-1'"},
         {"pack ball:9 --gap nan", 2, "--gap 'nan'"},
         {"pack ball:9 --radius constant:1 --gap 100", 3, "gap 100"},
         {"pack ball:9 --voxel 0", 2, "--voxel '0'"},
         {"pack ball:9 --voxel inf", 2, "--voxel 'inf'"},
         {"pack ball:9 --voxel 1x", 2, "--voxel '1x'"},
         {"pack @ball.obj --voxel 1e300", 2, "@ball.obj 1e+300 20"},
         {"pack @ball.obj --voxel 1e-6", 5, "--voxel"},
         {"pack @ball.obj --scale 0", 2, "--scale 0"},
         {"pack @ball.obj --scale nan", 2, "--scale nan"},
         {"pack @ball.obj --scale 1e-30", 3, "@ball.obj --unit --scale"},
         {"pack @ball.obj --scale 1e30", 3, "@ball.obj unit"},
         {"pack @ball.obj --shell 12", 3, "--shell 12 deepest 9.9"},
         {"measure @ball.obj --domain @ball.obj --shell nan", 2, "--shell 'nan'"},
         {"pack ball:9 --shell 20", 3, "--shell 20 9"},
         {"pack ball:9 --contact-tol 5", 2, "--contact-tol 5"},
         {"pack ball:9 --density 0", 2, "--density '0' bulk:D"},
         {"pack ball:9 --slice z=50", 3, "z=50 -9 9"},
         {"pack ball:9 --slice z=nan", 2, "'z=nan' z=V"},
         {"pack ball:9 --slice x=0", 2, "--slice 'x=0' z --rotate"},
         {"pack ball:9 --clip plane:1,0,0,-50", 3, "--clip (-9, 9)"},
         {"pack @ball.obj --clip plane:1,0,0,-50", 3, "clip"},
         {"pack @ball.obj --clip plane:1,0,0,-50 --dry-run", 3, "--clip left mm;"},
         {"pack ball:9 --clip plane:0,0,0,1", 2, "clip plane:nx,ny,nz,d"},
         {"pack ball:9 --clip plane:nan,0,0,1", 2, "'plane:nan,0,0,1' plane:nx,ny,nz,d"},
         {"pack ball:nan", 2, "'ball:nan' ball:R"},
         {"pack ball:-3", 2, "ball -3"},
         {"pack cube:10", 2, "'cube:10' box:LX,LY,LZ ball:R cylinder:R,H disc:R"},
         {"pack sphere:3,4", 2, "'sphere:3,4' ball:R"},
         {"verify @p.csv --domain cube:10", 4, "@p.csv"},
         {"pack box:0,1,1", 2, "box:0,1,1 length x 0"},
         {"pack ball:9 --preview p.png --preview-size 1e9x1e9", 2, "--preview-size '1e9x1e9' WxH"},
         {"pack ball:9 --preview p.png --preview-size 99999x99999", 2,
          "--preview-size 99999x99999 16384"}},
        folder.path());
}

TEST_CASE("texts that are no numbers, and percents, are refused with what to write") {
    const TemporaryFolder folder;
    putContent(folder.file("p.csv"), "x;y;z;radius\n0,5;1;2;1\n");
    putContent(folder.file("l.csv"), "x;y;z;a;b\n0,5;1;2;1;1\n");
    putContent(folder.file("t.csv"), "radius;weight\n0,5;1\n");
    const std::string voids = "voids ball:9 --voids boolean --void-radius constant:1 ";
    check({{"verify @p.csv", 3, "@p.csv '0,5' point: 0.5"},
           {"voids ball:9 --voids list:@l.csv", 3, "@l.csv '0,5' point: 0.5"},
           {"pack ball:9 --radius table:@t.csv", 3, "@t.csv point"},
           {"pack ball:9 --contact-tol 5%", 2, "--contact-tol '5%' 0.05"},
           {voids + "--target-bvtv 30%", 2, "--target-bvtv '30%' 0.3"},
           {voids + "--target-bvtv 30", 2, "--target-bvtv 30 0.3 %"}},
          folder.path());
}

TEST_CASE("voids that cannot be are refused") {
    const TemporaryFolder folder;
    writeMeshes(folder);
    std::ofstream(folder.file("thin.csv")) << "x,y,z,a,b,ux,uy,uz\n0,0,0,5,0.0001,1,0,0\n";
    std::ofstream(folder.file("control.csv"))
        << "x,y,z,a,b,ux,uy,uz\n0,0,0,\x1b[2Jtwo" << '\0' << ",0.5,1,0,0\n";
    check(
        {{"pack ball:9 --target-bvtv 0.5", 2, "--target-bvtv --voids"},
         {"pack ball:9 --voids boolean --target-bvtv 2", 2, "--target-bvtv 2"},
         {"pack ball:9 --voids boolean --target-bvtv nan", 2, "--target-bvtv nan"},
         {"pack ball:9 --voids mixed --void-probability 2", 2, "--void-probability 2"},
         {"pack ball:9 --voids concentric --delete-fraction 2", 2, "--delete-fraction 2"},
         {"voids ball:9 --voids grid --void-cell 0", 2, "--void-cell 0 X,Y,Z"},
         {"voids ball:9 --voids grid --void-cell 1e-9", 5, "--void-voxel"},
         {"voids ball:9 --voids list:@control.csv", 3, "?[2Jtwo"},
         {"voids ball:9 --voids list:@thin.csv", 5, "--void-voxel 2.5e-05"},
         {"pack ball:9 --radius constant:1 --voids list:@thin.csv", 5, "--void-voxel 2.5e-05"},
         {"pack ball:9 --radius constant:1 --voids list:@thin.csv --dry-run", 5, "--void-voxel"},
         {"voids ball:9 --voids boolean --void-radius constant:50 --void-count 2", 2, "100 18"},
         {"voids ball:9 --voids boolean --void-radius constant:1 --void-voxel 1e300", 2,
          "--void-voxel 1e+300 18"},
         {"voids ball:9 --voids boolean --void-radius constant:1 --void-count 5 --void-voxel 1e-6",
          5, "--void-voxel"}},
        folder.path());
}

TEST_CASE("meshes without an inside are refused") {
    const TemporaryFolder folder;
    writeMeshes(folder);
    check({{"pack @one.obj", 3, "@one.obj 3 --repair"},
           {"pack @flat.obj", 3, "@flat.obj --repair"},
           {"pack @nan.obj", 3, "@nan.obj"},
           {"pack @open.obj --radius uniform:0.5,1", 3, "@open.obj vertex"},
           {"measure @one.obj", 3, "@one.obj 3 --repair"},
           {"pack @needle.obj --target-count 200", 3, "@needle.obj 0.0002"},
           {"voids @flat.obj --voids boolean --void-radius constant:1 --void-count 3", 3,
            "@flat.obj --repair"}},
          folder.path());
}

TEST_CASE("a fog volume as domain asks for a threshold and takes one") {
    const TemporaryFolder folder;
    writeObj(ballMesh(6, 2), folder.file("ball.obj"));
    const auto made = asked({"convert", folder.file("ball.obj"), "--voxel", "0.5", "-o",
                             "fog:" + folder.file("fog.vdb")});
    REQUIRE(made.code == 0);
    check({{"pack @fog.vdb --target-count 40", 3, "@fog.vdb density --threshold"},
           {"pack @fog.vdb --target-count 40 --threshold 7", 3, "@fog.vdb density --threshold 7"},
           {"pack @fog.vdb --target-count 40 --threshold 0.5", 0, "solidFraction"}},
          folder.path());
}

TEST_CASE("spheres that are too large for a thin domain are refused at once") {
    check({{"pack box:1e12,1,1 --target-count 20", 3, "0.5"},
           {"pack box:1e300,1,1 --target-count 20", 3, "0.5"},
           {"pack cylinder:1e6,1e-6 --target-count 20", 3, "5e-07"}},
          {});
}

TEST_CASE("devices that never end are not read") {
    const TemporaryFolder folder;
    check({{"pack ball:9 --radius table:/dev/zero", 4, "/dev/zero"},
           {"pack ball:9 --radius psd:/dev/zero", 4, "/dev/zero"},
           {"pack --config /dev/zero", 2, "/dev/zero"},
           {"verify /dev/zero.csv", 4, "/dev/zero.csv"},
           {"pack /dev/zero", 3, "/dev/zero"}},
          folder.path());
}

TEST_CASE("packs to go on from that are none are refused, copies are not") {
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
           {"pack box:20,20,20 --radius constant:1 --existing @heap.csv", 3, "@heap.csv 20000"},
           {"pack box:20,20,20 --radius constant:1 --existing @last.csv", 3,
            "@last.csv 9223372036854775807"},
           {"densify @last.csv --domain box:20,20,20 --densify 0.1", 3,
            "@last.csv 9223372036854775807"}},
          folder.path());
}

TEST_CASE("files that are empty, missing, folders or locked are distinguished") {
    const TemporaryFolder folder;
    const std::string pack = "pack ball:9 --radius ", voids = pack + "constant:1 --voids ";
    const bool root = ::geteuid() == 0;  // may read anything
    for (const std::string& words :
         std::vector<std::string>{"pack @.stl",
                                  "pack @.obj",
                                  "pack @.ply",
                                  "pack @.off",
                                  "pack @.vtp",
                                  "pack @.vtk",
                                  "mesh @.stl",
                                  "verify @.vdb",
                                  "verify @.csv",
                                  "verify @.vtp",
                                  "verify @.ply",
                                  "verify @.xyz",
                                  "verify @.npz",
                                  "verify @.data",
                                  "verify @.dump",
                                  "verify yade:@.txt",
                                  "measure @.csv",
                                  "carve @.csv --domain ball:9 --voids boolean",
                                  "convert @.csv -o @out.vtp",
                                  "pack ball:9 --existing @.csv",
                                  pack + "table:@.txt",
                                  pack + "psd:@.txt",
                                  voids + "list:@.csv",
                                  voids + "grid --void-matrix @.txt",
                                  voids + "boolean --void-count 3 --void-field @.csv"}) {
        const auto at = words.find("@.") + 1;
        const std::string end = words.substr(at, words.find(' ', at) - at);
        std::ofstream(folder.file("empty" + end));
        std::ofstream(folder.file("locked" + end)) << "x";
        ::chmod(folder.file("locked" + end).c_str(), 0);
        std::filesystem::create_directories(folder.file("folder" + end));
        for (const std::string state : {"empty", "folder", "missing", "locked"}) {
            if (root && state == "locked") continue;
            const std::string line = words.substr(0, at) + state + words.substr(at);
            CAPTURE(line);
            const auto run = asked(wordsIn(line, folder.path()));
            CHECK(run.code == (state == "empty" ? 3 : 4));
            CHECK_THAT(run.text, Contains(state + end));
        }
    }
}

TEST_CASE("recipes that are missing and outputs that cannot be are refused") {
    const TemporaryFolder folder;
    std::filesystem::create_directories(folder.file("folder.csv"));
    const std::string pack = "pack ball:9 --radius constant:1 -o ";
    check({{"pack ball:9 --config @missing.toml", 2, "--config @missing.toml"},
           {"pack ball:9 --config @folder.csv", 2, "--config @folder.csv"},
           {pack + "@folder.csv", 4, "@folder.csv"},
           {pack + "@none/p.csv", 4, "@none/p.csv"},
           {"pack ball:9 --radius constant:1 --report @none/p.json", 4, "@none/p.json"},
           {pack + "@p.csv -o @p.docx", 2, "@p.docx"},
           {pack + "@p.csv -o @p.svg", 2, "@p.svg"},
           {pack + "@p.csv -o @p.csv", 2, "@p.csv twice"},
           {"pack bone.xyz -o @p.csv", 3, "bone.xyz"}},
          folder.path());
}

TEST_CASE("options of all parts are refused in a part") {
    const TemporaryFolder folder;
    for (const std::string key :
         {"bond-modulus = 1e5", "interface-tol = 0.7", "bond-hinged = true", "contact-tol = 0.1",
          "out-unit = 'm'", "output = 'p.csv'", "seed = 3", "json = true", "table = 't.csv'"}) {
        CAPTURE(key);
        const std::string file = folder.file("parts.toml");
        std::ofstream(file) << "[[part]]\nname = 'a'\ndomain = 'ball:4'\n" + key + "\n";
        const auto refused = vdbPack("pack --radius constant:1 --parts " + file);
        CHECK(refused.code == 2);
        CHECK_THAT(refused.text, Contains("part 'a'") && Contains("is of all parts") &&
                                     Contains("--" + key.substr(0, key.find(' '))));
    }
}

TEST_CASE("what is wrong with the image of a part is said with the part and its file") {
    const TemporaryFolder folder;
    writeHalves(folder.file("two.nrrd"));
    const std::string file = folder.file("parts.toml");
    for (const auto& [words, code, expected] :
         {std::tuple{"label = '7'", 2, "--label 7: "},
          std::tuple{"label = '5'\ndensity = 'heavy'", 2, "'heavy'"},
          std::tuple{"label = '5'\nmodulus = '110 GPa'", 2, "'110 GPa'"},
          std::tuple{"label = '5'\nmask = '3=tow.nrrd'", 4, "two.nrrd?"},
          std::tuple{"label = '5'\nmask = '3=two.nrrd'", 2, "--mask 3="}}) {
        CAPTURE(words);
        std::ofstream(file) << "[[part]]\nname = 'low'\ndomain = 'two.nrrd'\nlabel = '9'\n"
                            << "[[part]]\nname = 'high'\ndomain = 'two.nrrd'\n"
                            << words << '\n';
        const auto refused = vdbPack("pack --radius constant:1 --quiet --json --parts " + file);
        CHECK(refused.code == code);
        CHECK_THAT(refused.text, Contains("parts.toml: part 'high': ") && Contains(expected));
    }
    // A name that is almost that of a file of options.
    const auto absent = vdbPack("pack " + folder.file("part.toml") + " --radius constant:1 --json");
    CHECK(absent.code == 4);
    CHECK_THAT(absent.text, Contains("did you mean ") && Contains("parts.toml?"));
    CHECK_THAT(vdbPack("stiffness " + folder.file("part.toml")).text, Contains("parts.toml?"));
}
