// Requests for voids that cannot be met, and leave nothing behind.
#include "support/message_of.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"
#include "voids/void_recipes.h"

#include "vdbpack/core/error.h"
#include "vdbpack/run/run.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;

TEST_CASE("what needs the front says so where there is none", "[run][voids]") {
    const TemporaryFolder folder;
    auto whole = packOf<3>("");
    whole.outputs = {folder.file("p.csv")};
    runPack(whole);
    for (const std::string method : {"mixed", "ellipses"}) {
        const VoidRecipe voids = methodRecipe<3>(method).voids;
        CarveRecipe carve;
        carve.pack = folder.file("p.csv");
        carve.domain = whole.domain;
        carve.voids = voids;
        carve.outputs = {folder.file("c.csv")};
        const auto why = Contains("`voids` " + method);
        CHECK_THAT(messageOf<ParameterError>([&] { runCarve(carve); }), why);
        VoidsRecipe alone;
        alone.domain = whole.domain;
        alone.voids = voids;
        alone.outputs = {folder.file("v.vdb")};
        CHECK_THAT(messageOf<ParameterError>([&] { runVoids(alone); }), why);
        CHECK_FALSE(std::filesystem::exists(folder.file("c.csv")));
        CHECK_FALSE(std::filesystem::exists(folder.file("v.vdb")));
    }
    VoidsRecipe thin;
    thin.domain = whole.domain;
    thin.voids = methodRecipe<3>("threshold").voids;
    CHECK_THAT(messageOf<ParameterError>([&] { runVoids(thin); }), Contains("`voids` threshold"));
    thin.voids = {};
    CHECK_THAT(messageOf<ParameterError>([&] { runVoids(thin); }), Contains("`voids`"));
    CarveRecipe nothing;
    nothing.pack = folder.file("p.csv");
    nothing.domain = whole.domain;
    CHECK_THAT(messageOf<ParameterError>([&] { runCarve(nothing); }), Contains("`voids`"));
    nothing.voids = methodRecipe<3>("threshold").voids;
    nothing.domain = {};
    CHECK_THAT(messageOf<ParameterError>([&] { runCarve(nothing); }), Contains("`domain`"));
}

namespace {

using R = PackRecipe;
const ParameterError parameter("");
const InputError input("");

/// Runs that are refused without leaving an output.
struct RefusedVoids {
    TemporaryFolder folder;
    std::string out = folder.file("out.csv");

    std::string write(const std::string& name, const std::string& content) const {
        std::ofstream(folder.file(name)) << content;
        return folder.file(name);
    }
    template <class Failure>
    void refuse(const Failure&, const std::string& method,
                const std::function<void(PackRecipe&)>& change, const std::string& part) const {
        PackRecipe recipe = methodRecipe<3>(method);
        recipe.outputs = {out};
        change(recipe);
        CAPTURE(method, part);
        CHECK_THAT(messageOf<Failure>([&] { runPack(recipe); }), Contains(part));
        CHECK_FALSE(std::filesystem::exists(out));
    }
};

}  // namespace

TEST_CASE_METHOD(RefusedVoids, "numbers of voids out of range are refused", "[run][voids]") {
    for (const double p : {-0.1, 1.1, std::nan("")}) {
        refuse(
            parameter, "grid", [&](R& r) { r.voids.probability = p; }, "`voids.probability`");
        refuse(
            parameter, "mixed", [&](R& r) { r.voids.probability = p; }, "`voids.probability`");
        refuse(
            parameter, "threshold", [&](R& r) { r.voids.deleteFraction = p; }, "`deleteFraction`");
    }
    refuse(
        parameter, "ellipses", [](R& r) { r.voids.probability = 1; }, "`voids.probability` 1");
    for (const double f : {0.0, 1.0, -1.0, std::nan("")})
        refuse(
            parameter, "boolean", [&](R& r) { r.voids.targetBvtv = f; }, "`targetBvtv`");
    for (const char* angles : {"tz=nan", "tz=uniform:0,inf", "tx=a"})
        refuse(
            parameter, "boolean", [&](R& r) { r.voids.orientation.angles = angles; }, "angle '");
    refuse(
        parameter, "boolean", [](R& r) { r.voids.orientation.angles = "phi=1"; }, "'phi=1'");
    refuse(
        parameter, "boolean", [](R& r) { r.voids.orientation.axis = "0,0,0"; }, "'0,0,0'");
}

TEST_CASE_METHOD(RefusedVoids,
                 "voids and shells larger than the domain are refused, and sizes that are none",
                 "[run][voids]") {
    refuse(
        parameter, "boolean", [](R& r) { r.voids.radius = "constant:20"; }, "24 mm");
    refuse(
        parameter, "overlay", [](R& r) { r.voids.radius = "constant:20"; }, "24 mm");
    refuse(
        parameter, "foam", [](R& r) { r.voids.jitter = 1.5; }, "`voids.jitter` 1.5");
    refuse(
        parameter, "boolean", [](R& r) { r.voids.jitter = 0.5; }, "`voids.jitter`");
    refuse(
        parameter, "ellipses", [](R& r) { r.voids.radius = "constant:20"; }, "24 mm");
    refuse(
        parameter, "mixed", [](R& r) { r.voids.radius = "constant:20"; }, "24 mm");
    refuse(
        parameter, "grid", [](R& r) { r.voids.cell = "100"; }, "24 mm");
    refuse(
        parameter, "boolean", [](R& r) { r.voids.radius = "uniform:2"; }, "uniform");
    refuse(
        input, "boolean", [](R& r) { r.voids.shell = 12; }, "`shell` 12 mm");
    refuse(
        input, "",
        [](R& r) {
            r.voids = {};
            r.voids.shell = 1e4;
        },
        "`shell` 10000 mm");
    refuse(
        parameter, "boolean", [](R& r) { r.voids.shell = -1; }, "`voids.shell` -1");
    refuse(
        parameter, "boolean", [](R& r) { r.voids.shell = std::nan(""); }, "`voids.shell` nan");
    refuse(
        parameter, "boolean", [](R& r) { r.voids.voxelSize = -0.1; }, "`voids.voxelSize` -0.1");
    refuse(
        parameter, "boolean", [](R& r) { r.voids.count = 0; }, "`voids.count` 0");
}

