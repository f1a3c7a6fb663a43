#include "support/image_file.h"
#include "support/test.h"

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/domain/pose.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/mesh/mesh_check.h"

namespace {

/// A text file of ITK. @param fixed  the center
std::string transformFile(const TemporaryFolder& folder, const std::string& parameters,
                          const std::string& fixed = "0 0 0",
                          const std::string& type = "AffineTransform_double_3_3") {
    const std::string file = folder.file("t.tfm");
    writeBytes(file, "#Insight Transform File V1.0\n#Transform 0\nTransform: " + type +
                         "\nParameters: " + parameters + "\nFixedParameters: " + fixed + "\n");
    return file;
}

AffineMap mapOf(const Pose& pose, std::vector<std::string>* warnings = nullptr,
                ImageSpace space = ImageSpace::lps) {
    DomainRecipe recipe;
    recipe.pose = pose;
    recipe.space = space;
    Callbacks callbacks;
    callbacks.warning = [&](const std::string& text) {
        if (warnings) warnings->push_back(text);
    };
    return poseMap(recipe, callbacks);
}

void checkNear(const Vec<3>& a, const Vec<3>& b) {
    CHECK(length(a - b) < 1e-12);
}

}  // namespace

TEST_CASE("a transform of 3D Slicer moves a part as Slicer moves a model") {
    // What Slicer writes for a translation by (-12, 14, 6) in its RAS: the inverse, in LPS.
    const TemporaryFolder folder;
    Pose pose;
    pose.file = transformFile(folder, "1 0 0 0 1 0 0 0 1 -12 14 -6");
    checkNear(mapOf(pose)({}), {{12, -14, 6}});
    checkNear(mapOf(pose, nullptr, ImageSpace::ras)({}), {{-12, 14, 6}});
    // y = A (x - c) + c + t takes (11, 0, 2) to (10, 1, 7).
    transformFile(folder, "0 -1 0 1 0 0 0 0 1 0 0 5", "10 0 0", "AffineTransform_float_3_3");
    checkNear(mapOf(pose)({{10, 1, 7}}), {{11, 0, 2}});
    // The same in RAS: x and y of both points have the other sign.
    checkNear(mapOf(pose, nullptr, ImageSpace::ras)({{-10, -1, 7}}), {{-11, 0, 2}});
}

TEST_CASE("a part is moved by its matrix, then turned, then shifted") {
    Pose pose;
    pose.rotate = parseRotation("0,0,2,90");
    CHECK(mapOf(pose)({{1, 0, 0}}) == Vec<3>{{0, 1, 0}});
    pose.rotate = parseRotation("0,0,1,90,1,1,0");
    CHECK(mapOf(pose)({{2, 1, 5}}) == Vec<3>{{1, 2, 5}});
    pose.rotate = parseRotation("1,1,1,120");  // takes x to y, y to z
    checkNear(mapOf(pose)({{1, 2, 3}}), {{3, 1, 2}});
    pose.rotate = parseRotation("0,0,1,90");
    pose.matrix = parseMatrix("1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1");
    pose.translate = {{0, 0, 3}};
    CHECK(mapOf(pose)({}) == Vec<3>{{0, 1, 3}});
}

TEST_CASE("a mirrored mesh faces outward, and what changes shapes is warned of") {
    DomainRecipe recipe;
    recipe.pose.matrix = parseMatrix("-2,0,0,0,0,2,0,0,0,0,2,0");
    std::vector<std::string> warnings;
    Callbacks callbacks;
    callbacks.warning = [&](const std::string& text) { warnings.push_back(text); };
    TriangleMesh mesh = boxMesh({{{1, 0, 0}}, {{2, 1, 1}}});
    place(mesh, recipe, callbacks);
    CHECK(checkMesh(mesh).enclosedVolume == Approx(8));
    CHECK(mesh.bounds().lo[0] == -4);
    REQUIRE(warnings.size() == 2);
    CHECK_THAT(warnings[0], Contains("by 2"));
    CHECK_THAT(warnings[1], Contains("mirrors"));
    mapOf({"", parseMatrix("1,0.01,0,0,0,1,0,0,0,0,1,0"), {}, {}}, &warnings);
    CHECK_THAT(warnings.back(), Contains("not rigid"));
}

TEST_CASE("meshes, images and their grids are placed, shapes are not") {
    const TemporaryFolder folder;
    writeStl(boxMesh({{{0, 0, 0}}, {{4, 2, 1}}}), folder.file("a.stl"), Unit::centimeter, "test");
    DomainRecipe recipe;
    recipe.source = folder.file("a.stl");
    recipe.pose.rotate = parseRotation("0,0,1,90");
    recipe.pose.translate = {{5, 0, 0}};
    const Box<3> moved = DomainSource(recipe).domainBounds();
    CHECK(length(moved.lo - Vec<3>{{3, 0, 0}}) < 1e-6);
    CHECK(length(moved.hi - Vec<3>{{5, 4, 1}}) < 1e-6);

    const ImageGrid grid = turned(gridAround(6, {{1, 1, 1.3}}), 0.3, 0.5);
    DomainRecipe image;
    image.source = folder.file("ball.mha");
    writeMeta(image.source,
              Voxels<std::uint8_t>::of(grid, [](const Vec<3>& p) { return length(p) < 5; }),
              "MET_UCHAR");
    const Vec<3> before = DomainSource(image).imageGrid()->origin;
    image.pose = recipe.pose;
    const DomainSource source(image);
    checkNear(source.imageGrid()->origin, {{5 - before[1], before[0], before[2]}});

    recipe.source = "box:1,2,3";
    CHECK_THAT(messageOf<ParameterError>([&] { DomainSource source2(recipe); }),
               Contains("only files can be moved"));
}

TEST_CASE("transforms that are not linear, or flatten, are refused with their kind") {
    const TemporaryFolder folder;
    Pose pose;
    const auto refusal = [&] { return messageOf<InputError>([&] { mapOf(pose); }); };
    pose.file = transformFile(folder, "0 0 0 0 0 0", "0 0 0", "VersorRigid3DTransform_double_3_3");
    CHECK_THAT(refusal(), Contains("holds a VersorRigid3DTransform"));
    transformFile(folder, "1 0 0 0 1 0 0 0 1 0 0");
    CHECK_THAT(refusal(), Contains("line 4: has 11 numbers"));
    transformFile(folder, "1 0 0 0 1 0 0 0 0 0 0 0");
    CHECK_THAT(refusal(), Contains("determinant is 0"));
    writeBytes(pose.file, "\x89HDF");
    CHECK_THAT(refusal(), Contains("no text file"));
    pose.matrix = parseMatrix("1,0,0,0,0,1,0,0,0,0,1,0");
    CHECK_THROWS_AS(mapOf(pose), ParameterError);
    for (const char* bad : {"1,2,3", "1,0,0,0,0,1,0,0,0,0,1,0,0,0,1,1", "1,x"})
        CHECK_THROWS_AS(parseMatrix(bad), ParameterError);
    CHECK_THROWS_AS(parseRotation("0,0,0,90"), ParameterError);
}
