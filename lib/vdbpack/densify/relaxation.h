// Private to densify: overlapping spheres pushed apart, all at once.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/densify/body_cells.h"
#include "vdbpack/densify/candidates.h"
#include "vdbpack/densify/octet.h"
#include "vdbpack/densify/wall_planes.h"
#include "vdbpack/domain/domain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace vdbpack {

/// How hard overlaps are pushed at.
struct RelaxationPace {
    double inertia = 0.97;  ///< share of its velocity that a sphere keeps in a step
    double cap = 0.07;      ///< largest step, in smallest radii
    int swapEvery = 3;      ///< steps between exchanges of radii; 0: none
};

/// Spheres in a domain that push one another, and are pushed by the wall, until none overlap.
///
/// v <- inertia v + 0.3 F, x <- x + v for all spheres at once, F the sum of the overlaps with
/// spheres and wall (radii larger by a small share, so that the true ones end up apart). Now and
/// then two spheres of nearly the same size, of which the larger is squeezed more, change places.
/// The same on every machine and for any number of threads.
template <int Dim>
class Relaxation {
public:
    /// @param spheres  to be relaxed; radii and centers in mm.
    /// @param fixed    the first of them that stay where they are.
    /// @param regions  of the spheres: they change places within their own only; empty: one.
    /// @param domain   must outlive this.
    /// @throws ResourceError above 2^31 spheres.
    Relaxation(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
               std::size_t fixed, const std::vector<std::int32_t>& regions, std::uint64_t seed);
    ~Relaxation();
    Relaxation(const Relaxation&) = delete;
    Relaxation& operator=(const Relaxation&) = delete;

    struct Outcome {
        bool apart = false;  ///< no two spheres overlap, none crosses the wall
        bool interrupted = false;
        int steps = 0;
        double worst = 0;  ///< largest overlap, as a share of the sum of the radii
    };
    /// Goes on for up to `steps`.
    /// @param goOn  asked before every step, with the steps done and the worst overlap; false ends
    ///              it.
    Outcome run(const RelaxationPace& pace, int steps, const Callbacks& callbacks,
                const std::function<bool(int, double)>& goOn = {});

    /// A place for each of further spheres, of some that are drawn all over that which has most
    /// room; they overlap others, and one another. Radii in mm.
    /// @param regions  of each, beside whose spheres it is put; empty: wherever.
    std::vector<Sphere<Dim>> roomiestPlaces(const std::vector<double>& radii,
                                            const std::vector<std::int32_t>& regions,
                                            std::uint64_t salt);

    /// The spheres in the order in which they were given, at their places now; whole multiples of
    /// `quantum` but for the fixed ones.
    std::vector<Sphere<Dim>> spheres() const;
    double quantum() const { return quantum_; }

private:
    static constexpr std::uint32_t kNone = 0xffffffff;
    static constexpr std::uint32_t kRun = 1024;  ///< slots that are one task

    /// Velocity, and what the last look for exchanges found; units of the quantum.
    struct alignas(16) Motion {
        float x = 0, y = 0, z = 0;
        float squeeze = 0;  ///< sum of the overlaps
    };

    /// What belongs to a place rather than to the sphere in it, and moves with the sorting.
    struct Slots {
        std::vector<Body> bodies;
        std::vector<Motion> motions;
        std::vector<Home> homes;            ///< positions when lists were made, in quanta
        std::vector<std::uint32_t> labels;  ///< which of the spheres given is here
        std::vector<typename WallPlanes<Dim>::Place> places;

        void resize(std::size_t n);
    };

    /// A run of slots with their neighbors.
    struct Run {
        std::uint32_t first = 0, last = 0;
        std::vector<std::uint32_t> ids;   ///< neighbors, filled up to whole eights with oneself
        std::vector<std::uint32_t> ends;  ///< of each slot's in `ids`
        std::vector<WallPlane> planes;    ///< walls that are near
        std::vector<std::uint32_t> planeEnds;  ///< of each slot's in `planes`
        std::vector<std::uint32_t> ranks;  ///< slots that may change places, by region and radius
        float worst = 0;                   ///< largest (r_i + r_j) (1 + delta) / d - 1
        float fastest = 0;                 ///< largest squared step, quanta²
        bool coincides = false;  ///< two of its spheres were on the same spot when lists were made
        float grown = 0;         ///< most that a radius has grown since the list was made
    };

    void sort();
    void rebuild();
    void askWalls();
    void askWall(std::size_t slot);
    void listNeighbors();
    void listRun(Run& run);
    /// All that may be neighbors of those in a row of slots.
    void collect(std::uint32_t first, std::uint32_t last, Candidates& around) const;
    void listSlot(Run& run, std::uint32_t slot, Candidates& around);
    void listPlanes(Run& run);
    bool mustRebuild();
    void part(std::uint32_t slot, std::uint32_t other);
    template <bool kSqueeze>
    void stepRun(Run& run, float inertia, float cap, Body* next);
    void swapRun(Run& run);
    /// Two of a run's ranks, the smaller sphere first, change places.
    void exchange(Run& run, std::uint32_t k, std::uint32_t l);
    /// The largest overlap of a slot's sphere with others, as `Run::worst`.
    float worstOf(const Run& run, std::uint32_t slot) const;
    void loosen(float worst);
    bool keepsWall();

    /// Calls `visit(slot)` for (at least) all whose surface is closer than `reach`.
    template <class Visit>
    void forEachNear(const Home& home, double reach, const Visit& visit) const;
    bool isFixed(std::uint32_t label) const { return label < fixed_; }
    /// Whether the spheres in two slots may change places.
    bool isAlike(std::uint32_t a, std::uint32_t b) const {
        return regions_.empty() || regions_[now_.labels[a]] == regions_[now_.labels[b]];
    }

    double quantum_;  ///< mm
    std::vector<Sphere<Dim>> given_;
    std::vector<std::int32_t> regions_;
    std::uint32_t fixed_;
    std::uint64_t seed_;
    std::uint64_t clock_ = 0;        ///< steps in all
    float least_ = 0;                ///< smallest radius of those that move, quanta
    float smallest_ = 0, most_ = 0;  ///< radii of all, quanta
    float delta_ = 0;
    float skin_ = 0;   ///< quanta
    float spent_ = 0;  ///< bound of what any sphere has moved since lists were made, quanta
    int listed_ = 0;   ///< steps since then

    Slots now_, sorted_;
    std::vector<Body> next_;
    std::vector<float> listedRadii_;
    std::vector<float> touching_;  ///< contacts of each slot when squeezes were summed
    WallPlanes<Dim> walls_;
    BodyCells cells_;
    std::vector<Run> runs_;
    bool wraps_ = false;  ///< whether far spheres may have near low bits
    bool ready_ = false;
};

template <int Dim>
template <class Visit>
void Relaxation<Dim>::forEachNear(const Home& home, double reach, const Visit& visit) const {
    for (const auto& level : cells_.levels())
        cells_.forEachRow(level, home, home, reach + static_cast<double>(level.largest),
                          [&](std::uint32_t first, std::uint32_t last) {
                              for (std::uint32_t j = first; j < last; ++j)
                                  if (isNear(home, now_.homes[j])) visit(j);
                          });
}

extern template class Relaxation<2>;
extern template class Relaxation<3>;

}  // namespace vdbpack
