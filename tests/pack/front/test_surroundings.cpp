#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/pack/front/surroundings.h"

namespace {

/// Spheres around a pivot at the origin, and planes given by normal and the height of the pivot.
template <int Dim>
struct Scene {
    double pivotRadius;
    std::vector<Sphere<Dim>> spheres;
    std::vector<std::pair<Vec<Dim>, double>> planes;

    std::size_t bodies() const { return spheres.size() + planes.size(); }
    /// Gap between body `i` and a sphere at x.
    double gapTo(std::size_t i, const Vec<Dim>& x, double r) const {
        if (i < spheres.size()) return length(x - spheres[i].center) - spheres[i].radius - r;
        const auto& [normal, above] = planes[i - spheres.size()];
        return dot(x, normal) + above - r;
    }
    double leastGap(const Vec<Dim>& x, double r) const {
        double least = length(x) - pivotRadius - r;
        for (std::size_t i = 0; i < bodies(); ++i) least = std::min(least, gapTo(i, x, r));
        return least;
    }
};

template <int Dim>
Vec<Dim> randomDirection(RandomStream& random) {
    for (;;) {
        Vec<Dim> v;
        for (int d = 0; d < Dim; ++d) v[d] = 2 * random.uniform() - 1;
        if (length(v) > 0.1 && length(v) < 1) return normalized(v);
    }
}

/// @param least  spheres at least; up to 7 more, and up to 2 planes.
template <int Dim>
Scene<Dim> randomScene(RandomStream& random, int least) {
    // One draw a statement: compilers order those of an expression differently.
    const int spheres = least + static_cast<int>(8 * random.uniform());
    const int planes = static_cast<int>(3 * random.uniform());
    Scene<Dim> scene;
    scene.pivotRadius = 1 + random.uniform();
    for (int tries = 0; tries < 400 && static_cast<int>(scene.spheres.size()) < spheres; ++tries) {
        Sphere<Dim> s;
        s.radius = 1 + random.uniform();
        const Vec<Dim> towards = randomDirection<Dim>(random);
        s.center = towards * (scene.pivotRadius + s.radius + 3 * random.uniform());
        const bool free = std::none_of(scene.spheres.begin(), scene.spheres.end(),
                                       [&](const auto& o) { return gap(o, s) < 0; });
        if (free) scene.spheres.push_back(s);
    }
    for (int p = 0; p < planes; ++p) {
        const Vec<Dim> normal = randomDirection<Dim>(random);
        scene.planes.emplace_back(normal, scene.pivotRadius + 2 * random.uniform());
    }
    return scene;
}

template <int Dim>
void fillWith(Surroundings<Dim>& around, const Scene<Dim>& scene) {
    around.spheres.count = 0;
    CellList<Dim> cells;
    cells.reset({Box<Dim>::filled(-10), Box<Dim>::filled(10)}, 3, 2);
    for (std::uint32_t i = 0; i < scene.spheres.size(); ++i) cells.add(scene.spheres[i], i);
    around.collect(cells, Vec<Dim>{}, 8, 0xffffffffu);
    REQUIRE(around.spheres.count == scene.spheres.size());
    for (std::uint32_t p = 0; p < scene.planes.size(); ++p) {
        std::array<float, Dim> normal;
        for (std::size_t d = 0; d < Dim; ++d)
            normal[d] = static_cast<float>(scene.planes[p].first.c[d]);
        around.addWall(normal, static_cast<float>(scene.planes[p].second),
                       static_cast<std::uint32_t>(scene.spheres.size()) + p);
    }
}

template <int Dim>
using Sites = std::vector<typename Surroundings<Dim>::Site>;

/// The sites of a scene where a probe of radius 1 fits, with limits up to 2.
/// @param least  radius that a site has to allow.
template <int Dim>
Sites<Dim> sitesOf(const Scene<Dim>& scene, float least = 0,
                   std::uint32_t body = Surroundings<Dim>::kAll,
                   const typename Surroundings<Dim>::Region* region = nullptr) {
    Surroundings<Dim> around;
    fillWith(around, scene);
    Sites<Dim> sites;
    around.findSites(static_cast<float>(scene.pivotRadius), {1.0f, least, 2.0f}, body, region,
                     sites);
    return sites;
}

/// Centers of spheres of radius r that touch the pivot and the bodies, by Newton steps from many
/// starts: nothing in common with the code under test.
template <int Dim>
std::vector<Vec<Dim>> touching(const Scene<Dim>& scene, const std::vector<std::size_t>& bodies,
                               double r) {
    std::vector<Vec<Dim>> found;
    RandomStream random(99, 0);
    for (int start = 0; start < 24; ++start) {
        Vec<Dim> x = randomDirection<Dim>(random) * (scene.pivotRadius + r);
        const auto residuals = [&](const Vec<Dim>& at) {
            Vec<Dim> f;
            f[0] = length(at) - scene.pivotRadius - r;
            for (std::size_t b = 0; b < bodies.size(); ++b)
                f[static_cast<int>(b) + 1] = scene.gapTo(bodies[b], at, r);
            return f;
        };
        for (int step = 0; step < 40; ++step) {
            const Vec<Dim> f = residuals(x);
            // Numerical Jacobian, solved by Cramer's rule.
            Vec<Dim> column[Dim];
            for (int d = 0; d < Dim; ++d) {
                Vec<Dim> y = x;
                y[d] += 1e-6;
                column[d] = (residuals(y) - f) * 1e6;
            }
            Vec<Dim> move;
            if constexpr (Dim == 3) {
                const double det = dot(column[0], cross(column[1], column[2]));
                if (std::fabs(det) < 1e-9) break;
                move = {{dot(f, cross(column[1], column[2])) / det,
                         dot(column[0], cross(f, column[2])) / det,
                         dot(column[0], cross(column[1], f)) / det}};
            } else {
                const double det = column[0][0] * column[1][1] - column[1][0] * column[0][1];
                if (std::fabs(det) < 1e-9) break;
                move = {{(f[0] * column[1][1] - column[1][0] * f[1]) / det,
                         (column[0][0] * f[1] - f[0] * column[0][1]) / det}};
            }
            const double l = length(move);
            x -= move * std::min(1.0, 0.5 / std::max(l, 1e-12));
        }
        if (length(residuals(x)) > 1e-9) continue;
        if (std::none_of(found.begin(), found.end(),
                         [&](const Vec<Dim>& y) { return length(x - y) < 1e-5; }))
            found.push_back(x);
    }
    return found;
}

template <int Dim>
Vec<Dim> toDouble(const std::array<float, Dim>& v) {
    Vec<Dim> d;
    for (std::size_t i = 0; i < Dim; ++i) d.c[i] = static_cast<double>(v[i]);
    return d;
}

template <int Dim>
std::vector<std::size_t> bodiesOf(const typename Surroundings<Dim>::Site& site) {
    return {site.bodies.begin(), site.bodies.end()};
}

}  // namespace

