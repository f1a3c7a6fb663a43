// Voids in periodic cells: against all images of the voids, one by one.
#include "support/jobs.h"
#include "support/test.h"

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/run/run.h"
#include "vdbpack/voids/stamp.h"
#include "vdbpack/voids/void_list.h"

namespace {

template <int Dim>
PackJob cellRecipe(const std::string& method = {}) {
    auto recipe = Dim == 3 ? recipeFor("periodic:24,22,26", "uniform:0.6,1")
                           : recipeFor("periodic:60,50", "uniform:0.5,1");
    VoidRequest& v = recipe.request;
    v.method = method;
    if (method == "grid") {
        v.cell = "5";
        v.probability = 0.6;
    } else if (method == "concentric" || method == "threshold") {
        v.deleteFraction = 0.3;
    } else if (!method.empty()) {
        v.radius = method == "overlay" ? "uniform:1.2,2" : "uniform:1.5,2.5";
        v.aspect = "constant:1.3";
        v.targetBvtv = method == "overlay" ? 0.65 : 0.4;
    }
    if (method == "foam") v.blend = v.strut = 0;
    return recipe;
}

/// All images of voids next to a cell, itself included.
template <int Dim>
std::vector<Ellipsoid<Dim>> imagesOf(const std::vector<Ellipsoid<Dim>>& voids,
                                     const PeriodicCell<Dim>& cell) {
    std::vector<Ellipsoid<Dim>> all;
    for (const auto& e : voids)
        for (int k = 0; k < (Dim == 3 ? 27 : 9); ++k) {
            all.push_back(e);
            typename PeriodicCell<Dim>::Laps laps{};
            for (int d = 0, rest = k; d < Dim; ++d, rest /= 3)
                laps[static_cast<std::size_t>(d)] = rest % 3 - 1;
            all.back().center += cell.shift(laps);
        }
    return all;
}

template <int Dim>
bool isInAny(const std::vector<Ellipsoid<Dim>>& voids, const Vec<Dim>& x) {
    return std::any_of(voids.begin(), voids.end(), [&](const auto& e) { return e.contains(x); });
}

/// The share of points of a cell for which `test` is true.
template <int Dim, class Test>
double shareOf(const PeriodicCell<Dim>& cell, int points, const Test& test) {
    // The additive recurrences of Roberts (2018) in space and in the plane.
    constexpr double kSpace[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    constexpr double kPlane[2] = {0.7548776662466927, 0.5698402909980532};
    const double* const steps = Dim == 3 ? kSpace : kPlane;
    int found = 0;
    for (int k = 0; k < points; ++k) {
        Vec<Dim> x;
        for (int d = 0; d < Dim; ++d)
            x[d] = cell.box.lo[d] + std::fmod((k + 0.5) * steps[d], 1.0) * cell.length(d);
        found += test(x);
    }
    return static_cast<double>(found) / points;
}

template <int Dim>
const Pack<Dim>& packOf(const RunResult& run) {
    return std::get<Pack<Dim>>(run.pack);
}

template <int Dim>
const std::vector<Ellipsoid<Dim>>& voidsOf(const RunResult& run) {
    return std::get<std::vector<Ellipsoid<Dim>>>(run.voids);
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("voids of a periodic cell remove spheres by all of their images", "[long]",
                       ((int Dim), Dim), 2, 3) {
    const std::string method = GENERATE("boolean", "overlay", "grid", "foam");
    CAPTURE(Dim, method);
    const auto run = runPack(cellRecipe<Dim>(method)), whole = runPack(cellRecipe<Dim>());
    CHECK(run.passed);
    const PeriodicCell<Dim> cell = packOf<Dim>(run).cell;
    REQUIRE(cell.all());
    const auto voids = imagesOf(voidsOf<Dim>(run), cell);
    // Also those that no image outside the cell removes: the test is about more than one void.
    std::vector<Sphere<Dim>> expected;
    std::size_t byImages = 0;
    for (const auto& s : packOf<Dim>(whole).spheres) {
        const bool removed = isInAny(voids, s.center);
        byImages += removed && !isInAny(voidsOf<Dim>(run), s.center);
        if (!removed) expected.push_back(s);
    }
    CHECK(packOf<Dim>(run).spheres == expected);
    if (method != "grid") CHECK(byImages > 0);
    const double share =
        shareOf(cell, 30'000, [&](const Vec<Dim>& x) { return !isInAny(voids, x); });
    CHECK(run.report.voids->bvtv.value_or(0) == Approx(share).margin(0.01));
    if (method != "grid")
        CHECK(run.report.voids->bvtv.value_or(0) ==
              Approx(method == "overlay" ? 0.65 : 0.4).margin(0.006));
}

DIM_TEST_CASE("no sphere that is kept touches a void of a periodic cell") {
    auto recipe = cellRecipe<Dim>("boolean");
    const auto whole = runPack(cellRecipe<Dim>());
    recipe.request.cull = Cull::touch;
    recipe.request.targetBvtv = 0.6;
    const auto run = runPack(recipe);
    const auto voids = imagesOf(voidsOf<Dim>(run), packOf<Dim>(run).cell);
    const double h = run.report.voids->voxelSize;
    std::size_t at = 0;
    for (const auto& s : packOf<Dim>(whole).spheres) {
        double distance = 1.5;  // more than the largest radius and a voxel
        for (const auto& e : voids)
            if (length(e.center - s.center) < std::max(e.a, e.b) + distance)
                distance = std::min(distance, e.signedDistance(s.center));
        const auto& kept = packOf<Dim>(run).spheres;
        const bool isKept = at < kept.size() && kept[at] == s;
        at += isKept;
        CAPTURE(distance, s.radius, h);
        if (isKept) CHECK(distance > s.radius - 0.5 * h);
        if (!isKept) CHECK(distance < s.radius + 0.5 * h);
    }
    CHECK(at == packOf<Dim>(run).spheres.size());
}

DIM_TEST_CASE("voids moved by lengths of a periodic cell are the same voids") {
    const TemporaryFolder folder;
    auto recipe = cellRecipe<Dim>("boolean");
    recipe.outputs = {folder.file("pack.vtp")};
    const auto run = runPack(recipe);
    auto moved = voidsOf<Dim>(run);
    int turn = 0;
    for (auto& e : moved) {
        typename PeriodicCell<Dim>::Laps laps{};
        for (std::size_t d = 0; d < Dim; ++d) laps[d] = ++turn % 5 - 2;
        e.center += packOf<Dim>(run).cell.shift(laps);
    }
    writeVoidList(moved, folder.file("moved.csv"));
    recipe.request = {};
    recipe.request.method = "list:" + folder.file("moved.csv");
    const auto again = runPack(recipe);
    CHECK(again.report.hash == run.report.hash);
    CHECK(again.report.voids->bvtv.value_or(0) ==
          Approx(run.report.voids->bvtv.value_or(1)).margin(0.005));
    // What is cut into a pack that was read, in the cell that its file states.
    recipe.request = {};
    runPack(recipe);
    auto carve = onPack<CarveJob>(folder.file("pack.vtp"));
    carve.request = cellRecipe<Dim>("boolean").request;
    CHECK(runCarve(carve).report.hash == run.report.hash);
}

TEST_CASE("joined voids go on across the faces of a periodic cell") {
    auto recipe = cellRecipe<3>("foam");
    recipe.request.blend = 0.3;
    recipe.request.strut = 0.6;
    recipe.request.strutShare = 0.7;
    recipe.threads = 1;
    const auto run = runPack(recipe);
    const PeriodicCell<3> cell = packOf<3>(run).cell;
    const auto voids = imagesOf(voidsOf<3>(run), cell);
    VoidJoin how;
    how.blend = 0.3;
    how.strut = 0.3;
    how.strutShare = 0.7;
    std::vector<const Ellipsoid<3>*> near;
    const auto isSolid = [&](const Vec<3>& x) {
        near.clear();
        for (const auto& e : voids)
            if (length(e.center - x) < std::max(e.a, e.b) + 4) near.push_back(&e);
        return !(joinedDistance(near, x, how) < 0);
    };
    CHECK(run.report.voids->bvtv.value_or(0) == Approx(0.4).margin(0.002));
    CHECK(shareOf(cell, 3'000, isSolid) == Approx(0.4).margin(0.02));
    for (const int threads : {3, 8}) {
        recipe.threads = threads;
        CHECK(runPack(recipe).report.hash == run.report.hash);
    }
}

TEST_CASE("an axis of a foam is that of its voids in any periodic cell", "[long]") {
    auto recipe = cellRecipe<3>("foam");
    recipe.request.radius = "uniform:1.2,1.8";
    recipe.request.orientation.axis =
        VoidAxis::parse(GENERATE(as<std::string>(), "0,0,1", "1,1,0"));
    const auto run = runPack(recipe);
    CHECK(run.report.voids->bvtv.value_or(0) == Approx(0.4).margin(0.002));
    const auto voids = imagesOf(voidsOf<3>(run), packOf<3>(run).cell);
    CHECK(shareOf(packOf<3>(run).cell, 20'000,
                  [&](const Vec<3>& x) { return !isInAny(voids, x); }) == Approx(0.4).margin(0.01));
}

TEST_CASE("walls beside periodic faces end the voids") {
    auto recipe = cellRecipe<3>("boolean");
    recipe.domain.source = "box:24,22,26";
    recipe.domain.periodic = {true, true, false};
    const auto run = runPack(recipe);
    const PeriodicCell<3> cell = packOf<3>(run).cell;
    CHECK_FALSE(cell.all());
    const auto voids = imagesOf(voidsOf<3>(run), cell);
    for (const auto& s : packOf<3>(run).spheres) REQUIRE_FALSE(isInAny(voids, s.center));
    CHECK(run.report.voids->bvtv.value_or(0) == Approx(0.4).margin(0.002));
    CHECK(shareOf(cell, 30'000, [&](const Vec<3>& x) { return !isInAny(voids, x); }) ==
          Approx(0.4).margin(0.006));
}

TEST_CASE("spheres stay connected across the faces of a periodic cell") {
    auto recipe = cellRecipe<3>("boolean");
    recipe.request.targetBvtv = 0.3;
    recipe.request.keepConnected = true;
    const auto run = runPack(recipe);
    CHECK(run.passed);
    CHECK(run.report.contacts->largestComponent == 1);
    CHECK(run.report.voids->dropped > 0);
}

TEST_CASE("level sets of a periodic cell end at its faces") {
    const TemporaryFolder folder;
    auto recipe = voidsIn("periodic:24,22,26");
    recipe.request = cellRecipe<3>("boolean").request;
    recipe.outputs = {folder.file("solid.stl"), folder.file("sets.vdb"),
                      "fog:" + folder.file("fog.vdb"), "list:" + folder.file("list.csv")};
    const auto run = runVoids(recipe);
    CHECK(run.report.voids->bvtv.value_or(0) == Approx(0.4).margin(0.002));
    CHECK(readVoidList<3>(folder.file("list.csv")).size() == run.report.voids->count);
    MeshRecipe mesh;
    mesh.domain.source = folder.file("solid.stl");
    const MeshHealth health = runMesh(mesh).health;
    CHECK(health.boundaryEdges == 0);
    CHECK(health.enclosedVolume == Approx(0.4 * 24 * 22 * 26).epsilon(0.03));
}
