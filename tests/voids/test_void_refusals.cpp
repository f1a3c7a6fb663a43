// Requests for voids that cannot be met, and leave nothing behind.
#include "support/message_of.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"
#include "voids/void_recipes.h"

#include "vdbpack/core/error.h"
#include "vdbpack/options/command_line.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;

TEST_CASE("what needs the front says so where there is none", "[run][voids]") {
    const TemporaryFolder folder;
    auto whole = packOf<3>("");
    whole.outputs = {folder.file("p.csv")};
    runPack(whole);
    for (const std::string method : {"mixed", "ellipses"}) {
        const VoidRequest voids = methodRecipe<3>(method).request;
        CarveJob carve;
        carve.pack = folder.file("p.csv");
        carve.domain = whole.domain;
        carve.request = voids;
        carve.outputs = {folder.file("c.csv")};
        const auto why = Contains("`voids` " + method);
        CHECK_THAT(messageOf<ParameterError>([&] { runCarve(carve); }), why);
        VoidsJob alone;
        alone.domain = whole.domain;
        alone.request = voids;
        alone.outputs = {folder.file("v.vdb")};
        CHECK_THAT(messageOf<ParameterError>([&] { runVoids(alone); }), why);
        CHECK_FALSE(std::filesystem::exists(folder.file("c.csv")));
        CHECK_FALSE(std::filesystem::exists(folder.file("v.vdb")));
    }
    VoidsJob thin;
    thin.domain = whole.domain;
    thin.request = methodRecipe<3>("threshold").request;
    CHECK_THAT(messageOf<ParameterError>([&] { runVoids(thin); }), Contains("`voids` threshold"));
    thin.request = {};
    CHECK_THAT(messageOf<ParameterError>([&] { runVoids(thin); }), Contains("`voids`"));
    CarveJob nothing;
    nothing.pack = folder.file("p.csv");
    nothing.domain = whole.domain;
    CHECK_THAT(messageOf<ParameterError>([&] { runCarve(nothing); }), Contains("`voids`"));
    nothing.request = methodRecipe<3>("threshold").request;
    nothing.domain = {};
    CHECK_THAT(messageOf<ParameterError>([&] { runCarve(nothing); }), Contains("`domain`"));
}

namespace {

/// Words of voids after a box of 24 mm, and what the message about them has.
struct Refusal {
    const char* words;
    const char* part;
};

/// Runs that are refused without leaving an output.
struct RefusedVoids {
    TemporaryFolder folder;

    std::string write(const std::string& name, const std::string& content) const {
        std::ofstream(folder.file(name)) << content;
        return folder.file(name);
    }
    template <class Failure>
    void refuse(const std::string& voids, const std::string& part,
                const std::string& domain = "box:24,24,24") const {
        std::vector<std::string> words{"pack",          domain, "--radius",
                                       "uniform:0.5,1", "-o",   folder.file("out.csv")};
        std::istringstream in(voids);
        for (std::string word; in >> word;) words.push_back(word);
        CAPTURE(voids, part);
        const auto message =
            messageOf<Failure>([&] { vdbpack::runPack(std::get<PackJob>(jobOf(words))); });
        CHECK_THAT(withOptionNames(message), Contains(part));
        CHECK_FALSE(std::filesystem::exists(folder.file("out.csv")));
    }
    void refuse(const std::vector<Refusal>& all) const {
        for (const Refusal& each : all) refuse<ParameterError>(each.words, each.part);
    }
};

}  // namespace