DIM_TEST_CASE("sites are the free positions that touch the pivot and the bodies") {
    const auto seed = GENERATE(range(1u, 31u));
    CAPTURE(Dim, seed);
    RandomStream random(seed, Dim);
    const auto scene = randomScene<Dim>(random, 2);
    const double probe = 1.0;
    const auto sites = sitesOf(scene);
    for (const auto& site : sites) {
        const Vec<Dim> x = toDouble<Dim>(site.start);
        CHECK(length(x) == Approx(scene.pivotRadius + probe).epsilon(1e-5));
        for (const auto body : site.bodies) CHECK(std::fabs(scene.gapTo(body, x, probe)) < 1e-3);
        CHECK(scene.leastGap(x, probe) > -1e-3);
    }
    // None is missed.
    const std::size_t count = scene.bodies();
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = Dim == 3 ? i + 1 : 0; j < (Dim == 3 ? count : 1); ++j) {
            const auto bodies = Dim == 3 ? std::vector<std::size_t>{i, j} : std::vector{i};
            for (const auto& x : touching(scene, bodies, probe)) {
                bool clearlyFree = true;
                for (std::size_t k = 0; k < count; ++k)
                    if (std::find(bodies.begin(), bodies.end(), k) == bodies.end())
                        clearlyFree = clearlyFree && scene.gapTo(k, x, probe) > 1e-3;
                if (!clearlyFree) continue;
                CAPTURE(i, j, x[0], x[1]);
                CHECK(std::any_of(sites.begin(), sites.end(), [&](const auto& site) {
                    return length(toDouble<Dim>(site.start) - x) < 2e-3;
                }));
            }
        }
    // Those that touch one body are the same as found alone.
    for (std::uint32_t body = 0; body < count; ++body) {
        const auto some = sitesOf(scene, 0, body);
        const auto expected = std::count_if(sites.begin(), sites.end(), [&](const auto& site) {
            return std::find(site.bodies.begin(), site.bodies.end(), body) != site.bodies.end();
        });
        CHECK(static_cast<std::ptrdiff_t>(some.size()) == expected);
    }
    // Those that start in a region are the same as found among all.
    typename Surroundings<Dim>::Region region;
    region.lo.fill(-0.3f);
    region.hi.fill(9.0f);
    const auto some = sitesOf(scene, 0, Surroundings<Dim>::kAll, &region);
    std::size_t next = 0;
    for (const auto& site : sites) {
        if (std::any_of(site.start.begin(), site.start.end(), [](float x) { return x < -0.3f; }))
            continue;
        REQUIRE(next < some.size());
        CHECK(some[next].bodies == site.bodies);
        CHECK(some[next++].start == site.start);
    }
    CHECK(next == some.size());
}

