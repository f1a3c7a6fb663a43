#include "support/random_point.h"
#include "support/sizes.h"
#include "support/test.h"
#include "voids/turning.h"

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/symmetric.h"
#include "vdbpack/voids/orientation.h"

namespace {

template <int Dim>
Box<Dim> unitBox() {
    return {Box<Dim>::filled(0), Box<Dim>::filled(1)};
}

OrientationRecipe recipeOf(const std::string& angles, const std::string& axis = "",
                           const std::string& field = "") {
    OrientationRecipe recipe;
    if (!angles.empty()) recipe.angles = VoidAngles::parse(angles);
    if (!axis.empty()) recipe.axis = VoidAxis::parse(axis);
    recipe.field = field;
    return recipe;
}

template <int Dim>
std::vector<Vec<Dim>> drawn(const OrientationRecipe& recipe, int count) {
    const auto orientation = makeOrientation<Dim>(recipe, unitBox<Dim>());
    RandomStream random(14, Dim);
    std::vector<Vec<Dim>> axes;
    for (int i = 0; i < count; ++i) {
        axes.push_back(orientation->axis({}, random));
        REQUIRE(length(axes.back()) == Approx(1));
    }
    return axes;
}

template <int Dim>
Vec<Dim> first(const OrientationRecipe& recipe) {
    return drawn<Dim>(recipe, 1)[0];
}

template <int Dim>
std::string failure(const std::string& angles, const std::string& axis = "",
                    const std::string& field = "") {
    return messageOf<ParameterError>(
        [&] { makeOrientation<Dim>(recipeOf(angles, axis, field), unitBox<Dim>()); });
}

}  // namespace

TEST_CASE("without angles voids point along z, in the plane along x") {
    CHECK(first<3>(recipeOf("")) == Vec<3>{{0, 0, 1}});
    CHECK(first<2>(recipeOf("")) == Vec<2>{{1, 0}});
}

DIM_TEST_CASE("isotropic directions are uniform") {
    constexpr int kCount = 40000;
    Matrix<Dim> mean{};
    std::vector<double> lastComponent;
    for (const auto& u : drawn<Dim>(recipeOf("isotropic"), kCount)) {
        for (std::size_t i = 0; i < Dim; ++i) mean[i] += u * (u.c[i] / kCount);
        lastComponent.push_back(std::fabs(u[Dim - 1]));
    }
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j)
            CHECK(mean[static_cast<std::size_t>(i)][j] ==
                  Approx(i == j ? 1.0 / Dim : 0.0).margin(0.01));
    // On a sphere heights are uniform, on a circle angles are.
    const auto cdf = [](double h) { return Dim == 3 ? h : 2 / kPi * std::asin(h); };
    CHECK(ksDistance(lastComponent, cdf) < 1.63 / std::sqrt(kCount));
}

TEST_CASE("angles turn the axis about x, then about z") {
    CHECK(first<3>(recipeOf("tz=constant:0.7;tx=0.3")) == axisOf(0.7, 0.3));
    CHECK(first<3>(recipeOf(" tx = 0.3 ; tz = 0.7 ")) == axisOf(0.7, 0.3));
    CHECK(first<3>(recipeOf("tx=-0.3")) == axisOf(0, -0.3));
    CHECK(first<2>(recipeOf("phi=-0.4")) == axisOf(-0.4));
    CHECK(length(first<3>(recipeOf("tz=90deg;tx=constant:-30deg")) - axisOf(kPi / 2, -kPi / 6)) <
          1e-12);
    for (const auto& u : drawn<3>(recipeOf("tx=uniform:0,20deg;tz=uniform:-180deg,180deg"), 1000))
        CHECK(u[2] >= std::cos(kPi / 9) - 1e-12);
}

TEST_CASE("drawn angles follow their distribution") {
    constexpr int kCount = 20000;
    const double bound = 1.63 / std::sqrt(kCount);
    const auto angles = [](const std::string& spec) {
        std::vector<double> values;
        for (const auto& u : drawn<2>(recipeOf("phi=" + spec), kCount))
            values.push_back(std::atan2(u[1], u[0]));
        return values;
    };
    CHECK(ksDistance(angles("uniform:-10deg,0.5"), [](double x) {
              const double lo = -kPi / 18;
              return (x - lo) / (0.5 - lo);
          }) < bound);
    const auto normal = [](double x) { return 0.5 * std::erfc(-(x - 0.1) / 0.2 / std::sqrt(2.0)); };
    CHECK(ksDistance(angles("normal:0.1,0.2,-0.1,0.6"), [&](double x) {
              return (normal(x) - normal(-0.1)) / (normal(0.6) - normal(-0.1));
          }) < bound);
    const auto cut = AngleDistribution::parse("normal:0,1,-1deg,2deg");
    CHECK(cut.quantile(0) == Approx(-kPi / 180));
    CHECK(cut.quantile(1) == Approx(kPi / 90));
}

