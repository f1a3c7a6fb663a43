// Private to densify: overlapping spheres pushed apart, all at once.
#pragma once

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/core/ranks.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/densify/body.h"
#include "vdbpack/densify/body_cells.h"
#include "vdbpack/densify/candidates.h"
#include "vdbpack/densify/group_boundary.h"
#include "vdbpack/densify/pace.h"
#include "vdbpack/densify/step_device.h"
#include "vdbpack/densify/wall_planes.h"
#include "vdbpack/domain/domain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdbpack {

namespace eight {
struct Push;
}

/// Spheres in a domain that push one another, and are pushed by the wall, until none overlap.
///
/// v <- inertia v + 0.3 F, x <- x + v for all spheres at once, F the sum of the overlaps with
/// spheres and wall (of radii enlarged by a small share, so that spheres of the true radii end up
/// apart). After a step, two spheres of nearly the same size, of which the larger is squeezed
/// more, exchange positions. Positions are whole, sums go in the order of lists, exchanges are of
/// pairs without a common sphere, and roots need no more than additions and multiplications: the
/// same bits on every machine and for any number of threads.
template <int Dim>
class Relaxation {
public:
    /// @param spheres  to be relaxed; radii and centers in mm.
    /// @param fixed    the first of them that stay where they are.
    /// @param regions  of the spheres, which exchange positions within a region only; empty: one.
    /// @param domain   must outlive this.
    /// @param graded   whether sizes differ by place: then steps, and gaps up to which neighbors
    /// are
    ///                 listed, go with each sphere's own radius, not with the smallest of all.
    /// @throws ResourceError above 2^31 spheres.
    Relaxation(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
               std::size_t fixed, const std::vector<std::int32_t>& regions, std::uint64_t seed,
               bool graded = false);
    /// Over ranks: spheres of this one, of which all move, in one region.
    /// @param labels  of the spheres: their numbers among the spheres of all ranks, rising.
    /// @param further  radius of the spheres for which vacancies are sought, mm; 0: none are.
    Relaxation(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres, Ranks& ranks,
               const std::vector<std::uint32_t>& labels, double further, std::uint64_t seed);
    ~Relaxation();
    /// Keeps the centers of spheres on their side of a boundary; see GroupBoundary. Both must
    /// outlive this. @param isInside  whether the spheres of a region lie inside
    void keepTo(GroupBoundary<Dim>& boundary, const std::function<bool(std::int32_t)>& isInside) {
        boundary_ = &boundary;
        isInside_ = &isInside;
    }
    /// Lets no spheres exchange positions from now on.
    void exchangeNone() { mayExchange_ = false; }
    /// Takes steps on a device; null: on the processor alone.
    void useDevice(StepDevice* device) { device_ = device; }
    Relaxation(const Relaxation&) = delete;
    Relaxation& operator=(const Relaxation&) = delete;

    struct Outcome {
        bool apart = false;  ///< no two spheres overlap, none crosses the wall
        bool interrupted = false;
        int steps = 0;
        double worst = 0;  ///< largest overlap, as a share of the sum of the radii
    };
    /// Takes up to `steps` steps, or fewer where no overlap is left.
    /// @param goOn  called before every step with the number of steps taken and the worst overlap;
    ///              false ends the relaxation.
    Outcome run(const RelaxationPace& pace, int steps, const Callbacks& callbacks,
                const std::function<bool(int, double)>& goOn = {});

    /// The sum of the overlaps of a sphere that moves, in its radii, on average over all of them.
    double strain();

    /// Draws spheres that are apart together until they touch. Where not apart in the end, they are
    /// no pack. @param loose  whether wider gaps than in a densified front are closed.
    /// @param onStep  called before every step with the share of them that is done.
    Outcome drawTogether(bool loose, const Callbacks& callbacks,
                         const std::function<void(double)>& onStep = {});
    /// The same for the spheres of a front that were moved a little at random: they are pushed
    /// apart until gaps are alike everywhere, so that no direction and no place tells where the
    /// front began, and then drawn together.
    Outcome settle(const Callbacks& callbacks, const std::function<void(double)>& onStep = {});