DIM_TEST_CASE("a site's limit is where a growing sphere meets a further body") {
    const auto seed = GENERATE(range(1u, 31u));
    CAPTURE(Dim, seed);
    RandomStream random(seed, 10 + Dim);
    const auto scene = randomScene<Dim>(random, 3);
    for (const auto& site : sitesOf(scene)) {
        const double limit = static_cast<double>(site.limit);
        REQUIRE(limit >= 1);
        REQUIRE(limit <= 2);
        const Vec<Dim> end = toDouble<Dim>(site.end);
        CHECK(length(end) == Approx(scene.pivotRadius + limit).epsilon(1e-4));
        for (const auto body : site.bodies) CHECK(std::fabs(scene.gapTo(body, end, limit)) < 5e-3);
        CHECK(scene.leastGap(end, limit) > -5e-3);
        if (limit >= 2) continue;
        // A slightly larger one fits nowhere near the last, or only inside another body.
        const double more = limit + 0.02;
        for (const auto& x : touching(scene, bodiesOf<Dim>(site), more))
            if (length(x - end) < 0.1) CHECK(scene.leastGap(x, more) < 5e-3);
    }
}

DIM_TEST_CASE("a least radius leaves out only sites that cannot grow to it") {
    const auto seed = GENERATE(range(1u, 31u));
    CAPTURE(Dim, seed);
    RandomStream random(seed, 20 + Dim);
    const auto scene = randomScene<Dim>(random, 3);
    const float least = 1.3f;
    auto all = sitesOf(scene);
    auto some = sitesOf(scene, least);
    const auto tooSmall = [&](const auto& site) { return site.limit < least; };
    all.erase(std::remove_if(all.begin(), all.end(), tooSmall), all.end());
    some.erase(std::remove_if(some.begin(), some.end(), tooSmall), some.end());
    REQUIRE(some.size() == all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        CHECK(some[i].bodies == all[i].bodies);
        CHECK(some[i].start == all[i].start);
        CHECK(some[i].limit == all[i].limit);
    }
}

TEST_CASE("a body that covers a pivot leaves no site") {
    Surroundings<3> around;
    Scene<3> scene;
    scene.pivotRadius = 1;
    // Between two planes that a probe cannot pass.
    scene.planes = {{{{0, 0, 1}}, 1.0}, {{{0, 0, -1}}, 0.5}};
    fillWith(around, scene);
    std::vector<Surroundings<3>::Site> sites;
    around.findSites(1.0f, {3.0f, 0.0f, 4.0f}, Surroundings<3>::kAll, nullptr, sites);
    CHECK(sites.empty());
}
