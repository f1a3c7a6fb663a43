// Properties of spheres and voids from the grey values of images, and packs as label maps.
#include "support/generators.h"
#include "support/image_file.h"
#include "support/jobs.h"
#include "support/mesh_file.h"
#include "support/requests.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/image/image_surface.h"

#include <atomic>

namespace {

/// Values that grow along x and fall along z.
void writeSlope(const std::string& path) {
    writeNrrd(path,
              Voxels<float>::of(gridAround(20, {{1, 1, 1}}),
                                [](const Vec<3>& p) { return 100 + 3 * p[0] - p[2]; }),
              "float");
}

const std::vector<double>& numbersOf(const PackAttributes& pack, const char* name) {
    const Column* column = columnOfNumbers(pack, name);
    REQUIRE(column);
    return column->numbers;
}

/// The labels of a file, and how many voxels have each.
std::map<std::int64_t, int> countsIn(const std::string& file) {
    std::map<std::int64_t, int> counts;
    const Image image = readImage(file);
    image.visit([&](const auto* numbers) {
        for (std::size_t i = 0; i < image.values(); ++i)
            ++counts[static_cast<std::int64_t>(numbers[i])];
    });
    return counts;
}

}  // namespace

TEST_CASE("grey values of an image become a column") {
    const TemporaryFolder folder;
    const std::string file = folder.file("halves.nrrd"), grey = folder.file("grey.nrrd");
    writeHalves(file);
    writeSlope(grey);
    PackJob recipe = recipeFor(file, "uniform:0.8,1.6", folder.file("p.csv"));
    recipe.domain.label = GENERATE("all", "5+9");
    recipe.grey.samples = {"hu=" + grey};
    runPack(recipe);
    const std::string again = folder.file("again.csv");
    REQUIRE(vdbPack("convert " + folder.file("p.csv") + " --sample mean=" + grey + " -o " + again)
                .code == 0);
    const Pack<3> pack = readPack(again);
    int found = 0;
    for (const Column& column : pack.columns)
        if (column.name == "hu" || column.name == "mean") {
            ++found;
            for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
                const Vec<3>& x = pack.spheres[i].center;
                CHECK(column.numbers[i] == Approx(100 + 3 * x[0] - x[2]).margin(3));
            }
        }
    CHECK(found == 2);
}

namespace {

/// Checks the rows of a table of materials, one a class of density.
/// @return  the spheres of all.
std::size_t checkTable(const std::string& file, double least, double most) {
    std::istringstream table(contentOf(file));
    std::string line;
    std::getline(table, line);
    CHECK(line == "material,part,region,density_class,spheres,density_kg_m3,modulus_MPa");
    std::size_t spheres = 0;
    for (int row = 0; std::getline(table, line); ++row) {
        int material = 0, part = 0, region = 0, densityClass = 0, count = 0;
        double mean = 0;
        REQUIRE(std::sscanf(line.c_str(), "%d,%d,%d,%d,%d,%lf", &material, &part, &region,
                            &densityClass, &count, &mean) == 6);
        CHECK(material == row);
        CHECK(densityClass == row);
        CHECK(mean >= least + row * (most - least) / 6 - 1e-6);
        CHECK(mean <= least + (row + 1) * (most - least) / 6 + 1e-6);
        spheres += static_cast<std::size_t>(count);
    }
    return spheres;
}

}  // namespace

