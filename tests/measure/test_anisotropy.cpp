// What tells where a front began: stiffness by direction, and the center of mass.
#include "measure/packs.h"
#include "support/test.h"
#include "support/thread_ranks.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/mass_offset.h"
#include "vdbpack/measure/stiffness.h"

#include <mutex>

namespace {

/// The stiffness of springs along directions.
template <int Dim>
Matrix<Dim*(Dim + 1) / 2> stiffnessOf(const std::vector<Vec<Dim>>& directions) {
    Matrix<Dim*(Dim + 1) / 2> sum{};
    for (const auto& n : directions) {
        const auto m = mandelDyad(n);
        for (std::size_t p = 0; p < sum.size(); ++p) sum[p] += m * m.c[p];
    }
    return sum;
}

template <int Dim>
std::vector<Vec<Dim>> randomDirections(std::size_t n, std::uint64_t seed) {
    RandomStream random(seed, 3);
    std::vector<Vec<Dim>> directions;
    while (directions.size() < n) {
        Vec<Dim> x;
        for (int d = 0; d < Dim; ++d) x[d] = 2 * random.uniform() - 1;
        const double l = length(x);
        if (l > 0.1 && l < 1) directions.push_back(x * (1 / l));
    }
    return directions;
}

Vec<3> turned(const Vec<3>& x, const Vec<3>& axis, double angle) {
    return x * std::cos(angle) + cross(axis, x) * std::sin(angle) +
           axis * (dot(axis, x) * (1 - std::cos(angle)));
}

/// Touching spheres on a lattice that has all its faces.
std::vector<Sphere<3>> wholeLattice(Lattice lattice, int cells) {
    double edge = 0;
    auto spheres = latticeSpheres(lattice, cells + 1, edge);
    const double last = (cells + 0.1) * edge;
    const auto isBeyond = [&](const Sphere<3>& s) {
        return *std::max_element(s.center.c.begin(), s.center.c.end()) > last;
    };
    spheres.erase(std::remove_if(spheres.begin(), spheres.end(), isBeyond), spheres.end());
    return spheres;
}

}  // namespace

TEST_CASE("a face-centered lattice is 1.8 times as stiff along its diagonal") {
    // C11 : C12 : C44 = 2 : 1 : 1, so that S11 = 3/4, S12 = -1/4 and S44 = 1: E along <100> is 4/3,
    // and along <111> 1 / (S11 - 2/3 (S11 - S12 - S44/2)) = 12/5; with C44 = 1 that is 1.8 times.
    const double expected = (1 / (0.75 - 2.0 / 3 * (0.75 + 0.25 - 0.5))) / (1 / 0.75);
    auto spheres = wholeLattice(Lattice::fcc, 6);
    const auto angle = GENERATE(0.0, 0.3, 1.1, 2.0);
    const auto axis = normalized(Vec<3>{{1, angle, -0.4}});
    for (auto& s : spheres) s.center = turned(s.center, axis, angle);
    const auto check = countContacts(spheres, 1e-3);
    CHECK(check.deepContacts == 2 * check.pairs);
    CHECK(check.modulusRatio == Approx(expected).epsilon(1e-5));
    double off = 1;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            off = std::min(off, length(cross(check.stiffest,
                                             turned(normalized(Vec<3>{{x, y, 1}}), axis, angle))));
    CHECK(off < 1e-3);
}

TEST_CASE("lattices that a shear meets no resistance in have no modulus ratio") {
    for (const auto lattice : {Lattice::sc, Lattice::bcc}) {
        const auto check = countContacts(wholeLattice(lattice, 6), 1e-3);
        CHECK(check.deepContacts > 1000);
        CHECK(check.modulusRatio == 0);
    }
    CHECK(countContacts(wholeLattice(Lattice::fcc, 1), 1e-3).modulusRatio == 0);  // too few
}

