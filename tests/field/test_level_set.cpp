// Level sets as domains.
#include "support/generators.h"
#include "support/grids.h"
#include "support/test.h"
#include "voids/stamping.h"

#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/vdb_init.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/mesh/mesh_check.h"

namespace {

FieldOptions options(double voxelSize) {
    FieldOptions o;
    o.voxelSize = voxelSize;
    o.depth = 2;
    return o;
}

void writeGrids(const std::string& path, const openvdb::GridPtrVec& grids) {
    openvdb::io::File file(path);
    file.write(grids);
    file.close();
}

}  // namespace

TEST_CASE("the surface grid of a mesh is a symmetric level set in mm of the mesh") {
    const Vec<3> center{{700, -30, 5}};
    const double cavity = GENERATE(0.0, 4.0);
    auto mesh = ballMesh(8, 4, center);
    if (cavity > 0) mesh = merged(mesh, ballMesh(cavity, 4, center));
    const auto domain = meshDomain(mesh, options(0.4));
    const auto& grid = *domain->grid()->grid;
    REQUIRE(grid.getName() == "surface");
    REQUIRE(grid.getGridClass() == openvdb::GRID_LEVEL_SET);
    REQUIRE(grid.hasUniformVoxels());
    REQUIRE(grid.voxelSize()[0] == Approx(0.4));
    REQUIRE(grid.background() == Approx(1.2));
    for (auto value = grid.cbeginValueAll(); value; ++value) {
        REQUIRE(std::abs(*value) <= grid.background());
        REQUIRE(value.isValueOn() == (std::abs(*value) < grid.background()));
    }
    auto accessor = grid.getConstAccessor();
    const auto at = [&](double x) {
        const openvdb::Vec3d place(center[0] + x, center[1], center[2]);
        return static_cast<double>(
            accessor.getValue(grid.transform().worldToIndexNodeCentered(place)));
    };
    REQUIRE(at(0) == Approx(cavity > 0 ? 1.2 : -1.2));
    REQUIRE(at(6) == Approx(-1.2));
    REQUIRE(at(20) == Approx(1.2));
    REQUIRE(at(7.5) == Approx(-0.5).margin(0.36));
    REQUIRE(at(8.5) == Approx(0.5).margin(0.36));
    REQUIRE(domain->grid() == domain->grid());
}

TEST_CASE("a level set written and read is the same domain") {
    const TemporaryFolder folder;
    const Vec<3> center{{300, 20, -10}};
    const auto mesh = merged(ballMesh(8, 5, center), ballMesh(4, 5, center));
    const auto first = meshDomain(mesh, options(0.4));
    const std::string path = folder.file("bone.vdb");
    writeGrids(path, {first->grid()->grid});

    const auto again = levelSetDomain(path, "", 1, options(0.4));
    REQUIRE(again->facts().kind == "levelset");
    REQUIRE(again->volume() == Approx(first->volume()).epsilon(0.01));
    // The contour faces outward.
    REQUIRE(checkMesh(again->wall()).signedVolume == Approx(first->volume()).epsilon(0.01));
    const auto asker = again->sampler();
    REQUIRE(asker->signedDistance(center) > 0);
    REQUIRE(asker->signedDistance(center + Vec<3>{{6, 0, 0}}) < -1);
    REQUIRE(asker->signedDistance(center + Vec<3>{{9, 0, 0}}) > 0);

    // In a file in meters the same numbers are a thousand times as large.
    const auto meters = levelSetMesh(path, "surface", 1000);
    REQUIRE(meters.bounds().center()[0] == Approx(3e5).epsilon(1e-5));
    REQUIRE(meters.bounds().size()[0] == Approx(16000).epsilon(0.01));
    REQUIRE_THROWS_WITH(levelSetMesh(path, "solid", 1),
                        Contains("'solid'") && Contains("'surface'"));
    REQUIRE_THROWS_AS(levelSetMesh(path, "surface", 0), ParameterError);
}

