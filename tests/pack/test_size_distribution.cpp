#include "support/test.h"

#include "vdbpack/core/sphere.h"
#include "vdbpack/pack/size_distribution.h"

TEST_CASE("quantile and cdf of a continuous distribution are inverse") {
    const auto spec = GENERATE(as<std::string>{}, "uniform:1,2", "normal:1.5,0.3,1,2",
                               "lognormal:1,0.5,0.3,3", "normal:5,0.1,1,5.2");
    CAPTURE(spec);
    const auto sizes = SizeDistribution::parse(spec, 3);
    double before = 0;
    for (int i = 0; i <= 1000; ++i) {
        const double u = i / 1000.0, r = sizes.quantile(u);
        REQUIRE(r >= sizes.min());
        REQUIRE(r <= sizes.max());
        REQUIRE(r >= before);
        REQUIRE(sizes.cdf(r) == Approx(u).margin(2e-4));
        before = r;
    }
    REQUIRE(sizes.cdf(sizes.min() * 0.999) == 0);
    REQUIRE(sizes.cdf(sizes.max()) == 1);
}

TEST_CASE("what is left up to a radius keeps its shares") {
    const auto spec =
        GENERATE(as<std::string>{}, "uniform:1,2", "normal:1.5,0.3,1,2", "lognormal:1,0.5,0.3,3");
    const double factor = GENERATE(1.0, 2.5), most = 1.25 * factor;
    const auto sizes = SizeDistribution::parse(spec, 3).scaled(factor);
    const auto part = sizes.upTo(most);
    CHECK(part.min() == Approx(sizes.min()));
    CHECK(part.max() == Approx(most));
    double sum = 0;
    for (int i = 0; i < 1000; ++i) {
        const double r = part.quantile((i + 0.5) / 1000);
        sum += r;
        REQUIRE(part.cdf(r) == Approx(sizes.cdf(r) / sizes.cdf(most)).margin(2e-4));
    }
    CHECK(part.mean() == Approx(sum / 1000).epsilon(1e-4));
    CHECK(sizes.upTo(sizes.max()).mean() == sizes.mean());
    CHECK(sizes.upTo(0.5 * sizes.min()).max() == sizes.max());
    const auto table = SizeDistribution::table({1, 2, 3}, {1, 3, 4}).upTo(2.5);
    CHECK(table.max() == 2);
    CHECK(table.cdf(1) == Approx(0.25).margin(1e-3));
    const auto sieved = SizeDistribution::sieve({2, 4, 8}, {0, 50, 100});
    CHECK(sieved.upTo(3).cdf(2) == Approx(sieved.cdf(2) / sieved.cdf(3)).margin(1e-3));
}

TEST_CASE("moments match the integrals") {
    const auto uniform = SizeDistribution::parse("uniform:1,2", 3);
    CHECK(uniform.mean() == Approx(1.5));
    CHECK(uniform.meanBall(3) == Approx(Measure<3>::ball(1) * 15.0 / 4));
    CHECK(uniform.meanBall(2) == Approx(kPi * 7.0 / 3));
    // A wide truncation leaves the plain log-normal mean.
    const auto lognormal = SizeDistribution::parse("lognormal:2,0.25,0.1,40", 3);
    CHECK(lognormal.mean() == Approx(2 * std::exp(0.25 * 0.25 / 2)).epsilon(1e-4));
    const auto scaled = uniform.scaled(3);
    CHECK(scaled.mean() == Approx(4.5));
    CHECK(scaled.meanBall(3) == Approx(27 * uniform.meanBall(3)));
    CHECK(scaled.max() == Approx(6));
}

TEST_CASE("drawn radii are floats inside the range") {
    // 0.31 and 0.62 are not floats: rounding must not leave the range.
    const auto sizes = SizeDistribution::parse("uniform:0.31,0.62", 3);
    for (const double u : {0.0, 1e-9, 0.3, 1 - 1e-9, 1.0}) {
        const double r = sizes.quantile(u);
        CHECK(r == static_cast<double>(static_cast<float>(r)));
        CHECK(r >= 0.31);
        CHECK(r <= 0.62);
    }
}

TEST_CASE("a table is discrete and can be weighted by volume") {
    const TemporaryFolder folder;
    const std::string file = folder.file("sizes.csv");
    std::ofstream(file) << "radius,weight\n2,1\n1,8\n";
    const auto byCount = SizeDistribution::parse("table:" + file, 3);
    CHECK(byCount.cdf(1) == Approx(8.0 / 9));
    CHECK(byCount.cdfBelow(1) == 0);
    CHECK(byCount.quantile(0.5) == 1);
    CHECK(byCount.quantile(0.95) == 2);
    // Equal volumes of r = 1 and (1/8 of them) r = 2 ... weights 8 and 1 by volume are 64 to 1.
    const auto byVolume = SizeDistribution::parse("table:" + file, 3, WeightBy::volume);
    CHECK(byVolume.cdf(1) == Approx(64.0 / 65));
}

