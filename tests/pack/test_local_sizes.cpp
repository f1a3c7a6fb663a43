// Sizes that differ by place: a factor on the radii, and radii of their own in the shell.
#include "support/cube.h"
#include "support/paths.h"
#include "support/random_point.h"
#include "support/sizes.h"
#include "support/test.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/verify.h"

namespace {

/// Factors met but for this share.
constexpr double kMet = 1e-3;

/// Edge of the cubes that are packed.
template <int Dim>
constexpr double kEdge = Dim == 3 ? 36 : 120;

using Factor = std::function<double(const Vec<3>&)>;

/// From 0.5 to 2 along x.
template <int Dim>
double ramp(const Vec<3>& x) {
    return 0.5 + 1.5 * std::clamp(x[0] / kEdge<Dim> + 0.5, 0.0, 1.0);
}

/// 0.7 and 1.4 in turn.
template <int Dim>
double checkerboard(const Vec<3>& x) {
    int cells = 0;
    for (int d = 0; d < Dim; ++d) cells += x[d] > 1 ? 1 : 0;
    return cells % 2 == 0 ? 0.7 : 1.4;
}

template <int Dim>
std::shared_ptr<const SizeField> tabulated(const Box<Dim>& box, double step, const Factor& factor) {
    Box<3> bounds{{}, {}};
    for (int d = 0; d < Dim; ++d) {
        bounds.lo[d] = box.lo[d];
        bounds.hi[d] = box.hi[d];
    }
    return std::make_shared<SizeField>(bounds, Vec<3>{}, step, factor);
}

template <int Dim>
PackOptions withFactor(const Domain<Dim>& domain, const Factor& factor, double step = 1) {
    PackOptions options(SizeDistribution::uniform(1, 2));
    options.local.factor = tabulated<Dim>(domain.bounds(), step, factor);
    return options;
}

/// Radii of the spheres of a group where the factor is 1, sorted, mm.
template <int Dim>
std::vector<double> radiiOf(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                            const LocalSizes& local, std::uint32_t group) {
    LocalSizeSampler<Dim> sampler(domain, local);
    std::vector<double> radii;
    for (const auto& s : spheres)
        if (const LocalSize here = sampler.at(s.center); here.group == group)
            radii.push_back(s.radius / here.factor);
    std::sort(radii.begin(), radii.end());
    return radii;
}

/// The largest room at some points, in local mean radii.
template <int Dim>
double largestVacancy(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                      const PackOptions& options) {
    constexpr int kPoints = Dim == 3 ? 4000 : 2000;
    LocalSizeSampler<Dim> sampler(domain, options.local);
    const auto inside = domain.sampler();
    RandomStream random(5, 7);
    double largest = 0;
    for (int k = 0; k < kPoints; ++k) {
        const Vec<Dim> x = randomPoint(random, domain.bounds());
        const LocalSize here = sampler.at(x);
        const double mean = options.local.sizesOf(here.group, options.sizes).mean() * here.factor;
        double room = -inside->signedDistance(x);
        for (const auto& s : spheres) {
            if (room < 0.9 * mean) break;
            room = std::min(room, length(s.center - x) - s.radius);
        }
        largest = std::max(largest, room / mean);
    }
    return largest;
}

}  // namespace

TEST_CASE("a size field of the plane has one layer") {
    const Box<3> box{{{0, 0, 4}}, {{10, 10, 4}}};
    const SizeField field(box, {}, 0.5, [](const Vec<3>& x) { return 1 + x[0] + x[2]; });
    CHECK(field.at(Vec<2>{{3.25, 7}}) == Approx(8.25));
    CHECK(field.within(Box<2>{{{2, 2}}, {{3, 3}}}).most == Approx(8).margin(1.1));
}

DIM_TEST_CASE("radii follow a field, and the field alone") {
    const auto domain = boxDomain<Dim>(cube<Dim>(kEdge<Dim>));
    const bool jumps = GENERATE(false, true);
    CAPTURE(Dim, jumps);
    PackOptions options = withFactor<Dim>(*domain, jumps ? checkerboard<Dim> : ramp<Dim>);
    const auto pack = packSpheres(*domain, options).pack.spheres;
    const auto radii = radiiOf(pack, *domain, options.local, 0);
    REQUIRE(radii.size() > 500);
    CHECK(radii.front() >= 1 - kMet);
    CHECK(radii.back() <= 2 * (1 + kMet));
    // Some 32 radii stay pending.
    CHECK(ksOf(radii, options.sizes) < 0.02 + 32.0 / static_cast<double>(radii.size()));
    CHECK(checkOverlap(pack).max == 0);
    const auto inside = domain->sampler();
    for (const auto& s : pack) REQUIRE(-inside->signedDistance(s.center) >= s.radius);
    CHECK(largestVacancy(pack, *domain, options) < 1.1);
}

DIM_TEST_CASE("a pack of sizes by place is the same for any number of threads") {
    const auto domain = ballDomain<Dim>(Dim == 3 ? 29 : 60);  // blocks of 8 largest radii
    PackOptions options = withFactor<Dim>(*domain, ramp<Dim>);
    options.blockSide = 16;
    options.threads = 1;
    const auto alone = packSpheres(*domain, options);
    REQUIRE(alone.blocks > 1);
    for (const int threads : {2, 3, 8}) {
        options.threads = threads;
        CHECK(packSpheres(*domain, options).pack.spheres == alone.pack.spheres);
    }
}

