// Options that do not go together, or not with the domain or the files: refused before the work,
// and no file is left.
#include "support/requests.h"
#include "support/test.h"

#include "vdbpack/preview/preview.h"

#include <fmt/format.h>

TEST_CASE("what is not done in a periodic cell is refused") {
    const TemporaryFolder folder;
    check(
        {{"pack periodic:24,22,26 --voids mixed --void-radius uniform:2,3", 2, "periodic mixed"},
         // Longer than the cell with their aspect.
         {"pack periodic:24,22,26 --voids boolean --void-radius uniform:2,12", 2, "24 22 periodic"},
         {"pack periodic:24,22,26 --voids boolean --fill solid", 2, "periodic --fill"},
         {"pack periodic:24,22,26 -o @s.stl", 2, "periodic @s.stl"},
         {"pack periodic:24,22,26 --shell 2", 2, "--shell periodic"},
         {"pack periodic:24,22,26 --clip plane:0,0,1,3", 2, "--clip periodic"},
         {"pack periodic:24,22,26 --slice z=0", 2, "--slice"},
         {"pack periodic:24,22,26 --order center", 2, "--order"},
         {"pack periodic:24,22,26 -o labels:@l.nrrd --voxel-spacing 1", 2, "labels"},
         {"pack box:24,22,26 --periodic xx", 2, "--periodic 'xx'"},
         {"pack ball:20 --periodic x", 2, "--periodic"},
         {"pack periodic:20,20,20 --periodic x", 2, "--periodic"},
         {"pack box:20,18,22 --images -o @v.csv", 2, "--images"}},
        folder.path());
}

TEST_CASE("sizes by place refuse what they cannot use") {
    const TemporaryFolder folder;
    const auto ramp = [&](const char* name, double low, double high, double side = 26) {
        std::ofstream out(folder.file(name));
        out << "x,y,z,factor\n";
        for (int i = 0; i < 9 * 9 * 9; ++i)
            out << fmt::format("{},{},{},{}\n", (i % 9 / 8.0 - 0.5) * side,
                               (i / 9 % 9 / 8.0 - 0.5) * side, (i / 81 / 8.0 - 0.5) * side,
                               low + (high - low) * (i % 9) / 8);
    };
    ramp("short.csv", 1, 2, 10);
    ramp("zero.csv", 0, 2);
    ramp("negative.csv", -1, 2);
    ramp("wide.csv", 1, 21);
    putContent(folder.file("nan.csv"), "x,y,z,value\n0,0,0,nan\n");
    const std::string field = "pack box:24,24,24 --radius uniform:1,2 --size-field @",
                      shell = "pack box:24,24,24 --radius uniform:1,2 ";
    check({{field + "short.csv", 3, "@short.csv covers"},
           {field + "zero.csv", 3, "@zero.csv line factor 0"},
           {field + "negative.csv", 3, "@negative.csv -1"},
           {field + "nan.csv", 3, "@nan.csv"},
           {field + "wide.csv", 3, "@wide.csv 21 20"},
           {field + "field.stl", 2, "@field.stl"},
           {field + "none.csv", 4, "@none.csv"},
           {shell + "--shell-radius uniform:0.5,1", 2, "--shell-radius --shell"},
           {shell + "--shell 2 --shell-radius uniform:0.5", 2, "'uniform:0.5'"},
           {shell + "--shell 2 --shell-radius constant:0.001", 2, "200"},
           {shell + "--shell 2 --shell-radius uniform:0.5,1 --voids mixed", 2, "mixed sizes"}},
          folder.path());
}

TEST_CASE("pictures that cannot be are refused before the work") {
    const TemporaryFolder folder;
    const char* const cutPlace = canDrawSpace() ? "--preview-cut" : "libembree-dev";
    check({{"pack rect:30,20 --preview @a.jpg", 2, ".png"},
           {"pack rect:30,20 --preview @no/a.png", 4, "@no/a.png"},
           {"pack rect:30,20 --preview @a.png --preview-size 160x3", 2, "160x3"},
           {"pack rect:30,20 --preview @a.png --preview-cut x=0", 2, "--preview-cut"},
           {"pack ball:10 --preview-cut x=0", 2, "--preview"},
           {"pack ball:10 --preview-view left", 2, "--preview-view has no effect"},
           {"pack rect:30,20 --preview @a.png --preview-view top", 2, "--preview-view"},
           {"pack ball:10 --preview @a.png --preview-view front --preview-cut x=0", 2, "edge-on"},
           {"pack ball:10 --preview-color region", 2, "--preview-color"},
           {"pack ball:10 --preview @a.png --preview-color dpth", 2, "dpth column depth?"},
           {"pack ball:10 --preview @a.png --preview-cut z=11", 2, cutPlace},
           {"pack rect:30,20 --preview @a.png --report @a.png", 2, "@a.png"},
           {"pack rect:30,20 --preview @a.png --seed 1..2", 2, "{seed}"}},
          folder.path());
}

