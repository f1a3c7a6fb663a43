// The spheres of a block, and the sites on them that later blocks take over.
#pragma once

#include "vdbpack/core/sphere.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// The bit of the neighbor block at `offset`, each -1, 0 or 1.
template <std::size_t Dim>
std::uint32_t neighborBit(const std::array<int, Dim>& offset) {
    unsigned n = 0;
    for (const int o : offset) n = 3 * n + static_cast<unsigned>(o + 1);
    return std::uint32_t{1} << n;
}

/// A site of one block's front that lies in a later block, which continues from there.
template <int Dim>
struct HandedSite {
    /// What a sphere at the site touches beside the pivot.
    struct Support {
        enum class Kind { sphere, wall, none } kind;
        Vec<Dim> at;      ///< center; of a wall, the point touched, mm
        Vec<Dim> normal;  ///< of a wall, into the domain
        double radius;    ///< of a sphere, mm
    };
    std::array<Support, Dim - 1> supports;
    Vec<Dim> center;         ///< at radius `limit`, mm
    float limit;             ///< largest radius that fits, as far as the block knew, mm
    float side;              ///< see Track::side
    std::uint32_t pivot;     ///< index in BlockSpheres::spheres
    std::uint32_t neighbor;  ///< in which it lies; see neighborBit

    HandedSite movedBy(const Vec<Dim>& shift) const {
        HandedSite site = *this;
        for (Support& support : site.supports) support.at += shift;
        site.center += shift;
        return site;
    }
};

/// Spheres of a block, or around one.
template <int Dim>
struct BlockSpheres {
    std::vector<Sphere<Dim>> spheres;
    /// Sites on them that lie in other blocks, by rising pivot.
    std::vector<HandedSite<Dim>> sites;
    /// Indices of spheres that no block placed and others may touch, rising: their sites are yet
    /// to be found.
    std::vector<std::uint32_t> unexplored;
    /// Species of each sphere, see PackOptions::species; empty where there is one.
    std::vector<std::uint8_t> species;

    void clear() {
        spheres.clear();
        sites.clear();
        unexplored.clear();
        species.clear();
    }
};

}  // namespace vdbpack
