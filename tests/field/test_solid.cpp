#include "support/test.h"
#include "voids/stamping.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/field/solid.h"

namespace {

/// Connected components of the voxels inside, found one by one.
struct Flood {
    std::vector<std::uint32_t> component;  ///< of each voxel, 0 outside
    std::vector<std::size_t> size{0};      ///< voxels of each
};

/// @param faces  voxels are connected by faces; else by edges as well.
Flood floodOf(const VoxelImage& image, bool faces = true) {
    Flood flood;
    flood.component.assign(image.voxels(), 0);
    const auto nx = image.size[0], ny = image.size[1], nz = image.size[2];
    std::vector<std::size_t> stack;
    for (std::size_t start = 0; start < image.voxels(); ++start) {
        if (image.distance[start] >= 0 || flood.component[start] != 0) continue;
        const auto name = static_cast<std::uint32_t>(flood.size.size());
        flood.size.push_back(0);
        flood.component[start] = name;
        stack.push_back(start);
        while (!stack.empty()) {
            const auto at = static_cast<std::int64_t>(stack.back());
            stack.pop_back();
            ++flood.size[name];
            const std::int64_t i = at % nx, j = at / nx % ny, k = at / nx / ny;
            for (int c = -1; c <= 1; ++c)
                for (int b = -1; b <= 1; ++b)
                    for (int a = -1; a <= 1; ++a) {
                        const int steps = std::abs(a) + std::abs(b) + std::abs(c);
                        if (steps == 0 || steps > (faces ? 1 : 2)) continue;
                        if (i + a < 0 || i + a >= nx || j + b < 0 || j + b >= ny || k + c < 0 ||
                            k + c >= nz)
                            continue;
                        const auto next =
                            static_cast<std::size_t>(i + a + nx * (j + b + ny * (k + c)));
                        if (image.distance[next] >= 0 || flood.component[next] != 0) continue;
                        flood.component[next] = name;
                        stack.push_back(next);
                    }
        }
    }
    return flood;
}

/// Balls so close to one another that they part what is inside a sphere from what is outside.
std::vector<Ellipsoid<3>> sphericalGap(double radius, double halfWidth) {
    const auto count = static_cast<int>(16 * kPi * radius * radius / (halfWidth * halfWidth));
    std::vector<Ellipsoid<3>> voids(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        auto& e = voids[static_cast<std::size_t>(i)];
        const double z = 1 - (2 * i + 1.0) / count, turn = kPi * (3 - std::sqrt(5.0)) * i;
        const double across = std::sqrt(1 - z * z);
        e.center = Vec<3>{{across * std::cos(turn), across * std::sin(turn), z}} * radius;
        e.a = e.b = halfWidth;
        e.axis = {{0, 0, 1}};
    }
    return voids;
}

struct Cut {
    std::shared_ptr<const VdbGrid> surface;
    Solid solid;
    VoxelImage image, before;
};

Cut cutOf(const Domain<3>& domain, const std::vector<Ellipsoid<3>>& voids, double voxelSize,
          double shell, bool keepConnected) {
    Cut cut;
    cut.surface = surfaceLevelSet(domain, voxelSize);
    const auto stamped = stampVoids(voids, domain, stampOptions(domain, voxelSize, shell));
    cut.solid = cutVoids(*cut.surface, *stamped->grid(), shell, keepConnected);
    const Box<3> box = domain.bounds().grown(3 * voxelSize);
    cut.image = sampleLevelSet(*cut.solid.grid, box);
    cut.before = sampleLevelSet(*cut.surface, box);
    return cut;
}

/// Number of voxels in components that contain a part of the shell (without one: in the largest
/// component).
std::size_t attachedVoxels(const VoxelImage& image, const Flood& flood, const Domain<3>& domain,
                           double shell) {
    std::vector<bool> attached(flood.size.size());
    if (shell > 0) {
        const auto sampler = domain.sampler();
        for (std::size_t i = 0; i < image.voxels(); ++i)
            if (flood.component[i] != 0 && sampler->isWallCloser(centerOf(image, i), 0.9 * shell))
                attached[flood.component[i]] = true;
    } else {
        attached[static_cast<std::size_t>(std::max_element(flood.size.begin(), flood.size.end()) -
                                          flood.size.begin())] = true;
    }
    std::size_t voxels = 0;
    for (std::size_t p = 0; p < attached.size(); ++p)
        if (attached[p]) voxels += flood.size[p];
    return voxels;
}

std::size_t voxelsOf(const Flood& flood) {
    std::size_t all = 0;
    for (const std::size_t n : flood.size) all += n;
    return all;
}

}  // namespace

