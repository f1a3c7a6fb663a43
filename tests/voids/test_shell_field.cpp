// Shells whose thickness varies.
#include "support/generators.h"
#include "support/mesh_file.h"
#include "support/test.h"
#include "voids/stamping.h"
#include "voids/void_recipes.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/core_volume.h"
#include "vdbpack/voids/cull.h"
#include "vdbpack/voids/shell_field.h"

#include <fmt/format.h>

namespace {

constexpr double kRadius = 5;

/// From 0.3 to 1.3 mm along x.
double thicknessAt(double x) {
    return 0.8 + 0.1 * x;
}

ShellThickness linearShell() {
    return {[](const Vec<3>& x) { return thicknessAt(x[0]); }, thicknessAt(-kRadius),
            thicknessAt(kRadius)};
}

/// The same as a table, in the plane.
std::string shellTable(double scale = 1) {
    std::string text = "x,y,thickness\n";
    for (int k = 0; k < 21 * 11; ++k) {
        const double x = (k % 21 - 10) * 0.1 * kRadius;
        text += fmt::format("{},{},{}\n", x, (k / 21 - 5) * 0.2 * kRadius, scale * thicknessAt(x));
    }
    return text;
}

struct ShellFile {
    TemporaryFolder folder;
    VoidRequest request;

    explicit ShellFile(const std::string& table = shellTable()) {
        request.shellField = folder.file("shell.csv");
        putContent(request.shellField, table);
    }
    /// The thickness that runs use.
    ShellThickness over(const Box<3>& box) const { return shellOver(voidsOf(request), box, 0); }
};

/// Voxels of a level set in a cube whose centers lie inside.
template <class Visit>
void forVoxelsInside(const VdbGrid& grid, const Visit& visit) {
    const VoxelImage image = sampleLevelSet(grid, cube<3>(2 * kRadius));
    for (std::size_t i = 0; i < image.voxels(); ++i)
        if (image.distance[i] < 0) visit(centerOf(image, i));
}

}  // namespace

DIM_TEST_CASE("no void is cut into a shell that varies") {
    const double h = Dim == 3 ? 0.2 : 0.1;
    const auto domain = ballDomain<Dim>(kRadius);
    const ShellThickness shell = linearShell();
    const auto voids = anyVoids<Dim>(Dim == 3 ? 60 : 30, cube<Dim>(10), 0.4, 1, 0.5, 2, 31);
    auto options = stampOptions(*domain, h);
    options.shell = shell;
    const auto stamped = stampVoids(voids, *domain, options);
    typename StampedVoids<Dim>::Sampler distance(*stamped);
    std::size_t inVoids = 0, inShell = 0;
    forEachVoxel(cube<Dim>(2 * kRadius), options, [&](const Vec<Dim>& x) {
        const double deep = kRadius - length(x) - thicknessAt(x[0]);
        const double toVoid = distancesTo(voids, x)[0];
        if (deep <= 0) REQUIRE(distance(x) >= 0);
        if (deep > 1e-5 && std::fabs(toVoid) > 1e-3) REQUIRE((distance(x) < 0) == (toVoid < 0));
        inVoids += deep > 0 && toVoid < 0;
        inShell += deep <= 0 && toVoid < 0;
    });
    CHECK(inShell > (Dim == 3 ? 500 : 50));
    CHECK(stamped->volume() ==
          Approx(std::pow(h, Dim) * static_cast<double>(inVoids)).epsilon(0.002));
}

DIM_TEST_CASE("the part deeper than a shell that varies") {
    const auto domain = ballDomain<Dim>(kRadius);
    const ShellThickness shell = linearShell();
    RandomStream random(9, 1);
    std::vector<Sphere<Dim>> spheres(150'000);
    for (auto& s : spheres) s = {randomPoint(random, cube<Dim>(2 * kRadius)), 0.1};
    const auto deep = deeperThan(spheres, *domain, shell);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const Vec<Dim>& x = spheres[i].center;
        REQUIRE((deep[i] == 1) == (kRadius - length(x) > thicknessAt(x[0])));
        inside += deep[i] == 1;
    }
    const double share = static_cast<double>(inside) / static_cast<double>(spheres.size());
    CHECK(coreVolume(*domain, shell) == Approx(share * std::pow(2 * kRadius, Dim)).epsilon(0.01));
    // One thickness as a field.
    const ShellThickness uniform([](const Vec<3>&) { return 0.7; }, 0.2, 1.1);
    CHECK(coreVolume(*domain, uniform) == Approx(coreVolume(*domain, 0.7)).epsilon(0.001));
}