    /// A vacancy for each of further spheres: the point with the most room of some points drawn
    /// near a sphere. They may overlap other spheres and one another. Radii in mm.
    /// @param regions  of each further sphere, near whose spheres it is placed; empty: anywhere.
    /// @param belongs  whether a point (mm) is one for a region; thread-safe. Empty: all are.
    using Belongs = std::function<bool(const Vec<Dim>& x, std::int32_t region)>;
    std::vector<Sphere<Dim>> vacancies(const std::vector<double>& radii,
                                       const std::vector<std::int32_t>& regions, std::uint64_t salt,
                                       const Belongs& belongs = {});

    /// The same over ranks: of those vacancies that this rank finds.
    struct Vacancy {
        std::uint64_t number;  ///< among the radii
        Vec<Dim> center;       ///< mm
    };
    std::vector<Vacancy> vacanciesHere(const std::vector<double>& radii, std::uint64_t salt);

    /// Over ranks: what is left of a sphere of any of them.
    struct Settled {
        std::uint32_t label, place;  ///< its number, and the number of the first one there
        Vec<Dim> center;             ///< mm
    };
    std::vector<Settled> settled() const;

    /// Moves spheres, in the order of the constructor, to their current positions: whole multiples
    /// of `quantum` except for the fixed ones.
    void move(std::vector<Sphere<Dim>>& spheres) const;
    /// For each of them, the number of the sphere that was at first where exchanges have put it.
    std::vector<std::uint32_t> places() const;
    double quantum() const { return quantum_; }

private:
    /// Positions and the spheres in them, in the order of the cells.
    struct Slots {
        std::vector<Body> bodies;
        std::vector<Body> before;           ///< where bodies were before the last step
        std::vector<Home> homes;            ///< positions when lists were made, in quanta
        std::vector<Body> listed;           ///< the same, with the ways from there that the lists
                                            ///< allow for in place of radii
        std::vector<std::uint32_t> labels;  ///< number of the sphere in the constructor's order
        std::vector<std::uint32_t> places;  ///< number of the sphere that was there at first
        std::vector<typename WallPlanes<Dim>::Vicinity> vicinities;

        void resize(std::size_t n);
        /// Puts the slots into an order. @param from  number of the slot that comes at a place.
        template <class From>
        void sort(const From& from) {
            const auto sortOne = [&](auto& all) {
                std::decay_t<decltype(all)> sorted(all.size());
                forAll(labels.size(), [&](std::size_t to) { sorted[to] = all[from(to)]; });
                all.swap(sorted);
            };
            sortOne(bodies), sortOne(before), sortOne(homes), sortOne(listed);
            sortOne(places), sortOne(vicinities), sortOne(labels);
        }
        /// Takes slot `i` of others (or of these) as slot `to`.
        void take(std::size_t to, const Slots& from, std::size_t i) {
            bodies[to] = from.bodies[i];
            before[to] = from.before[i];
            homes[to] = from.homes[i];
            listed[to] = from.listed[i];
            labels[to] = from.labels[i];
            places[to] = from.places[i];
            vicinities[to] = from.vicinities[i];
        }
    };

