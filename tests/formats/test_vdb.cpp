// What stands in a .vdb file, seen through OpenVDB itself.
#include "formats/file_text.h"
#include "formats/lattice_pack.h"
#include "support/grids.h"
#include "support/test.h"

#include <openvdb/points/PointConversion.h>
#include <openvdb/points/PointCount.h>
#include <openvdb/points/PointDataGrid.h>

namespace points = openvdb::points;

namespace {

/// All grids of a file, and the file that they are still tied to.
struct Opened {
    explicit Opened(const std::string& path) : file(path) {
        openvdb::initialize();
        file.open();
        grids = file.getGrids();
    }
    openvdb::GridBase::Ptr grid(const std::string& name) const {
        for (const auto& g : *grids)
            if (g->getName() == name) return g;
        return nullptr;
    }
    openvdb::io::File file;
    openvdb::GridPtrVecPtr grids;
};

std::shared_ptr<const VdbGrid> ballSurface() {
    return std::make_shared<VdbGrid>(ballGrid(10.0f, openvdb::Vec3f(3, 4, 5), 0.5f));
}

}  // namespace

TEST_CASE("the point grid is what viewers expect") {
    const TemporaryFolder scratch;
    const auto pack = latticePack<3>(5000, {{200, 0, -50}}, 40, 31);
    PackWriteOptions options;
    options.generator = "vdb_pack test";
    writePack(pack, scratch.file("p.vdb"), options);
    const Opened opened(scratch.file("p.vdb"));
    REQUIRE(opened.grids->size() == 1);
    const auto grid = openvdb::gridPtrCast<points::PointDataGrid>(opened.grid("points"));
    REQUIRE(grid);
    REQUIRE(grid->getGridClass() == openvdb::GRID_UNKNOWN);
    REQUIRE((*grid)[openvdb::GridBase::META_GRID_CLASS] == nullptr);
    REQUIRE(grid->getMetadata<openvdb::StringMetadata>("unit_of_length")->value() == "mm");
    REQUIRE(grid->getMetadata<openvdb::StringMetadata>("generator")->value() == "vdb_pack test");
    REQUIRE(points::pointCount(grid->tree()) == pack.spheres.size());
    const double voxel = grid->voxelSize()[0];
    int exponent = 0;
    REQUIRE(std::frexp(voxel, &exponent) == 0.5);
    REQUIRE(grid->transform().indexToWorld(openvdb::Vec3d(0, 0, 0)) == openvdb::Vec3d(0, 0, 0));
    REQUIRE(grid->hasUniformVoxels());

    const auto& set = grid->tree().cbeginLeaf()->attributeSet();
    const auto type = [&set](const char* name) {
        const auto at = set.find(name);
        REQUIRE(at != points::AttributeSet::INVALID_POS);
        return set.descriptor().type(at);
    };
    REQUIRE(type("P") == openvdb::NamePair("vec3s", "null"));
    REQUIRE(type("pscale") == openvdb::NamePair("float", "null"));
    REQUIRE(type("depth") == openvdb::NamePair("float", "null"));
    for (const char* name : {"id", "region", "order", "contacts"})
        REQUIRE(type(name) == openvdb::NamePair("int32", "null"));

    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
        REQUIRE_NOTHROW(leaf->validateOffsets());
        const points::AttributeHandle<openvdb::Vec3f> offsets(leaf->constAttributeArray("P"));
        for (openvdb::Index k = 0; k < offsets.size(); ++k)
            for (int d = 0; d < 3; ++d) {
                REQUIRE(offsets.get(k)[d] >= -0.5f);
                REQUIRE(offsets.get(k)[d] < 0.5f);
            }
    }
}

TEST_CASE("every sphere lies in the voxel that OpenVDB looks for it in") {
    const TemporaryFolder scratch;
    const auto pack = latticePack<3>(2000, {{-730, 10, 4}}, 30, 32);
    writePack(pack, scratch.file("p.vdb"), {});
    const Opened opened(scratch.file("p.vdb"));
    const auto grid = openvdb::gridPtrCast<points::PointDataGrid>(opened.grid("points"));
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const auto& c = pack.spheres[i].center;
        const auto voxel =
            grid->transform().worldToIndexCellCentered(openvdb::Vec3d(c[0], c[1], c[2]));
        const auto* leaf = grid->tree().probeConstLeaf(voxel);
        REQUIRE(leaf);
        const points::AttributeHandle<std::int32_t> ids(leaf->constAttributeArray("id"));
        bool found = false;
        for (auto k = leaf->beginIndexVoxel(voxel); k; ++k)
            found = found || ids.get(*k) == static_cast<std::int32_t>(i);
        REQUIRE(found);
    }
}

