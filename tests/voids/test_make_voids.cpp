// Voids of a domain from C++, without a run.

#include "support/test.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/voids/make_voids.h"

namespace {

VoidRecipe recipeOf(VoidMethod method) {
    VoidRecipe recipe;
    recipe.method = std::move(method);
    recipe.voxelSize = 0.2;
    return recipe;
}

}  // namespace

TEST_CASE("voids are made of a domain until BV/TV is the target") {
    const auto ball = ballDomain<3>(6);
    BooleanVoids boolean;
    boolean.shape.radius = SizeDistribution::uniform(0.8, 1.2);
    boolean.targetBvtv = 0.3;
    FoamVoids foam;
    foam.shape.radius = SizeDistribution::uniform(0.8, 1.2);
    foam.targetBvtv = 0.3;
    const VoidRecipe recipe = recipeOf(GENERATE_COPY(VoidMethod(boolean), VoidMethod(foam)));
    CAPTURE(nameOf(recipe));
    const MadeVoids<3> made = makeVoids(*ball, recipe);
    CHECK(*made.report.bvtv == Approx(0.3).margin(0.003));
    CHECK(made.report.method == nameOf(recipe));
    CHECK(made.levelSets().size() == 3);
    CHECK(made.list.size() == made.report.count);
}

TEST_CASE("what a domain alone cannot have is refused") {
    const auto ball = ballDomain<3>(6);
    const auto refusal = [&](VoidMethod method) {
        return messageOf<ParameterError>([&] { makeVoids(*ball, recipeOf(std::move(method))); });
    };
    CHECK_THAT(refusal(BooleanVoids{}), Contains("`voids.radius`"));
    CHECK_THAT(refusal(FrontHoles{}), Contains("`voids` mixed"));
    CHECK_THAT(refusal(Thinning{}), Contains("`voids` concentric"));
    BooleanVoids large;
    large.shape.radius = SizeDistribution::constant(7);
    CHECK_THAT(refusal(large), Contains("12 mm"));
}
