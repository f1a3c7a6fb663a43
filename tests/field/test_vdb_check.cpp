// .vdb files that are damaged or lie, before OpenVDB sees them.
#include "support/flipped_bits.h"
#include "support/grids.h"
#include "support/test.h"

#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/vdb_check.h"

#include <openvdb/io/Stream.h>

#include <cstring>
#include <iterator>

namespace {

/// A level set of a ball, over the faces of nodes so that it has several leaves.
openvdb::FloatGrid::Ptr ball() {
    openvdb::initialize();
    const auto grid = openvdb::FloatGrid::create(1.5f);
    grid->setName("surface");
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    auto values = grid->getAccessor();
    for (int x = 0; x < 16; ++x)
        for (int y = 0; y < 8; ++y)
            for (int z = 0; z < 8; ++z) {
                const double d = std::hypot(x - 8.0, y - 4.0, z - 4.0) - 2;
                if (std::fabs(d) < 3)
                    values.setValue(openvdb::Coord(x, y, z), static_cast<float>(0.5 * d));
            }
    return grid;
}

class Files : public TemporaryFolder {
public:
    std::string put(const std::string& content) const {
        const std::string path = file("f.vdb");
        putContent(path, content);
        return path;
    }
    std::string save(const openvdb::GridPtrVec& grids, std::uint32_t compression) const {
        const std::string path = file("f.vdb");
        openvdb::io::File out(path);
        out.setCompression(compression);
        out.write(grids);
        return path;
    }
    std::string saveBall() const {
        return save({ball()}, openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    }
};

template <typename T>
std::string with(std::string content, std::size_t at, T value) {
    std::memcpy(content.data() + at, &value, sizeof value);
    return content;
}

std::string refusal(const std::string& path) {
    try {
        checkVdbFile(path);
    } catch (const InputError& e) {
        return e.what();
    }
    return "nothing thrown";
}

/// Whether the level set could be read; any error but ours escapes.
bool reads(const std::string& path) {
    try {
        levelSetMesh(path, "", 1);
        return true;
    } catch (const InputError&) {
        return false;
    }
}

}  // namespace

TEST_CASE("what OpenVDB writes passes, however it is packed") {
    using namespace openvdb::io;
    const Files files;
    const auto compression = GENERATE(
        as<std::uint32_t>{}, COMPRESS_NONE, COMPRESS_ZIP, COMPRESS_BLOSC, COMPRESS_ACTIVE_MASK,
        COMPRESS_ZIP | COMPRESS_ACTIVE_MASK, COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK);
    const bool asHalf = GENERATE(false, true);
    CAPTURE(compression, asHalf);
    const auto vectors = newGrid<openvdb::Vec3DGrid>(openvdb::Vec3d(1, 2, 3));
    vectors->setName("vectors");
    vectors->fill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(127)),
                  openvdb::Vec3d(0, 0, 1));
    vectors->tree().setValue(openvdb::Coord(-5000, 4096, 77), openvdb::Vec3d(5, 6, 7));
    vectors->insertMeta("a", openvdb::Vec3IMetadata(openvdb::Vec3i(1, 2, 3)));
    vectors->insertMeta("b", openvdb::StringMetadata("text"));
    vectors->transform().postRotate(0.3, openvdb::math::X_AXIS);
    const auto mask = newGrid<openvdb::MaskGrid>();
    mask->tree().setValueOn(openvdb::Coord(3));
    const auto whole = newGrid<openvdb::Int64Grid>(-7);
    whole->tree().setValue(openvdb::Coord(100, 0, 0), 1 << 20);
    const auto surface = ball();
    const auto same = openvdb::FloatGrid::create(*surface);  // an instance: no tree of its own
    same->setTree(surface->treePtr());
    same->setName("again");
    openvdb::GridPtrVec grids{mask, surface, vectors, whole, same, openvdb::FloatGrid::create()};
    for (const auto& grid : grids) grid->setSaveFloatAsHalf(asHalf);
    CHECK_NOTHROW(checkVdbFile(files.save(grids, compression)));
    CHECK(reads(files.file("f.vdb")));

    const std::string stream = files.file("s.vdb");
    {
        std::ofstream out(stream, std::ios::binary);
        openvdb::io::Stream writer(out);
        writer.setCompression(compression);
        writer.write(openvdb::GridCPtrVec{surface, vectors, whole});
    }
    CHECK_NOTHROW(checkVdbFile(stream));
    CHECK(reads(stream));
}

