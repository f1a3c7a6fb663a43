// --device: OpenCL takes the steps of relaxations, to the same pack. Here, PoCL is the device.
#include "densify/densifying.h"
#include "mesh/formats/mesh_files.h"
#include "support/generators.h"
#include "support/jobs.h"
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/core/error.h"

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <cstdlib>

namespace {

const DeviceChoice kProcessor{DeviceChoice::Kind::processor, 0},
    kDevice{DeviceChoice::Kind::gpu, 0};

/// Whether OpenCL has a device; tools/test needs one.
bool hasDevice() {
    auto options = to<3>(0.5, "");
    options.device = kDevice;
    try {
        densify<3>(*box<3>(8), {{{}, 1}}, options);
    } catch (const ParameterError& e) {
        if (std::getenv("VDBPACK_TEST_DEVICE") != nullptr) FAIL(e.what());
        WARN("skipped: " << e.what());
        return false;
    }
    return true;
}

/// Packs of the processor and of the device have the same bits.
template <int Dim>
void checkSame(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
               DensifyOptions options) {
    options.device = kProcessor;
    const auto expected = densify(domain, spheres, options);
    CHECK(expected.device.steps == 0);
    options.device = kDevice;
    const auto result = densify(domain, spheres, options);
    CHECK(result.device.steps >= expected.steps);
    CHECK_FALSE(result.device.name.empty());
    CHECK(expected.apart);
    CHECK((result.spheres == expected.spheres));
    CHECK(result.regions == expected.regions);
    CHECK(result.steps == expected.steps);
}

}  // namespace

DIM_TEST_CASE("a device makes the pack of the processor in boxes, balls and periodic cells") {
    if (!hasDevice()) return;
    const std::string spec = "uniform:1,2";
    const double side = Dim == 3 ? 24 : 80;
    PeriodicCell<Dim> cell{{Vec<Dim>(), Box<Dim>::filled(side)}, {}};
    cell.wraps.fill(true);
    for (const auto& domain : {box<Dim>(side), ballDomain<Dim>(side / 2), periodicDomain(cell)}) {
        const auto before = front(*domain, spec);
        auto options = to<Dim>(solidFraction(before, *domain) + 0.02, spec);
        checkSame(*domain, before, options);
        options.random = true;
        checkSame(*domain, {}, options);
        options.random = false;
        options.settle = true;
        checkSame(*domain, before, options);
    }
}

TEST_CASE(
    "a device makes the pack of the processor around fixed spheres, in regions and with gaps") {
    if (!hasDevice()) return;
    const auto domain = box<3>(24);
    const auto before = front(*domain, "uniform:1,2");
    auto options = to<3>(solidFraction(before, *domain) + 0.01, "");
    SECTION("fixed") {
        options.fixed = before.size() / 8;
    }
    SECTION("regions") {
        for (const auto& s : before) options.regions.push_back(s.center[0] > 0 ? 4 : -1);
    }
    SECTION("gap") {
        options.gap = 0.05;
        options.fraction -= 0.03;
        PackOptions packing(sizesOf("uniform:1,2", 3));
        packing.gap = options.gap;
        return checkSame(*domain, packSpheres(*domain, packing).pack.spheres, options);
    }
    SECTION("as dense as can be") {
        options.fraction = kMax;
    }
    checkSame(*domain, before, options);
}

TEST_CASE("a device makes the pack of the processor at walls of triangles and of sizes by place") {
    if (!hasDevice()) return;
    const TemporaryFolder folder;
    PackJob job = recipeFor("box:24,24,24", "uniform:1,2");
    job.densify.fraction = 0.61;
    SECTION("triangles") {
        job.densify.fraction = 0.6;
        job.domain.source = folder.file("torus.stl");
        putContent(job.domain.source, asciiStl(torusMesh(12, 5, 48, 24)));
    }
    SECTION("sizes by place, and a shell of its own sizes") {
        job.sizeField = folder.file("factors.csv");
        std::string table = "x,y,z,factor\n";
        for (int i = 0; i < 27; ++i)
            table += fmt::format("{},{},{},{}\n", 13 * (i % 3 - 1), 13 * (i / 3 % 3 - 1),
                                 13 * (i / 9 - 1), 1 - 0.25 * (i % 3));
        putContent(job.sizeField, table);
        job.shellRadius = SizeRequest::parse("uniform:0.5,0.8");
        setVoids(job.request, "boolean", "uniform:1.5,2", 0.1);
        job.request.shell = 2;
    }
    job.densify.device = kProcessor;
    const RunResult expected = runPack(job);
    job.densify.device = kDevice;
    const RunResult result = runPack(job);
    CHECK(result.report.densified->steps > 20);
    CHECK(result.report.device.steps >= result.report.densified->steps);
    CHECK(result.report.hash == expected.report.hash);
}

TEST_CASE("a device is chosen by kind and number, and named in the report") {
    if (!hasDevice()) return;
    const auto run = [&](const std::string& device) {
        return vdbPack("pack box:12,12,12 --radius uniform:1,2 --densify max --json --device '" +
                       device + "'");
    };
    CHECK(jsonOf(run("cpu"))["device"].is_null());
    CHECK(jsonOf(run("auto"))["device"].is_null());  // so few spheres need none
    const auto device = jsonOf(run("gpu:0"))["device"];
    CHECK(device["steps"] > 0);
    CHECK(device["seconds"] > 0);
    for (const char* word : {"gpu:", "gpu:x", "gpu:-1", "cuda", ""}) {
        CAPTURE(word);
        CHECK(run(word).code == 2);
    }
    const Output beyond = run("gpu:999");
    CHECK(beyond.code == 2);
    CHECK(beyond.text.find("gpu:0 ") != std::string::npos);  // what there is
}
