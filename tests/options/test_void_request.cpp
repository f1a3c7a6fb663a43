// Options of voids become a recipe of their method.
#include "support/message_of.h"

#include "vdbpack/core/error.h"
#include "vdbpack/options/jobs.h"

#include <catch2/catch.hpp>

#include <string>
#include <utility>
#include <vector>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;

namespace {

VoidRequest requestOf(const std::string& method) {
    VoidRequest request;
    request.method = method;
    return request;
}

std::string refusalOf(const VoidRequest& request) {
    return messageOf<ParameterError>([&] { voidsOf(request); });
}

}  // namespace

TEST_CASE("each method is named as it was requested", "[options][voids]") {
    const std::string method = GENERATE("", "grid", "overlay", "boolean", "foam", "list:v.csv",
                                        "concentric", "threshold", "mixed", "ellipses");
    CHECK(nameOf(voidsOf(requestOf(method))) == method);
}

TEST_CASE("options of voids arrive in the recipe of their method", "[options][voids]") {
    VoidRequest request = requestOf("boolean");
    request.radius = "uniform:1,2";
    request.aspect = "constant:1.5";
    request.targetBvtv = 0.3;
    request.bvtvField = "ct.nii";
    request.bvtvRange = "0,1200";
    request.shell = 2;
    request.cull = Cull::touch;
    request.blend = 0.1;
    const VoidRecipe recipe = voidsOf(request);
    const auto* voids = recipe.as<BooleanVoids>();
    REQUIRE(voids);
    CHECK(voids->shape.radius.in(3).max() == 2);
    CHECK(voids->shape.aspect.in(2).mean() == 1.5);
    CHECK(voids->targetBvtv == 0.3);
    CHECK(voids->bvtvField.file == "ct.nii");
    CHECK(voids->bvtvField.range == std::pair{0.0, 1200.0});
    CHECK(recipe.shell == 2);
    CHECK(recipe.cull == Cull::touch);
    CHECK(recipe.blend == 0.1);
}

TEST_CASE("an option that the method does not use is refused with the methods that use it",
          "[options][voids]") {
    VoidRequest request = requestOf("boolean");
    request.probability = 0.5;
    CHECK_THAT(refusalOf(request), Contains("`voids.probability`") && Contains("boolean") &&
                                       Contains("grid, mixed, ellipses"));
    request = requestOf("list:v.csv");
    request.targetBvtv = 0.3;
    CHECK_THAT(refusalOf(request), Contains("`targetBvtv`") && Contains("foam"));
    request = requestOf("");
    request.aspect = "constant:2";
    CHECK_THAT(refusalOf(request), Contains("`voids.aspect`") && Contains("`voids`"));
}

TEST_CASE("malformed texts of voids are refused with the text", "[options][voids]") {
    for (const char* cell : {"a", "1,", ",1", "nan", "inf", "1 2 3"}) {
        VoidRequest request = requestOf("grid");
        request.cell = cell;
        CHECK_THAT(refusalOf(request), Contains("`cell` " + std::string(cell)));
    }
    for (const char* range : {"5", "a,b", "1,2,3"}) {
        VoidRequest request = requestOf("foam");
        request.bvtvRange = range;
        CHECK_THAT(refusalOf(request), Contains("`bvtvRange`") && Contains(range));
    }
    VoidRequest request = requestOf("foam");
    request.radius = "uniform:2";
    CHECK_THAT(refusalOf(request), Contains("uniform:2"));
    for (const char* method : {"holes", "list:", "Grid"})
        CHECK_THAT(refusalOf(requestOf(method)), Contains(method) && Contains("list:FILE"));
}
