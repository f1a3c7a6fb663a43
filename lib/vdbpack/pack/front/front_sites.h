// The sites of a block's front, and the order in which they come up.
#pragma once

#include "vdbpack/pack/front/block_spheres.h"
#include "vdbpack/pack/front/block_state.h"
#include "vdbpack/pack/front/bucket_queue.h"
#include "vdbpack/pack/front/front_walls.h"
#include "vdbpack/pack/front/surroundings.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// To floats and back, for what is stored relative to a block.
template <int Dim>
std::array<float, Dim> toFloat(const Vec<Dim>& v) {
    std::array<float, Dim> f;
    for (std::size_t d = 0; d < Dim; ++d) f[d] = static_cast<float>(v.c[d]);
    return f;
}
template <int Dim>
Vec<Dim> fromFloat(const std::array<float, static_cast<std::size_t>(Dim)>& f) {
    Vec<Dim> v;
    for (std::size_t d = 0; d < Dim; ++d) v.c[d] = static_cast<double>(f[d]);
    return v;
}

/// Sites where a sphere could touch a pivot and Dim - 1 more bodies, in a queue: by their position
/// along the sweep, those that a further body limits ahead of it. Bodies are spheres of the block,
/// or walls from `kWallBody` on.
template <int Dim>
class FrontSites {
public:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    /// Body indices at and above this are walls (kWallBody + index in FrontWalls).
    static constexpr std::uint32_t kWallBody = 0x40000000u;
    /// In place of a body where a sphere touches the pivot alone.
    static constexpr std::uint32_t kNoBody = 0x7fffffffu;
    using Bodies = std::array<std::uint32_t, Dim - 1>;

    /// @param block, walls  of the block, with its settings; must outlive this.
    FrontSites(const BlockState<Dim>& block, FrontWalls<Dim>& walls);

    /// Empties the front for the block as it is set up.
    void clear();
    /// The next sphere, which has no sites yet.
    void addSphere() { first_.push_back(kNone); }
    /// The same where sizes differ by place.
    void addSphere(const FrontLengths& lengths) {
        addSphere();
        radii_.emplace_back(lengths);
    }

    /// Finds and adds the sites on a pivot: all, or those that touch body `only`.
    /// @param around      the spheres around the pivot, as collected.
    /// @param inOwnBlock  leaves out sites that lie in other blocks.
    void find(std::uint32_t pivot, std::uint32_t only, Surroundings<Dim>& around, bool inOwnBlock);
    /// Adds a site. @return its index, or kNone if no sphere fits there or its block is done.
    /// @param around  the spheres around the pivot; null: those near the site are yet to be
    /// counted.
    std::uint32_t add(std::uint32_t pivot, const typename Surroundings<Dim>::Site& site,
                      const Surroundings<Dim>* around = nullptr);
    /// Counts a sphere that was there before the site.
    void countNear(std::uint32_t index, std::uint32_t sphere);
    /// How far from a site, beside its limit, spheres are counted, mm.
    float nearGap(std::uint32_t pivot) const { return radiiOf(pivot).nearGap; }

    /// Limits the sites that a new sphere reaches into. @param around  the spheres around it.
    void keepOff(std::uint32_t intruder, const Surroundings<Dim>& around);
    /// Limits the sites on a pivot by a wall that it did not know of.
    void keepOffWall(std::uint32_t pivot, std::uint32_t wall);
    /// Limits one site by a sphere, if that reaches into it.
    void keepOff(std::uint32_t index, std::uint32_t intruder);

    /// Takes the next site from the queue. @return kNone if there is none.
    std::uint32_t pop() { return queue_.pop(); }
    void enqueue(std::uint32_t index);
    /// A sphere was placed there: once its pivot's neighbor is placed the index is used again.
    void remove(std::uint32_t index) { ends_[index].dead = true; }
    /// Leaves a site that turned out to lie at `center`, outside the block, to its block.
    void leave(std::uint32_t index, const Vec<Dim>& center);
    /// The later neighbor (`neighborBit`) that has a site before this one in the order of the front
    /// where a sphere would reach into the one here; 0: none has.
    /// @param around  the spheres around `center`, where a sphere of `radius` would be placed.
    std::uint32_t precededIn(std::uint32_t index, const Vec<Dim>& center, double radius,
                             const Surroundings<Dim>& around) const;
    /// Leaves a site to a later neighbor.
    void leaveTo(std::uint32_t index, std::uint32_t neighbor) {
        queue_.remove(index);
        sites_[index].foreign = neighbor;
    }
    /// Leaves a site alone; a block whose search reaches back to it may have a radius for it.
    void giveUp(std::uint32_t index);

