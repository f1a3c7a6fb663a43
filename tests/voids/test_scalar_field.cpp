// Fields of numbers in tables and .vdb files.
#include "support/grids.h"
#include "support/jobs.h"
#include "support/random_point.h"
#include "support/test.h"

#include "vdbpack/voids/scalar_field.h"

#include <fmt/format.h>

namespace {

const Box<3> kBox{{}, {{10, 10, 10}}};

ScalarMeaning share() {
    return {"BV/TV", {"value", "bvtv"}, [](double v) {
                return v >= 0 && v <= 1 ? std::string() : fmt::format("{:g} is no share", v);
            }};
}

double ramp(const Vec<3>& x) {
    return 0.05 * x[0] + 0.02 * x[1] + 0.01 * x[2] + 0.1;
}

std::string scatteredRamp(const char* name) {
    std::string text = fmt::format("x,y,z,{}\n", name);
    RandomStream random(3, 1);
    for (int i = 0; i < 1000; ++i) {
        const Vec<3> x = randomPoint(random, kBox);
        text += fmt::format("{},{},{},{}\n", x[0], x[1], x[2], ramp(x));
    }
    return text;
}

std::shared_ptr<const ScalarField> fieldOf(const std::string& table) {
    const TextFile file(table, "field.csv");
    return readScalarField(file.path(), share());
}

/// The ramp on voxels of a millimeter, turned and moved.
template <class GridType>
typename GridType::Ptr rampGrid() {
    const auto grid = newGrid<GridType>(typename GridType::ValueType(0.9));
    const auto transform = openvdb::math::Transform::createLinearTransform(1);
    transform->postRotate(0.3, openvdb::math::Z_AXIS);
    transform->postTranslate(openvdb::Vec3d(2, -3, 0.5));
    grid->setTransform(transform);
    auto accessor = grid->getAccessor();
    for (int i = 0; i < 10; ++i)
        for (int j = 0; j < 10; ++j)
            for (int k = 0; k < 10; ++k) {
                const openvdb::Vec3d p = transform->indexToWorld(openvdb::Vec3d(i, j, k));
                accessor.setValueOn(openvdb::Coord(i, j, k),
                                    typename GridType::ValueType(ramp(Vec<3>{{p[0], p[1], p[2]}})));
            }
    return grid;
}

Vec<3> placeOf(const openvdb::GridBase& grid, const openvdb::Vec3d& voxel) {
    const openvdb::Vec3d p = grid.transform().indexToWorld(voxel);
    return {{p[0], p[1], p[2]}};
}

std::string writtenGrid(const TemporaryFolder& folder, const openvdb::GridBase::Ptr& grid) {
    const std::string path = folder.file("field.vdb");
    openvdb::io::File(path).write({grid});
    return path;
}

}  // namespace

TEST_CASE("numbers at scattered points are interpolated linearly") {
    const auto field = fieldOf(scatteredRamp(GENERATE("value", "bvtv", "BV/TV")));
    RandomStream random(4, 1);
    for (int i = 0; i < 1000; ++i) {
        const Vec<3> x = randomPoint(random, Box<3>{{{1, 1, 1}}, {{9, 9, 9}}});
        REQUIRE(field->at(x) == Approx(ramp(x)).margin(0.02));
    }
    CHECK(field->least() < 0.2);
    CHECK(field->most() > 0.75);
    const Vec<3> far{{100, 100, 100}};
    CHECK((field->at(far) >= field->least() && field->at(far) <= field->most()));
    CHECK(field->bounds().contains(kBox.lo));
    CHECK(field->bounds().contains(kBox.hi));
}

TEST_CASE("numbers at the nodes of a lattice are linear between its planes") {
    // Uneven planes along x, few along y and z; in the order of neither.
    const std::vector<double> planes{0, 0.3, 0.5, 4, 4.25, 10};
    const auto number = [](double x) { return x < 4.1 ? 0.1 + 0.05 * x : 0.9; };
    std::string text = "x,y,z,value\n";
    for (const double z : {10.0, 0.0})
        for (const double x : {4.25, 0.0, 10.0, 0.3, 4.0, 0.5})
            for (const double y : {0.0, 10.0})
                text += fmt::format("{},{},{},{}\n", x, y, z, number(x) + 0.005 * y);
    const auto field = fieldOf(text);
    RandomStream random(5, 1);
    for (int i = 0; i < 1000; ++i) {
        const Vec<3> x = randomPoint(random, kBox);
        const auto next = std::upper_bound(planes.begin(), planes.end(), x[0]);
        const double a = next[-1], b = *next;
        const double expected =
            number(a) + (x[0] - a) / (b - a) * (number(b) - number(a)) + 0.005 * x[1];
        REQUIRE(field->at(x) == Approx(expected).margin(1e-12));
    }
    CHECK(field->at({{-0.5, 0, 0}}) == Approx(0.1));
    CHECK(field->at({{10.5, 10, 5}}) == Approx(0.95));
    CHECK(field->lattice().second == Approx(0.1));
}