TEST_CASE("grey values become densities, moduli and classes of material") {
    const TemporaryFolder folder;
    const std::string file = folder.file("halves.nrrd"), grey = folder.file("grey.nrrd");
    writeHalves(file);
    writeSlope(grey);
    PackJob recipe = recipeFor(file, "uniform:0.8,1.6");
    recipe.domain.label = "5+9";
    recipe.grey.samples = {"hu=" + grey};
    recipe.grey.calibration = "12,-150";
    recipe.grey.modulus = "6850,1.49";
    recipe.grey.classes = 6;
    recipe.outputs = {folder.file("p.csv"), folder.file("p.data"), "yade:" + folder.file("p.txt"),
                      "materials:" + folder.file("m.csv")};
    const RunResult run = runPack(recipe);
    const auto& pack = std::get<Pack<3>>(run.pack);
    const auto &hu = numbersOf(pack, "hu"), &density = numbersOf(pack, kDensityColumn),
               &modulus = numbersOf(pack, kModulusColumn), &kind = numbersOf(pack, kClassColumn);
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        CHECK(density[i] == Approx(12 * hu[i] - 150));
        CHECK(modulus[i] == Approx(6850 * std::pow(density[i] / 1000, 1.49)));
    }
    // A class is a range of densities, and all are as wide.
    const auto [least, most] = std::minmax_element(density.begin(), density.end());
    for (std::size_t i = 0; i < density.size(); ++i) {
        CHECK(density[i] >= *least + (kind[i] - 1e-9) * (*most - *least) / 6);
        CHECK(density[i] <= *least + (kind[i] + 1 + 1e-9) * (*most - *least) / 6);
    }
    CHECK(*std::max_element(kind.begin(), kind.end()) == 5);

    const Pack<3> atoms = readPack(folder.file("p.data"));
    const Pack<3> yade = readPack("yade:" + folder.file("p.txt"));
    const auto &types = numbersOf(atoms, "type"), &written = numbersOf(atoms, kDensityColumn);
    for (std::size_t i = 0; i < density.size(); ++i) {
        CHECK(written[i] == Approx(density[i]));
        CHECK(types[i] == kind[i] + 1);
        CHECK(numbersOf(yade, "matId")[i] == kind[i]);
    }
    CHECK(checkTable(folder.file("m.csv"), *least, *most) == pack.spheres.size());
    // A column of a file does as well as a sample.
    const Output output = vdbPack("convert " + folder.file("p.csv") +
                                  " --calibrate hu=12,-150 -o " + folder.file("q.csv"));
    CAPTURE(output.text);
    REQUIRE(output.code == 0);
    CHECK(numbersOf(readPack(folder.file("q.csv")), kDensityColumn) == density);
}

TEST_CASE("a part with a density of its own keeps it") {
    const TemporaryFolder folder;
    const std::string file = folder.file("halves.nrrd"), grey = folder.file("grey.nrrd");
    writeHalves(file);
    writeSlope(grey);
    PackJob recipe;
    recipe.grey.samples = {"hu=" + grey};
    recipe.grey.calibration = "12,-150";
    recipe.radius = SizeRequest::parse("uniform:0.8,1.6");
    PackJob part = recipe;
    part.domain.source = file;
    part.domain.label = "5";
    recipe.parts.push_back(part);
    part.domain.label = "9";
    part.density = "4430";
    recipe.parts.push_back(part);
    recipe.outputs = {folder.file("p.data")};
    // The grey values are those of the whole run.
    for (PackRecipe& one : recipe.parts) one.grey = {};
    const RunResult run = runPack(recipe);
    const auto& pack = std::get<Pack<3>>(run.pack);
    const auto &density = numbersOf(pack, kDensityColumn), &parts = numbersOf(pack, kPartColumn);
    const auto written = numbersOf(readPack(folder.file("p.data")), kDensityColumn);
    for (std::size_t i = 0; i < density.size(); ++i) {
        CHECK((parts[i] == 1) == (density[i] == 4430));
        CHECK(written[i] == Approx(density[i]));
    }
    // Metal with the density of the bone around it.
    recipe.parts[1].density.clear();
    recipe.grey.modulus = recipe.parts[0].grey.modulus = "4730,1.56";
    recipe.parts[1].grey.modulus = "110000";
    CHECK(mentions(runPack(recipe).report.warnings, "set `density` in the part"));
    recipe.parts[1].domain = {};
    recipe.parts[1].domain.source = folder.file("peg.obj");
    writeObj(boxMesh({{-3, -3, 0}}, {{3, 3, 20}}), recipe.parts[1].domain.source);
    recipe.parts[1].grey.modulus.clear();
    recipe.grey.modulus = recipe.parts[0].grey.modulus = "";
    CHECK(mentions(runPack(recipe).report.warnings, "if it is an implant"));
}

TEST_CASE("an interrupt or a damaged image costs columns, not the pack") {
    const TemporaryFolder folder;
    const std::string grey = folder.file("grey.nrrd");
    writeSlope(grey);
    PackJob recipe = recipeFor("box:60,60,60", "uniform:0.5,1", folder.file("p.csv"));
    recipe.grey.samples = {"hu=" + grey};
    std::atomic<bool> stop{false};
    Callbacks callbacks;
    callbacks.progress = [&](const Progress& p) {
        stop = stop || (p.stage == "pack" && p.count > 0);
    };
    callbacks.cancelled = [&] { return stop.load(); };
    const RunResult run = runPack(recipe, callbacks);
    REQUIRE(run.report.interrupted);
    CHECK(numbersOf(readPack(folder.file("p.interrupted.csv")), "hu").size() == run.report.count);

    recipe.domain.source = "box:8,8,8";
    writeBytes(grey, contentOf(grey).substr(0, 600));
    CHECK_THROWS_AS(runPack(recipe), InputError);
    CHECK(readPack(folder.file("p.csv")).spheres.size() > 100);
}