TEST_CASE("spheres, voids and BV/TV of a run agree with a field of thickness", "[long]") {
    const ShellFile file;
    const bool mesh = GENERATE(false, true);
    PackJob recipe = recipeFor("ball:5", "uniform:0.15,0.3");
    if (mesh) {
        recipe.domain.source = file.folder.file("ball.obj");
        writeObj(ballMesh(kRadius, 4), recipe.domain.source);
    }
    recipe.request = file.request;
    recipe.request.method = GENERATE("boolean", "foam");
    CAPTURE(mesh, recipe.request.method);
    recipe.request.radius = "uniform:0.5,0.8";
    recipe.request.targetBvtv = 0.3;
    recipe.outputs = {file.folder.file("p.csv")};
    const RunResult run = runPack(recipe);
    const ShellThickness shell = file.over(cube<3>(2 * kRadius));
    const auto depthOf = [](const Vec<3>& x) { return kRadius - length(x); };
    // The mesh lies up to this deep in the ball.
    const double error = mesh ? 0.03 : 1e-9;
    const auto& pack = std::get<Pack<3>>(run.pack);
    std::size_t cortical = 0;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const Vec<3>& x = pack.spheres[i].center;
        cortical += pack.region[i] == 0;
        if (const double deep = depthOf(x) - shell.at(x); std::fabs(deep) > error)
            REQUIRE((pack.region[i] == 1) == (deep > 0));
    }
    CHECK(run.report.voids->cortical == cortical);
    CHECK(*run.report.voids->leastShell == Approx(0.3));
    CHECK(run.report.voids->shell == Approx(1.3));
    CHECK(*run.report.voids->across == Approx(0.8 / 0.45).epsilon(0.3));
    // Of `surface`, `voids` and `solid`.
    forVoxelsInside(*run.levelSets.at(1),
                    [&](const Vec<3>& x) { REQUIRE(depthOf(x) > shell.at(x) - error - 1e-5); });
    std::size_t solid = 0, core = 0;
    forVoxelsInside(*run.levelSets.at(2),
                    [&](const Vec<3>& x) { solid += depthOf(x) > shell.at(x); });
    forVoxelsInside(*run.levelSets.at(0),
                    [&](const Vec<3>& x) { core += depthOf(x) > shell.at(x); });
    CHECK(static_cast<double>(solid) / static_cast<double>(core) == Approx(0.3).margin(0.006));
    CHECK(*run.report.voids->bvtv == Approx(0.3).margin(0.003));
}

TEST_CASE("a solid below a shell that varies is filled, and connected to it") {
    const ShellFile file;
    PackJob recipe = recipeFor("ball:5", "uniform:0.06,0.1", file.folder.file("p.csv"));
    recipe.request = file.request;
    setVoids(recipe.request, "foam", "uniform:0.6,0.9", 0.25);
    recipe.request.fill = Fill::solid;
    recipe.request.keepConnected = true;
    const RunResult run = runPack(recipe);
    CHECK(run.passed);
    CHECK(*run.report.voids->bvtv == Approx(0.25).margin(0.003));
    CHECK(*run.report.voids->spheresAttached > 0.8);
    const ShellThickness shell = file.over(cube<3>(2 * kRadius));
    const auto& pack = std::get<Pack<3>>(run.pack);
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const Vec<3>& x = pack.spheres[i].center;
        REQUIRE((pack.region[i] == 1) == (kRadius - length(x) > shell.at(x)));
    }
}

TEST_CASE("a shell that varies sets regions alone, of spheres that are carved and in the plane") {
    const ShellFile file;
    PackJob recipe = recipeFor("disc:5", "uniform:0.1,0.2", file.folder.file("p.csv"));
    recipe.request = file.request;
    const RunResult flat = runPack(recipe);
    const ShellThickness shell = shellOver(voidsOf(file.request), cube<2>(2 * kRadius), 0);
    const auto& circles = std::get<Pack<2>>(flat.pack);
    for (std::size_t i = 0; i < circles.spheres.size(); ++i) {
        const Vec<2>& x = circles.spheres[i].center;
        REQUIRE((circles.region[i] == 1) == (kRadius - length(x) > shell.at(x)));
    }
    recipe.domain.source = "ball:5";
    recipe.radius = SizeRequest::parse("uniform:0.2,0.4");
    recipe.request = {};
    runPack(recipe);
    auto carve = onPack<CarveJob>(file.folder.file("p.csv"), "ball:5", file.folder.file("c.csv"));
    carve.request = file.request;
    carve.request.method = "threshold";
    carve.request.deleteFraction = 0.4;
    const RunResult carved = runCarve(carve);
    const auto& pack = std::get<Pack<3>>(carved.pack);
    std::size_t deep = 0;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const Vec<3>& x = pack.spheres[i].center;
        const bool below = kRadius - length(x) > shell.at(x);
        REQUIRE((pack.region[i] == 1) == below);
        if (below) REQUIRE(pack.spheres[i].radius < 0.33);
        deep += below;
    }
    CHECK(deep > 0);
    CHECK(carved.report.voids->culled > 100);
}