DIM_TEST_CASE("a factor of 1 everywhere gives a pack of the same kind") {
    const auto domain = boxDomain<Dim>(cube<Dim>(kEdge<Dim>));
    PackOptions options = withFactor<Dim>(*domain, [](const Vec<3>&) { return 1.0; });
    const auto fraction = [&] {
        double sum = 0;
        for (const auto& s : packSpheres(*domain, options).pack.spheres)
            sum += Measure<Dim>::ball(s.radius);
        return sum / domain->volume();
    };
    const double local = fraction();
    options.local = {};
    CHECK(local == Approx(fraction()).margin(0.004));
}

DIM_TEST_CASE("a shell has radii of its own") {
    const auto domain = ballDomain<Dim>(0.5 * kEdge<Dim>);
    PackOptions options(SizeDistribution::uniform(1, 2));
    options.local.shellSizes = SizeDistribution::uniform(0.4, 0.8);
    options.local.shell = 3;
    const auto pack = packSpheres(*domain, options).pack.spheres;
    for (const std::uint32_t group : {0u, 1u}) {
        CAPTURE(Dim, group);
        const SizeDistribution& sizes = options.local.sizesOf(group, options.sizes);
        const auto radii = radiiOf(pack, *domain, options.local, group);
        REQUIRE(radii.size() > 200);
        CHECK(radii.front() >= sizes.min());
        CHECK(radii.back() <= sizes.max() * (1 + 1e-6));
        CHECK(ksOf(radii, sizes) < 0.01 + 32.0 / static_cast<double>(radii.size()));
    }
    CHECK(checkOverlap(pack).max == 0);
    CHECK(largestVacancy(pack, *domain, options) < 1.1);
}

TEST_CASE("a shell thinner than the spheres below it has radii of its own, too") {
    // Along the curved wall of a bone, spheres move where they come to touch it.
    FieldOptions field;
    field.detail = 0.4;
    field.depth = 5;
    const auto domain = meshDomain(readMesh(kMeshes + "/mandible.ply"), field);
    PackOptions options(SizeDistribution::uniform(0.8, 1.6));
    options.local.shellSizes = SizeDistribution::uniform(0.4, 0.8);
    options.local.shell = GENERATE(1.0, 1.4);
    const auto pack = packSpheres<3>(*domain, options).pack.spheres;
    for (const std::uint32_t group : {0u, 1u}) {
        CAPTURE(group, options.local.shell.most());
        const SizeDistribution& sizes = options.local.sizesOf(group, options.sizes);
        const auto radii = radiiOf<3>(pack, *domain, options.local, group);
        REQUIRE(radii.size() > 1000);
        CHECK(radii.front() >= sizes.min() * (1 - 1e-6));
        CHECK(radii.back() <= sizes.max() * (1 + 1e-6));
        CHECK(ksOf(radii, sizes) < 0.01);
    }
    CHECK(checkOverlap(pack).max == 0);
    CHECK(largestVacancy<3>(pack, *domain, options) < 1.1);
}

TEST_CASE("a gap is kept between spheres of sizes by place") {
    const auto domain = boxDomain<3>(cube<3>(24));
    PackOptions options = withFactor<3>(*domain, ramp<3>);
    options.gap = 0.1;
    const auto pack = packSpheres(*domain, options).pack.spheres;
    auto grown = pack;
    for (auto& s : grown) s.radius += 0.05 * (1 - 1e-6);
    CHECK(checkOverlap(grown).max == 0);
    const auto radii = radiiOf(pack, *domain, options.local, 0);
    CHECK(radii.front() >= 1 - kMet);
    CHECK(radii.back() <= 2 * (1 + kMet));
}

TEST_CASE("a target count scales the radii of all places alike") {
    const auto domain = ballDomain<3>(18);
    PackOptions options = withFactor<3>(*domain, ramp<3>);
    options.local.shellSizes = SizeDistribution::uniform(0.5, 1);
    options.local.shell = 4;
    const auto result = packToCount<3>(*domain, options, 4000);
    CHECK(static_cast<double>(result.pack.spheres.size()) == Approx(4000).epsilon(0.02));
    CHECK(options.local.shellSizes->max() / options.sizes.max() == Approx(0.5).epsilon(1e-4));
    const auto radii = radiiOf(result.pack.spheres, *domain, options.local, 0);
    CHECK(radii.back() <= options.sizes.max() * (1 + kMet));
}

TEST_CASE("factors beyond the limits are refused with their values") {
    const auto domain = boxDomain<3>(cube<3>(24));
    PackOptions options =
        withFactor<3>(*domain, [](const Vec<3>& x) { return x[0] > 0 ? 30.0 : 1.0; });
    CHECK_THROWS_AS(packSpheres(*domain, options), ParameterError);
    options = withFactor<3>(*domain, [](const Vec<3>& x) { return x[0] > 0 ? 0.0 : 1.0; });
    CHECK_THROWS_AS(packSpheres(*domain, options), ParameterError);
}
