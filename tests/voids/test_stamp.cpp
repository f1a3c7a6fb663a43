#include "support/generators.h"
#include "support/test.h"
#include "voids/stamping.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/solid.h"
#include "vdbpack/voids/void_field.h"

DIM_TEST_CASE("stamped distances are those to the nearest void") {
    const Scene<Dim> scene(0.2);
    const double h = scene.options.voxelSize;
    const auto stamped = scene.stamp();
    typename StampedVoids<Dim>::Sampler distance(*stamped);
    RandomStream random(6, Dim);
    double worst = 0;
    for (int i = 0; i < 15000; ++i) {
        const Vec<Dim> x = voxelAt(randomPoint(random, cube<Dim>(19.8)), scene.options);
        const double exact = distancesTo(scene.voids, x)[0];
        const double error = std::fabs(distance(x) - std::max(-3 * h, std::min(exact, 3 * h)));
        worst = std::max(worst, error);
        if (std::fabs(exact) > 1e-3) REQUIRE((distance(x) < 0) == (exact < 0));
    }
    // 1e-3 of the longest of the shorter half-axes; inside, feet are found less well.
    CHECK(worst < 2e-3);
}

DIM_TEST_CASE("stamped voids repeat in a periodic cell") {
    Scene<Dim> scene(0.2);
    PeriodicCell<Dim> cell{cube<Dim>(20), {}};
    cell.wraps.fill(true);
    cell.wraps[0] = GENERATE(false, true);
    const auto domain = periodicDomain(cell);
    const auto stamped = stampVoids(scene.voids, *domain, scene.options);
    std::vector<Ellipsoid<Dim>> images;  // centers lie in a box of side 22
    for (const auto& e : scene.voids)
        for (int k = 0; k < (Dim == 3 ? 125 : 25); ++k) {
            typename PeriodicCell<Dim>::Laps laps{};
            for (int d = 0, rest = k; d < Dim; ++d, rest /= 5)
                laps[static_cast<std::size_t>(d)] = rest % 5 - 2;
            if (squaredLength(cell.shift(laps)) == 0 && k != (Dim == 3 ? 62 : 12)) continue;
            images.push_back(e);
            images.back().center += cell.shift(laps);
            if (!cell.box.grown(8).contains(images.back().center)) images.pop_back();
        }
    typename StampedVoids<Dim>::Sampler distance(*stamped);
    RandomStream random(6, Dim);
    const double h = scene.options.voxelSize;
    std::size_t inside = 0;
    constexpr int kPoints = Dim == 3 ? 2000 : 10'000;
    for (int i = 0; i < kPoints; ++i) {
        // Also in the band beyond the faces.
        const Vec<Dim> x = voxelAt(randomPoint(random, cube<Dim>(20.5)), scene.options);
        const double exact = distancesTo(images, x)[0];
        CAPTURE(exact, x[0], x[1]);
        REQUIRE(std::fabs(distance(x) - std::clamp(exact, -3 * h, 3 * h)) < 2e-3);
        if (std::fabs(exact) > 1e-3) REQUIRE(stamped->isIn(scene.voids, x) == (exact < 0));
        inside += exact < 0;
    }
    CHECK(stamped->volume() / cell.box.volume() ==
          Approx(static_cast<double>(inside) / kPoints).margin(0.02));
}

DIM_TEST_CASE("between voxels the error of distances is quadratic in the voxel size") {
    const auto domain = boxDomain<Dim>(cube<Dim>(20));
    Ellipsoid<Dim> e;
    e.a = 6;
    e.b = 3;
    RandomStream random(7, Dim);
    e.axis = anyDirection<Dim>(random);
    e.center[0] = 0.3;
    double before = 0;
    for (const double h : {0.6, 0.3, 0.15}) {
        const auto stamped = stampVoids<Dim>({e}, *domain, stampOptions(*domain, h));
        typename StampedVoids<Dim>::Sampler distance(*stamped);
        double worst = 0;
        for (int i = 0; i < 15000; ++i) {
            const Vec<Dim> x = randomPoint(random, cube<Dim>(16));
            const double exact = e.signedDistance(x);
            if (std::fabs(exact) < h) worst = std::max(worst, std::fabs(distance(x) - exact));
        }
        CAPTURE(h, worst, before);
        // The curvature is a / b^2 at most: each direction adds h^2 / 8 times that.
        CHECK(worst < Dim * h * h / 8 * e.a / (e.b * e.b) * 1.5 + 1e-3 * e.b);
        if (before > 0) CHECK(worst < before / 2.5);
        before = worst;
    }
}

