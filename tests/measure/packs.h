// Packs with known answers.
#pragma once

#include "vdbpack/core/rng.h"
#include "vdbpack/core/sphere.h"

#include <array>
#include <cmath>
#include <vector>

namespace vdbpack::test {

/// Spheres at random in a cube of side `side` about the origin, radii log-uniform in
/// [smallest, smallest * ratio]; they overlap as it comes.
template <int Dim>
std::vector<Sphere<Dim>> randomSpheres(std::size_t n, double side, double smallest, double ratio,
                                       std::uint64_t seed) {
    RandomStream random(seed, 1);
    std::vector<Sphere<Dim>> spheres(n);
    for (auto& s : spheres) {
        for (int i = 0; i < Dim; ++i) s.center[i] = (random.uniform() - 0.5) * side;
        s.radius = smallest * std::pow(ratio, random.uniform());
    }
    return spheres;
}

enum class Lattice { sc, bcc, fcc };

/// Touching spheres of radius 1 on a lattice that fills a cube of `cells` unit cells a side, its
/// corner at the origin. `edge` is set to the edge of a unit cell, mm.
inline std::vector<Sphere<3>> latticeSpheres(Lattice lattice, int cells, double& edge) {
    std::vector<Vec<3>> basis{{{0, 0, 0}}};
    edge = 2;
    if (lattice == Lattice::bcc) {
        basis.push_back({{0.5, 0.5, 0.5}});
        edge = 4 / std::sqrt(3.0);
    } else if (lattice == Lattice::fcc) {
        basis.insert(basis.end(), {{{0.5, 0.5, 0}}, {{0.5, 0, 0.5}}, {{0, 0.5, 0.5}}});
        edge = 2 * std::sqrt(2.0);
    }
    std::vector<Sphere<3>> spheres;
    for (int z = 0; z < cells; ++z)
        for (int y = 0; y < cells; ++y)
            for (int x = 0; x < cells; ++x)
                for (const auto& b : basis)
                    spheres.push_back({(b + Vec<3>{{static_cast<double>(x), static_cast<double>(y),
                                                    static_cast<double>(z)}}) *
                                           edge,
                                       1});
    return spheres;
}

/// Disjoint spheres with radii 0.6 to 1 on a square or cubic lattice of pitch 2, `n` a side, the
/// first one at (1, 1, 1).
template <int Dim>
std::vector<Sphere<Dim>> disjointSpheres(int n, std::uint64_t seed) {
    RandomStream random(seed, 2);
    std::vector<Sphere<Dim>> spheres;
    for (int z = 0; z < (Dim == 3 ? n : 1); ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                const std::array<int, 3> at{x, y, z};
                Sphere<Dim> s;
                for (int i = 0; i < Dim; ++i) s.center[i] = 2 * at[static_cast<std::size_t>(i)] + 1;
                s.radius = 0.6 + 0.4 * random.uniform();
                spheres.push_back(s);
            }
    return spheres;
}

}  // namespace vdbpack::test