TEST_CASE("densities end where others are requested; added spheres have those of the nearest") {
    const TemporaryFolder folder;
    const std::string grey = folder.file("grey.nrrd"), file = folder.file("p.csv");
    writeSlope(grey);
    PackJob recipe = recipeFor("ball:8", "uniform:0.8,1.6", file);
    recipe.request.shell = 3;
    recipe.grey.samples = {"hu=" + grey};
    recipe.grey.calibration = "12,-150";
    const RunResult run = runPack(recipe);
    const auto& pack = std::get<Pack<3>>(run.pack);
    REQUIRE(
        vdbPack("convert " + file + " --density 0=1900,1=1100 -o " + folder.file("p.data")).code ==
        0);
    const Pack<3> atoms = readPack(folder.file("p.data"));
    for (std::size_t i = 0; i < pack.spheres.size(); ++i)
        CHECK(numbersOf(atoms, kDensityColumn)[i] == Approx(pack.region[i] == 0 ? 1900 : 1100));

    auto densify = onPack<DensifyRecipe>(file, "ball:8");
    densify.densify.fraction = 0.6;
    const RunResult dense = runDensify(densify);
    const auto& more = std::get<Pack<3>>(dense.pack);
    REQUIRE(more.spheres.size() > pack.spheres.size());
    const auto wayTo = [&](std::size_t i, std::size_t k) {
        return length(more.spheres[i].center - more.spheres[k].center) - more.spheres[k].radius;
    };
    for (std::size_t i = 0; i < more.spheres.size(); ++i) {
        const bool isAdded = i >= pack.spheres.size();
        std::size_t nearest = isAdded ? 0 : i;
        for (std::size_t k = 0; isAdded && k < pack.spheres.size(); ++k)
            if (wayTo(i, k) < wayTo(i, nearest)) nearest = k;
        for (const char* name : {"hu", kDensityColumn, kClassColumn})
            REQUIRE(numbersOf(more, name)[i] == Approx(numbersOf(pack, name)[nearest]));
    }
}

TEST_CASE("samples and calibrations that say too little or too much are refused") {
    const TemporaryFolder folder;
    writeSlope(folder.file("g.nrrd"));
    const std::string pack = "pack ball:5 --radius uniform:0.8,1.6 -o @p.csv ",
                      sampled = pack + "--sample a=@g.nrrd ";
    std::vector<Request> requests{
        {pack + "--sample hu", 2, "'hu'"},
        {pack + "--sample =@g.nrrd", 2, "--sample"},
        {pack + "--sample radius=@g.nrrd", 2, "radius"},
        {pack + "--sample a=b.stl", 2, "b.stl"},
        {pack + "--sample a=@absent.nii", 4, "@absent.nii"},
        {pack + "--sample a=@g.nrrd -o labels:@g.nrrd", 2, "@g.nrrd"},
        {pack + "--calibrate 1,0", 2, "--sample"},
        {sampled + "--sample b=@g.nrrd --calibrate 1,0", 2, "several"},
        {sampled + "--calibrate c=1,0", 2, "'c'"},
        {sampled + "--preview @p.png --preview-color column:raduis", 2, "raduis"},
        {sampled + "--calibrate a=1,0 --density 1200", 2, "density"},
        {sampled + "--calibrate a=1,0 --modulus -1,2", 2, "A,B"},
        {sampled + "--calibrate a=1,0 --modulus 1,-2", 2, "not negative"},
        {sampled + "--modulus 1,2", 2, "--calibrate"},
        {"pack ball:6 --radius uniform:1,2 -o labels-regions:@r.nii.gz", 2, "--voxel-spacing"}};
    for (const std::string bad : {"1", "a=", "=1,2", "a=0,3", "x,y"})
        requests.push_back({sampled + "--calibrate " + bad, 2, "SLOPE,INTERCEPT"});
    const std::string voids =
        "voids box:20,20,20 --voids boolean --void-radius uniform:0.5,0.8 -o @v.vdb "
        "--bvtv-field @g.nrrd ";
    for (const Request& request : std::vector<Request>{{"", 2, "--bvtv-range"},
                                                       {"--bvtv-range 5,5", 2, "--bvtv-range"},
                                                       {"--bvtv-range 3000,5000", 3, "@g.nrrd"}})
        requests.push_back({voids + request.words, request.code, request.names});
    requests.push_back(
        {"voids box:500,0,0,520,20,20 --voids boolean --void-radius constant:1 "
         "-o @v.vdb --bvtv-field @g.nrrd --bvtv-range 0,2000",
         3, "elsewhere"});
    requests.push_back(
        {"voids box:20,20,20 --voids overlay -o @v.vdb --bvtv-field @g.nrrd "
         "--bvtv-range 0,2000",
         2, "boolean"});
    check(requests, folder.path());
}