TEST_CASE("files of newer versions are read where they hold the grids that are known") {
    const Files files;
    const auto surface = ball();
    const auto other = openvdb::Int32Grid::create(7);
    other->setName("other");
    const auto later = openvdb::gridPtrCast<openvdb::FloatGrid>(surface->deepCopyGrid());
    later->setName("voids");
    later->transform().postScale(2.0);
    files.save({later, surface, other, surface->deepCopy()}, openvdb::io::COMPRESS_BLOSC);
    std::string content = contentOf(files.file("f.vdb"));
    // What OpenVDB 13 writes: version 225, and grids of types that older ones do not know.
    const std::string type = "Tree_int32_5_4_3";
    content.replace(content.find(type), type.size(), "Tree_half__5_4_3");
    for (const std::uint32_t version : {224u, 225u, 226u}) {
        CAPTURE(version);
        const std::string path = files.put(with(content, 8, version));
        const TriangleMesh mesh = levelSetMesh(path, "surface", 1);
        CHECK(mesh.triangles.size() > 100);
        CHECK(levelSetMesh(path, "", 1).vertices == mesh.vertices);  // the first by name
        CHECK(levelSetMesh(path, "voids", 1).vertices != mesh.vertices);
        CHECK(levelSetMesh(path, "surface[1]", 1).vertices == mesh.vertices);
        try {
            levelSetMesh(path, "other", 1);
            FAIL("a grid of another type was read");
        } catch (const InputError& e) {
            CHECK_THAT(e.what(),
                       Contains("'other' (Tree_half__5_4_3") && Contains("'surface[1]' (float)"));
        }
    }
}

TEST_CASE("a level set cut short anywhere is refused") {
    const Files files;
    const std::string path = files.saveBall();
    const std::size_t size = contentOf(path).size();
    for (std::size_t n = size; n-- > 0;) {
        CAPTURE(n);
        std::filesystem::resize_file(path, n);
        const std::string why = refusal(path);
        REQUIRE_THAT(why, Contains(path));
        if (n > 44) REQUIRE_THAT(why, Contains("byte"));
        if (n % 64 == 0) REQUIRE(!reads(path));
    }
}

TEST_CASE("a level set cut short does not pass where its offsets are corrected") {
    const Files files;
    const std::string whole = contentOf(files.saveBall());
    // The last of three offsets, which point at the grid and at its end.
    const std::int64_t size = static_cast<std::int64_t>(whole.size());
    const auto at = whole.find(std::string(reinterpret_cast<const char*>(&size), sizeof size));
    REQUIRE(at != std::string::npos);
    for (std::size_t n = at + 8; n < whole.size(); n += 7) {
        CAPTURE(n);
        REQUIRE_THAT(refusal(files.put(with(whole.substr(0, n), at, std::int64_t(n)))),
                     Contains("byte"));
    }
}

