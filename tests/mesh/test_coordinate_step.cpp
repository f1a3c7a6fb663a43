#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/mesh/coordinate_step.h"

#include <cstdio>

namespace {

TriangleMesh rounded(TriangleMesh mesh, double step) {
    for (auto& v : mesh.vertices)
        for (double& c : v.c)
            c = step > 0 ? std::round(c / step) * step : static_cast<double>(static_cast<float>(c));
    return mesh;
}

/// As programs write text: so many significant digits.
void writeText(const TriangleMesh& mesh, int digits, const std::string& path) {
    std::FILE* file = std::fopen(path.c_str(), "w");
    REQUIRE(file);
    for (const auto& v : mesh.vertices)
        std::fprintf(file, "v %.*g %.*g %.*g\n", digits, v[0], digits, v[1], digits, v[2]);
    for (const auto& t : mesh.triangles)
        std::fprintf(file, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
    std::fclose(file);
}

}  // namespace

TEST_CASE("the step between coordinates is reported") {
    const auto ball = ballMesh(10, 3);
    const auto at = [&](double far) { return translated(ball, {{far, -far, far}}); };
    CHECK(coordinateStep(at(1234.5), 1) == 0);  // double
    CHECK(coordinateStep(rounded(at(1e6), 0), 1) == 0.0625);
    CHECK(coordinateStep(rounded(at(1e4), 0), 1) == Approx(0x1p-10));
    CHECK(coordinateStep(rounded(at(1e6), 0.1), 1) == Approx(0.1));
    CHECK(coordinateStep(rounded(at(1e6), 0.001), 1) == Approx(0.001));
    CHECK(coordinateStep(rounded(at(0), 0.01), 1) == Approx(0.01));
    // In the file's unit: meters in steps of a tenth of a millimeter.
    auto meters = rounded(at(1e6), 0.1);
    CHECK(coordinateStep(meters, 1000) == Approx(0.1));
    CHECK(medianEdge(ball) > 0.5);
    CHECK(medianEdge(ball) < 3);
}

TEST_CASE("a file that has lost its digits far from the origin is reported") {
    const TemporaryFolder folder;
    const auto warnings = [&](double far, int digits) {
        const std::string path = folder.file("b.obj");
        writeText(translated(ballMesh(10, 3), {{far, far, far}}), digits, path);
        std::vector<std::string> told;
        Callbacks callbacks;
        callbacks.warning = [&](const std::string& text) { told.push_back(text); };
        DomainRecipe recipe;
        recipe.source = path;
        const DomainSource source(recipe, callbacks);
        return told;
    };
    CHECK(warnings(0, 6).empty());
    CHECK(warnings(1e4, 9).empty());
    CHECK(warnings(1e6, 12).empty());
    const auto told = warnings(2e6, 8);  // as many as a 32-bit float has
    REQUIRE(told.size() == 1);
    CHECK_THAT(told[0], Contains("0.1 mm") && Contains("3.46e+06 mm"));
}