TEST_CASE("lines of a table of radii may end in any way") {
    const TemporaryFolder folder;
    const std::string file = folder.file("sizes.csv");
    const std::string end = GENERATE(as<std::string>{}, "\n", "\r\n", "\r", "\n\n", "\r\r");
    std::ofstream(file) << "radius,weight" + end + "2,1" + end + "1,8" + end;
    CHECK(SizeDistribution::parse("table:" + file, 3).cdf(1) == Approx(8.0 / 9));
    std::ofstream(file) << "radius,weight" + end + "2,1" + end + "1,x" + end;
    CHECK_THROWS_WITH(SizeDistribution::parse("table:" + file, 3),
                      Contains(end.size() == 1 || end == "\r\n" ? "line 3" : "line 5"));
}

TEST_CASE("a grading curve is met by mass") {
    const TemporaryFolder folder;
    const std::string file = folder.file("curve.csv");
    std::ofstream(file) << "diameter,finer\n1,0\n2,30\n4,100\n";
    const auto sizes = SizeDistribution::parse("psd:" + file, 3);
    double mass = 0, below = 0;
    constexpr int kDraws = 200000;
    for (int i = 0; i < kDraws; ++i) {
        const double r = sizes.quantile((i + 0.5) / kDraws);
        mass += r * r * r;
        if (r < 1) below += r * r * r;
    }
    CHECK(below / mass == Approx(0.3).margin(1e-3));
}

TEST_CASE("columns of tables of sizes go by their names and units") {
    const TemporaryFolder folder;
    const std::string file = folder.file("sizes.csv");
    const auto [kind, text, least, most, middle] =
        GENERATE(table<std::string, std::string, double, double, double>({
            {"table:", "radius,weight\n1,1\n2,3\n", 1, 2, 0.25},
            {"table:", "diameter,weight\n2,1\n4,3\n", 1, 2, 0.25},
            {"table:", "count;diameter_um\n3;4000\n1;2000\n", 1, 2, 0.25},
            {"table:", "# Radius [cm], weight\n0.1,1\n0.2,3\n", 1, 2, 0.25},
            {"table:", "1 1\n2 3\n", 1, 2, 0.25},
            {"psd:", "diameter,finer\n2,0\n4,100\n", 1, 2, 0.75},
            {"psd:", "radius,percent finer by mass\n2,100\n1,0\n", 1, 2, 0.75},
            {"psd:", "d [mm]  passing\n2 0\n4 100\n", 1, 2, 0.75},
            {"psd:", "Sieve size (µm);retained [%]\n4000;0\n2000;100\n", 1, 2, 0.75},
            {"psd:", "# D_um coarser\n2000 100\n4000 0\n", 1, 2, 0.75},
        }));
    CAPTURE(text);
    std::ofstream(file) << text;
    const auto sizes = SizeDistribution::parse(kind + file, 2);
    CHECK(sizes.min() == Approx(least));
    CHECK(sizes.max() == Approx(most));
    // Mass spread evenly over radii in a plane: by number, the share below r goes with 1 - 1/r.
    CHECK(sizes.cdf(kind == "psd:" ? 1.6 : 1.5) == Approx(middle));
}

TEST_CASE("columns of sizes that are not understood are refused with their names") {
    const TemporaryFolder folder;
    const std::string file = folder.file("sizes.csv");
    const auto [kind, text, name] = GENERATE(table<std::string, std::string, std::string>({
        {"psd:", "diameter,sample A,sample B\n1,0,0\n2,100,100\n", "sample B"},
        {"psd:", "diameter,finer,finer\n1,0,0\n2,100,100\n", "finer, finer"},
        {"psd:", "phi,finer\n1,0\n2,100\n", "phi"},
        {"psd:", "diameter [in],finer\n1,0\n2,100\n", "[in]"},
        {"psd:", "diameter,weight\n1,0\n2,100\n", "weight"},
        {"psd:", "diameter,radius\n1,0\n2,100\n", "radius"},
        {"table:", "radius,volume\n1,1\n2,3\n", "weight-by"},
        {"table:", "1,1,5\n2,3,5\n", "1, 1, 5"},
        {"table:", "size,finer\n1,1\n", "finer"},
    }));
    CAPTURE(text);
    std::ofstream(file) << text;
    CHECK_THAT(messageOf<InputError>([&] { SizeDistribution::parse(kind + file, 3); }),
               Contains(file) && Contains(name));
}

TEST_CASE("a malformed SPEC is refused with its form") {
    const auto spec = GENERATE(
        as<std::string>{}, "", "uniform", "uniform:", "uniform:1", "uniform:1,2,3", "uniform:2,1",
        "uniform:0,1", "uniform:-1,1", "uniform:nan,1", "uniform:1,inf", "uniform:1,2x",
        "uniform:1e300,2e300", "constant:", "constant:-1", "normal:1,0,1,2", "normal:1,1,2,2",
        "normal:1,0.01,5,6", "lognormal:0,1,1,2", "gauss:1,2", "table:", "psd:");
    CAPTURE(spec);
    REQUIRE_THROWS_AS(SizeDistribution::parse(spec, 3), ParameterError);
}

