// The front of a pack by default, with waves: its contacts gather around no direction.
#include "support/cube.h"
#include "support/test.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/verify.h"

#include <optional>

namespace {

template <int Dim>
std::vector<Sphere<Dim>> packed(const Domain<Dim>& domain, std::uint64_t seed = 1,
                                std::optional<Order> order = {}) {
    PackOptions options(SizeDistribution::parse("uniform:1,2", Dim));
    if (order) options.order = *order;
    options.seed = seed;
    options.threads = 2;
    return packSpheres(domain, options).pack.spheres;
}

/// Largest share of the contacts' fabric along any of many directions.
template <int Dim>
double largestShare(const std::vector<Sphere<Dim>>& spheres) {
    const auto fabric = countContacts(spheres, 1e-3).fabric;
    double largest = 0;
    for (int k = 0; k < 400; ++k) {
        const double turn = 2.399963 * k, z = Dim == 3 ? 1 - (k + 0.5) / 200 : 0;
        const double flat = std::sqrt(1 - z * z);
        const double n[3] = {flat * std::cos(turn), flat * std::sin(turn), z};
        double share = 0;
        for (std::size_t i = 0; i < Dim; ++i)
            for (std::size_t j = 0; j < Dim; ++j) share += fabric[i].c[j] * n[i] * n[j];
        largest = std::max(largest, share);
    }
    return largest;
}

}  // namespace

DIM_TEST_CASE("contacts of a default pack gather around no direction") {
    constexpr double kIsotropic = 1.0 / Dim;
    const double side = Dim == 3 ? 64 : 300;
    const auto domain = boxDomain<Dim>(cube<Dim>(side));
    const auto level = packed<Dim>(*domain, 1, Order::sweep);
    CHECK(largestShare<Dim>(level) > kIsotropic + 0.07);
    CHECK(countContacts(level, 1e-3).modulusRatio > 1.5);
    std::vector<std::vector<Sphere<Dim>>> packs;
    for (const std::uint64_t seed : {1, 2}) {
        packs.push_back(packed<Dim>(*domain, seed));
        CHECK(largestShare<Dim>(packs.back()) < kIsotropic + (Dim == 3 ? 0.012 : 0.03));
        const auto network = countContacts(packs.back(), 1e-3);
        CHECK(network.meanOfSpheres > (Dim == 3 ? 5.6 : 3.9));
        CHECK(network.modulusRatio < (Dim == 3 ? 1.12 : 1.35));
        CHECK(solidFraction(packs.back(), *domain) > solidFraction(level, *domain) - 0.006);
        CHECK(checkOverlap(packs.back()).max == 0);
    }
    CHECK(packs[0] != packs[1]);
}

DIM_TEST_CASE("waves move with the domain") {
    Box<Dim> box = cube<Dim>(40);
    const auto here = packed<Dim>(*boxDomain<Dim>(box));
    const auto by = Box<Dim>::filled(1024);
    box.lo += by, box.hi += by;
    auto there = packed<Dim>(*boxDomain<Dim>(box));
    for (Sphere<Dim>& s : there) s.center -= by;
    CHECK(here == there);
}

TEST_CASE("nearly equal spheres are swept without waves") {
    const auto domain = ballDomain<3>(12);
    PackOptions options(SizeDistribution::parse("uniform:0.9,1.1", 3));
    const auto usual = packSpheres(*domain, options).pack.spheres;
    options.order = Order::sweep;
    CHECK(packSpheres(*domain, options).pack.spheres == usual);
}