TEST_CASE("angles scatter about a given axis") {
    const Vec<3> axis = normalized(Vec<3>{{1, -2, 0.5}});
    CHECK(degreesBetween(first<3>(recipeOf("", "1,-2,0.5")), axis) < 1e-9);
    Vec<3> mean;
    constexpr int kCount = 20000;
    for (const auto& u : drawn<3>(recipeOf("tx=0.3;tz=uniform:0,360deg", "1,-2,0.5"), kCount)) {
        REQUIRE(std::fabs(dot(u, axis)) == Approx(std::cos(0.3)));
        mean += u * (1.0 / kCount);
    }
    // On all sides of it.
    CHECK(degreesBetween(normalized(mean), axis) < 0.5);
    CHECK(length(first<2>(recipeOf("phi=0.4", "0,-3")) - axisOf(0.4 - kPi / 2)) < 1e-12);
    CHECK(length(first<2>(recipeOf("", "3,4,100")) - Vec<2>{{0.6, 0.8}}) < 1e-12);
    // Its length may be anything, its sign means nothing.
    CHECK(degreesBetween(first<3>(recipeOf("tx=0.3;tz=1", "1e300,-2e300,0.5e300")),
                         first<3>(recipeOf("tx=0.3;tz=1", "-1e-200,2e-200,-0.5e-200"))) < 1e-9);
    CHECK(first<3>(recipeOf("tx=0.3;tz=1", "0,0,-1")) == first<3>(recipeOf("tx=0.3;tz=1")));
}

TEST_CASE("z is mapped to an axis by the shortest rotation") {
    RandomStream random(15, 1);
    for (int i = 0; i < 100; ++i) {
        Vec<3> d = normalized(randomPoint(random, 1));
        if (d[2] < 0) d *= -1;
        const auto spec =
            std::to_string(d[0]) + "," + std::to_string(d[1]) + "," + std::to_string(d[2]);
        CAPTURE(spec);
        // What lies along the hinge, z x d, stays: with tx = 90 degrees the axis is (sin tz, -cos
        // tz, 0).
        const double tz = std::atan2(-d[1], -d[0]);
        const auto u = first<3>(recipeOf("tx=90deg;tz=" + std::to_string(tz), spec));
        CHECK(length(u - normalized(Vec<3>{{-d[1], d[0], 0}})) < 1e-4);
    }
}

DIM_TEST_CASE("every orientation draws the same number of random numbers") {
    const TextFile field("x,y,ux,uy\n0,0,1,0\n1,1,0,1\n");
    const std::string angles = Dim == 3 ? "tx=normal:0,0.1,-1,1" : "phi=normal:0,0.1,-1,1";
    for (const auto& recipe :
         {recipeOf(""), recipeOf("isotropic"), recipeOf(angles), recipeOf("", "1,1,0"),
          recipeOf(angles, "1,1,0"), recipeOf(angles, "", field.path())}) {
        CAPTURE(Dim, recipe.angles, recipe.axis, recipe.field);
        RandomStream random(16, 1), same(16, 1);
        makeOrientation<Dim>(recipe, unitBox<Dim>())->axis({}, random);
        for (int i = 0; i < Dim - 1; ++i) same.bits();
        CHECK(random.bits() == same.bits());
    }
}

TEST_CASE("angles scatter about the direction of a field") {
    const TextFile field(
        "x,y,z,ux,uy,uz\n0,0,0,1,0,0\n1,0,0,0,-1,0\n0,1,0,0,0,5\n0,0,1,-1,1,1\n1,1,1,0,0,1\n");
    const auto plain = makeOrientation<3>(recipeOf("", "", field.path()), unitBox<3>());
    RandomStream random(17, 1);
    CHECK(degreesBetween(plain->axis({{1, 0, 0}}, random), {{0, 1, 0}}) < 1e-9);
    CHECK(degreesBetween(plain->axis({{0, 1, 0}}, random), {{0, 0, 1}}) < 1e-9);
    const auto scattered =
        makeOrientation<3>(recipeOf("tx=0.2;tz=uniform:0,6", "", field.path()), unitBox<3>());
    for (int i = 0; i < 100; ++i)
        CHECK(std::fabs(scattered->axis({{0, 0, 0}}, random)[0]) == Approx(std::cos(0.2)));
    // In a slice at height 1 the direction is projected into the plane.
    const auto planar = makeOrientation<2>(recipeOf("phi=0.1", "", field.path()), unitBox<2>(), 1);
    const Vec<2> u = planar->axis({{0, 0}}, random);
    CHECK(std::fabs(dot(u, axisOf(0.1 + 0.75 * kPi))) == Approx(1));
    // A direction normal to the plane is replaced by x.
    CHECK(length(planar->axis({{1, 1}}, random) - axisOf(0.1)) < 1e-9);
}

