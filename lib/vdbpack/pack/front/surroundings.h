// The bodies around a pivot, and the sites on it.
#pragma once

#include "vdbpack/pack/front/cap.h"
#include "vdbpack/pack/front/cell_list.h"
#include "vdbpack/pack/front/track.h"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace vdbpack {

/// The bodies around one pivot: spheres as a cell list finds them, and wall planes.
///
/// Computes in float, eight bodies at a time: results carry errors of about 1e-5 of the radii, and
/// the caller decides in double. Source: a sphere on the pivot touches Dim - 1 more bodies where
/// the edges of their caps meet on the sphere of directions; the largest sphere there is a vertex
/// of the additively weighted Voronoi (Apollonius) diagram.
template <int Dim>
class Surroundings {
public:
    /// Where a sphere touches the pivot and Dim - 1 bodies.
    struct Site {
        std::array<float, Dim> start;  ///< center at the probe's radius, relative to the pivot
        std::array<float, Dim> end;    ///< the same at radius `limit`
        Track<float, Dim> track;       ///< from the probe's radius on
        float limit;                   ///< largest radius that fits, mm
        float side;                    ///< +1 or -1, see Track::set
        std::array<std::uint32_t, Dim - 1>
            bodies;  ///< their indices in the front, see `collect` and `addWall`
    };

    /// Replaces the bodies by the spheres of `cells` whose gap to the point `x` is smaller than
    /// `reach` (mm), without sphere `except`: the pivot, whose center `x` is.
    void collect(const CellList<Dim>& cells, const Vec<Dim>& x, double reach,
                 std::uint32_t except) {
        walls_.clear();
        cells.collect(x, reach, except, spheres);
    }
    /// As collected, followed by the walls that were added.
    typename CellList<Dim>::Around spheres;

    /// Adds a wall with unit normal into the domain, `above` which the pivot's center lies (mm).
    void addWall(const std::array<float, Dim>& normal, float above, std::uint32_t index);

    /// Where sites are wanted, relative to the pivot.
    struct Region {
        std::array<float, Dim> lo, hi;
    };
    /// For what radii sites are wanted, mm.
    struct Radii {
        float probe;    ///< sites are those of a sphere of this radius
        float least;    ///< sites where this one does not fit may be left out
        float largest;  ///< growth ends here
    };
    /// All sites on the pivot for a sphere of the probe's radius, in a fixed order.
    /// @param only    keeps the sites that touch this body; kAll: all.
    /// @param region  keeps the sites that start within; null: all.
    /// @param sites   is overwritten.
    void findSites(float pivotRadius, const Radii& radii, std::uint32_t only, const Region* region,
                   std::vector<Site>& sites);
    static constexpr std::uint32_t kAll = 0xffffffffu;

    /// Bodies that a sphere of the probe's radius on the pivot can reach; after `findSites`.
    std::size_t reached() const { return near_.count; }
    /// The growth, at most `most`, at which a sphere on `track` hits one of the bodies; after
    /// `findSites` with the radii that the track starts from.
    float growth(const Track<float, Dim>& track, float most) const;

    /// How many spheres a sphere at `x` (relative to the pivot) touches, those at a gap of up to
    /// `range` by less: the sum of (1 - gap / range)²; after `findSites`. mm.
    float crowdAt(const std::array<float, Dim>& x, float radius, float range) const;

private:
    /// Caps as padded arrays.
    struct Caps {
        std::array<std::vector<float>, Dim> to;
        std::vector<float> level;  ///< at the probe's radius
        std::vector<float> slope;
        std::vector<float> square;         ///< |to|²
        std::vector<float> open;           ///< gap between the body and the pivot's center
        std::vector<std::uint32_t> index;  ///< in `spheres`
        std::size_t count = 0;

        void resize(std::size_t n);
        void pad();
    };
    bool sortByReach(float pivotRadius, float probe);
    void findPairs(float rolling, std::uint32_t only);
    Track<Float8, Dim> tracksFrom(std::size_t firstPair, float rolling) const;
    Site siteOf(const std::array<std::uint32_t, 2>& pair, const Track<float, Dim>& track,
                float sign, const Radii& radii);
    float growth(const Caps& caps, const Track<float, Dim>& track, float most) const;

    float tolerance_ = 0;   ///< growth that counts as none, mm
    float pivotReach_ = 0;  ///< pivot radius and twice the probe's, mm
    std::vector<std::pair<std::size_t, Cap<float, Dim>>> walls_;  ///< position in `spheres`, cap
    Caps near_, far_;  ///< in reach of the probe, and of larger spheres only
    std::array<std::vector<std::uint32_t>, 2> pairs_;  ///< of `near_`; 2D: one body, twice
    std::size_t pairCount_ = 0;
};

}  // namespace vdbpack
