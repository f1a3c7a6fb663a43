#include "measure/packs.h"
#include "support/test.h"

#include "vdbpack/measure/pair_correlation.h"

namespace {

/// Disjoint spheres of radius `r`, thrown at random one after the other into a cube about zero: at
/// this low density nothing orders them but that they do not overlap.
template <int Dim>
std::vector<Sphere<Dim>> gas(std::size_t n, double side, double r, std::uint64_t seed) {
    RandomStream random(seed, 7);
    std::vector<Sphere<Dim>> spheres;
    const auto cells = static_cast<std::size_t>(side / (2 * r));
    std::vector<std::vector<std::size_t>> cell(
        static_cast<std::size_t>(std::pow(static_cast<double>(cells), Dim) + 0.5));
    const auto coordinate = [&](double x) {
        const double at = (x / side + 0.5) * static_cast<double>(cells);
        return std::min(cells - 1, static_cast<std::size_t>(std::max(0.0, at)));
    };
    while (spheres.size() < n) {
        Sphere<Dim> s;
        for (int d = 0; d < Dim; ++d) s.center[d] = (random.uniform() - 0.5) * side;
        s.radius = r;
        std::size_t lo[3] = {0, 0, 0}, hi[3] = {0, 0, 0}, home = 0;
        for (int d = Dim - 1; d >= 0; --d) {
            const std::size_t c = coordinate(s.center[d]);
            lo[d] = c > 0 ? c - 1 : 0;
            hi[d] = std::min(cells - 1, c + 1);
            home = home * cells + c;
        }
        bool isFree = true;
        for (std::size_t z = lo[2]; z <= hi[2]; ++z)
            for (std::size_t y = lo[1]; y <= hi[1]; ++y)
                for (std::size_t x = lo[0]; x <= hi[0]; ++x)
                    for (const std::size_t o : cell[(z * cells + y) * cells + x])
                        isFree = isFree && gap(spheres[o], s) >= 0;
        if (!isFree) continue;
        cell[home].push_back(spheres.size());
        spheres.push_back(s);
    }
    return spheres;
}

}  // namespace

DIM_TEST_CASE("a thin gas has no order beyond contact") {
    const double side = Dim == 3 ? 60 : 400, radius = 0.5, reach = 5;
    // One percent of the volume: g(r) - 1 just beyond contact is about eight times that in 3D.
    const double share = Dim == 3 ? 0.002 : 0.004;
    const auto spheres =
        gas<Dim>(static_cast<std::size_t>(share * std::pow(side, Dim) / Measure<Dim>::ball(radius)),
                 side, radius, 4);
    std::vector<float> depth;
    for (const auto& s : spheres) {
        double d = side;
        for (int i = 0; i < Dim; ++i) d = std::min(d, side / 2 - std::fabs(s.center[i]));
        depth.push_back(static_cast<float>(d));
    }
    const auto found = pairCorrelation(spheres, depth, reach, std::pow(side - 2 * reach, Dim), 10);
    REQUIRE(found);
    for (int b = 0; b < 10; ++b) {
        const double g = found->g[static_cast<std::size_t>(b)];
        CAPTURE(b, g, found->error[static_cast<std::size_t>(b)]);
        if (b < 2) {  // closer than a diameter
            CHECK(g == 0);
        } else {
            // Pairs are counted from both ends: errors are larger by up to the root of two.
            const double most = 4 * std::sqrt(2.0) * found->error[static_cast<std::size_t>(b)];
            CHECK(std::fabs(g - 1) < most + 8 * share);
        }
    }
    CHECK(found->density ==
          Approx(static_cast<double>(spheres.size()) / std::pow(side, Dim)).epsilon(0.05));
}

TEST_CASE("the pair correlation of a cubic lattice has its shells") {
    double edge = 0;
    const auto spheres = latticeSpheres(Lattice::sc, 20, edge);
    std::vector<float> depth;
    for (const auto& s : spheres) {
        double d = 40;
        for (const double x : s.center.c) d = std::min({d, x, 19 * edge - x});
        depth.push_back(static_cast<float>(d));
    }
    const double reach = 5;
    const auto found =
        pairCorrelation(spheres, depth, reach, std::pow(19 * edge - 2 * reach, 3), 50);
    REQUIRE(found);
    // 6 neighbors at 2, 12 at 2.83, 8 at 3.46, 6 at 4, 24 at 4.47, 24 at 4.90
    const auto neighborsAt = [&](double r) {
        const auto b = static_cast<std::size_t>(r / found->width);
        const double shell = Measure<3>::ball(static_cast<double>(b + 1) * found->width) -
                             Measure<3>::ball(static_cast<double>(b) * found->width);
        return found->g[b] * found->density * shell;
    };
    CHECK(neighborsAt(2.001) == Approx(6));
    CHECK(neighborsAt(2.829) == Approx(12));
    CHECK(neighborsAt(3.465) == Approx(8));
    CHECK(neighborsAt(4.001) == Approx(6));
    CHECK(neighborsAt(4.473) == Approx(24));
    CHECK(neighborsAt(3.05) == 0);
}

TEST_CASE("too few centers have no pair correlation") {
    const auto spheres = randomSpheres<3>(200, 10, 0.1, 1, 3);
    const std::vector<float> shallow(spheres.size(), 1.0f);
    CHECK_FALSE(pairCorrelation(spheres, shallow, 2.0, 100.0, 10));
    CHECK_THROWS_AS(pairCorrelation(spheres, shallow, -1.0, 100.0, 10), ParameterError);
    CHECK_THROWS_AS(pairCorrelation(spheres, {}, 1.0, 100.0, 10), ParameterError);
}