TEST_CASE("a density below that of air is raised, with a warning") {
    const TemporaryFolder folder;
    writeSlope(folder.file("g.nrrd"));
    PackJob recipe = recipeFor("ball:5", "uniform:0.8,1.6");
    recipe.grey.samples = {"a=" + folder.file("g.nrrd")};
    recipe.grey.calibration = "a=1,-100";
    const RunResult run = runPack(recipe);
    CHECK(mentions(run.report.warnings, "less than 1 kg/m³"));
    for (const double d : numbersOf(std::get<Pack<3>>(run.pack), kDensityColumn)) CHECK(d >= 1);
}

TEST_CASE("densities that a calibration gives in another unit are warned of") {
    const TemporaryFolder folder;
    writeSlope(folder.file("g.nrrd"));
    PackJob recipe = recipeFor("ball:5", "uniform:0.8,1.6");
    recipe.grey.samples = {"a=" + folder.file("g.nrrd")};
    recipe.grey.calibration = "a=1,1000";
    CHECK_FALSE(mentions(runPack(recipe).report.warnings, "kg/m³"));
    recipe.grey.calibration = "a=1000,1000000";
    CHECK(mentions(runPack(recipe).report.warnings, "more than 6000 kg/m³"));
    recipe.grey.calibration = "a=0.001,1000";
    CHECK(mentions(runPack(recipe).report.warnings, "Check the slope"));
    // A map of six labels in place of the scan.
    writeNrrd(folder.file("l.nrrd"),
              Voxels<float>::of(gridAround(20, {{1, 1, 1}}),
                                [](const Vec<3>& p) { return std::floor((p[0] + 20) / 8); }),
              "float");
    CHECK_FALSE(mentions(runPack(recipe).report.warnings, "label map"));
    recipe.grey.samples = {"a=" + folder.file("l.nrrd")};
    CHECK(mentions(runPack(recipe).report.warnings, "label map"));
}

TEST_CASE("voids follow the BV/TV that grey values say") {
    const TemporaryFolder folder;
    const std::string grey = folder.file("grey.nrrd");
    // BV/TV 0.1 at one end, 0.7 at the other.
    writeNrrd(grey,
              Voxels<float>::of(gridAround(20, {{1, 1, 1}}),
                                [](const Vec<3>& p) { return 800 + 60 * p[0]; }),
              "float");
    auto recipe = voidsIn("box:20,20,20", "labels-solid:" + folder.file("s.nrrd"));
    setVoids(recipe.request, "boolean", "uniform:0.5,0.8");
    recipe.request.bvtvField = grey;
    recipe.request.bvtvRange = "0,2000";
    recipe.domain.voxelSpacing = Vec<3>{{0.25, 0.25, 0.25}};
    const RunResult run = runVoids(recipe);
    CHECK(*run.report.voids->bvtv == Approx(0.4).margin(0.005));
    const Image image = readImage(folder.file("s.nrrd"));
    double solid[4] = {}, all[4] = {};
    const auto& size = image.grid.size;
    std::size_t voxel = 0;
    for (std::size_t z = 0; z < size[2]; ++z)
        for (std::size_t y = 0; y < size[1]; ++y)
            for (std::size_t x = 0; x < size[0]; ++x, ++voxel) {
                const Vec<3> at = image.grid.at(
                    {{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}});
                if (std::fabs(at[0]) > 10 || std::fabs(at[1]) > 10 || std::fabs(at[2]) > 10)
                    continue;
                const auto slab =
                    std::min<std::size_t>(3, static_cast<std::size_t>((at[0] + 10) / 5));
                all[slab] += 1;
                solid[slab] += std::to_integer<int>(image.bytes[voxel]) != 0;
            }
    for (int slab = 0; slab < 4; ++slab)
        CHECK(solid[slab] / all[slab] ==
              Approx((800 + 60 * (-7.5 + 5 * slab)) / 2000).margin(0.04));
}