TEST_CASE("points on faces, edges and corners of voxels come back exactly") {
    const double away = GENERATE(0.0, 4096.0, -8192.0, 1e4);
    Pack<3> pack;
    // Voxels of 4 mm have their faces at odd multiples of 2.
    for (const double x : {-6.0, -2.0, -2.0 + 0x1p-23, -2.0 - 0x1p-23, -0x1p-23, 0.0, 2.0,
                           2.0 - 0x1p-23, 2.0 + 0x1p-23, 4.0})
        for (const double y : {-2.0, 0.0, 2.0, 1.999, 6.0})
            for (const double z : {-2.0, 2.0 - 0x1p-23, 30.0})
                pack.spheres.push_back(
                    {{{away + x, std::nearbyint(y * 0x1p23) * 0x1p-23 - away, z}}, 1.0});
    PackWriteOptions options;
    options.pointVoxel = 4;
    const TemporaryFolder scratch;
    writePack(pack, scratch.file("p.vdb"), options);
    REQUIRE(Opened(scratch.file("p.vdb")).grid("points")->voxelSize()[0] == 4);
    REQUIRE(readPack(scratch.file("p.vdb")).spheres == pack.spheres);
}

TEST_CASE("doubles on no lattice come back within 2^-26 of a voxel") {
    RandomStream random(33, 0);
    Pack<3> pack;
    for (int i = 0; i < 5000; ++i)
        pack.spheres.push_back(
            {{{730 + 50 * random.uniform(), 50 * random.uniform(), -1e4 + 50 * random.uniform()}},
             1 + random.uniform()});
    const TemporaryFolder scratch;
    writePack(pack, scratch.file("p.vdb"), {});
    const double voxel = Opened(scratch.file("p.vdb")).grid("points")->voxelSize()[0];
    const auto read = readPack(scratch.file("p.vdb"));
    for (std::size_t i = 0; i < pack.spheres.size(); ++i)
        for (int d = 0; d < 3; ++d)
            REQUIRE(std::abs(read.spheres[i].center[d] - pack.spheres[i].center[d]) <=
                    voxel * 0x1p-26 * 1.0001 + 1e-12);
}

TEST_CASE("a sparse pack does not lose its lattice to large voxels") {
    // As after culling: few of the spheres are left, on the lattice of the full pack.
    const auto pack = latticePack<3>(300, {{500, 500, 500}}, 300, 34);
    REQUIRE(readBack(pack, "p.vdb").spheres == pack.spheres);
}

TEST_CASE("the surface is written as a level set beside the points") {
    const auto unit = GENERATE(Unit::millimeter, Unit::meter);
    const double scale = unit == Unit::meter ? 1e-3 : 1;
    CAPTURE(unitName(unit));
    const TemporaryFolder scratch;
    const auto surface = ballSurface();
    PackWriteOptions options;
    options.unit = unit;
    surface->grid->setName("surface");
    options.levelSets = {surface};
    const auto pack = latticePack<3>(100, {{3, 4, 5}}, 10, 35);
    writePack(pack, scratch.file("p.vdb"), options);
    const Opened opened(scratch.file("p.vdb"));
    REQUIRE(opened.grids->size() == 2);
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(opened.grid("surface"));
    REQUIRE(grid);
    REQUIRE(grid->getGridClass() == openvdb::GRID_LEVEL_SET);
    REQUIRE(grid->activeVoxelCount() == surface->grid->activeVoxelCount());
    REQUIRE(grid->background() == Approx(1.5 * scale));
    REQUIRE(grid->voxelSize()[0] == Approx(0.5 * scale));
    REQUIRE(grid->getMetadata<openvdb::StringMetadata>("unit_of_length")->value() ==
            unitName(unit));
    const auto value = [&](double x) {
        return grid->tree().getValue(
            grid->transform().worldToIndexCellCentered(openvdb::Vec3d(x, 4, 5) * scale));
    };
    REQUIRE(value(3) == Approx(-1.5 * scale));
    REQUIRE(value(13) == Approx(0).margin(0.01 * scale));
    REQUIRE(value(12) == Approx(-1 * scale).margin(0.01 * scale));
    REQUIRE(value(40) == Approx(1.5 * scale));
    // The caller's grid is as it was.
    REQUIRE(surface->grid->background() == 1.5f);
    REQUIRE(readPack(scratch.file("p.vdb")).spheres.size() == 100);
}

