#include "support/random_point.h"
#include "support/test.h"
#include "voids/turning.h"

#include "vdbpack/core/symmetric.h"
#include "vdbpack/voids/direction_field.h"
#include "vdbpack/voids/tensor_field.h"

#include <fmt/format.h>

namespace {

std::shared_ptr<const DirectionField> fieldOf(const std::string& table, double scale = 1) {
    const TextFile file(table, "field.csv");
    return readDirectionField(file.path(), scale);
}

std::string failure(const std::string& table) {
    return messageOf<InputError>([&] { fieldOf(table); });
}

constexpr double kSide = 60;
const Box<3> kBox{{}, {{kSide, kSide, kSide}}};

/// The turning field at scattered points 3 mm apart, each direction times `factor(i)`.
template <class Factor>
std::string turningTable(const Factor& factor) {
    std::string text = "uz,uy,ux,z,y,x\n";
    RandomStream random(6, 1);
    for (int i = 0; i < 8000; ++i) {
        const Vec<3> x = randomPoint(random, kBox), u = turning(x, kSide) * factor(i);
        text += fmt::format("{},{},{},{},{},{}\n", u[2], u[1], u[0], x[2], x[1], x[0]);
    }
    return text;
}

Tensor tensorOf(const Vec<3>& values, const Matrix<3>& axes) {
    Tensor t{};
    for (std::size_t i = 0; i < 3; ++i) addScaled(t, values.c[i], dyad(axes[i]));
    return t;
}

}  // namespace

TEST_CASE("a field that turns across the bone is interpolated between its points") {
    const auto field = fieldOf(turningTable([](int) { return 1.0; }));
    RandomStream random(7, 1);
    double worst = 0, sum = 0;
    for (int i = 0; i < 4000; ++i) {
        const Vec<3> x = randomPoint(random, kBox), u = field->at(x);
        REQUIRE(length(u) == Approx(1));
        const double error = degreesBetween(u, turning(x, kSide));
        worst = std::max(worst, error);
        sum += error;
    }
    CHECK(worst < 4);  // at the walls, where all points lie on one side
    CHECK(sum / 4000 < 0.6);
}

TEST_CASE("signs and lengths of directions have no effect") {
    const auto field = fieldOf(turningTable([](int) { return 1.0; }));
    RandomStream flip(8, 1);
    const auto flipped =
        fieldOf(turningTable([&](int) { return flip.uniform() < 0.5 ? -1.0 : 1.0; }));
    const auto scaled = fieldOf(turningTable([](int i) { return 1e-3 * (1 + i % 1000); }));
    RandomStream random(9, 1);
    for (int i = 0; i < 500; ++i) {
        const Vec<3> x = randomPoint(random, kBox);
        REQUIRE(degreesBetween(field->at(x), flipped->at(x)) < 1e-6);
        REQUIRE(degreesBetween(field->at(x), scaled->at(x)) < 1e-6);
    }
}

TEST_CASE("the main axis of a stress belongs to the eigenvalue of largest magnitude") {
    RandomStream random(10, 1);
    for (int i = 0; i < 200; ++i) {
        const Vec<3> a = normalized(randomPoint(random, 1));
        const Vec<3> b = normalized(cross(a, {{0.2, 1, 0.5}}));
        const Matrix<3> axes{a, b, cross(a, b)};
        const double size = std::pow(10.0, 40 * random.uniform() - 20);
        CAPTURE(i, size);
        CHECK(degreesBetween(mainAxis(tensorOf(Vec<3>{{-3, 2, 1}} * size, axes)), a) < 1e-6);
        CHECK(degreesBetween(mainAxis(tensorOf(Vec<3>{{2, 3, -1}} * size, axes)), b) < 1e-6);
        CHECK(degreesBetween(mainAxis(tensorOf(Vec<3>{{1, 2, -2.1}} * size, axes)), axes[2]) <
              1e-6);
        // Of shear the tension counts.
        CHECK(degreesBetween(mainAxis(tensorOf(Vec<3>{{-2, 2, 0}} * size, axes)), b) < 1e-6);
    }
}