    /// A run of slots with their neighbors.
    struct Run {
        std::uint32_t first = 0, last = 0;
        std::uint32_t number = 0;  ///< of the first slot among the slots of all ranks
        /// The slots that move, with the longest lists first, filled up to eights with the last
        /// one; before all others those near walls.
        std::vector<std::uint32_t> members;
        std::size_t wallMembers = 0;
        /// Rows of a neighbor of each of eight members, filled up with nobody.
        std::vector<std::uint32_t> ids;
        std::vector<std::uint32_t> ends;       ///< of each eight's in `ids`
        std::vector<WallPlane> planes;         ///< walls that are near
        std::vector<std::uint32_t> planeEnds;  ///< of each slot's in `planes`
        std::vector<WallPlane> edges;  ///< ends of a shell near centers, as walls for the spheres
        std::vector<std::uint32_t> edgeEnds;  ///< of each slot's in `edges`; empty: none
        std::vector<std::uint32_t> ranks;     ///< slots that may exchange, by region and radius
        std::vector<std::pair<std::uint32_t, std::uint32_t>>
            exchanged;           ///< slots, by the last step
        float worst = 0;         ///< largest (r_i + r_j) (1 + delta) / d - 1
        float fastest = 0;       ///< largest squared step, quanta²
        bool coincides = false;  ///< two centers coincided when lists were made
        bool expired = false;    ///< a sphere went farther, or grew more, than the lists allow for
        bool hasWall(std::uint32_t slot) const {
            return planeEnds[slot - first] > (slot > first ? planeEnds[slot - first - 1] : 0);
        }
        /// Whether a slot is between two walls.
        bool isBetweenWalls(std::uint32_t slot) const {
            const std::uint32_t k = slot - first;
            for (std::uint32_t p = k > 0 ? planeEnds[k - 1] : 0; p + 1 < planeEnds[k]; ++p)
                for (std::uint32_t q = p + 1; q < planeEnds[k]; ++q)
                    if (planes[p].nx * planes[q].nx + planes[p].ny * planes[q].ny +
                            planes[p].nz * planes[q].nz <
                        -0.5f)
                        return true;
            return false;
        }
    };

    /// Largest values of all runs, of all ranks.
    struct Extremes {
        float worst = 0, fastest = 0;
        std::uint32_t coincides = 0, expired = 0, cancelled = 0;
    };

    struct Drawing;
    Outcome draw(const Drawing& drawing, const Callbacks& callbacks,
                 const std::function<void(double)>& onStep);
    /// Spheres whose overlaps stay exchange, or leave the walls that squeeze them.
    /// @param left  steps until pulls end. @param before  the worst overlap when this was asked
    /// last
    void relieve(int left, float worst, float& before, const RelaxationStep& step);
    void setDelta(double delta);
    void setRadii(const std::vector<Sphere<Dim>>& spheres);
    void placeSlots(const std::vector<Sphere<Dim>>& spheres);
    /// One step of all runs, into `before`. @return the worst overlap.
    float stepAll(const RelaxationStep& step);
    void stepRuns(const RelaxationStep& step);
    /// What is to be known of all runs before a step.
    Extremes stateOfAll(const Callbacks& callbacks) const;
    /// Takes up the positions of the last step.
    void advance();

    /// The point with the most room of some drawn near a slot, mm.
    /// @param radius  quanta. @param around  scratch space. @param belongs  of points, mm; empty:
    /// all.
    Vec<Dim> vacancyNear(std::uint32_t slot, double radius, RandomStream& random,
                         std::vector<Body>& around,
                         const std::function<bool(const Vec<Dim>&)>& belongs = {});

    // relaxation_images.cpp
    struct Image {
        std::uint32_t slot, source;  ///< of the image, and of that which it is one of
        Home shift;                  ///< quanta
    };
    /// Puts the slots into the periodic cell, and images of those that are near others across its
    /// faces behind them: slots that stay where they are until `refreshImages` moves them.
    void addImages();
    /// After all were sorted. @param order  where each slot was before.
    void findImages(const std::vector<std::uint32_t>& order);
    void refreshImages();
    /// The cell's image of a position; as whole quanta.
    Home wrapped(Home home) const;

    // relaxation_ranks.cpp
    Extremes agreed(const Extremes& own) const;
    void sortOverRanks();
    struct Layers;
    struct Traveler;
    Layers layersOverRanks() const;
    /// Moves slots to other ranks, and slots of others here, behind the own slots.
    /// @param to  rank of each slot.
    void send(const std::vector<int>& to);
    void sortLocally(std::vector<std::pair<std::uint64_t, std::uint64_t>>& keys);
    struct Interval;
    std::vector<std::vector<Interval>> slotIntervals(const Layers& layers) const;
    std::vector<std::vector<std::uint32_t>> slotsNear(const Layers& layers) const;
    void addNear(const Layers& layers);
    std::vector<std::uint32_t> sortWithNear(std::size_t own);
    /// Tells other ranks where the slots are now that are near theirs.
    void refreshNear();