TEST_CASE("point grids of other programs are read") {
    openvdb::initialize();
    const TemporaryFolder scratch;
    const std::vector<openvdb::Vec3d> positions = {{1, 2, 3}, {-40, 5.5, 6}, {7, -8, 90}};
    const auto transform = openvdb::math::Transform::createLinearTransform(0.3);
    transform->postTranslate(openvdb::Vec3d(0.1, 0.2, 0.3));
    const points::PointAttributeVector<openvdb::Vec3d> wrapper(positions);
    const auto index =
        openvdb::tools::createPointIndexGrid<openvdb::tools::PointIndexGrid>(wrapper, *transform);
    const auto grid =
        points::createPointDataGrid<points::FixedPointCodec<false>, points::PointDataGrid>(
            *index, wrapper, *transform);
    grid->setName("grains");
    const std::string path = scratch.file("p.vdb");
    const auto save = [&] { openvdb::io::File(path).write({grid}); };

    SECTION("without a radius they are refused") {
        save();
        REQUIRE_THROWS_WITH(readPack(path), Contains("radius"));
    }
    SECTION("with one, codec, transform and further attributes do not matter") {
        points::appendAttribute<float, points::TruncateCodec>(grid->tree(), "radius", 0.5f);
        points::appendAttribute<openvdb::Vec3f>(grid->tree(), "v", openvdb::Vec3f(1, 2, 3));
        save();
        const auto pack = readPack(path);
        REQUIRE(pack.spheres.size() == 3);
        for (const auto& p : positions)
            REQUIRE(std::any_of(pack.spheres.begin(), pack.spheres.end(), [&p](const auto& s) {
                return length(s.center - Vec<3>{{p[0], p[1], p[2]}}) < 1e-4 && s.radius == 0.5;
            }));
        REQUIRE(pack.columns.size() == 3);
        REQUIRE(pack.columns[1].name == "v_1");
        REQUIRE(pack.columns[1].numbers == std::vector<double>{2, 2, 2});
        PackReadOptions options;
        options.gridName = "grains";
        REQUIRE(readPack(path, options).spheres.size() == 3);
        options.gridName = "others";
        REQUIRE_THROWS_WITH(readPack(path, options), Contains("'others'") && Contains("'grains'"));
    }
    SECTION("a file with a level set alone holds no pack") {
        openvdb::io::File(path).write({ballSurface()->grid});
        REQUIRE_THROWS_AS(readPack(path), InputError);
        REQUIRE_THROWS_WITH(readPack(path), Contains(path));
    }
}

TEST_CASE("column names that OpenVDB refuses are adapted") {
    auto pack = latticePack<3>(20, {}, 9, 36);
    pack.columns.push_back({"Young's modulus", std::vector<double>(20, 1.5), {}});
    pack.columns.push_back({"Young_s modulus", std::vector<double>(20, 2.5), {}});
    pack.columns.push_back({"P", std::vector<double>(20, 0.1), {}});
    const auto read = readBack(pack, "p.vdb");
    REQUIRE(read.columns.size() == 3);
    REQUIRE(read.columns[0].name == "Young_s_modulus");
    REQUIRE(read.columns[1].numbers[0] == 2.5);
    REQUIRE(read.columns[2].numbers[0] == 0.1);
}

TEST_CASE("a million spheres are written and read in seconds", "[.slow]") {
    const auto pack = latticePack<3>(1'000'000, {{100, 200, 300}}, 300, 37);
    for (const char* name : {"p.vdb", "p.csv", "p.vtp", "p.ply"}) {
        CAPTURE(name);
        REQUIRE(readBack(pack, name).spheres.size() == pack.spheres.size());
    }
}