TEST_CASE("a field that does not cover the domain is refused with both boxes") {
    const TextFile field("x,y,z,ux,uy,uz\n0,0,0,1,0,0\n10,20,30,0,1,0\n", "field.csv");
    const auto fit = [&](const Box<3>& bounds) {
        return messageOf<InputError>(
            [&] { makeOrientation<3>(recipeOf("", "", field.path()), bounds); });
    };
    CHECK(fit({{{-1, -2, -3}}, {{11, 22, 33}}}).empty());
    CHECK_THAT(fit({{{-1, -2, -3}}, {{11, 22, 34}}}),
               Contains("field.csv") && Contains("(-1, -2, -3) to (11, 22, 33) mm") &&
                   Contains("(-1, -2, -3) to (11, 22, 34) mm") && Contains("unit"));
    const auto slice = [&](double height) {
        return messageOf<InputError>([&] {
            makeOrientation<2>(recipeOf("", "", field.path()), {{{0, 0}}, {{5, 5}}}, height);
        });
    };
    CHECK(slice(15).empty());
    CHECK_THAT(slice(40), Contains("(0, 0, 40) to (5, 5, 40) mm"));
}

TEST_CASE("a malformed orientation is refused with its parameter and value") {
    const auto angles = Contains("`orientation.angles`"), axis = Contains("`orientation.axis`"),
               field = Contains("`orientation.field`");
    CHECK_THAT(failure<3>("", "1,0,0", "f.csv"),
               axis && Contains("'1,0,0'") && field && Contains("'f.csv'"));
    CHECK_THAT(failure<3>("isotropic", "1,0,0"),
               angles && axis && Contains("'1,0,0'") && Contains("tz="));
    CHECK_THAT(failure<2>("isotropic", "", "f.csv"),
               angles && field && Contains("'f.csv'") && Contains("phi="));
    CHECK_THAT(failure<3>("phi=1"), angles && Contains("'phi=1'") && Contains("tz="));
    CHECK_THAT(failure<2>("tz=1;tx=2"), angles && Contains("'tz=1;tx=2'") && Contains("phi="));
    CHECK_THAT(failure<3>("tz=1;tz=2"), angles && Contains("'tz'"));
    CHECK_THAT(failure<3>("tz=1;"), Contains("''"));
    CHECK_THAT(failure<3>("tz"), Contains("'tz'"));
    CHECK_THAT(failure<3>("everywhere"), Contains("'everywhere'"));

    CHECK_THAT(failure<3>("", "1,0"), axis && Contains("'1,0'") && Contains("2 components"));
    CHECK_THAT(failure<3>("", "0,0,0"), axis && Contains("X,Y,Z"));
    CHECK_THAT(failure<3>("", "1,inf,0"), Contains("'inf'"));
    CHECK_THAT(failure<3>("", "1,,0"), Contains("''"));
    CHECK_THAT(failure<2>("", "0,0,1"), axis && Contains("plane"));
}

TEST_CASE("a malformed distribution of angles is refused with its text and value") {
    const auto angle = [](const std::string& spec) { return failure<2>("phi=" + spec); };
    CHECK_THAT(angle("uniform:1"), Contains("'uniform:1'") && Contains("constant:V"));
    CHECK_THAT(angle("lognormal:1,2"), Contains("'lognormal:1,2'"));
    CHECK_THAT(angle("uniform:1,x"), Contains("'x'") && Contains("constant:V"));
    CHECK_THAT(angle("1 rad"), Contains("'1 rad'"));
    CHECK_THAT(angle("nan"), Contains("'nan'"));
    CHECK_THAT(angle(""), Contains("''"));
    CHECK_THAT(angle("uniform:0.5,-0.5"), Contains("0.5 and -0.5 rad"));
    CHECK_THAT(angle("uniform:0,30"), Contains("30 rad") && Contains("deg"));
    CHECK_THAT(angle("800deg"), Contains("800 deg"));
    CHECK_THAT(angle("normal:0,0,-1,1"), Contains("SD 0 rad") && Contains("constant:V"));
    CHECK_THAT(angle("normal:0,1,1,1"), Contains("from 1 to 1"));
    CHECK_THAT(angle("normal:0,0.1,2,3"), Contains("from 2 to 3 rad"));
    CHECK(angle("uniform:-360deg,360deg").empty());
}