TEST_CASE("outputs and measures that cannot be are refused before anything is written") {
    const TemporaryFolder folder;
    putContent(folder.file("p.csv"), "x,y,z,radius\n0,0,0,1\n");
    check({{"convert @p.csv", 2, "-o"},
           {"convert @p.csv -o @p.csv", 2, "@p.csv"},
           {"convert @p.csv -o @p.stl", 2, "@p.stl --domain"},
           {"convert @p.csv -o fog:@p.txt", 2, "fog:FILE.vdb"},
           {"convert @p.csv -o @{part}.vtp", 2, "{part}"},
           {"convert ball:9 -o @{seed}.stl", 2, "{seed}"},
           {"convert @p.csv -o solid:@p.stl", 2, "solid"},
           {"convert @p.csv -o list:@v.csv", 2, "@v.csv"},
           {"measure @p.csv --unit m", 2, "--pack-unit"},
           {"measure @p.csv --shell 1", 2, "--shell --domain"},
           {"measure @p.csv -o @x.csv", 2, "contacts:"},
           {"measure @p.csv -o contacts:@none/x.csv", 4, "@none/x.csv"},
           {"measure @p.csv -o contacts:@p.csv", 2, "@p.csv"},
           {"pack ball:10 --radius uniform:1,2 --seed 1..2 -o @s.csv", 2, "{seed}"},
           {"pack ball:10 --radius uniform:1,2 --seed 1..2 --report @s.json", 2, "{seed}"},
           {"pack ball:10 --radius uniform:1,2 --seed 1..2 --table @t.txt", 2, ".csv"},
           {"pack ball:10 --radius uniform:1,2 --seed 1..2 --table @t{seed}.csv", 2, "{seed}"},
           {"pack ball:10 --radius uniform:1,2 --seed 1..2 -o @s{seed}.csv --table @s2.csv", 2,
            "@s2.csv"}},
          folder.path());
}

TEST_CASE("densities that make no sense are refused") {
    const TemporaryFolder folder;
    putContent(folder.file("p.csv"), "x,y,z,radius\n0,0,0,1\n");
    check({{"pack ball:9 --densify 0", 2, "'0' max fraction"},
           {"pack ball:9 --densify 1", 2, "'1' max"},
           {"pack ball:9 --densify nan", 2, "'nan' max"},
           {"pack ball:9 --densify 0.6x", 2, "'0.6x' max"},
           {"pack ball:9 --densify most", 2, "'most' max"},
           {"pack ball:9 --radius constant:2 --densify 0.97", 2, "0.97"},
           {"pack ball:9 --densify 0.6 --max-count 9", 2, "--max-count"},
           {"pack ball:9 --start random", 2, "--densify"},
           {"pack ball:9 --start random --densify 0.6 --size-field @p.csv", 2, "--size-field"},
           {"pack ball:9 --start random --densify 0.6 --existing @p.csv", 2, "--existing"},
           {"pack ball:9 --start random --densify 0.6 --shell 2 --shell-radius constant:1", 2,
            "--shell-radius"},
           {"pack ball:9 --settle on --max-count 9", 2, "--max-count"},
           {"pack ball:9 --settle on --densify 0.6", 2, "--settle"},
           {"pack ball:9 --settle yes", 2, "--settle"},
           {"pack ball:9 --densify 0.6 --voids mixed --void-radius constant:2 "
            "--void-probability 0.1",
            2, "mixed"},
           {"densify @p.csv", 2, "--domain"}},
          folder.path());
}

TEST_CASE("targets and samples of a foam that cannot be met are refused") {
    const TemporaryFolder folder;
    const std::string voids = "voids box:4,4,4 -o @v.vdb ";
    check({{voids + "--target-bvtv 0.3 --target-tbth 0.1 --target-tbsp 2", 2,
            "--target-bvtv 0.3 --target-tbth 0.1 --target-tbsp 0.076"},
           {voids + "--target-da 1.48 --target-tbsp 1", 2, "R²"},
           {voids + "--target-da 0.5 --target-tbsp 1 --voids boolean", 2, "foam"},
           {voids + "--like @none.vdb", 4, "@none.vdb"},
           {voids + "--like-threshold 3 --voids foam", 2, "--like"},
           {voids + "--trabecular tooth", 2, "tooth vertebra"},
           {"voids rect:20,20 --voids foam --target-bvtv 0.15 --target-tbth 0.25 --target-da 0.5",
            2, "--target-da"}},
          folder.path());
}