DIM_TEST_CASE("next to the interface the gradient of distances is one") {
    const Scene<Dim> scene(0.1);
    const double h = scene.options.voxelSize;
    const auto stamped = scene.stamp();
    typename StampedVoids<Dim>::Sampler distance(*stamped);
    RandomStream random(8, Dim);
    int looked = 0;
    for (int i = 0; i < 100000 && looked < 1500; ++i) {
        const Vec<Dim> x = voxelAt(randomPoint(random, cube<Dim>(19)), scene.options);
        if (std::fabs(distance(x)) >= 1.5 * h) continue;
        // Not where two voids meet, nor where one is as narrow as the step.
        const auto nearest = distancesTo(scene.voids, x);
        if (nearest[1] - nearest[0] < 3 * h) continue;
        ++looked;
        Vec<Dim> gradient;
        for (int d = 0; d < Dim; ++d) {
            Vec<Dim> step;
            step[d] = h;
            gradient[d] = (distance(x + step) - distance(x - step)) / (2 * h);
        }
        CAPTURE(x.c, nearest[0]);
        REQUIRE(length(gradient) == Approx(1).margin(0.1));
    }
    CHECK(looked > 500);
}

DIM_TEST_CASE("signs are right far inside a void and far outside") {
    const auto domain = boxDomain<Dim>(cube<Dim>(40));
    // Larger than hundreds of voxels, side by side and across one another.
    std::vector<Ellipsoid<Dim>> voids(3);
    for (auto& e : voids) e.axis[0] = 1;
    voids[0].a = 12, voids[0].b = 9, voids[0].center[0] = -6;
    voids[1].a = 8, voids[1].b = 8, voids[1].center[0] = 11;
    voids[2].a = 1, voids[2].b = 1, voids[2].center[0] = -6;  // in the middle of the first
    const auto options = stampOptions(*domain, 0.1);
    const auto stamped = stampVoids(voids, *domain, options);
    typename StampedVoids<Dim>::Sampler distance(*stamped);
    RandomStream random(9, Dim);
    for (int i = 0; i < 15000; ++i) {
        const Vec<Dim> x = randomPoint(random, cube<Dim>(40));
        const double exact = distancesTo(voids, x)[0];
        if (std::fabs(exact) < 0.01) continue;
        CAPTURE(x.c, exact);
        REQUIRE((distance(x) < 0) == (exact < 0));
        if (std::fabs(exact) > 0.5) REQUIRE(distance(x) == Approx(exact < 0 ? -0.3 : 0.3));
    }
    // No voxels are kept where nothing changes.
    const double surface = Dim == 3 ? 4 * kPi * (100 + 64) : 2 * kPi * (11 + 8);
    CHECK(static_cast<double>(stamped->activeVoxels()) <
          1.2 * 6 * 0.1 * surface / std::pow(0.1, Dim));
}

DIM_TEST_CASE("stamping is the same for any number of threads and any order") {
    const double shell = GENERATE(0.0, 1.3);
    CAPTURE(Dim, shell);
    Scene<Dim> scene(0.15, shell);
    // Voids of one shape at one place tie.
    scene.voids.push_back(scene.voids[3]);
    scene.voids.push_back(scene.voids[3]);
    const auto values = [&](const StampedVoids<Dim>& stamped) {
        typename StampedVoids<Dim>::Sampler distance(stamped);
        RandomStream random(10, Dim);
        std::vector<double> all{stamped.volume(), static_cast<double>(stamped.activeVoxels())};
        for (int i = 0; i < 50000; ++i)
            all.push_back(distance(voxelAt(randomPoint(random, cube<Dim>(20.6)), scene.options)));
        return all;
    };
    const auto one = withThreads(1, [&] { return values(*scene.stamp()); });
    for (const int threads : {2, 8})
        REQUIRE(withThreads(threads, [&] { return values(*scene.stamp()); }) == one);
    shuffle(scene.voids, 77);
    REQUIRE(values(*scene.stamp()) == one);
}

