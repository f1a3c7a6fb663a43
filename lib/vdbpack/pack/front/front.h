// The front of a block: spheres, the walls that they know and the sites on them.
#pragma once

#include "vdbpack/pack/front/block_state.h"
#include "vdbpack/pack/front/front_sites.h"
#include "vdbpack/pack/front/front_walls.h"

#include <cstddef>
#include <cstdint>

namespace vdbpack {

template <int Dim>
struct Front {
    BlockState<Dim> block;
    FrontWalls<Dim> walls;
    FrontSites<Dim> sites;
    std::size_t standing = 0;  ///< spheres that were there before the block

    explicit Front(const FrontSettings<Dim>& settings)
        : block{settings, {}, {}, {}, 0, {}, {}, nullptr, nullptr}, sites(block, walls) {}
    Front(const Front&) = delete;
    Front& operator=(const Front&) = delete;

    const Sphere<Dim>& sphere(std::uint32_t i) const { return block.spheres[i]; }
    /// Gap to the center of a sphere up to which bodies matter to it, mm.
    double reachOf(std::uint32_t i) const { return sphere(i).radius + sites.reach(i); }

    void clear() {
        block.spheres.clear();
        block.leastMeans.clear();
        walls.clear();
        sites.clear();
    }
    /// Adds a sphere that `block.cells` finds. @return its index.
    std::uint32_t add(const Sphere<Dim>& sphere) {
        block.cells.add(sphere, static_cast<std::uint32_t>(block.spheres.size()));
        return append(sphere, true);
    }
    /// Adds a sphere for the sites that refer to it alone: not to the cells.
    std::uint32_t addHidden(const Sphere<Dim>& sphere) { return append(sphere, false); }

private:
    std::uint32_t append(const Sphere<Dim>& sphere, bool isPivot) {
        block.spheres.push_back(sphere);
        walls.addSphere();
        if (block.local) {
            FrontLengths lengths = block.settings;
            double leastMean = lengths.meanRadius;
            if (isPivot)
                lengths =
                    block.local->ofPivot(sphere.center + block.origin, sphere.radius, leastMean);
            sites.addSphere(lengths);
            block.leastMeans.push_back(leastMean);
        } else {
            sites.addSphere();
        }
        return static_cast<std::uint32_t>(block.spheres.size() - 1);
    }
};

}  // namespace vdbpack