TEST_CASE("solid is the surface without the voids") {
    const auto domain = ballDomain<3>(8);
    const auto voids = anyVoids<3>(60, cube<3>(16), 0.8, 2, 0.5, 3, 61);
    const double shell = GENERATE(0.0, 1.2);
    CAPTURE(shell);
    const double h = 0.2;
    const auto cut = cutOf(*domain, voids, h, shell, false);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < cut.image.voxels(); i += 13) {
        const Vec<3> x = centerOf(cut.image, i);
        const double wall = length(x) - 8;
        const double toVoid = std::max(distancesTo(voids, x)[0], shell > 0 ? wall + shell : -1e9);
        const double exact = std::clamp(std::max(wall, -toVoid), -3 * h, 3 * h);
        const double d = static_cast<double>(cut.image.distance[i]);
        CAPTURE(x.c, d, exact);
        REQUIRE(std::fabs(d - exact) < 4e-3);
        inside += d < 0;
    }
    CHECK(inside > 5000);
}

TEST_CASE("a void all around parts a ball from the bone") {
    const double shell = GENERATE(0.0, 1.5);
    const auto domain = ballDomain<3>(8);
    const auto voids = sphericalGap(5, 0.8);
    const double h = 0.2;
    const auto cut = cutOf(*domain, voids, h, shell, false);
    CHECK(cut.solid.components == 2);
    const Flood flood = floodOf(cut.image);
    REQUIRE(flood.size.size() == 3);
    const auto all = static_cast<double>(voxelsOf(flood));
    const auto held = static_cast<double>(std::max(flood.size[1], flood.size[2]));
    CHECK(cut.solid.attached == Approx(held / all).epsilon(1e-12));
    CHECK(held / all ==
          Approx((512 - std::pow(5.75, 3)) / (512 - std::pow(5.75, 3) + std::pow(4.25, 3)))
              .margin(0.01));
    CHECK(cut.solid.dropped == 0);

    const auto dropped = cutOf(*domain, voids, h, shell, true);
    CHECK(dropped.solid.dropped == Approx((all - held) * h * h * h).epsilon(1e-12));
    CHECK(dropped.solid.components == 2);
    CHECK(dropped.solid.attached == cut.solid.attached);
    const Flood left = floodOf(dropped.image);
    REQUIRE(left.size.size() == 2);
    CHECK(static_cast<double>(left.size[1]) == held);
    // Nothing else has changed.
    for (std::size_t i = 0; i < cut.image.voxels(); ++i)
        if (cut.image.distance[i] < 0 && left.component[i] != 0)
            REQUIRE(cut.image.distance[i] == dropped.image.distance[i]);
}

TEST_CASE("components are those of a search voxel by voxel") {
    const double shell = GENERATE(0.0, 0.6);
    const auto seed = GENERATE(71u, 72u);
    CAPTURE(shell, seed);
    const auto domain = boxDomain<3>(cube<3>(12));
    // Little is left between so many.
    const auto voids = anyVoids<3>(700, cube<3>(14), 0.7, 1.1, 0.5, 2, seed);
    const auto cut = cutOf(*domain, voids, 0.15, shell, false);
    const Flood flood = floodOf(cut.image);
    const std::size_t all = voxelsOf(flood);
    CAPTURE(all, flood.size.size());
    // Some touch one another by edges only.
    CHECK(floodOf(cut.image, false).size.size() < flood.size.size());
    CHECK(flood.size.size() > 30);
    CHECK(cut.solid.components == flood.size.size() - 1);
    const std::size_t held = attachedVoxels(cut.image, flood, *domain, shell);
    CHECK(cut.solid.attached ==
          Approx(static_cast<double>(held) / static_cast<double>(all)).epsilon(1e-12));
    const auto kept = cutOf(*domain, voids, 0.15, shell, true);
    CHECK(kept.solid.dropped ==
          Approx(static_cast<double>(all - held) * 0.15 * 0.15 * 0.15).epsilon(1e-9));
    const Flood left = floodOf(kept.image);
    CHECK(voxelsOf(left) == held);
}