TEST_CASE("a pack is written as label maps on the grid of its image") {
    const TemporaryFolder folder;
    const std::string file = folder.file("halves.nrrd");
    writeHalves(file);
    const ImageSpace space = GENERATE(ImageSpace::lps, ImageSpace::ras);
    PackJob recipe = recipeFor(file, "uniform:2,3");
    recipe.domain.label = "all";
    recipe.domain.space = space;
    recipe.outputs = {"labels:" + folder.file("ids.nii.gz"),
                      "labels-parts:" + folder.file("parts.mha"),
                      "labels-solid:" + folder.file("solid.nrrd")};
    const RunResult run = runPack(recipe);
    const auto& pack = std::get<Pack<3>>(run.pack);
    CHECK(run.report.axes == (space == ImageSpace::lps ? "LPS" : "RAS"));
    const Image from = readImage(file), parts = readImage(folder.file("parts.mha")),
                solid = readImage(folder.file("solid.nrrd"));
    for (const Image* image : {&parts, &solid}) {
        CHECK(image->grid.size == from.grid.size);
        CHECK(length(image->grid.origin - from.grid.origin) < 1e-9);
    }
    // The solid is what the image says, but where its surface was smoothed; spheres lie in their
    // own part.
    std::size_t off = 0, voxels = 0;
    for (std::size_t i = 0; i < from.values(); ++i) {
        const int value = std::to_integer<int>(from.bytes[i]);
        const int expected = value == 5 ? 1 : value == 9 ? 2 : 0;
        voxels += expected != 0;
        off += std::to_integer<int>(solid.bytes[i]) != expected;
        const int part = std::to_integer<int>(parts.bytes[i]);
        if (part != 0) CHECK(part == expected);
    }
    CHECK(100 * off < voxels);
    const auto counts = countsIn(folder.file("ids.nii.gz"));
    CHECK(10 * counts.size() > 9 * pack.spheres.size());
    CHECK(counts.rbegin()->first <= static_cast<std::int64_t>(pack.spheres.size()));

    CHECK_THROWS_AS(OutputTarget("labels:" + folder.file("r.vdb")), ParameterError);
}

TEST_CASE("label maps of a shape have the volumes of its regions") {
    const TemporaryFolder folder;
    PackJob recipe = recipeFor("ball:6", "uniform:1,2");
    recipe.request.shell = 2;
    recipe.outputs = {"labels-regions:" + folder.file("r.nii.gz"),
                      "labels-solid:" + folder.file("s.nii.gz")};
    recipe.domain.voxelSpacing = Vec<3>{{0.2, 0.2, 0.2}};
    const RunResult run = runPack(recipe);
    const auto& pack = std::get<Pack<3>>(run.pack);
    double volume[2] = {};
    for (std::size_t i = 0; i < pack.spheres.size(); ++i)
        volume[pack.region[i]] += Measure<3>::ball(pack.spheres[i].radius) / 0.008;
    auto counts = countsIn(folder.file("r.nii.gz"));
    CHECK(counts[1] == Approx(volume[0]).epsilon(0.01));
    CHECK(counts[2] == Approx(volume[1]).epsilon(0.02));
    CHECK(countsIn(folder.file("s.nii.gz"))[1] == Approx(run.report.volume / 0.008).epsilon(0.005));
}

TEST_CASE("a cube of ten voxels is ten voxels wide in a label map, as a shape and as a mesh") {
    const TemporaryFolder folder;
    writeObj(boxMesh({{0, 0, 0}}, {{10, 10, 10}}), folder.file("cube.obj"));
    const std::string domain = GENERATE("box:0,0,0,10,10,10", "cube.obj");
    PackJob recipe = recipeFor(domain[0] == 'c' ? folder.file(domain) : domain, "constant:1");
    recipe.outputs = {"labels-solid:" + folder.file("s.nrrd")};
    recipe.domain.voxelSpacing = Vec<3>{{1, 1, 2}};
    runPack(recipe);
    const Image image = readImage(folder.file("s.nrrd"));
    CHECK(image.grid.size == std::array<std::size_t, 3>{12, 12, 7});
    const auto labels = labelsOf(image).value();
    REQUIRE(labels.size() == 1);
    CHECK(labels[0].voxels == 500);
    CHECK(length(image.grid.at(labels[0].voxelBox.center()) - Vec<3>{{5, 5, 5}}) < 1e-9);
}