    // neighbor_lists.cpp
    void sort();
    /// Takes up where the bodies are by now.
    void moveHomes();
    /// @param rough  whether overlaps are still large: walls are then queried less often.
    void rebuild(bool rough);
    /// Rebuilds the lists where they may miss a neighbor or are far too long.
    void renewLists(const Extremes& all, double worst);
    /// How far a sphere may go until lists expire: farther where it is fast.
    float marginOf(std::uint32_t slot) const;
    void setMargins();
    void listNeighbors();
    void listRun(Run& run);
    void rankRun(Run& run);
    /// Lists of the members of a run, eight by eight.
    void interleave(Run& run, const std::vector<std::uint32_t>& slots, const Candidates& lists);
    /// The body behind the last one: far smaller than nothing.
    std::uint32_t nobody() const { return static_cast<std::uint32_t>(now_.labels.size()); }
    /// Candidates for the neighbors of the slots `first` to `last` - 1.
    void collect(std::uint32_t first, std::uint32_t last, Candidates& around) const;
    void listSlot(Run& run, std::uint32_t slot, Candidates& around);
    void partCoinciding(Run& run, std::uint32_t slot, const Candidates& around);
    void part(std::uint32_t slot, std::uint32_t other);

    // relaxation_walls.cpp
    void askWalls();
    void askWall(std::size_t slot);
    void listPlanes(Run& run);
    /// Lists the end of a shell as a wall for the center of a slot.
    void listBoundary(Run& run, std::uint32_t slot);
    /// Whether all spheres lie inside by the exact wall, and on their side of the end of the shell;
    /// lists the planes of those that do not.
    bool keepsWall();
    /// Whether the center of a slot lies on its side of the end of the shell.
    bool keepsSide(const Run& run, std::uint32_t slot);

    // relaxation_step.cpp
    template <bool kPull, bool kGraded>
    void stepRun(Run& run, const RelaxationStep& step);
    /// The overlaps of eight slots with the planes near them.
    eight::Push pushOfPlanes(const Run& run, const std::uint32_t* slots,
                             const RelaxationStep& step) const;

    // relaxation_device.cpp
    /// A step of all runs, by the device where it is its turn.
    void takeStep(const RelaxationStep& step);
    void stepOnDevice(const RelaxationStep& step);
    /// Whether the processor's step has the same bits as the device's.
    bool isDeviceRight(const RelaxationStep& step);
    void toDevice();
    /// Takes back what steps have changed, if the device has it. The end of `run` and of `draw` is
    /// no place for it: `keepsWall` was there before.
    void toHost();

    // exchanges.cpp
    /// What a step has found of a slot.
    struct Squeezed {
        float squeeze = 0, touching = 0;  ///< sum of the overlaps, quanta, and their number
    };
    /// Exchanges for the positions after a step. @param squeezed  by slot, from the first.
    void swapRun(Run& run, const std::vector<Squeezed>& squeezed);
    /// The spheres at two ranks of a run, the smaller one first, exchange their places among
    /// `bodies`; not yet their labels.
    void exchange(Run& run, std::uint32_t k, std::uint32_t l, std::vector<Body>& bodies);
    void exchangeLabels(std::uint32_t a, std::uint32_t b);
    /// The overlaps of a member's sphere: the largest, as `Run::worst`, and the sum of all.
    struct Strain {
        float worst = 0, squeeze = 0;
    };
    Strain strainOf(const Run& run, std::size_t member) const;
    /// Exchanges the spheres with the worst overlaps, if asked, or, if they are the smallest ones,
    /// lets them leave the walls that squeeze them. @param kick  at this velocity; 0: they stay
    void loosen(float worst, float kick = 0, bool exchanges = true);
    void leaveWalls(const Run& run, std::uint32_t slot, float speed);