DIM_TEST_CASE("overlapping voids are measured once") {
    const double shell = GENERATE(0.0, 1.7);
    CAPTURE(Dim, shell);
    const Scene<Dim> scene(0.1, shell);
    RandomStream random(11, Dim);
    constexpr int kPoints = 60000;
    int inside = 0;
    for (int i = 0; i < kPoints; ++i) {
        const Vec<Dim> x = randomPoint(random, cube<Dim>(20 - 2 * shell));
        for (const auto& e : scene.voids)
            if (e.contains(x)) {
                ++inside;
                break;
            }
    }
    const double share = static_cast<double>(inside) / kPoints;
    const double error = std::sqrt(share * (1 - share) / kPoints);
    CHECK(scene.stamp()->volume() / cube<Dim>(20 - 2 * shell).volume() ==
          Approx(share).margin(4 * error + 5e-4));
}

DIM_TEST_CASE("voids that contain no voxel, or lie outside, have no volume") {
    const auto domain = ballDomain<Dim>(5);
    Ellipsoid<Dim> far, none;
    far.a = far.b = 3;
    far.axis[0] = 1;
    far.center = Box<Dim>::filled(30);
    const auto options = stampOptions(*domain, 0.25);
    const auto stamped = stampVoids<Dim>({far}, *domain, options);
    CHECK(stamped->volume() == 0);
    CHECK(stamped->activeVoxels() == 0);
    typename StampedVoids<Dim>::Sampler distance(*stamped);
    CHECK(distance({}) == Approx(0.75));
    CHECK(distance(Box<Dim>::filled(1e300)) == Approx(0.75));
    CHECK(stampVoids<Dim>({}, *domain, options)->volume() == 0);
    const auto refuse = [&](const Ellipsoid<Dim>& e, const StampOptions<Dim>& o) {
        return messageOf<ParameterError>([&] { stampVoids<Dim>({far, e}, *domain, o); });
    };
    CHECK_THAT(refuse(none, options), Contains("void 1") && Contains("0 and 0 mm"));
    auto negative = far;
    negative.b = -1;
    CHECK_THAT(refuse(negative, options), Contains("void 1") && Contains("-1 mm"));
    auto lost = far;
    lost.center[0] = std::nan("");
    CHECK_THAT(refuse(lost, options), Contains("void 1") && Contains("center"));
    auto bad = options;
    bad.voxelSize = 0;
    CHECK_THAT(refuse(far, bad), Contains("`voids.voxelSize` 0 mm"));
    bad = options;
    bad.shell = -1;
    CHECK_THAT(refuse(far, bad), Contains("`voids.shell` -1 mm"));
    bad = options;
    bad.voxelSize = 1e-9;
    CHECK_THROWS_AS(stampVoids<Dim>({far}, *domain, bad), ResourceError);
}