TEST_CASE("numbers of zero count, and tables of the plane hold at any height") {
    const auto field = fieldOf("x,y,value\n0,0,0\n1,0,0\n0,1,0\n1,1,0\n10,0,1\n10,1,1\n");
    CHECK(field->at({{0.5, 0.5, 7}}) == Approx(0).margin(0.02));
    CHECK(field->at({{0, 1, 7}}) == 0);
    CHECK(field->at({{10, 0, -7}}) == 1);
    CHECK(field->bounds().contains({{5, 0.5, 1e6}}));
}

TEMPLATE_TEST_CASE("a grid of numbers is linear between its voxels", "[voids]", openvdb::FloatGrid,
                   openvdb::DoubleGrid) {
    const TemporaryFolder folder;
    const auto grid = rampGrid<TestType>();
    const auto field = readScalarField(writtenGrid(folder, grid), share());
    RandomStream random(5, 1);
    for (int i = 0; i < 1000; ++i) {
        const Vec<3> voxel = randomPoint(random, Box<3>{{}, {{9, 9, 9}}});
        const Vec<3> x = placeOf(*grid, {voxel[0], voxel[1], voxel[2]});
        REQUIRE(field->at(x) == Approx(ramp(x)).epsilon(1e-5));
    }
    // Inactive voxels have no value: not that of the background, which is 0.9.
    const Vec<3> edge = placeOf(*grid, {-0.9, 4, 4});
    CHECK(field->at(edge) == Approx(ramp(placeOf(*grid, {0, 4, 4}))).epsilon(1e-5));
    CHECK(field->most() < 0.8);
    CHECK(field->bounds().contains(edge));
}

TEST_CASE("faulty fields of numbers are refused with the place") {
    const auto failure = [](const std::string& table) {
        return messageOf<InputError>([&] { fieldOf(table); });
    };
    CHECK_THAT(failure("x,y,z,value\n0,0,0,0.5\n1,2,3,1.5\n"),
               Contains("line 3") && Contains("(1, 2, 3)") && Contains("1.5"));
    CHECK_THAT(failure("x,y,z,grey\n0,0,0,0.5\n"), Contains("value"));
    CHECK_THAT(failure("x,y,z,value\n"), Contains("no rows"));
    CHECK_THAT(failure("x,y,z,value\n0,0,0,nan\n"), Contains("line 2"));
    CHECK_THROWS_AS(readScalarField("field.txt.gz", share()), ParameterError);

    const TemporaryFolder folder;
    auto grid = rampGrid<openvdb::FloatGrid>();
    const float wrong = GENERATE(-2.0f, std::numeric_limits<float>::infinity());
    grid->tree().setValueOn({3, 4, 5}, wrong);
    CHECK_THAT(messageOf<InputError>([&] { readScalarField(writtenGrid(folder, grid), share()); }),
               Contains("(3, 4, 5)") && Contains(fmt::format("{:g}", wrong)));
    CHECK_THAT(messageOf<InputError>([&] {
                   readScalarField(writtenGrid(folder, newGrid<openvdb::Vec3SGrid>()), share());
               }),
               Contains("floats"));
    CHECK_THAT(messageOf<InputError>([&] {
                   readScalarField(writtenGrid(folder, newGrid<openvdb::FloatGrid>()), share());
               }),
               Contains("active"));
}

TEST_CASE("Boolean voids follow BV/TV of a table or a grid") {
    const TemporaryFolder folder;
    auto recipe = voidsIn("box:0,0,0,10,10,10", folder.file("v.vdb"));
    setVoids(recipe.request, "boolean", "uniform:0.5,0.8");
    recipe.request.bvtvField = folder.file("field.csv");
    putContent(recipe.request.bvtvField, scatteredRamp("value"));
    // Its mean.
    CHECK(*runVoids(recipe).report.voids->bvtv == Approx(0.5).margin(0.01));
    recipe.request.bvtvRange = "0,2";
    CHECK(*runVoids(recipe).report.voids->bvtv == Approx(0.25).margin(0.01));
    recipe.request.bvtvRange.clear();
    recipe.domain.source = "box:0,0,0,30,10,10";
    CHECK_THAT(messageOf<InputError>([&] { runVoids(recipe); }),
               Contains("(30, 10, 10)") && Contains("covers") && Contains("10.9"));
    recipe.domain.source = "box:2,2,1,6,6,6";
    recipe.request.bvtvField = writtenGrid(folder, rampGrid<openvdb::FloatGrid>());
    CHECK(*runVoids(recipe).report.voids->bvtv == Approx(ramp({{4, 4, 3.5}})).margin(0.01));
}
