// Foams whose BV/TV and directions vary in space: runs with `voids` foam and fields.
#include "support/jobs.h"
#include "support/test.h"
#include "voids/turning.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/voids/stamp.h"

#include <fmt/format.h>

namespace {

/// A foam in a box, whose BV/TV goes from 0.1 to 0.4 along x.
constexpr double kLength = 10.2, kWidth = 5.1;

double ramp(double x) {
    return 0.1 + 0.3 * (x / kLength + 0.5);
}

std::string rampTable() {
    std::string text = "x,y,z,value\n";
    for (int k = 0; k < 7 * 3 * 3; ++k) {
        const double x = (k % 7 / 6.0 - 0.5) * kLength;
        text += fmt::format("{},{},{},{}\n", x, (k / 7 % 3 - 1) * 0.5 * kWidth,
                            (k / 21 - 1) * 0.5 * kWidth, ramp(x));
    }
    return text;
}

/// The turning directions over the same box.
std::string turningTable() {
    std::string text = "x,y,z,ux,uy,uz\n";
    for (int k = 0; k < 13 * 7 * 7; ++k) {
        const Vec<3> x{{(k % 13 / 12.0 - 0.5) * kLength, (k / 13 % 7 / 6.0 - 0.5) * kWidth,
                        (k / 91 / 6.0 - 0.5) * kWidth}};
        const Vec<3> u = turning(x, kLength);
        text += fmt::format("{},{},{},{},{},{}\n", x[0], x[1], x[2], u[0], u[1], u[2]);
    }
    return text;
}

struct LocalFoam {
    TemporaryFolder folder;
    VoidsJob recipe;

    explicit LocalFoam(const std::string& source) {
        recipe.domain.source = source;
        setVoids(recipe.request, "foam", "uniform:0.25,0.5");
        recipe.request.bvtvField = folder.file("bvtv.csv");
        recipe.outputs = {"list:" + folder.file("list.csv"), folder.file("v.vdb")};
        putContent(recipe.request.bvtvField, rampTable());
    }
    RunResult run() const { return runVoids(recipe); }
};

/// Root of the mean squared difference of local BV/TV and the ramp, in boxes of about three Tb.Sp,
/// which is 0.85 mm (the guide).
/// @param shareOf  BV/TV of a box.
template <int Dim, class Share>
double rampError(const Box<Dim>& box, const Share& shareOf) {
    constexpr double kSide = 3 * 0.85;
    std::array<int, 3> count{1, 1, 1}, at{};
    Vec<Dim> side;
    for (int d = 0; d < Dim; ++d) {
        const auto i = static_cast<std::size_t>(d);
        count[i] = static_cast<int>(box.size()[d] / kSide);
        side[d] = box.size()[d] / count[i];
    }
    double sum = 0;
    for (at[0] = 0; at[0] < count[0]; ++at[0])
        for (at[1] = 0; at[1] < count[1]; ++at[1])
            for (at[2] = 0; at[2] < count[2]; ++at[2]) {
                Box<Dim> part{box.lo, box.lo + side};
                for (int d = 0; d < Dim; ++d) {
                    part.lo[d] += at[static_cast<std::size_t>(d)] * side[d];
                    part.hi[d] += at[static_cast<std::size_t>(d)] * side[d];
                }
                sum += std::pow(shareOf(part) - ramp(part.center()[0]), 2);
            }
    return std::sqrt(sum / (count[0] * count[1] * count[2]));
}

double solidShare(const VdbGrid& solid, const Box<3>& box) {
    const VoxelImage image = sampleLevelSet(solid, box);
    const auto inside =
        std::count_if(image.distance.begin(), image.distance.end(), [](float d) { return d < 0; });
    return static_cast<double>(inside) / static_cast<double>(image.voxels());
}

}  // namespace

TEST_CASE("BV/TV of a foam follows a ramp, and its directions a field", "[long]") {
    LocalFoam foam(fmt::format("box:{},{},{}", kLength, kWidth, kWidth));
    foam.recipe.request.voxelSize = 0.05;
    const bool directed = GENERATE(false, true);
    CAPTURE(directed);
    if (directed) {
        foam.recipe.request.orientation.field = foam.folder.file("u.csv");
        foam.recipe.request.aspect = "constant:1.8";
        putContent(foam.recipe.request.orientation.field, turningTable());
    }
    const RunResult run = foam.run();
    CHECK(*run.report.voids->bvtv == Approx(0.25).margin(0.002));
    const VdbGrid& solid = *run.levelSets.at(2);
    const Vec<3> corner{{0.5 * kLength, 0.5 * kWidth, 0.5 * kWidth}};
    const double error = rampError(Box<3>{-corner, corner},
                                   [&](const Box<3>& part) { return solidShare(solid, part); });
    CHECK(error <= 0.02);
    CHECK(*run.report.voids->solidAttached > 0.98);
    if (!directed) return;
    // Main directions in cubes of three Tb.Sp.
    std::vector<double> cosines;
    for (int k = 0; k < 4 * 2 * 2; ++k) {
        constexpr double kSide = kLength / 4;
        const Vec<3> lo = Vec<3>{{k % 4 - 2.0, k / 4 % 2 - 1.0, k / 8 - 1.0}} * kSide;
        const Box<3> part{lo, lo + Vec<3>{{kSide, kSide, kSide}}};
        const auto measured = measureMorphometry(sampleLevelSet(solid, part));
        REQUIRE(measured.anisotropy);
        cosines.push_back(
            std::fabs(dot(measured.anisotropy->axes[0], turning(part.center(), kLength))));
    }
    std::sort(cosines.begin(), cosines.end());
    CHECK(cosines[8] >= 0.97);
}