namespace {

/// Voids that would eat all of a domain.
template <int Dim>
std::vector<Ellipsoid<Dim>> devouring(const Domain<Dim>& domain) {
    Ellipsoid<Dim> e;
    e.center = domain.bounds().center();
    e.a = e.b = length(domain.bounds().size());
    e.axis[0] = 1;
    auto voids = anyVoids<Dim>(60, domain.bounds(), 1, 3, 0.5, 3, 12);
    voids.push_back(e);
    return voids;
}

/// What is wrong with a shell that voids had to leave alone.
template <int Dim>
struct ShellFlaws {
    int within = 0;   ///< voxels in voids nearer to the wall than the shell
    int missing = 0;  ///< voxels deeper than shell and voxel that are not in voids
    int shallow = 0;  ///< voxels of the same deeper than the band whose value is not its end
    int voids = 0;
};

template <int Dim>
ShellFlaws<Dim> flawsOf(const Domain<Dim>& domain, const StampedVoids<Dim>& stamped,
                        const StampOptions<Dim>& options, double slack) {
    ShellFlaws<Dim> flaws;
    typename StampedVoids<Dim>::Sampler distance(stamped);
    const auto sampler = domain.sampler();
    const double h = options.voxelSize, error = domain.facts().voxelSize;
    forEachVoxel(domain.bounds().grown(2 * h), options, [&](const Vec<Dim>& x) {
        const double d = distance(x);
        WallPoint<Dim> wall;
        if (d < 0) {
            ++flaws.voids;
            flaws.within +=
                sampler->nearestWall(x, options.shell.at(x), wall) || !sampler->contains(x);
        }
        if (!sampler->contains(x)) return;
        flaws.missing += d >= 0 && !sampler->isWallCloser(x, options.shell.at(x) + slack);
        flaws.shallow +=
            d > -2.99 * h && !sampler->isWallCloser(x, options.shell.at(x) + 3 * h + error);
    });
    return flaws;
}

template <int Dim>
void checkShell(const Domain<Dim>& domain, double voxelSize, double shell, double slack = 2e-3) {
    CAPTURE(domain.facts().kind, domain.facts().voxelSize, voxelSize, shell);
    const auto options = stampOptions(domain, voxelSize, shell);
    const auto stamped = stampVoids(devouring(domain), domain, options);
    const auto flaws = flawsOf(domain, *stamped, options, slack);
    CHECK(flaws.within == 0);
    CHECK(flaws.missing == 0);
    CHECK(flaws.shallow == 0);
    CHECK(flaws.voids > 0);
    CHECK(stamped->volume() == Approx(flaws.voids * std::pow(voxelSize, Dim)).epsilon(1e-12));
}

std::shared_ptr<const MeshDomain> fieldOf(TriangleMesh mesh, double voxelSize, double depth) {
    FieldOptions options;
    options.voxelSize = voxelSize;
    options.depth = depth;
    return meshDomain(std::move(mesh), options);
}

}  // namespace

DIM_TEST_CASE("no voxel of a void lies in the shell of a shape") {
    checkShell<Dim>(*boxDomain<Dim>(cube<Dim>(10)), 0.2, 1.5);
    checkShell<Dim>(*ballDomain<Dim>(5), 0.2, 0.7);
    Vec<Dim> normal;
    normal[0] = 1;
    normal[1] = 0.4;
    checkShell<Dim>(*clippedDomain<Dim>(ballDomain<Dim>(5), {{normal, 2}}), 0.2, 1.1);
}

TEST_CASE("no voxel of a void lies in the shell of a mesh") {
    const double fieldVoxel = GENERATE(0.2, 0.8);
    const double shell = 1.5;
    const auto ball = fieldOf(ballMesh(6, 4), fieldVoxel, 1.1 * shell + 10 * 0.2);
    checkShell<3>(*ball, 0.2, shell);
    checkShell<3>(*clippedDomain<3>(ball, {{{{1, 0.3, -0.2}}, 2}}), 0.2, shell);
    checkShell<2>(*sliceDomain(ball, 1.2), 0.1, shell);
}

TEST_CASE("stampings that share what is known of the shell are those that do not") {
    for (const double deep : {1.1 * 1.5 + 10 * 0.2, 0.5}) {  // the second field ends above it
        CAPTURE(deep);
        const auto ball = fieldOf(ballMesh(6, 4), 0.35, deep);
        auto options = stampOptions<3>(*ball, 0.2, 1.5);
        options.core = unknownCore<3>();
        auto alone = options;
        alone.core = nullptr;
        const auto voids = anyVoids<3>(60, test::cube<3>(11), 0.5, 2, 0.6, 1.6, 5);
        for (const std::ptrdiff_t count : {20, 60, 40}) {
            const std::vector<Ellipsoid<3>> some(voids.begin(), voids.begin() + count);
            const auto shared = stampVoids(some, *ball, options),
                       own = stampVoids(some, *ball, alone);
            CHECK(shared->volume() == own->volume());
            CHECK(shared->activeVoxels() == own->activeVoxels());
            StampedVoids<3>::Sampler a(*shared), b(*own);
            RandomStream random(7, 3);
            for (int i = 0; i < 5000; ++i) {
                const Vec<3> x = randomPoint(random, cube<3>(12));
                REQUIRE(a(x) == b(x));
            }
        }
    }
}

