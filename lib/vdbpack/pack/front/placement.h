// Puts single spheres into a front.
#pragma once

#include "vdbpack/pack/front/front.h"

#include <cstdint>

namespace vdbpack {

/// Decides in double whether a sphere is free at a position, adds it there and brings the front up
/// to date: the sites around it are limited, those on it are found.
template <int Dim>
class Placement {
public:
    /// @param front  must outlive this.
    explicit Placement(Front<Dim>& front) : front_(front) {}

    enum class Outcome {
        placed,
        blocked,     ///< by a sphere or a wall, or other sizes are requested there
        foreign,     ///< the site is left to another block
        wallLearned  ///< by a wall that the pivot now knows of
    };
    /// Tries a sphere of `radius` at a site.
    /// @param center   where it rests at the site, see FrontSites::restingCenter.
    /// @param size     what the radius was chosen for.
    /// @param lengths  of that.
    Outcome placeAtSite(std::uint32_t site, double radius, Vec<Dim> center, const LocalSize& size,
                        const FrontLengths& lengths);
    /// After a sphere was blocked at a site whose pivot did not know of all bodies around: limits
    /// the site by those in the way. @return whether that left it less room.
    bool tighten(std::uint32_t site, double radius, const Vec<Dim>& center);

    /// Places a sphere at `center` if it is free there. @return whether it was.
    /// @param beyond  how far the center may lie past the upper faces of the block, mm.
    bool placeAt(const Vec<Dim>& center, double radius, double beyond);

    /// Places a sphere ahead of the front, as near to a site as there is room: one far larger than
    /// the others would hardly ever fit between three of them.
    /// @param depth   that its surface keeps from the wall, mm.
    /// @param beyond  as in `placeAt`.
    bool setDown(std::uint32_t site, double radius, double depth, double beyond);

    /// Finds the sites on a sphere that no block placed.
    void explore(std::uint32_t sphere);

private:
    const Sphere<Dim>& sphere(std::uint32_t i) const { return front_.block.spheres[i]; }
    void add(const Sphere<Dim>& sphere);
    void learn(std::uint32_t pivot, const TangentPlane<Dim>& plane);
    bool followWalls(std::uint32_t site, double radius, Vec<Dim>& center) const;
    bool overlaps(const Vec<Dim>& center, double radius) const;
    void collect(const Vec<Dim>& center, double reach, std::uint32_t except) {
        around_.collect(front_.block.cells, center, reach, except);
    }

    Front<Dim>& front_;
    Surroundings<Dim> around_;  ///< of the candidate
    TangentPlane<Dim> wall_;    ///< nearest to the candidate
    bool hasWall_ = false;
};

}  // namespace vdbpack