TEST_CASE("a bad table is refused with its line") {
    const TemporaryFolder folder;
    const std::string file = folder.file("bad.csv");
    std::ofstream(file) << "radius,weight\n1,1\nx,2\n";
    CHECK_THROWS_WITH(SizeDistribution::parse("table:" + file, 3), Contains("line 3"));
    std::ofstream(file) << "1,0\n";
    CHECK_THROWS_AS(SizeDistribution::parse("table:" + file, 3), InputError);
    std::ofstream(file) << "1,50\n2,20\n";
    CHECK_THROWS_AS(SizeDistribution::parse("psd:" + file, 3), InputError);
}

TEST_CASE("shares by volume are integrals of the radius cubed") {
    const auto uniform = SizeDistribution::parse("uniform:1,2", 3);
    const VolumeShares volume(uniform, 3);
    const VolumeShares area(uniform, 2);
    for (double r = 1; r <= 2; r += 0.125) {
        CHECK(volume(uniform.cdf(r)) == Approx((std::pow(r, 4) - 1) / 15).margin(1e-5));
        CHECK(area(uniform.cdf(r)) == Approx((std::pow(r, 3) - 1) / 7).margin(1e-5));
    }
    const auto constant = SizeDistribution::parse("constant:3", 3);
    CHECK(VolumeShares(constant, 3)(constant.cdfBelow(3)) == 0);
    CHECK(VolumeShares(constant, 3)(constant.cdf(3)) == 1);
}

TEST_CASE("typed distributions are those of the texts, bit by bit") {
    const TemporaryFolder folder;
    const std::string radii = folder.file("radii.csv"), curve = folder.file("curve.csv");
    std::ofstream(radii) << "radius,weight\n2,1\n1,8\n1.5,0\n2,0.5\n";
    std::ofstream(curve) << "diameter,finer\n4,100\n1,0\n2,30\n";
    const auto dim = GENERATE(2, 3);
    struct Pair {
        std::string text;
        SizeDistribution typed;
        WeightBy weightBy = WeightBy::count;
    };
    const std::vector<Pair> pairs{
        {"constant:0.3", SizeDistribution::constant(0.3)},
        {"uniform:0.31,0.62", SizeDistribution::uniform(0.31, 0.62)},
        {"uniform:2,2", SizeDistribution::uniform(2, 2)},
        {"normal:1.5,0.3,1,2", SizeDistribution::normal(1.5, 0.3, 1, 2)},
        {"lognormal:1,0.5,0.3,3", SizeDistribution::lognormal(1, 0.5, 0.3, 3)},
        {"table:" + radii, SizeDistribution::table({2, 1, 1.5, 2}, {1, 8, 0, 0.5})},
        {"table:" + radii,
         SizeDistribution::table({2, 1, 1.5, 2}, {1, 8, 0, 0.5}, WeightBy::volume, dim),
         WeightBy::volume},
        {"psd:" + curve, SizeDistribution::sieve({4, 1, 2}, {100, 0, 30}, dim)},
    };
    for (const Pair& pair : pairs) {
        CAPTURE(pair.text, dim);
        const auto parsed = SizeDistribution::parse(pair.text, dim, pair.weightBy);
        for (const double factor : {1.0, 0.7}) {
            const auto a = parsed.scaled(factor), b = pair.typed.scaled(factor);
            for (int i = 0; i <= 1000; ++i) {
                REQUIRE(a.quantile(i / 1000.0) == b.quantile(i / 1000.0));
                const double r = a.min() + i / 1000.0 * (a.max() - a.min());
                REQUIRE(a.cdf(r) == b.cdf(r));
                REQUIRE(a.cdfBelow(r) == b.cdfBelow(r));
            }
            CHECK(a.mean() == b.mean());
            CHECK(a.meanBall(dim) == b.meanBall(dim));
        }
        if (pair.text.find(".csv") == std::string::npos) {
            CHECK(parsed.spec() == pair.typed.spec());
            CHECK(parsed.scaled(0.7).spec() == pair.typed.scaled(0.7).spec());
        }
    }
}

TEST_CASE("bad values of typed distributions are refused") {
    const double nan = std::nan("");
    CHECK_THROWS_AS(SizeDistribution::constant(0), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::constant(nan), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::uniform(2, 1), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::uniform(1, nan), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::normal(nan, 1, 1, 2), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::normal(1, 0, 1, 2), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::lognormal(-1, 1, 1, 2), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::table({}, {}), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::table({1, 2}, {1}), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::table({1, 2}, {1, -1}), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::table({1, 2}, {0, 0}), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::sieve({1}, {100}), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::sieve({1, 2}, {50, 20}), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::sieve({1, 2}, {50, nan}), ParameterError);
    // A part of the mass of which no size is known.
    CHECK_THROWS_AS(SizeDistribution::sieve({1, 2}, {5, 100}), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::sieve({1, 2}, {0, 90}), ParameterError);
    CHECK_THROWS_AS(SizeDistribution::sieve({1, 2}, {0, 1}), ParameterError);
    CHECK_NOTHROW(SizeDistribution::sieve({1, 2}, {0.1, 99.9}));
}
