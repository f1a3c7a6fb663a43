#include "report/sample_report.h"
#include "support/test.h"

#include <nlohmann/json.hpp>

namespace {

Report fullReport() {
    Report r = sampleReport();
    r.domain.triangles = 624608;
    r.domain.meshVolume = 12345.5;
    r.domain.voxelSize = 0.3;
    r.domain.activeVoxels = 2900000;
    r.domain.boundaryEdges = 3;
    r.area = 4567;
    r.contacts->histogram = {1, 1101920};
    r.contacts->modulusRatio = 1.5;
    r.contacts->stiffest = {{0.6, 0.8, 0}};
    r.wallSizes = Report::WallSizes{};
    r.seconds.domain = 1.5;
    r.densified = Report::Densified{};
    r.densified->requested = 0.65;
    r.densified->contactsAfter = {0.4, 5, 7};
    r.densified->solidLike = 0.01;
    r.peakMemoryBytes = 300 << 20;
    r.chosen = {
        "radius uniform:0.31,0.62, so that about 100,000 spheres fill the domain; say "
        "--radius or --target-count to choose",
        "voxels of 0.3 mm"};
    r.files = {"femur.vdb"};
    return r;
}

}  // namespace

TEST_CASE("the report has the keys that scripts rely on") {
    const auto json = toJson(fullReport());
    const auto expected = nlohmann::ordered_json::parse(R"({
      "version": "", "command": "", "unit": "mm", "axes": null, "seed": 1, "threads": 2, "ranks": 1, "hash": "", "interrupted": false, "found": [],
      "domain": {"kind": "", "triangles": 0, "volume": 0, "meshVolume": 0, "area": 0,
                 "voxelSize": 0, "activeVoxels": 0, "boundaryEdges": 0, "nonManifoldEdges": 0},
      "spheres": {"count": 0, "existing": 0, "requested": "", "radius": {"min":0,"mean":0,"max":0,"sd":0},
                  "ks": 0, "ksByVolume": 0, "wall": {"depth": 0, "count": 0, "ks": 0, "ksByVolume": 0}},
      "solidFraction": {"total": 0, "interior": 0},
      "massOffset": {"axes": [0, 0, 0], "length": 0, "share": 0},
      "contacts": {"mean": 0, "tolerance": 0, "meanOfSpheres": 0, "wallsKnown": true, "pairs": 0,
                   "wall": 0, "histogram": [0, 1], "few": {"below": 4, "share": 0},
                   "components": 0, "largestComponent": 0,
                   "modulus": {"ratio": 0, "direction": [0, 0, 0], "deepContacts": 0},
                   "fabric": {"tensor": [[0, 0, 0], [0, 0, 0], [0, 0, 0]],
                              "eigenvalues": [0, 0, 0], "direction": [0, 0, 0]}},
      "overlap": {"max": 0, "pairs": 0},
      "gap": {"asked": 0, "min": 0},
      "protrusion": {"max": 0, "spheres": 0, "centersOutside": 0},
      "densified": {"asked": 0.65, "start": "pack", "before": 0, "after": 0, "inserted": 0, "steps": 0, "stages": 0,
                    "contacts": [{"tolerance": 0, "before": 0, "after": 0},
                                 {"tolerance": 0, "before": 0, "after": 0},
                                 {"tolerance": 0, "before": 0, "after": 0}], "solidLike": 0},
      "voids": {"count": 0, "bvtv": 0, "culled": 0},
      "seconds": {"mesh": 0, "domain": 0, "pack": 0, "settle": 0, "densify": 0, "voids": 0, "measure": 0, "write": 0,
                  "total": 0},
      "peakMemoryBytes": 0, "warnings": []})");
    const auto keys = [](const nlohmann::ordered_json& j) {
        std::vector<std::string> names;
        const auto flat = j.flatten();
        for (auto it = flat.begin(); it != flat.end(); ++it) names.push_back(it.key());
        return names;
    };
    REQUIRE(keys(json) == keys(expected));
    REQUIRE(json["hash"] == "0000000000000abc");
    REQUIRE(json["spheres"]["count"] == 1101921);
    REQUIRE(json["solidFraction"]["interior"] == 0.62);
    REQUIRE(json["voids"]["bvtv"].is_null());
    REQUIRE(json["massOffset"]["axes"].dump() == "[0.3,null,-0.4]");
}

TEST_CASE("what was not measured is null") {
    const auto json = toJson(Report{});
    for (const char* path :
         {"/spheres/ks", "/spheres/requested", "/spheres/radius/min", "/solidFraction/total",
          "/solidFraction/interior", "/massOffset", "/contacts/mean", "/overlap/max",
          "/overlap/pairs", "/protrusion/max", "/protrusion/spheres", "/protrusion/centersOutside",
          "/voids/bvtv", "/domain/meshVolume"}) {
        CAPTURE(path);
        REQUIRE(json.at(nlohmann::ordered_json::json_pointer(path)).is_null());
    }
}

TEST_CASE("the summary fits a terminal and says what matters") {
    auto report = fullReport();
    const auto text = summary(report);
    CAPTURE(text);
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::size_t columns = 0;
        for (const char c : line) columns += (static_cast<unsigned char>(c) & 0xC0) != 0x80;
        REQUIRE(columns <= 80);
    }
    REQUIRE(text.back() == '\n');
    REQUIRE_THAT(text, Contains("1,101,921") && Contains("0.5860") &&
                           Contains("624,608 triangles") && Contains("femur.vdb") &&
                           Contains("center of mass 0.5 mm (0.5 % of the length) off") &&
                           Contains("estimated modulus along (0.6, 0.8, 0) 1.50 times") &&
                           Contains("pack 10.00") && !Contains("FAILED"));
    report.contacts->modulusRatio = 0;
    report.massOffset.reset();
    REQUIRE_THAT(summary(report), !Contains("modulus") && !Contains("center of mass"));
    report.overlap->pairs = 12;
    report.overlap->max = 0.25;
    REQUIRE_THAT(summary(report), Contains("CHECK FAILED: 12 pairs"));
    report.dim = 2;
    REQUIRE_THAT(summary(report), Contains("circles") && Contains("mm²"));
}