TEST_CASE("a stress is known by the names that programs give its components") {
    // A bar bent in the plane askew, as its components, in the order xx yy zz xy yz xz.
    const Vec<3> u = normalized(Vec<3>{{1, -2, 3}});
    const Tensor t = tensorOf({{-5, 0, 0}}, {u, u, u});
    const auto rows = [&t](const std::string& header, const std::vector<std::size_t>& order) {
        std::string text = header + "\n";
        for (int i = 0; i < 3; ++i) {
            text += fmt::format("{},{},{}", i, i * i, -i);
            for (const std::size_t c : order) text += fmt::format(",{}", t[c]);
            text += '\n';
        }
        return text;
    };
    const std::vector<std::size_t> plain{0, 1, 2, 3, 4, 5}, abaqus{0, 1, 2, 3, 5, 4};
    for (const auto& table :
         {rows("x,y,z,sxx,syy,szz,sxy,syz,sxz", plain), rows("X,Y,Z,SX,SY,SZ,SXY,SYZ,SXZ", plain),
          rows("COORD1,COORD2,COORD3,S.S11,S.S22,S.S33,S.S12,S.S13,S.S23", abaqus),
          rows("x,y,z,S11,S22,S33,S12,S13,S23", abaqus),
          rows("\"Points:0\",\"Points:1\",\"Points:2\",stress_XX,stress_YY,stress_ZZ,stress_XY,"
               "stress_YZ,stress_XZ",
               plain),
          rows("x [mm],y [mm],z [mm],sigma_xx [MPa],sigma_yy,sigma_zz,sigma_yx,sigma_zy,sigma_zx",
               plain)}) {
        CAPTURE(table);
        CHECK(degreesBetween(fieldOf(table)->at({{0.3, 0.4, 0.1}}), u) < 1e-6);
    }
}

TEST_CASE("stresses at one point are averaged, zero stresses are ignored") {
    const std::string header = "x,y,z,sxx,syy,szz,sxy,syz,sxz\n";
    const std::string far = "10,0,0,0,0,1,0,0,0\n0,10,0,0,0,1,0,0,0\n";
    CHECK(degreesBetween(
              fieldOf(header + "0,0,0,5,0,0,0,0,0\n0,0,0,-4,3,0,0,0,0\n" + far)->at({{0, 0, 0}}),
              {{0, 1, 0}}) < 1e-9);
    CHECK(degreesBetween(fieldOf(header + "0,0,0,0,0,0,0,0,0\n" + far)->at({{0, 0, 0}}),
                         {{0, 0, 1}}) < 1e-9);
    // Where tension and compression cancel, the direction is that of a neighbor.
    const Vec<3> between =
        fieldOf(header + "0,0,0,0,1,0,0,0,0\n2,0,0,0,-1,0,0,0,0\n")->at({{1, 0, 0}});
    CHECK(degreesBetween(between, {{0, 1, 0}}) < 1e-9);
}

TEST_CASE("a field has a direction beyond its points, and reports what it covers") {
    const auto field = fieldOf("x,y,z,dx,dy,dz\n0,0,0,0,0,2\n100,50,0,0,0,-3\n", 2);
    const auto bounds = field->bounds();
    CHECK(length(bounds.lo - Vec<3>{{-20, -10, -2}}) < 1e-9);
    CHECK(length(bounds.hi - Vec<3>{{220, 110, 2}}) < 1e-9);
    for (const double far : {0.0, 1e3, 1e12, 1e200})
        CHECK(degreesBetween(field->at({{far, -far, 0}}), {{0, 0, 1}}) < 1e-9);
    CHECK(fieldOf("x,y,z,vx,vy,vz\n1,1,1,1,0,0\n")->at({{1, 1, 1}})[0] == Approx(1));
}