TEST_CASE("a triangular lattice of the plane is isotropic, one with a spring less is not") {
    std::vector<Vec<2>> directions{{{1, 0}}, {{0.5, std::sqrt(0.75)}}, {{-0.5, std::sqrt(0.75)}}};
    CHECK(modulusRatio<2>(stiffnessOf(directions))->ratio == Approx(1).epsilon(1e-9));
    directions.push_back({{0, 1}});
    const auto more = modulusRatio<2>(stiffnessOf(directions));
    // C11 = 9/8, C12 = 3/8, C22 = 17/8, C66 = 3/8: E along y / E along x = C22 / C11.
    REQUIRE(more);
    CHECK(more->ratio >= 17.0 / 9 * (1 - 1e-9));
    directions.resize(2);
    CHECK_FALSE(modulusRatio<2>(stiffnessOf(directions)));
}

DIM_TEST_CASE("random directions are isotropic but for chance, and squeezed ones are not") {
    auto directions = randomDirections<Dim>(400'000, 4);
    CHECK(modulusRatio<Dim>(stiffnessOf(directions))->ratio < 1.02);
    for (auto& n : directions) {
        n[0] *= 1.3;
        n = normalized(n);
    }
    const auto along = modulusRatio<Dim>(stiffnessOf(directions));
    CHECK(along->ratio > 1.3);
    CHECK(along->direction[0] > 0.99);
}

TEST_CASE("contacts of spheres deeper than three of their radii count for the stiffness") {
    const auto spheres = wholeLattice(Lattice::fcc, 6);
    std::vector<float> depth(spheres.size(), 3.01f);
    CHECK(countContacts(spheres, 1e-3, depth).deepContacts ==
          countContacts(spheres, 1e-3).deepContacts);
    depth[40] = 2.99f;
    const auto less = countContacts(spheres, 1e-3, depth);
    CHECK(less.deepContacts ==
          2 * less.pairs - static_cast<std::uint64_t>(countContacts(spheres, 1e-3).counts[40]));
}

DIM_TEST_CASE("the center of mass is that of the spheres, for any number of threads and ranks") {
    RandomStream random(8, Dim);
    Box<Dim> box{{}, Box<Dim>::filled(20)};
    box.hi[0] = 40;
    std::vector<Sphere<Dim>> spheres(5000);
    Vec<Dim> moment;
    double mass = 0;
    for (auto& s : spheres) {
        for (int d = 0; d < Dim; ++d) s.center[d] = box.hi[d] * std::pow(random.uniform(), 1.2);
        s.radius = 0.05 + 0.2 * random.uniform();
        moment += s.center * std::pow(s.radius, Dim);
        mass += std::pow(s.radius, Dim);
    }
    const Vec<Dim> expected = moment * (1 / mass) - box.center();
    const auto domain = boxDomain<Dim>(box);
    const auto offset = withThreads(1, [&] { return massOffset(spheres, *domain); });
    REQUIRE(offset);
    for (int d = 0; d < Dim; ++d)
        CHECK(*offset->axes[static_cast<std::size_t>(d)] == Approx(expected[d]).epsilon(1e-9));
    CHECK(offset->axes[2].has_value() == (Dim == 3));
    CHECK(offset->length == Approx(length(expected)).epsilon(1e-9));
    CHECK(offset->share == Approx(length(expected) / 40).epsilon(1e-9));
    CHECK(withThreads(8, [&] { return massOffset(spheres, *domain); })->axes == offset->axes);
    RankOffice office(3);
    std::mutex checking;
    onRanks(office, [&](Ranks& ranks) {
        std::vector<Sphere<Dim>> own;
        for (std::size_t i = 0; i < spheres.size(); ++i)
            if (static_cast<int>(i % 7) % 3 == ranks.rank()) own.push_back(spheres[i]);
        const auto shared = massOffset(own, *domain, &ranks);
        const std::lock_guard<std::mutex> lock(checking);
        CHECK(shared->axes == offset->axes);
    });
    PeriodicCell<Dim> cell{box, {}};
    cell.wraps[0] = true;
    const auto partly = massOffset(spheres, *periodicDomain<Dim>(cell));
    CHECK_FALSE(partly->axes[0]);
    CHECK(partly->axes[1] == offset->axes[1]);
    cell.wraps.fill(true);
    CHECK_FALSE(massOffset(spheres, *periodicDomain<Dim>(cell)));
    CHECK_FALSE(massOffset(std::vector<Sphere<Dim>>{}, *domain));
}
