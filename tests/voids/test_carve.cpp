// Packs that voids are carved out of, and what has to stay.
#include "support/test.h"
#include "voids/void_recipes.h"

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/voids/void_list.h"

DIM_TEST_CASE("the shell of a pack with voids stays whole") {
    auto recipe = methodRecipe<Dim>("boolean");
    recipe.request.shell = 4;
    recipe.request.targetBvtv = 0.2;
    auto whole = recipe;
    whole.request = {};
    whole.request.shell = 4;
    const auto all = runPack(whole), run = runPack(recipe);
    CHECK(run.passed);
    const auto compact = [](const RunResult& r) {
        std::vector<Sphere<Dim>> shell;
        for (std::size_t i = 0; i < packIn<Dim>(r).spheres.size(); ++i)
            if (packIn<Dim>(r).region[i] == 0) shell.push_back(packIn<Dim>(r).spheres[i]);
        return sorted(shell);
    };
    const auto before = compact(all), after = compact(run);
    CHECK(before == after);
    CHECK(packIn<Dim>(run).spheres.size() < packIn<Dim>(all).spheres.size());
    // What stays can be reported as connected; the rest can be dropped.
    recipe.request.keepConnected = true;
    const auto kept = runPack(recipe);
    CHECK(kept.report.voids->dropped > 0);
    CHECK(*run.report.voids->spheresAttached < 1);
    CHECK(compact(kept) == before);
}

DIM_TEST_CASE("spheres that stood before stay whatever the voids") {
    const TemporaryFolder folder;
    std::ofstream(folder.file("s.csv")) << "x,y,z,radius\n0,0,0,2\n3,4,0,1\n";
    for (const char* method : {"boolean", "threshold", "ellipses"}) {
        auto recipe = methodRecipe<Dim>(method);
        CAPTURE(method);
        recipe.existing = folder.file("s.csv");
        if (recipe.request.method == "boolean") recipe.request.targetBvtv = 0.05;
        recipe.request.keepConnected = true;
        const auto run = runPack(recipe);
        REQUIRE(packIn<Dim>(run).spheres.size() > 2);
        CHECK(packIn<Dim>(run).spheres[0].radius == 2);
        CHECK(packIn<Dim>(run).spheres[1].radius == 1);
    }
}

DIM_TEST_CASE("carve does to a pack what pack does with the same voids") {
    const TemporaryFolder folder;
    auto whole = packOf<Dim>("");
    whole.outputs = {folder.file("whole.csv")};
    runPack(whole);
    auto recipe = methodRecipe<Dim>("boolean");
    recipe.request.targetBvtv = 0.3;
    recipe.request.shell = 2;
    recipe.outputs = {"list:" + folder.file("l.csv")};
    const auto drawn = runPack(recipe);

    auto listed = packOf<Dim>("list:" + folder.file("l.csv"));
    listed.request.shell = 2;
    listed.request.cull = GENERATE(Cull::center, Cull::touch);
    listed.request.voxelSize = drawn.report.voids->voxelSize;
    const auto direct = runPack(listed);
    if (listed.request.cull == Cull::center) CHECK(direct.report.hash == drawn.report.hash);
    auto carve = onPack<CarveJob>(folder.file("whole.csv"), {}, folder.file("carved.csv"));
    carve.domain = listed.domain;
    carve.request = listed.request;
    const auto carved = runCarve(carve);
    CHECK(carved.passed);
    CHECK(carved.report.hash == direct.report.hash);
    CHECK(sorted(packIn<Dim>(carved).spheres) == sorted(packIn<Dim>(direct).spheres));
    CHECK(carved.report.voids->culled == direct.report.voids->culled);
    CHECK(packIn<Dim>(carved).region == packIn<Dim>(direct).region);
    CHECK(packIn<Dim>(carved).order == packIn<Dim>(direct).order);
    for (const char* method : {"concentric", "threshold", "grid", "overlay"}) {
        CAPTURE(method);
        auto one = methodRecipe<Dim>(method);
        one.request.shell = 2;
        carve.request = one.request;
        carve.outputs.clear();
        CHECK(runCarve(carve).report.hash == runPack(one).report.hash);
    }
}

TEST_CASE("carve takes any pack as it is, and keeps what it does not know") {
    const TemporaryFolder folder;
    const std::string file = folder.file("foreign.csv");
    {
        std::ofstream out(file);
        out << "name,z,y,x,radius,material,id\n";
        // A lattice that overlaps, one sphere in ten sticking out.
        int n = 0;
        for (int i = -5; i <= 5; ++i)
            for (int j = -5; j <= 5; ++j)
                for (int k = -5; k <= 5; ++k, ++n)
                    out << "s" << n << "," << k << "," << j << "," << i << ","
                        << (n % 10 == 0 ? 0.7 : 0.4) << "," << n % 3 << "," << 1000 - n % 7 + 10 * n
                        << "\n";
    }
    {
        std::ofstream list(folder.file("l.csv"));
        list << "x,y,z,a,b,ux,uy,uz\n0,0,0,4.5,2.5,0,1,1\n";
    }
    auto carve = onPack<CarveJob>(file, "box:11,11,11", folder.file("carved.csv"));
    carve.request.method = "list:" + folder.file("l.csv");
    const auto run = runCarve(carve);
    CHECK(run.passed);
    CHECK(run.report.inputOverlaps > 0);
    CHECK(run.report.inputProtrusions > 0);
    const auto before = readPack(file), after = readPack(folder.file("carved.csv"));
    const auto voids = readVoidList<3>(folder.file("l.csv"));
    std::map<std::array<double, 3>, std::size_t> at;
    for (std::size_t i = 0; i < before.spheres.size(); ++i) at[before.spheres[i].center.c] = i;
    std::size_t kept = 0;
    for (const auto& s : before.spheres) kept += voids[0].signedDistance(s.center) >= 0;
    CHECK(after.spheres.size() == kept);
    CHECK(run.report.voids->culled == before.spheres.size() - kept);
    const auto column = [](const Pack<3>& pack, const std::string& name) {
        for (const auto& c : pack.columns)
            if (c.name == name) return c;
        return Column{};
    };
    const auto names = column(after, "name"), materials = column(after, "material");
    REQUIRE(names.texts.size() == after.spheres.size());
    REQUIRE(materials.numbers.size() == after.spheres.size());
    REQUIRE(after.id.size() == after.spheres.size());
    std::size_t last = 0;
    for (std::size_t n = 0; n < after.spheres.size(); ++n) {
        const std::size_t i = at.at(after.spheres[n].center.c);
        if (n > 0) REQUIRE(i > last);  // in the order they were in
        last = i;
        REQUIRE(names.texts[n] == column(before, "name").texts[i]);
        REQUIRE(materials.numbers[n] == column(before, "material").numbers[i]);
        REQUIRE(after.id[n] == before.id[i]);
        REQUIRE(after.spheres[n].radius == before.spheres[i].radius);
    }
}
