// Packs of a front to densify, and what must hold of them after that.
#pragma once

#include "support/sizes.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/verify.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace vdbpack::test {

/// As dense as can be.
constexpr double kMax = std::numeric_limits<double>::infinity();

template <int Dim>
std::shared_ptr<const Domain<Dim>> box(double side, const Vec<Dim>& center = {}) {
    return boxDomain<Dim>(
        {center + Box<Dim>::filled(-side / 2), center + Box<Dim>::filled(side / 2)});
}

inline SizeDistribution sizesOf(const std::string& spec, int dim) {
    return SizeDistribution::parse(spec, dim);
}

template <int Dim>
std::vector<Sphere<Dim>> front(const Domain<Dim>& domain, const std::string& spec) {
    return packSpheres(domain, PackOptions(sizesOf(spec, Dim))).pack.spheres;
}

template <int Dim>
DensifyOptions to(double fraction, const std::string& spec) {
    DensifyOptions options;
    options.fraction = fraction;
    if (!spec.empty()) options.sizes = sizesOf(spec, Dim);
    return options;
}

/// How far spheres protrude from a shape whose own distances are exact, mm.
template <int Dim>
double protrusion(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain) {
    const auto sampler = domain.sampler();
    double most = 0;
    for (const auto& s : spheres)
        most = std::max(most, s.radius + sampler->signedDistance(s.center));
    return most;
}

template <int Dim>
void checkSound(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain) {
    CHECK(checkOverlap(spheres).max == 0);
    CHECK(protrusion(spheres, domain) <= 0);
}

/// The radii that were given are all there, to the last bit.
template <int Dim>
void checkRadii(const std::vector<Sphere<Dim>>& before, const std::vector<Sphere<Dim>>& after) {
    auto given = radiiOf(before), all = radiiOf(after);
    std::sort(given.begin(), given.end());
    std::sort(all.begin(), all.end());
    CHECK(std::includes(all.begin(), all.end(), given.begin(), given.end()));
}

template <int Dim>
std::vector<Sphere<Dim>> shaken(std::vector<Sphere<Dim>> spheres, double by) {
    RandomStream random(5, 6);
    for (auto& s : spheres)
        for (int d = 0; d < Dim; ++d) s.center[d] += by * (2 * random.uniform() - 1);
    return spheres;
}

}  // namespace vdbpack::test