    /// Calls `visit(slot)` for (at least) all whose surface is closer than `reach`.
    template <class Visit>
    void forEachNear(const Home& home, double reach, const Visit& visit) const;
    static constexpr std::uint32_t kOfOthers = 0xffffffff;  ///< label of images
    bool isFixed(std::uint32_t label) const { return label < fixed_ || label == kOfOthers; }
    /// The length in which ways and gaps of a sphere are counted, in smallest radii.
    float unitOf(float radius) const { return graded_ ? radius * perLeast_ : 1; }
    /// No neighbors are listed farther apart than (r_i + r_j) `listedGrow()` + `listedGap()`,
    /// quanta.
    float listedGrow() const { return graded_ ? listGrow_ + marginMost_ * perLeast_ : listGrow_; }
    float listedGap() const { return graded_ ? 0 : 2 * marginMost_; }
    /// A wall farther than this from a sphere's surface need not be known.
    float wallMargin(std::size_t slot) const {
        const float radius = now_.bodies[slot].radius;
        return radius * (delta_ + std::max(0.0f, wallRange_ - 1)) +
               std::max(now_.listed[slot].radius, kLeastWallMargin * least_ * unitOf(radius));
    }
    static constexpr float kLeastWallMargin = 0.15f;  ///< in smallest radii
    /// Whether the spheres in two slots may exchange positions.
    bool isAlike(std::uint32_t a, std::uint32_t b) const {
        return regions_.empty() || regions_[now_.labels[a]] == regions_[now_.labels[b]];
    }

    double quantum_;  ///< mm
    PeriodicCell<Dim> cell_;
    Home cellLow_{}, period_{};  ///< of the cell, quanta; 0: no period
    std::vector<Image> images_;
    std::size_t given_ = 0;  ///< number of the spheres
    std::vector<std::int32_t> regions_;
    std::uint32_t fixed_;
    std::uint64_t seed_;
    std::uint64_t clock_ = 0;        ///< steps taken
    float least_ = 0;                ///< smallest radius of those that move, quanta
    float smallest_ = 0, most_ = 0;  ///< radii of all, quanta
    float delta_ = 0;
    float wallRange_ = 1;  ///< radii are enlarged by this factor where walls are listed
    float listGrow_ = 1;   ///< radii are enlarged by this factor where neighbors are listed
    bool graded_ = false;
    GroupBoundary<Dim>* boundary_ = nullptr;  ///< null: none
    const std::function<bool(std::int32_t)>* isInside_ = nullptr;
    float perLeast_ = 0;  ///< 1 / least_
    float fastest_ = 0;   ///< squared largest step of the last one, quanta² by squared units
    float marginBase_ = 0, marginMost_ = 0;  ///< of the lists, quanta by units
    int listed_ = 0;                         ///< steps since these were made

    Slots now_;
    WallPlanes<Dim> walls_;
    BodyCells cells_;
    std::vector<Run> runs_;
    // Over ranks: slots of others that are near own ones stand among them, in the order of all.
    Ranks* ranks_ = nullptr;
    float further_ = 0;                             ///< quanta
    std::vector<std::uint32_t> slots_;              ///< number of each among the slots of all ranks
    std::vector<std::uint8_t> isNearSlot_;          ///< 1 for those of others
    std::vector<std::vector<std::uint32_t>> tell_;  ///< own slots that are near each rank's
    std::vector<std::vector<std::uint32_t>> heard_;  ///< slots here that each rank tells of

    StepDevice* device_ = nullptr;
    bool deviceTurn_ = false, onDevice_ = false;  ///< until lists are renewed; it has all
    bool exchangesOnDevice_ = false;  ///< whether its last step, not taken up yet, had exchanges

    bool wraps_ = false;  ///< whether far spheres may have near low bits
    bool ready_ = false, mayExchange_ = true;
    /// Spheres between walls keep their places, where there may be no room for larger ones.
    bool settling_ = false;
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

}  // namespace vdbpack