TEST_CASE("numbers of a .vdb file that lie are an error or another grid") {
    const Files files;
    using namespace openvdb::io;
    const std::uint32_t compression =
        GENERATE(as<std::uint32_t>{}, COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK, COMPRESS_ZIP);
    CAPTURE(compression);
    const std::string whole = contentOf(files.save({ball()}, compression));
    RandomStream random(compression, 5);
    constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
    const std::int64_t lies[] = {-1,      0x7fffffff,     10'000'000'000, kLeast,
                                 ~kLeast, -1'000'000'000, 0x10000,        0};
    for (int trial = 0; trial < 1500; ++trial) {
        // The descriptor and the metadata come first, what is packed last; masks lie between.
        const std::size_t range = random.bits() % 2 == 0 ? 1200 : whole.size() - 8;
        const std::size_t at = random.bits() % range;
        const std::int64_t lie = lies[random.bits() % std::size(lies)];
        CAPTURE(trial, at, lie);
        const std::string path =
            files.put(trial % 2 == 0 ? with(whole, at, lie)
                                     : with(whole, at, static_cast<std::int32_t>(lie)));
        CHECK_NOTHROW(reads(path));
    }
}

TEST_CASE("a level set with flipped bits is an error or another one") {
    const Files files;
    const std::string whole = contentOf(files.saveBall());
    RandomStream random(3, 6);
    for (int trial = 0; trial < 1500; ++trial) {
        CAPTURE(trial);
        CHECK_NOTHROW(reads(files.put(withFlippedBits(whole, 1 + trial % 4, random))));
    }
}

TEST_CASE("what is wrong with a .vdb file is reported with its place") {
    const Files files;
    const std::string whole = contentOf(files.saveBall());
    // No file, a folder, an empty file, another format.
    CHECK_THROWS_AS(checkVdbFile(files.file("none.vdb")), IoError);
    CHECK_THROWS_AS(checkVdbFile(files.path()), IoError);
    CHECK_THAT(refusal(files.put("")), Contains("OpenVDB"));
    CHECK_THAT(refusal(files.put("solid bone\n" + std::string(100, 'x'))), Contains("OpenVDB"));
    // A version that is not known.
    CHECK_THAT(refusal(files.put(with(whole, 8, std::uint32_t{221}))),
               Contains("221") && Contains("222 to 225"));
    CHECK_THAT(refusal(files.put(with(whole, 8, std::uint32_t{300}).substr(0, 400))),
               Contains("300") && Contains("222 to 225"));
    // Metadata of 4 GB, and four billion of them.
    const std::size_t metadata = 8 + 4 + 8 + 1 + 36;
    CHECK_THAT(refusal(files.put(with(whole, metadata, 0xffffffffu))), Contains("4294967295"));
    CHECK_THAT(refusal(files.put(with(whole, metadata + 4, std::int32_t{-1}))), Contains("-1"));
    const auto levelSet = whole.find("level set");
    REQUIRE(levelSet != std::string::npos);
    CHECK_THAT(refusal(files.put(with(whole, levelSet - 4, 0xfffffff0u))), Contains("4294967280"));
    // A transform that is not finite.
    const auto map = whole.find("UniformScaleMap");
    REQUIRE(map != std::string::npos);
    CHECK_THAT(refusal(files.put(with(whole, map + 15, std::numeric_limits<double>::quiet_NaN()))),
               Contains("transform"));
    // Frustums within frustums.
    const std::string type("\x13\0\0\0NonlinearFrustumMap", 23);
    const std::string frustum = type + std::string(64, '\0');
    std::string nested = whole.substr(0, map - 4);
    for (int i = 0; i < 10000; ++i) nested += frustum;
    CHECK_THAT(refusal(files.put(nested + whole.substr(map - 4))), Contains("transform"));
    // Nodes out of place.
    const std::string origin(12, '\0');
    // Behind the background and two counts.
    const std::string root("\0\0\xc0\x3f\0\0\0\0\1\0\0\0", 12);
    const auto at = whole.find(root + origin);
    REQUIRE(at != std::string::npos);
    CHECK_THAT(refusal(files.put(with(whole, at + 12, std::int32_t{5}))), Contains("voxel 5"));
    CHECK_THAT(refusal(files.put(with(whole, at + 12, std::numeric_limits<std::int32_t>::min()))),
               Contains("voxel -2147483648"));
    CHECK_THAT(refusal(files.put(with(whole, at + 8, std::uint32_t{1} << 30))), Contains("nodes"));
    CHECK_THAT(refusal(files.put(with(whole, at + 4, std::uint32_t{1} << 30))), Contains("tiles"));
}

TEST_CASE("a grid that says both that it has half floats and that it has none is refused") {
    // OpenVDB would take values of one kind for the other, and lose a node's memory on the way.
    const Files files;
    const bool asHalf = GENERATE(false, true);
    const auto grid = ball();
    grid->setSaveFloatAsHalf(asHalf);
    std::string content = contentOf(files.save({grid}, openvdb::io::COMPRESS_BLOSC));
    const std::string name = openvdb::GridBase::META_SAVE_HALF_FLOAT;
    const std::size_t at = content.find(name);
    REQUIRE(at != std::string::npos);
    // Then the type, "bool", and its size, each with a length before it.
    char& value = content[at + name.size() + 4 + 4 + 4];
    REQUIRE(value == (asHalf ? 1 : 0));
    CHECK_NOTHROW(checkVdbFile(files.put(content)));
    value = asHalf ? 0 : 1;
    CHECK_THROWS_WITH(checkVdbFile(files.put(content)), Contains("half floats"));
    // Half floats by the header alone.
    value = asHalf ? 1 : 0;
    content[at] = 'I';
    if (asHalf)
        CHECK_THROWS_WITH(checkVdbFile(files.put(content)), Contains("half floats"));
    else
        CHECK_NOTHROW(checkVdbFile(files.put(content)));
}

TEST_CASE("a level set whose surface runs between large active tiles is refused, not contoured") {
    const Files files;
    const auto grid = ball();
    SECTION("of 4096 voxels a side") {
        grid->tree().root().addTile(openvdb::Coord(4096, 0, 0), -1.0f, /*state=*/true);
    }
    SECTION("of 128 voxels, amid inactive ones") {
        for (int i = 0; i < 8; ++i)
            grid->tree().addTile(2, openvdb::Coord(256 * i, 512, 0), -1.0f, /*active=*/true);
    }
    const std::string path = files.save({grid}, openvdb::io::COMPRESS_ZIP);
    CHECK_NOTHROW(checkVdbFile(path));
    try {
        levelSetMesh(path, "", 1);
        FAIL("contoured");
    } catch (const InputError& e) {
        CHECK_THAT(e.what(), Contains(path) && Contains("active tiles"));
    }
}

TEST_CASE("a level set whose inside is active has the contour of its narrow band") {
    const Files files;
    // Without a name, as well.
    const auto grid = ballGrid(120.0f, openvdb::Vec3f(64), 1.0f);
    const TriangleMesh narrow =
        levelSetMesh(files.save({grid}, openvdb::io::COMPRESS_ACTIVE_MASK), "", 1);
    std::size_t large = 0;
    for (auto value = grid->beginValueOff(); value; ++value) {
        if (*value > 0) continue;
        large += value.getBoundingBox().dim().x() == 128;
        value.setActiveState(true);
    }
    REQUIRE(large > 0);
    const TriangleMesh filled =
        levelSetMesh(files.save({grid}, openvdb::io::COMPRESS_ACTIVE_MASK), "", 1);
    CHECK(filled.triangles.size() == narrow.triangles.size());
    CHECK(filled.vertices.size() == narrow.vertices.size());
}

TEST_CASE("an inactive value that is not finite is found before contouring") {
    const Files files;
    const auto grid = ball();
    grid->tree().setValueOff(openvdb::Coord(8, 4, 6), std::numeric_limits<float>::quiet_NaN());
    const std::string path = files.save({grid}, openvdb::io::COMPRESS_NONE);
    CHECK_THROWS_AS(levelSetMesh(path, "", 1), InputError);
}