TEST_CASE("a shell is complete at edges that the field is too coarse for") {
    // Around the cavity distances bend most: the field takes points for deeper than they are.
    const auto mesh =
        merged(boxMesh({{-5, -5, -5}}, {{5, 5, 5}}), flipped(boxMesh({{-2, -2, -2}}, {{2, 2, 2}})));
    const auto domain = fieldOf(mesh, 0.9, 3);
    // In the corners of the box it takes some for outside.
    checkShell<3>(*domain, 0.08, 0.35, 0.45);
}

TEST_CASE("voids have their full band even if the field of the bone is shallow") {
    const auto domain = fieldOf(ballMesh(6, 4), 0.25, 1.1 * 1.5);
    CAPTURE(domain->fieldDepth());
    checkShell<3>(*domain, 0.3, 1.5);
    checkShell<3>(*clippedDomain<3>(domain, {{{{1, 0.3, -0.2}}, 2}}), 0.3, 1.5);
    checkShell<2>(*sliceDomain(domain, 1.2), 0.3, 1.5);
}

TEST_CASE("the shell stays solid to the last voxel") {
    const auto mesh = fieldOf(ballMesh(6, 4), 0.3, 3.6);
    const std::vector<std::shared_ptr<const Domain<3>>> domains{
        mesh, boxDomain<3>(cube<3>(10)), ballDomain<3>(5),
        clippedDomain<3>(mesh, {{{{1, 0.3, -0.2}}, 2}}), cylinderDomain(4, 9)};
    const double shell = 1.5, h = 0.2;
    const bool keepConnected = GENERATE(false, true);
    for (const auto& domain : domains) {
        CAPTURE(domain->facts().kind);
        const auto surface = surfaceLevelSet(*domain, h);
        const auto voids = stampVoids(devouring(*domain), *domain, stampOptions(*domain, h, shell));
        const auto solid = cutVoids(*surface, *voids->grid(), shell, keepConnected);
        const Box<3> box = domain->bounds();
        const auto before = sampleLevelSet(*surface, box), after = sampleLevelSet(*solid.grid, box);
        REQUIRE(before.size == after.size);
        const auto sampler = domain->sampler();
        int lost = 0, left = 0, shellVoxels = 0;
        for (std::size_t i = 0; i < after.voxels(); ++i) {
            const Vec<3> x = centerOf(after, i);
            WallPoint<3> wall;
            const bool inShell = sampler->nearestWall(x, shell - 1e-6, wall);
            if (before.distance[i] < 0 && inShell) {
                ++shellVoxels;
                lost += after.distance[i] >= 0;
            }
            if (!sampler->isWallCloser(x, shell + 1e-3)) left += after.distance[i] < 0;
        }
        CHECK(lost == 0);
        CHECK(left == 0);
        CHECK(shellVoxels > 1000);
        CHECK(solid.components == 1);
        CHECK(solid.attached == 1);
        CHECK(solid.dropped == 0);
    }
}

TEST_CASE("voids of a plane have no level set in space") {
    const auto domain = ballDomain<2>(5);
    CHECK_THROWS_AS(stampVoids<2>({}, *domain, stampOptions(*domain, 0.2))->grid(), ParameterError);
}

TEST_CASE("a wide reach for culling does not change the level set") {
    const Scene<3> scene(0.25);
    auto wide = scene.options;
    wide.reach = 3;
    const auto narrow = scene.stamp(), far = stampVoids(scene.voids, *scene.domain, wide);
    CHECK(narrow->volume() == far->volume());
    const auto a = sampleLevelSet(*narrow->grid(), cube<3>(20)),
               b = sampleLevelSet(*far->grid(), cube<3>(20));
    CHECK(a.distance == b.distance);
    StampedVoids<3>::Sampler distance(*far);
    RandomStream random(13, 3);
    for (int i = 0; i < 8000; ++i) {
        const Vec<3> x = voxelAt(randomPoint(random, cube<3>(19.8)), wide);
        const double exact = distancesTo(scene.voids, x)[0];
        REQUIRE(distance(x) == Approx(std::clamp(exact, -0.75, 3.0)).margin(2e-3));
    }
}