TEST_CASE("BV/TV of a foam in the plane follows a ramp") {
    LocalFoam foam(fmt::format("rect:{},{}", kLength, kWidth));
    const std::string list = "list:" + foam.folder.file("list.csv");
    foam.recipe.outputs = {list};
    foam.recipe.seed = GENERATE(1, 2);
    const RunResult run = foam.run();
    CHECK(*run.report.voids->bvtv == Approx(0.25).margin(0.002));
    const auto rect =
        boxDomain(Box<2>{{{-0.5 * kLength, -0.5 * kWidth}}, {{0.5 * kLength, 0.5 * kWidth}}});
    StampOptions<2> options;
    options.voxelSize = run.report.voids->voxelSize;
    options.origin = rect->bounds().lo;
    options.join = {0.0375, 0.015, 1};  // as a foam has them by default
    const auto stamped = stampVoids(std::get<std::vector<Ellipsoid<2>>>(run.voids), *rect, options);
    StampedVoids<2>::Sampler distance(*stamped);
    const double error = rampError(rect->bounds(), [&](const Box<2>& part) {
        constexpr int kPoints = 200;
        int solid = 0;
        for (int k = 0; k < kPoints * kPoints; ++k)
            solid += distance({{part.lo[0] + (k % kPoints + 0.5) / kPoints * part.size()[0],
                                part.lo[1] + (k / kPoints + 0.5) / kPoints * part.size()[1]}}) >= 0;
        return solid / static_cast<double>(kPoints * kPoints);
    });
    CHECK(error <= 0.02);
}

TEST_CASE("a local foam in a bone with a shell keeps its mean", "[long]") {
    LocalFoam foam("ball:2.9");
    foam.recipe.request.shell = 0.4;
    foam.recipe.request.keepConnected = true;
    const double target = GENERATE(0.2, 0.3);
    foam.recipe.request.targetBvtv = target;
    const RunResult run = foam.run();
    CHECK(*run.report.voids->bvtv == Approx(target).margin(0.002));
    CHECK(*run.report.voids->solidAttached > 0.99);
    // In the middle of both halves.
    const VdbGrid& solid = *run.levelSets.at(2);
    for (const double side : {-1.0, 1.0}) {
        const Vec<3> half{{0.75, 1.5, 1.5}}, center{{side, 0, 0}};
        CHECK(solidShare(solid, Box<3>{center - half, center + half}) ==
              Approx(ramp(side) * target / 0.25).margin(0.03));
    }
}

TEST_CASE("a local foam is the solid that spheres fill", "[long]") {
    LocalFoam foam("box:6,5,5");
    PackJob pack;
    pack.domain = foam.recipe.domain;
    pack.request = foam.recipe.request;
    pack.request.fill = Fill::solid;
    pack.request.keepConnected = true;
    pack.radius = SizeRequest::parse("constant:0.04");
    pack.outputs = {foam.folder.file("p.csv")};
    const RunResult run = runPack(pack);
    CHECK(run.passed);
    CHECK(*run.report.voids->bvtv == Approx(0.25).margin(0.003));
    std::size_t left = 0;
    const auto& spheres = std::get<Pack<3>>(run.pack).spheres;
    for (const auto& s : spheres) left += s.center[0] < 0;
    CHECK(static_cast<double>(left) < 0.45 * static_cast<double>(spheres.size()));
}

TEST_CASE("a field that leaves no void, or nothing but voids, in places") {
    LocalFoam foam("box:6,4,4");
    std::string text = "x,y,value\n";
    for (int k = 0; k < 16 * 11; ++k) {
        const double x = (k % 16 - 7.5) * 0.4;
        text += fmt::format("{},{},{}\n", x, (k / 16 - 5) * 0.4, x < 0 ? 0 : 1);
    }
    putContent(foam.recipe.request.bvtvField, text);
    const RunResult run = foam.run();
    CHECK(*run.report.voids->bvtv == Approx(0.5).margin(0.02));
    const VdbGrid& solid = *run.levelSets.at(2);
    CHECK(solidShare(solid, {{{-3, -2, -2}}, {{-1, 2, 2}}}) < 0.05);
    CHECK(solidShare(solid, {{{1, -2, -2}}, {{3, 2, 2}}}) > 0.95);
}
