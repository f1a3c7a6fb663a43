// Requests for voids that cannot be met, and leave nothing behind.
#include "support/requests.h"
#include "support/test.h"

namespace {

/// Words of voids after a box of 24 mm.
void checkVoids(std::vector<Request> requests, const std::string& folder) {
    for (Request& request : requests)
        request.words = "pack box:24,24,24 --radius uniform:0.5,1 -o @out.csv " + request.words;
    check(requests, folder);
}

}  // namespace

TEST_CASE("voids that need the front, or spheres, are refused where there are none") {
    const TemporaryFolder folder;
    putContent(folder.file("p.csv"), "x,y,z,radius\n0,0,0,1\n");
    check({{"carve @p.csv --domain ball:9 --voids mixed -o @c.csv", 2, "mixed"},
           {"carve @p.csv --domain ball:9 --voids ellipses -o @c.csv", 2, "ellipses"},
           {"voids ball:9 --voids mixed -o @v.vdb", 2, "mixed"},
           {"voids ball:9 --voids ellipses -o @v.vdb", 2, "ellipses"},
           {"voids ball:9 --voids threshold --delete-fraction 0.3", 2, "threshold"},
           {"voids ball:9 -o @v.vdb", 2, "--voids"},
           {"carve @p.csv --domain ball:9", 2, "--voids"},
           {"carve @p.csv --voids threshold --delete-fraction 0.3", 2, "--domain"},
           {"pack ball:8 --radius uniform:0.5,1 --fill solid", 2, "--fill"},
           {"pack ball:8 --radius uniform:0.5,1 --fill solid --voids mixed", 2, "--fill mixed"},
           {"pack disc:8 --radius uniform:0.5,1 --fill solid --voids boolean", 2, "--fill"},
           {"pack ball:6 --radius uniform:0.5,1 --voids boolean --void-radius constant:2 "
            "--void-count 3000",
            2, "boolean 0.0000"},
           {"pack ball:10 --shell-from outer --voids mixed --shell 2", 2, "--shell-from"}},
          folder.path());
}

TEST_CASE("values of voids out of range are refused") {
    const TemporaryFolder folder;
    std::vector<Request> requests{
        {"--voids ellipses --void-probability 1", 2, "--void-probability 1"},
        {"--voids boolean --void-angles phi=1", 2, "'phi=1'"},
        {"--voids boolean --void-axis 0,0,0", 2, "'0,0,0'"},
        {"--voids foam --void-jitter 1.5", 2, "--void-jitter 1.5"},
        {"--voids boolean --void-radius uniform:2", 2, "uniform"},
        {"--voids boolean --shell=-1", 2, "--shell"},
        {"--voids boolean --shell nan", 2, "--shell"},
        {"--voids boolean --void-voxel=-0.1", 2, "--void-voxel"},
        {"--voids boolean --void-count 0", 2, "--void-count 0"},
        {"--voids boolean --shell 12", 3, "--shell 12 mm"},
        {"--shell 10000", 3, "--shell 10000 mm"},
        {"--voids grid --void-cell 100", 2, "24 mm"}};
    for (const std::string bad : {"-0.1", "1.1", "nan"}) {
        requests.push_back(
            {"--voids grid --void-cell 4 --void-probability=" + bad, 2, "--void-probability"});
        requests.push_back({"--voids mixed --void-radius uniform:2,3 --void-probability=" + bad, 2,
                            "--void-probability"});
        requests.push_back({"--voids threshold --delete-fraction=" + bad, 2, "--delete-fraction"});
    }
    for (const std::string bad : {"0", "1", "-1", "nan"})
        requests.push_back({"--voids boolean --target-bvtv=" + bad, 2, "--target-bvtv"});
    for (const std::string angles : {"tz=nan", "tz=uniform:0,inf", "tx=a"})
        requests.push_back({"--voids boolean --void-angles " + angles, 2, "angle"});
    for (const std::string method : {"boolean", "overlay", "ellipses", "mixed"})
        requests.push_back({"--voids " + method + " --void-radius constant:20", 2, "24 mm"});
    checkVoids(requests, folder.path());
}