TEST_CASE("grids that are no level sets of cubes are refused with a reason") {
    const TemporaryFolder folder;
    const std::string path = folder.file("grids.vdb");
    const auto grid = [](float background, const char* name = "surface",
                         openvdb::GridClass kind = openvdb::GRID_LEVEL_SET) {
        const auto made = newGrid<openvdb::FloatGrid>(background);
        made->setName(name);
        made->setGridClass(kind);
        return made;
    };
    const auto refused = [&](const openvdb::FloatGrid::Ptr& made, const std::string& reason,
                             const char* name = "") {
        writeGrids(path, {made});
        REQUIRE_THROWS_WITH(levelSetMesh(path, name, 1), Contains(reason));
    };
    const auto fog = grid(0, "density", openvdb::GRID_FOG_VOLUME);
    fog->tree().setValue({0, 0, 0}, 1);
    refused(fog, "density");
    refused(fog, "'density'", "density");
    const auto stretched = grid(3);
    stretched->tree().setValue({0, 0, 0}, -1);
    openvdb::math::Mat4d matrix = openvdb::math::Mat4d::identity();
    matrix[0][0] = 2;
    stretched->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    refused(stretched, path);
    const auto empty = grid(3);
    refused(empty, path);
    empty->tree().setValue({1, 2, 3}, std::nanf(""));
    refused(empty, "(1, 2, 3)");
    const auto flat = grid(0);
    flat->tree().setValue({0, 0, 0}, -1);
    refused(flat, "background");
}

TEST_CASE("a fog volume has its surface where its values pass the threshold") {
    const TemporaryFolder folder;
    const std::string path = folder.file("fog.vdb");
    // From 2 in the middle to 0 at a distance of 10 mm; a hollow of 4 mm.
    const double voxelSize = 0.5, unit = 10;
    const auto fog = newGrid<openvdb::FloatGrid>(0);
    fog->setName("density");
    fog->setGridClass(openvdb::GRID_FOG_VOLUME);
    fog->setTransform(openvdb::math::Transform::createLinearTransform(voxelSize / unit));
    for (int x = -24; x <= 24; ++x)
        for (int y = -24; y <= 24; ++y)
            for (int z = -24; z <= 24; ++z) {
                const double r = openvdb::Vec3d(x, y, z).length() * voxelSize;
                const double value = std::min(0.2 * (10 - r), 2 * (r - 4) + 1);
                if (value > 0)
                    fog->tree().setValue(openvdb::Coord(x, y, z), static_cast<float>(value));
            }
    writeGrids(path, {fog});
    const auto found = findFogVolume(path, "", false);
    REQUIRE(found);
    CHECK(found->grid == "density");
    CHECK(found->lowest == 0);
    CHECK(found->highest > 1);
    for (const double threshold : {0.2, 0.6}) {
        const MeshHealth health = checkMesh(fogVolumeMesh(path, "density", unit, threshold));
        const double outer = 10 - threshold / 0.2, inner = 4 + (threshold - 1) / 2;
        CHECK(health.isWatertight());
        CHECK(health.signedVolume == Approx(health.enclosedVolume));
        CHECK(health.enclosedVolume ==
              Approx(Measure<3>::ball(outer) - Measure<3>::ball(inner)).epsilon(0.03));
    }
    for (const double threshold : {0.0, -1.0, 2.5})
        CHECK_THROWS_WITH(fogVolumeMesh(path, "", unit, threshold),
                          Contains("density") && Contains("`threshold`"));
    CHECK_THROWS_WITH(fogVolumeMesh(path, "other", unit, 1), Contains("'other'"));
    CHECK_THROWS_WITH(readPack(path), Contains("no point grid") && Contains("`threshold`"));
}

TEST_CASE("level sets whose voxels lie aslant are sampled, not copied") {
    initializeOpenVdb();
    auto ball = ballGrid(2.0f, openvdb::Vec3f(0), 0.1f);
    const auto transform = openvdb::math::Transform::createLinearTransform(0.1);
    transform->postRotate(0.5, openvdb::math::Z_AXIS);
    transform->postTranslate(openvdb::Vec3d(7, 8, 9));
    ball->setTransform(transform);
    const VdbGrid grid(ball);
    REQUIRE_THROWS_AS(sampleLevelSet(grid), InputError);
    REQUIRE_THROWS_WITH(sampleLevelSet(grid), Contains("voxel size"));
    const auto image = sampleLevelSet(grid, {}, 0.1);
    for (std::size_t i = 0; i < image.voxels(); i += 29) {
        const double exact = length(centerOf(image, i) - Vec<3>{{7, 8, 9}}) - 2.0;
        const double value{image.distance[i]};
        if (std::abs(exact) < 0.15)
            REQUIRE(value == Approx(exact).margin(0.01));
        else
            REQUIRE((value < 0) == (exact < 0));
    }

    const VdbGrid empty(openvdb::FloatGrid::create(0.3f));
    REQUIRE_THROWS_AS(sampleLevelSet(empty), InputError);
    REQUIRE_THROWS_WITH(sampleLevelSet(empty), Contains("level set"));
}