TEST_CASE_METHOD(RefusedVoids, "files of voids that cannot be used are refused", "[run][voids]") {
    const auto field = write("field.csv", "x,y,z,ux,uy,uz\n0,0,0,1,0,0\n5,5,5,0,1,0\n");
    refuse(
        input, "boolean", [&](R& r) { r.voids.orientation.field = field; }, "field.csv");
    const auto ragged = write("ragged.txt", "1 0\n1\n"), other = write("other.txt", "1 0\n2 0\n");
    refuse(
        input, "grid",
        [&](R& r) {
            r.voids.matrix = ragged;
            r.voids.cell.clear();
        },
        "line 2");
    refuse(
        input, "grid",
        [&](R& r) {
            r.voids.matrix = other;
            r.voids.cell.clear();
        },
        "line 2");
    const auto negative = write("negative.csv", "x,y,z,a,b\n0,0,0,2,2\n1,1,1,-2,2\n");
    const auto empty = write("empty.csv", "x,y,z,a,b\n");
    const auto large = write("large.csv", "x,y,z,a,b\n0,0,0,50,50\n");
    const auto method = [](const std::string& name) {
        return [=](R& r) {
            r.voids = {};
            r.voids.method = name;
        };
    };
    refuse(input, "", method("list:" + negative), "line 3");
    refuse(input, "", method("list:" + empty), "empty.csv");
    refuse(parameter, "", method("list:" + large), "24 mm");
    refuse(IoError(""), "", method("list:" + folder.file("none.csv")), "none.csv");
    refuse(parameter, "", method("holes"), "grid, overlay");
    refuse(parameter, "", method("list:"), "grid, overlay");
}

TEST_CASE_METHOD(RefusedVoids, "settings without effect on the method are refused",
                 "[run][voids]") {
    refuse(
        parameter, "boolean", [](R& r) { r.voids.probability = 0.5; }, "`voids.probability`");
    refuse(
        parameter, "grid", [](R& r) { r.voids.radius = "constant:1"; }, "`voids.radius`");
    refuse(
        parameter, "grid", [](R& r) { r.voids.orientation.axis = "0,0,1"; }, "`orientation.axis`");
    refuse(
        parameter, "mixed", [](R& r) { r.voids.aspect = "constant:2"; }, "`voids.aspect`");
    refuse(
        parameter, "mixed", [](R& r) { r.voids.cull = Cull::touch; }, "`cull`");
    refuse(
        parameter, "overlay",
        [](R& r) {
            r.voids.targetBvtv = 0.7;
            r.voids.targetTbth = 0.2;
        },
        "`targetTbth`");
    refuse(
        parameter, "threshold", [](R& r) { r.voids.voxelSize = 0.1; }, "`voids.voxelSize`");
    refuse(
        parameter, "", [](R& r) { r.voids.targetBvtv = 0.2; }, "`voids`");
}

TEST_CASE_METHOD(RefusedVoids, "missing and contradicting settings of voids are refused",
                 "[run][voids]") {
    refuse(
        parameter, "boolean", [](R& r) { r.voids.targetTbth = 0.2; }, "`targetBvtv`");
    refuse(
        parameter, "boolean",
        [](R& r) {
            r.voids.targetBvtv = 0.2;
            r.voids.count = 5;
        },
        "`voids.count` and `targetBvtv`");
    refuse(
        parameter, "threshold", [](R& r) { r.voids.deleteFraction.reset(); },
        "`deleteFraction` or `targetBvtv`");
    refuse(
        parameter, "grid", [](R& r) { r.voids.cell.clear(); }, "`matrix` or `cell`");
    refuse(
        parameter, "boolean",
        [](R& r) {
            r.voids.orientation.axis = "0,0,1";
            r.voids.orientation.angles = "isotropic";
        },
        "`orientation.axis`");
    refuse(
        parameter, "threshold", [&](R& r) { r.outputs = {"list:" + out}; }, "list");
}

TEST_CASE_METHOD(RefusedVoids, "voids that a plane has no room for are refused", "[run][voids]") {
    PackRecipe plane = methodRecipe<2>("foam");
    plane.voids.targetBvtv = 0.3;
    plane.voids.targetConnd = 0.2;
    CHECK_THAT(messageOf<ParameterError>([&] { runPack(plane); }), Contains("`targetConnd`"));
    const auto layers = write("layers.txt", "1 0\n0 1\n\n0 1\n1 0\n");
    plane = methodRecipe<2>("grid");
    plane.voids.cell.clear();
    plane.voids.matrix = layers;
    CHECK_THAT(messageOf<InputError>([&] { runPack(plane); }),
               Contains("layers.txt") && Contains("2 layers"));
}