TEST_CASE_METHOD(RefusedVoids, "values of voids out of range are refused", "[run][voids]") {
    for (const std::string bad : {"-0.1", "1.1", "nan"}) {
        refuse<ParameterError>("--voids grid --void-cell 4 --void-probability=" + bad,
                               "--void-probability");
        refuse<ParameterError>("--voids mixed --void-radius uniform:2,3 --void-probability=" + bad,
                               "--void-probability");
        refuse<ParameterError>("--voids threshold --delete-fraction=" + bad, "--delete-fraction");
    }
    for (const std::string bad : {"0", "1", "-1", "nan"})
        refuse<ParameterError>("--voids boolean --target-bvtv=" + bad, "--target-bvtv");
    for (const std::string angles : {"tz=nan", "tz=uniform:0,inf", "tx=a"})
        refuse<ParameterError>("--voids boolean --void-angles " + angles, "angle '");
    refuse({{"--voids ellipses --void-probability 1", "--void-probability 1"},
            {"--voids boolean --void-angles phi=1", "'phi=1'"},
            {"--voids boolean --void-axis 0,0,0", "'0,0,0'"},
            {"--voids foam --void-jitter 1.5", "--void-jitter 1.5"},
            {"--voids boolean --void-radius uniform:2", "uniform"},
            {"--voids boolean --shell=-1", "--shell"},
            {"--voids boolean --shell nan", "--shell"},
            {"--voids boolean --void-voxel=-0.1", "--void-voxel"},
            {"--voids boolean --void-count 0", "--void-count 0"}});
}

TEST_CASE_METHOD(RefusedVoids, "voids and shells larger than the domain are refused",
                 "[run][voids]") {
    for (const std::string method : {"boolean", "overlay", "ellipses", "mixed"})
        refuse<ParameterError>("--voids " + method + " --void-radius constant:20", "24 mm");
    refuse<ParameterError>("--voids grid --void-cell 100", "24 mm");
    refuse<InputError>("--voids boolean --shell 12", "--shell 12 mm");
    refuse<InputError>("--shell 10000", "--shell 10000 mm");
}

TEST_CASE_METHOD(RefusedVoids, "files of voids that cannot be used are refused", "[run][voids]") {
    const auto field = write("field.csv", "x,y,z,ux,uy,uz\n0,0,0,1,0,0\n5,5,5,0,1,0\n");
    refuse<InputError>("--voids boolean --void-field " + field, "field.csv");
    for (const char* matrix : {"1 0\n1\n", "1 0\n2 0\n"})
        refuse<InputError>("--voids grid --void-matrix " + write("m.txt", matrix), "line 2");
    const auto list = [&](const std::string& rows) {
        return "--voids list:" + write("l.csv", "x,y,z,a,b\n" + rows);
    };
    refuse<InputError>(list("0,0,0,2,2\n1,1,1,-2,2\n"), "line 3");
    refuse<InputError>(list(""), "l.csv");
    refuse<ParameterError>(list("0,0,0,50,50\n"), "24 mm");
    refuse<IoError>("--voids list:" + folder.file("none.csv"), "none.csv");
    refuse({{"--voids holes", "grid, overlay"}, {"--voids list:", "grid, overlay"}});
    const auto layers = write("layers.txt", "1 0\n0 1\n\n0 1\n1 0\n");
    refuse<InputError>("--voids grid --void-matrix " + layers, "2 layers", "rect:100,100");
}

TEST_CASE_METHOD(RefusedVoids, "settings of voids that do not go together are refused",
                 "[run][voids]") {
    refuse({{"--voids boolean --void-probability 0.5", "--void-probability"},
            {"--voids boolean --void-jitter 0.5", "--void-jitter"},
            {"--voids grid --void-cell 4 --void-radius constant:1", "--void-radius"},
            {"--voids grid --void-cell 4 --void-axis 0,0,1", "--void-axis"},
            {"--voids mixed --void-aspect constant:2", "--void-aspect"},
            {"--voids mixed --cull touch", "--cull"},
            {"--voids overlay --target-bvtv 0.7 --target-tbth 0.2", "--target-tbth"},
            {"--voids threshold --delete-fraction 0.3 --void-voxel 0.1", "--void-voxel"},
            {"--target-bvtv 0.2", "--voids"},
            {"--voids boolean --target-tbth 0.2", "--target-bvtv"},
            {"--voids boolean --target-bvtv 0.2 --void-count 5", "--void-count and --target-bvtv"},
            {"--voids threshold", "--delete-fraction or --target-bvtv"},
            {"--voids grid", "--void-matrix or --void-cell"},
            {"--voids boolean --void-axis 0,0,1 --void-angles isotropic", "--void-axis"},
            {"--voids threshold --delete-fraction 0.3 -o list:l.csv", "list"}});
    refuse<ParameterError>("--voids foam --target-bvtv 0.3 --target-connd 0.2", "--target-connd",
                           "rect:100,100");
}