    std::uint32_t pivot(std::uint32_t index) const { return sites_[index].pivot; }
    const Bodies& bodies(std::uint32_t index) const { return sites_[index].bodies; }
    float side(std::uint32_t index) const { return sites_[index].side; }
    bool isRemoved(std::uint32_t index) const { return ends_[index].dead; }
    /// Whether no further body limits the growth there.
    bool isOpen(std::uint32_t index) const {
        return !(ends_[index].limit < kOpen * radiiOf(sites_[index].pivot).largest);
    }
    /// The wall that a sphere touches there; null if it touches none.
    const TangentPlane<Dim>* wall(std::uint32_t index) const;
    /// Largest radius that fits, as far as is known, mm.
    float limit(std::uint32_t index) const { return ends_[index].limit; }
    /// The center at that radius.
    Vec<Dim> center(std::uint32_t index) const { return fromFloat<Dim>(ends_[index].center); }
    /// Where a sphere rests at a site, in double. @return false if nowhere.
    bool restingCenter(std::uint32_t index, double radius, Vec<Dim>& center) const;

    /// Calls `visit(index, neighbor)` for the sites on a pivot that are left to later blocks.
    template <class Visit>
    void forEachForeign(std::uint32_t pivot, const Visit& visit) const {
        for (std::uint32_t s = first_[pivot]; s != kNone; s = ends_[s].next)
            if (!ends_[s].dead && sites_[s].foreign != 0) visit(s, sites_[s].foreign);
    }
    /// The cap of a body beside a pivot.
    Cap<float, Dim> cap(std::uint32_t pivot, std::uint32_t body) const;
    float probe(std::uint32_t pivot) const { return radiiOf(pivot).probe; }
    /// FrontLengths::reach at a sphere, mm.
    double reach(std::uint32_t pivot) const { return radiiOf(pivot).reach; }

private:
    struct Site {
        Track<float, Dim> track;  ///< from the probe's radius on, relative to the pivot
        float base;               ///< FrontOrder::position at the probe's radius
        float slope;              ///< FrontOrder::slope
        float crowd;              ///< bodies near, see FrontSettings::crowdLead
        float side;
        Bodies bodies;
        std::uint32_t pivot;
        std::uint32_t foreign;  ///< the neighbor block it lies in if that comes later, else 0
    };
    /// What every new sphere asks of the sites around it: apart, since that is half the memory
    /// that a placement touches.
    struct End {
        std::array<float, Dim> center;  ///< at radius `limit`
        float limit;                    ///< largest radius that fits, as far as is known
        std::uint32_t next;             ///< of the same pivot
        bool dead = false;
    };
    /// FrontLengths for the sites on a pivot, mm.
    struct PivotRadii {
        float probe, least, largest, common, crowdLead, nearGap;
        double lead, wallLead, seamLead, reach;
        explicit PivotRadii(const FrontLengths& lengths);
    };
    /// Where sizes differ by place, each sphere has its own.
    const PivotRadii& radiiOf(std::uint32_t pivot) const {
        return radii_[block_.local ? pivot : 0];
    }
    const Sphere<Dim>& sphere(std::uint32_t i) const { return block_.spheres[i]; }
    template <class T>
    Cap<T, Dim> capOf(std::uint32_t pivot, std::uint32_t body) const;
    void addLoose(std::uint32_t pivot, const Surroundings<Dim>& around);
    FrontOrder orderOf(const Vec<Dim>& start);
    bool isBeyond(std::uint32_t index) const;
    double meetingLead(std::uint32_t index) const;
    float leadOf(std::uint32_t index) const;
    float keyOf(std::uint32_t index) const;
    float heightAbove(std::uint32_t pivot, const Bodies& bodies, const Vec<Dim>& start) const;
    static float nearness(float gap, float nearGap);
    static float wallCrowd(const End& end, const TangentPlane<Dim>& plane, float nearGap);
    static float squaredDistance(const std::array<float, Dim>& center, const End& end);
    static bool reaches(float square, float radius, const End& end);
    void crowd(std::uint32_t index, float square, float radius);
    void drop(std::uint32_t index) {
        ends_[index].dead = true;
        queue_.remove(index);
    }
    void limitBy(std::uint32_t index, const Cap<float, Dim>& cap);

    /// In largest radii: a limit that counts as none.
    static constexpr float kOpen = 0.99f;

    const BlockState<Dim>& block_;
    FrontWalls<Dim>& walls_;
    std::vector<PivotRadii> radii_;
    std::uint64_t arrived_ = 0;  ///< sites so far
    std::vector<Site> sites_;
    std::vector<End> ends_;             ///< beside `sites_`
    std::uint32_t unused_ = kNone;      ///< list of sites to use again
    std::vector<std::uint32_t> first_;  ///< site of each sphere
    BucketQueue queue_;
    std::vector<typename Surroundings<Dim>::Site> found_;
};

}  // namespace vdbpack