TEST_CASE("files of voids that cannot be used are refused") {
    const TemporaryFolder folder;
    putContent(folder.file("field.csv"), "x,y,z,ux,uy,uz\n0,0,0,1,0,0\n5,5,5,0,1,0\n");
    putContent(folder.file("ragged.txt"), "1 0\n1\n");
    putContent(folder.file("two.txt"), "1 0\n2 0\n");
    putContent(folder.file("layers.txt"), "1 0\n0 1\n\n0 1\n1 0\n");
    putContent(folder.file("negative.csv"), "x,y,z,a,b\n0,0,0,2,2\n1,1,1,-2,2\n");
    putContent(folder.file("none.csv"), "x,y,z,a,b\n");
    putContent(folder.file("large.csv"), "x,y,z,a,b\n0,0,0,50,50\n");
    checkVoids({{"--voids boolean --void-field @field.csv", 3, "@field.csv"},
                {"--voids grid --void-matrix @ragged.txt", 3, "@ragged.txt line 2"},
                {"--voids grid --void-matrix @two.txt", 3, "@two.txt line 2"},
                {"--voids list:@negative.csv", 3, "@negative.csv line 3"},
                {"--voids list:@none.csv", 3, "@none.csv"},
                {"--voids list:@large.csv", 2, "24 mm"},
                {"--voids list:@missing.csv", 4, "@missing.csv"},
                {"--voids holes", 2, "grid, overlay"},
                {"--voids list:", 2, "grid, overlay"}},
               folder.path());
    check({{"pack rect:100,100 --voids grid --void-matrix @layers.txt", 3, "2 layers"}},
          folder.path());
}

TEST_CASE("settings of voids that do not go together are refused") {
    const TemporaryFolder folder;
    checkVoids(
        {{"--voids boolean --void-probability 0.5", 2, "--void-probability"},
         {"--voids boolean --void-jitter 0.5", 2, "--void-jitter"},
         {"--voids grid --void-cell 4 --void-radius constant:1", 2, "--void-radius"},
         {"--voids grid --void-cell 4 --void-axis 0,0,1", 2, "--void-axis"},
         {"--voids mixed --void-aspect constant:2", 2, "--void-aspect"},
         {"--voids mixed --cull touch", 2, "--cull"},
         {"--voids overlay --target-bvtv 0.7 --target-tbth 0.2", 2, "--target-tbth"},
         {"--voids threshold --delete-fraction 0.3 --void-voxel 0.1", 2, "--void-voxel"},
         {"--target-bvtv 0.2", 2, "--voids"},
         {"--voids boolean --target-tbth 0.2", 2, "--target-bvtv"},
         {"--voids boolean --target-bvtv 0.2 --void-count 5", 2, "--void-count and --target-bvtv"},
         {"--voids threshold", 2, "--delete-fraction or --target-bvtv"},
         {"--voids grid", 2, "--void-matrix or --void-cell"},
         {"--voids boolean --void-axis 0,0,1 --void-angles isotropic", 2, "--void-axis"},
         {"--voids threshold --delete-fraction 0.3 -o list:@l.csv", 2, "list"}},
        folder.path());
    check({{"pack rect:100,100 --voids foam --target-bvtv 0.3 --target-connd 0.2", 2,
            "--target-connd"}},
          folder.path());
}

TEST_CASE("fields of thickness that cannot be used are refused") {
    const TemporaryFolder folder;
    // From `least` to `most` along x, over 10 mm.
    const auto put = [&](const char* name, double least, double most) {
        std::ofstream out(folder.file(name));
        out << "x,y,thickness\n";
        for (int k = 0; k < 21 * 11; ++k)
            out << (k % 21 - 10) * 0.5 << ',' << k / 21 - 5 << ','
                << least + (most - least) * (k % 21) / 20 << '\n';
    };
    put("shell.csv", 0.3, 1.3);
    put("negative.csv", -0.3, -1.3);
    put("thick.csv", 3, 13);
    const std::string boolean = " --voids boolean --void-radius constant:0.6 --shell-field @",
                      pack =
                          "pack ball:5 --radius uniform:0.3,0.5 --target-bvtv 0.9 "
                          "--shell-field @shell.csv --voids ";
    check({{"voids ball:7 -o @v.vdb" + boolean + "shell.csv", 3, "covers (-7, -7, -7)"},
           {"voids ball:5 --shell 1 -o @v.vdb" + boolean + "shell.csv", 2, "--shell-field"},
           {"voids ball:5 -o @v.vdb" + boolean + "none.csv", 4, "@none.csv"},
           {"voids ball:5 -o @v.vdb" + boolean + "shell.png", 2, "@shell.png"},
           {"voids ball:5 -o @v.vdb" + boolean + "negative.csv", 3, "line 2 -0.3"},
           {"voids box:1,1,1 -o @v.vdb" + boolean + "thick.csv", 3, "--shell-field"},
           {pack + "overlay", 2, "--shell-field overlay"},
           {pack + "mixed", 2, "--shell-field mixed"}},
          folder.path());
}