TEST_CASE("a component extends across leaves and tiles of any size") {
    // 480 voxels across: tiles of 128 voxels lie deep inside, beside those of eight.
    const auto domain = ballDomain<3>(60, {{3, -7, 11}});
    const double h = 0.25;
    auto voids = sphericalGap(45, 4);
    for (auto& e : voids) e.center += Vec<3>{{3, -7, 11}};
    const auto surface = surfaceLevelSet(*domain, h);
    const auto whole = stampVoids<3>({}, *domain, stampOptions(*domain, h, 2));
    const auto uncut = cutVoids(*surface, *whole->grid(), 2, true);
    CHECK(uncut.components == 1);
    CHECK(uncut.attached == 1);
    CHECK(uncut.dropped == 0);
    const auto stamped = stampVoids(voids, *domain, stampOptions(*domain, h, 2));
    const double core = std::pow(41, 3), ring = std::pow(60, 3) - std::pow(49, 3);
    for (const bool keepConnected : {false, true}) {
        const auto cut = cutVoids(*surface, *stamped->grid(), 2, keepConnected);
        CHECK(cut.components == 2);
        CHECK(cut.attached == Approx(ring / (ring + core)).margin(0.01));
        const auto at = [&](const Vec<3>& x) {
            const auto image = sampleLevelSet(*cut.grid, Box<3>{x, x}.grown(0.3));
            return image.distance[image.voxels() / 2];
        };
        // Interior and gap, by their signs.
        CHECK((at({{3, -7, 11}}) < 0) == !keepConnected);
        CHECK((at({{3, -7, 51}}) < 0) == !keepConnected);
        CHECK(at({{3, -7, 56}}) > 0);
        CHECK(at({{3, -7, 65}}) < 0);
        if (keepConnected) CHECK(cut.dropped == Approx(4.0 / 3 * kPi * core).epsilon(0.03));
    }
}

TEST_CASE("surface and voids must lie on one lattice") {
    const auto domain = ballDomain<3>(5);
    const auto surface = surfaceLevelSet(*domain, 0.25);
    auto options = stampOptions(*domain, 0.25);
    options.origin[1] += 0.1;
    const auto shifted = stampVoids<3>({}, *domain, options)->grid();
    CHECK_THROWS_AS(cutVoids(*surface, *shifted, 0, false), ParameterError);
}

TEST_CASE("voids that take all leave no component") {
    const auto domain = ballDomain<3>(5);
    Ellipsoid<3> e;
    e.a = e.b = 7;
    e.axis[0] = 1;
    const auto surface = surfaceLevelSet(*domain, 0.25);
    const auto stamped = stampVoids<3>({e}, *domain, stampOptions(*domain, 0.25));
    const auto solid = cutVoids(*surface, *stamped->grid(), 0, true);
    CHECK(solid.components == 0);
    CHECK(solid.attached == 0);
    CHECK(solid.dropped == 0);
}

TEST_CASE("what a periodic cell joins across its faces is one component") {
    const Box<3> box = cube<3>(8);
    const double h = GENERATE(0.25, 0.27);
    const auto surface = surfaceLevelSet(*boxDomain<3>(box), h);
    // A slab across the middle leaves a part below and one above.
    const auto slab = surfaceLevelSet(*boxDomain<3>({{{-6, -6, -1}}, {{6, 6, 1}}}), h);
    CHECK(cutVoids(*surface, *slab, 0, false).components == 2);
    PeriodicCell<3> cell{box, {true, true, false}};
    CHECK(cutVoids(*surface, *slab, 0, false, {}, cell).components == 2);
    cell.wraps = {false, false, true};
    const Solid joined = cutVoids(*surface, *slab, 0, true, {}, cell);
    CHECK(joined.components == 1);
    CHECK(joined.attached == 1);
    CHECK(joined.dropped == 0);
}
