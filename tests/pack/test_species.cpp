#include "support/test.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/verify.h"

namespace {

template <int Dim>
std::shared_ptr<const Domain<Dim>> ball() {
    return ballDomain<Dim>(Dim == 3 ? 32 : 150);
}

/// Radii 1 to 2, and with `probability` ones of 3 to 5.
template <int Dim>
PackOptions twoSpecies(double probability, double depth = 0) {
    PackOptions options(SizeDistribution::parse("uniform:1,2", Dim));
    options.species.push_back({SizeDistribution::parse("uniform:3,5", Dim), probability, depth});
    return options;
}

template <int Dim>
std::size_t countOf(const PackResult<Dim>& result, std::uint8_t species) {
    return static_cast<std::size_t>(
        std::count(result.species.begin(), result.species.end(), species));
}

}  // namespace

DIM_TEST_CASE("two species fill a domain without overlap, each of its own radii") {
    const auto seed = GENERATE(1u, 2u, 3u);
    CAPTURE(Dim, seed);
    auto options = twoSpecies<Dim>(0.02);
    options.seed = seed;
    const auto domain = ball<Dim>();
    const auto result = packSpheres(*domain, options);
    const auto& spheres = result.pack.spheres;
    REQUIRE(result.species.size() == spheres.size());
    REQUIRE(checkOverlap(spheres).pairs == 0);
    const auto sampler = domain->sampler();
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        REQUIRE(-sampler->signedDistance(spheres[i].center) >= spheres[i].radius);
        REQUIRE((spheres[i].radius > 2.5) == (result.species[i] == 1));
    }
}

DIM_TEST_CASE("as many spheres are of a species as its probability says") {
    const double probability = GENERATE(0.005, 0.02);
    const auto domain =
        boxDomain<Dim>({Box<Dim>::filled(0), Box<Dim>::filled(Dim == 3 ? 100 : 600)});
    const auto result = packSpheres(*domain, twoSpecies<Dim>(probability));
    const auto further = static_cast<double>(countOf(result, 1));
    const double expected = probability * static_cast<double>(result.pack.spheres.size());
    CAPTURE(Dim, further, expected);
    // Three deviations, and the share near the walls that finds no room.
    REQUIRE(std::fabs(further - expected) < 3 * std::sqrt(expected) + 0.07 * expected);
    double mean = 0;
    for (std::size_t i = 0; i < result.species.size(); ++i)
        if (result.species[i] == 1) mean += result.pack.spheres[i].radius / further;
    REQUIRE(std::fabs(mean - 4) < 0.05);
}

DIM_TEST_CASE("a species keeps its depth below the wall") {
    const double depth = 7;
    const auto domain = ball<Dim>();
    const auto result = packSpheres(*domain, twoSpecies<Dim>(0.05, depth));
    REQUIRE(countOf(result, 1) > 10);
    const auto sampler = domain->sampler();
    for (std::size_t i = 0; i < result.species.size(); ++i) {
        const auto& s = result.pack.spheres[i];
        if (result.species[i] == 1) REQUIRE(-sampler->signedDistance(s.center) - s.radius >= depth);
    }
}

DIM_TEST_CASE("a pack of species is the same for any number of threads") {
    auto options = twoSpecies<Dim>(0.03, 2);
    options.blockSide = 16;
    const auto domain = ball<Dim>();
    options.threads = 1;
    const auto one = packSpheres(*domain, options);
    for (const int threads : {2, 3, 8}) {
        options.threads = threads;
        const auto other = packSpheres(*domain, options);
        REQUIRE(one.pack.spheres == other.pack.spheres);
        REQUIRE(one.species == other.species);
    }
}

TEST_CASE("a species leaves out no layer at the faces of blocks") {
    const auto domain = boxDomain<3>({Box<3>::filled(0), Box<3>::filled(80)});
    // Two blocks along each axis.
    std::array<double, 20> layers{};
    double inner = 0;
    for (const unsigned seed : {1u, 2u, 3u, 4u}) {
        auto options = twoSpecies<3>(0.02);
        options.seed = seed;
        const auto result = packSpheres(*domain, options);
        REQUIRE(result.blocks == 8);
        for (std::size_t i = 0; i < result.species.size(); ++i) {
            if (result.species[i] == 0) continue;
            for (const double x : result.pack.spheres[i].center.c) {
                layers[static_cast<std::size_t>(x / 4)] += 1;
                if (x > 8 && x < 72) inner += 1.0 / 16;
            }
        }
    }
    CAPTURE(layers);
    for (std::size_t k = 2; k < 18; ++k) REQUIRE(std::fabs(layers[k] / inner - 1) < 0.5);
    // Nor does one pile up where the front ends.
    REQUIRE(layers[18] + layers[19] < 2.2 * (layers[0] + layers[1]));
}

TEST_CASE("a species that is never drawn leaves the pack as it is") {
    PackOptions plain(SizeDistribution::parse("uniform:1,2", 3));
    const auto domain = ball<3>();
    auto options = twoSpecies<3>(0);
    // No larger than the first one: the blocks are laid out alike.
    options.species[0].sizes = SizeDistribution::parse("uniform:1,2", 3);
    REQUIRE(packSpheres(*domain, options).pack.spheres == packSpheres(*domain, plain).pack.spheres);
}

TEST_CASE("probabilities of species that are none are refused") {
    const auto domain = ball<3>();
    for (const double p : {-0.1, 1.0, 1.5, std::nan("")})
        REQUIRE_THROWS_WITH(packSpheres(*domain, twoSpecies<3>(p)), Contains("probability"));
    auto two = twoSpecies<3>(0.6);
    two.species.push_back(two.species.front());
    REQUIRE_THROWS_AS(packSpheres(*domain, two), ParameterError);
}