TEST_CASE("a table without z is a field of the plane") {
    const auto field = fieldOf("x,y,ux,uy\n0,0,1,0\n10,0,1,1\n10,10,0,1\n");
    CHECK(field->bounds().contains({{5, 5, 1e6}}));
    CHECK_FALSE(field->bounds().contains({{5, 12, 0}}));
    CHECK(degreesBetween(field->at({{10, 0, 730}}), normalized(Vec<3>{{1, 1, 0}})) < 1e-9);
    const auto stress = fieldOf("x,y,sxx,syy,sxy\n0,0,0,0,3\n10,0,0,0,3\n");
    CHECK(degreesBetween(stress->at({{4, 1, 2}}), normalized(Vec<3>{{1, 1, 0}})) < 1e-9);
}

TEST_CASE("the nearest points are those of a search of all points") {
    RandomStream random(11, 1);
    const Box<3> box{{}, {{10, 10, 10}}};
    for (const int count : {1, 2, 12, 13, 100, 3000}) {
        std::vector<PointTensors::Sample> samples;
        for (int i = 0; i < count; ++i) {
            // Many on one plane, so that splits meet ties.
            Vec<3> x = randomPoint(random, box);
            if (i % 3 == 0) x[i % 2] = 5;
            samples.push_back({x, dyad(randomPoint(random, 1))});
        }
        const PointTensors tree(samples);
        for (int k = 0; k < 100; ++k) {
            const Vec<3> x = randomPoint(random, box.grown(1));
            std::vector<double> all;
            for (const auto& s : samples) all.push_back(squaredLength(s.x - x));
            std::sort(all.begin(), all.end());
            all.resize(std::min<std::size_t>(all.size(), 12));
            const auto found = tree.nearest(x);
            std::vector<double> squares;
            for (std::size_t i = 0; i < found.count; ++i) squares.push_back(found.near[i].square);
            std::sort(squares.begin(), squares.end());
            CAPTURE(count, k);
            REQUIRE(squares == all);
        }
    }
}

TEST_CASE("a malformed direction field is refused with its line and column") {
    CHECK_THAT(failure("x,y,z,ux,uy,uz\n0,0,0,1,0,0\n1,0,0,0,0,0\n"),
               Contains("field.csv: line 3") && Contains("(0, 0, 0)"));
    CHECK_THAT(failure("x,y,z,ux,uy,uz\n0,0,0,1,nan,0\n"),
               Contains("field.csv: line 2") && Contains("'nan'") && Contains("'uy'"));
    CHECK_THAT(failure("x,y,z,ux,uy,uz\n0,,0,1,1,0\n"), Contains("line 2") && Contains("'y'"));
    CHECK_THAT(failure("x,y,z,ux,uy,uz\n0,0,0,1,1\n"), Contains("line 2") && Contains("5 cells"));
    CHECK_THAT(failure("x,y,z,ux,uy\n0,0,0,1,1\n"),
               Contains("field.csv: line 1") && Contains("'uz'") && Contains("x,y,z,ux,uy"));
    CHECK_THAT(failure("x,y,z,sxx,syy,sxy\n0,0,0,1,1,1\n"), Contains("szz, syz, sxz"));
    CHECK_THAT(failure("x,y,z,radius\n0,0,0,1\n"), Contains("direction") && Contains("stress"));
    CHECK_THAT(failure("x,y,ux,uy,sxx,syy,sxy\n0,0,1,1,1,1,1\n"),
               Contains("direction") && Contains("stress"));
    CHECK_THAT(failure("x,y,ux,uy,vx,vy\n0,0,1,1,1,1\n"), Contains("direction"));
    CHECK_THAT(failure("y,z,ux,uy,uz\n"), Contains("'x'"));
    CHECK_THAT(failure("x,y,ux,uy\n"), Contains("field.csv"));
    CHECK_THAT(failure("x,y,sxx,syy,sxy\n1,1,0,0,0\n"), Contains("field.csv") && Contains("zero"));
    CHECK_THAT(failure(""), Contains("field.csv"));
    CHECK_THAT(messageOf<ParameterError>([] { readDirectionField("field.png"); }),
               Contains("field.png") && Contains("'.png'"));
    CHECK_THAT(messageOf<ParameterError>([] { readDirectionField("field.csv", 0); }),
               Contains("field.csv: scale 0"));
    CHECK_THROWS_AS(readDirectionField("/nowhere/field.csv"), IoError);
}
