#include "vdbpack/voids/stamp.h"

#include "vdbpack/core/count.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/level_set_builder.h"
#include "vdbpack/voids/tile.h"
#include "vdbpack/voids/tile_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bitset>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace vdbpack {

namespace {

static_assert(LevelSetTile::kSide == kTileSide);

/// Mean number of entries that are sorted together.
constexpr std::size_t kEntriesPerPart = 64;

/// A void and a tile that it reaches: sorted by tile, then the nearest void first, after which most
/// others can be skipped.
struct Entry {
    std::uint64_t tile;
    float lower;
    std::uint32_t ellipsoid;

    friend bool operator<(const Entry& a, const Entry& b) {
        if (a.tile != b.tile) return a.tile < b.tile;
        return a.lower != b.lower ? a.lower < b.lower : a.ellipsoid < b.ellipsoid;
    }
};

/// Distances to the part of the domain deeper than the shell (the core), as accurate as voids need.
template <int Dim>
class Core {
public:
    Core(const Domain<Dim>& domain, const StampOptions<Dim>& options)
        : sampler_((options.shell.any() ? domain.envelope() : domain).sampler()),
          domain_(options.shell.any() && &domain.envelope() != &domain ? domain.sampler()
                                                                       : nullptr),
          shell_(options.shell),
          h_(options.voxelSize),
          reach_(std::max(kStampBand * options.voxelSize, options.reach)),
          error_(domain.facts().voxelSize),
          deepest_(-domain.fieldDepth() * (1 - 1e-9)) {}

    /// Locates the ball of `radius` about `middle` relative to the core.
    /// @param inside   no void is cut deeper than this inside the core, mm.
    /// @param outside  distances farther outside of the core are not needed, mm.
    /// @param apart    set to whether the ball lies farther outside.
    /// @param cut      set to whether the boundary of the core may meet the ball.
    void look(const Vec<Dim>& middle, double radius, double inside, double outside, bool& apart,
              bool& cut) {
        const double field = sampler_->signedDistance(middle);
        const bool deep = field <= deepest_;
        apart = !deep && field + shell_.least() - radius - error_ > outside;
        // Below the field, ask the wall.
        cut = deep ? sampler_->isWallCloser(middle, shell_.most() + radius + inside)
                   : field + shell_.most() + radius + error_ > -inside;
        if (domain_) cut |= domain_->signedDistance(middle) + radius + error_ > 0;
    }
    /// Whether a point that the shell encloses is in the domain, and not in one of its cavities.
    bool inDomain(const Vec<Dim>& x) { return !domain_ || domain_->signedDistance(x) < 0; }
    /// Distance to the core, negative inside; by the exact distance to the wall below the field,
    /// and where a void may come closer to the wall than the field can resolve.
    double operator()(const Vec<Dim>& x, double toVoid) {
        const double field = sampler_->signedDistance(x);
        // Where the core's boundary is too far away to matter, any thickness does.
        const bool far =
            field + shell_.most() + error_ < toVoid || field + shell_.least() - error_ > reach_;
        const double shell = far ? shell_.most() : shell_.at(x);
        const double outside = field + shell;
        if (!(shell > 0 && error_ > 0 && toVoid < h_)) return outside;
        WallPoint<Dim> wall;
        if (field <= deepest_) {
            const double reach = shell + kStampBand * h_;
            return shell - (sampler_->nearestWall(x, reach, wall) ? wall.distance : reach);
        }
        // Where the field's lattice is that of the voids, this is the distance itself.
        const DepthRange depth = sampler_->depthRange(x);
        if (depth.least > shell || depth.most < shell)
            return std::clamp(outside, shell - depth.most, shell - depth.least);
        if (std::fabs(outside) < error_ && field < 0 &&
            sampler_->nearestWall(x, shell + error_, wall))
            return shell - wall.distance;
        return outside;
    }

private:
    std::unique_ptr<DomainSampler<Dim>> sampler_;  // of what the shell is measured in
    std::unique_ptr<DomainSampler<Dim>> domain_;   // null: the same
    ShellThickness shell_;
    double h_, reach_, error_, deepest_;
};

/// All pairs of voids and tiles that they reach, sorted.
template <int Dim>
std::vector<Entry> listEntries(const std::vector<Ellipsoid<Dim>>& voids,
                               const TileLattice<Dim>& lattice, double outside) {
    PerThread<std::vector<Entry>> found;
    const double radius = lattice.radius();
    parallelFor(IndexRange(0, voids.size(), 64), [&](const auto& range) {
        auto& mine = found.local();
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            lattice.forEach(
                voids[i].bounds().grown(outside), [&](std::uint64_t tile, const Vec<Dim>& middle) {
                    const double lower = boundsAt(voids[i], middle, radius).lower;
                    if (lower < outside)
                        mine.push_back(
                            {tile, static_cast<float>(lower), static_cast<std::uint32_t>(i)});
                });
    });
    // Distributes entries to parts of the lattice, in any order, and sorts each part.
    std::size_t count = 0;
    for (const auto& part : found) count += part.size();
    const std::size_t parts = count / kEntriesPerPart + 1;
    std::vector<std::atomic<std::size_t>> next(parts + 1);
    const auto forEachFound = [&](const auto& visit) {
        for (const std::vector<Entry>& mine : found)
            forAll(mine.size(), [&](std::size_t i) {
                visit(mine[i], next[lattice.partOf(mine[i].tile, parts)]);
            });
    };
    forEachFound([](const Entry&, std::atomic<std::size_t>& at) {
        at.fetch_add(1, std::memory_order_relaxed);
    });
    std::size_t before = 0;
    for (auto& at : next) before += at.exchange(before);
    std::vector<Entry> all(count);
    forEachFound([&](const Entry& e, std::atomic<std::size_t>& at) {
        all[at.fetch_add(1, std::memory_order_relaxed)] = e;
    });
    // next[part] is now the end of the part.
    parallelFor(IndexRange(0, parts), [&](const auto& range) {
        for (std::size_t part = range.begin(); part < range.end(); ++part) {
            const auto from = static_cast<std::ptrdiff_t>(part == 0 ? 0 : next[part - 1].load());
            const auto to = static_cast<std::ptrdiff_t>(next[part].load());
            std::sort(all.begin() + from, all.begin() + to);
        }
    });
    return all;
}

/// The result of stamping one tile.
struct Stamped {
    LevelSetTile leaf;         ///< empty if the tile is uniform
    bool inside = false;       ///< uniform and inside
    std::uint32_t voxels = 0;  ///< whose centers lie in the core and in voids
};

template <int Dim>
LevelSetTile makeLeaf(const VoxelIndex& at, const Tile<Dim>& tile, float outside) {
    LevelSetTile leaf(at, outside);
    // 2D: the first layer of the leaf.
    constexpr std::size_t kStride = Dim == 3 ? 1 : kTileSide;
    std::bitset<kTileVoxels<Dim>> band;
    tile.copyTo(leaf.values(), kStride, band);
    std::bitset<LevelSetTile::kVoxels> active;
    for (std::size_t i = 0; i < band.size(); ++i) active[i * kStride] = band[i];
    leaf.setActive(active);
    return leaf;
}

/// Counts the voxels in voids and in the core; `takeOut` removes from the voids what the core's
/// boundary cuts off.
template <int Dim>
std::uint32_t cutAtCore(Tile<Dim>& tile, Core<Dim>& core, bool takeOut) {
    std::uint32_t voxels = 0;
    for (std::size_t i = 0; i < kTileVoxels<Dim>; ++i) {
        float& v = tile.values()[i];
        if (v >= (takeOut ? tile.outside() : 0)) continue;
        const Vec<Dim> x = tile.centerOf(i);
        const auto depth = std::max(v, static_cast<float>(core(x, static_cast<double>(v))));
        if (takeOut) v = std::min(depth, tile.outside());
        voxels += depth < 0 && core.inDomain(x);
    }
    return voxels;
}

/// Width of the band outside of voids, mm.
template <int Dim>
double outsideOf(const StampOptions<Dim>& options) {
    return std::max(kStampBand * options.voxelSize, options.reach);
}

/// How far voids matter, mm.
template <int Dim>
double reachOf(const StampOptions<Dim>& options) {
    return std::max(outsideOf(options), options.join.reach(options.voxelSize));
}

/// Voids wrapped into a periodic cell, and behind them the images that reach nearer to it than
/// `reach`, mm. Images have the id of what they are images of, so that the same struts repeat.
template <int Dim>
std::vector<Ellipsoid<Dim>> repeatedVoids(const std::vector<Ellipsoid<Dim>>& voids,
                                          const PeriodicCell<Dim>& cell, double reach) {
    std::vector<Ellipsoid<Dim>> all = voids;
    for (Ellipsoid<Dim>& e : all) e.center = cell.wrapped(e.center);
    for (std::size_t i = 0; i < voids.size(); ++i) {
        const Ellipsoid<Dim> e = all[i];
        cell.forEachShift(e.bounds(), cell.box.grown(reach), [&](const Vec<Dim>& shift) {
            if (squaredLength(shift) == 0) return;
            all.push_back(e);
            all.back().center += shift;
        });
    }
    return all;
}

/// Whether struts may lie in a tile whose points are no farther than `upper` from one of its voids.
template <int Dim>
bool hasStrut(const Entry* entries, std::size_t count, double upper,
              const StampOptions<Dim>& options) {
    return options.join.strut > 0 && count >= Dim &&
           static_cast<double>(entries[Dim - 1].lower) <
               upper + options.join.strutReach(options.voxelSize);
}

/// Stamps one tile with the voids of its entries.
/// @param near  a buffer.
template <int Dim>
Stamped stampTile(const std::vector<Ellipsoid<Dim>>& voids, const Entry* entries, std::size_t count,
                  const TileLattice<Dim>& lattice, Core<Dim>& core,
                  const StampOptions<Dim>& options, std::vector<NearVoid<Dim>>& near) {
    const double inside = kStampBand * options.voxelSize, outside = outsideOf(options);
    const double radius = lattice.radius();
    const std::uint64_t at = entries[0].tile;
    const Vec<Dim> middle = lattice.middleOf(at);
    Stamped result;
    bool apart = false, cut = false;
    // Without a shell, the core only decides which voxels are counted.
    core.look(middle, radius, options.shell.any() ? inside : 0, outside, apart, cut);
    if (apart) return result;
    Tile<Dim> tile(lattice.firstCenterOf(at), options.voxelSize, inside, outside);
    near.clear();
    bool filled = false;
    for (std::size_t i = 0; i < count && !filled; ++i) {
        const auto& e = voids[entries[i].ellipsoid];
        if (std::min(e.a, e.b) > inside + radius) {
            const double upper = boundsAt(e, middle, radius).upper;
            filled = upper < -inside && !hasStrut(entries, count, upper, options);
        }
        near.push_back({&e, static_cast<double>(entries[i].lower)});
    }
    if (filled)
        tile.fillInside();
    else
        tile.stamp(near);
    if (!filled && !options.join.isNone()) tile.join(near, options.join);
    if (cut)
        result.voxels = cutAtCore(tile, core, options.shell.any());
    else
        result.voxels = static_cast<std::uint32_t>(tile.countInside());
    if (tile.isOutside()) return result;
    result.inside = tile.isInside();
    if (!result.inside)
        result.leaf = makeLeaf(lattice.firstVoxelOf(at), tile, static_cast<float>(outside));
    return result;
}

template <int Dim>
void checkStamp(const std::vector<Ellipsoid<Dim>>& voids, const StampOptions<Dim>& options) {
    if (!(options.voxelSize > 0 && std::isfinite(options.voxelSize)))
        throw ParameterError(
            fmt::format("`voids.voxelSize` {} mm must be positive", options.voxelSize));
    for (const double shell : {options.shell.least(), options.shell.most()})
        if (!(shell >= 0 && std::isfinite(shell)))
            throw ParameterError(fmt::format("`voids.shell` {} mm must be 0 or more", shell));
    for (const auto& [name, value] :
         {std::pair{"blend", options.join.blend}, std::pair{"strut", options.join.strut},
          std::pair{"strutShare", options.join.strutShare}})
        if (!(value >= 0 && std::isfinite(value)))
            throw ParameterError(fmt::format("`voids.{}` {} must be 0 or more", name, value));
    for (std::size_t i = 0; i < voids.size(); ++i) {
        const auto& e = voids[i];
        if (!(e.a > 0 && e.b > 0 && std::isfinite(e.a) && std::isfinite(e.b)) ||
            !isFinite(e.center) || !(std::fabs(squaredLength(e.axis) - 1) < 1e-6))
            throw ParameterError(fmt::format(
                "void {} has half-axes {} and {} mm; they must be positive, its center finite and "
                "its axis of length one",
                i, e.a, e.b));
    }
    indexable(voids.size(), "voids", "give fewer or larger ones");
}

}  // namespace

template <int Dim>
struct StampedVoids<Dim>::Impl {
    std::shared_ptr<const VdbGrid> grid;
    Vec<Dim> origin;
    double voxelSize = 0;
    double volume = 0;
    double inside = 0, outside = 0;        // widths of the band, mm
    VoidJoin join;                         // as in the options
    std::vector<Ellipsoid<Dim>> repeated;  // in a periodic cell: the voids with their images
    std::optional<TileLattice<Dim>> lattice;
    std::vector<std::uint64_t> tiles;  // tiles that voids reach into, sorted
    std::vector<std::size_t> starts;   // start of each in `ellipsoids`, and the end
    std::vector<std::uint32_t> ellipsoids;
};

template <int Dim>
StampedVoids<Dim>::StampedVoids() : impl_(std::make_unique<Impl>()) {}
template <int Dim>
StampedVoids<Dim>::~StampedVoids() = default;
template <int Dim>
double StampedVoids<Dim>::voxelSize() const {
    return impl_->voxelSize;
}
template <int Dim>
double StampedVoids<Dim>::volume() const {
    return impl_->volume;
}
template <int Dim>
std::uint64_t StampedVoids<Dim>::activeVoxels() const {
    return vdbpack::activeVoxels(*impl_->grid);
}

template <int Dim>
std::shared_ptr<const StampedVoids<Dim>> stampVoids(const std::vector<Ellipsoid<Dim>>& given,
                                                    const Domain<Dim>& outer,
                                                    const StampOptions<Dim>& options,
                                                    const Callbacks& callbacks) {
    checkStamp(given, options);
    auto stamped = std::make_shared<StampedVoids<Dim>>();
    auto& impl = *stamped->impl_;
    const double h = options.voxelSize;
    impl.voxelSize = h;
    impl.origin = options.origin;
    impl.join = options.join;
    impl.inside = kStampBand * h;
    impl.outside = outsideOf(options);
    std::shared_ptr<const Domain<Dim>> box;  // what is counted of a periodic cell
    if (const PeriodicCell<Dim> cell = outer.cell(); cell.any()) {
        box = boxDomain(cell.box);
        // The band goes on beyond the faces.
        impl.repeated = repeatedVoids(given, cell, reachOf(options) + 2 * kStampBand * h);
        indexable(impl.repeated.size(), "voids", "give fewer or larger ones");
    }
    const auto& voids = box ? impl.repeated : given;
    const Domain<Dim>& domain = box ? *box : outer;
    const auto inside = static_cast<float>(impl.inside), outside = static_cast<float>(impl.outside);

    const TileLattice<Dim> lattice(domain.bounds(), options.voxelSize, options.origin);
    callbacks.report("voids", 0, 0);
    StopRequest request(callbacks.cancelled);
    request.stop();
    const std::vector<Entry> entries = listEntries(voids, lattice, reachOf(options));
    std::vector<std::size_t> starts;
    for (std::size_t i = 0; i < entries.size(); ++i)
        if (i == 0 || entries[i].tile != entries[i - 1].tile) starts.push_back(i);
    const std::size_t tiles = starts.size();
    starts.push_back(entries.size());

    std::vector<Stamped> made(tiles);
    PerThread<Core<Dim>> cores([&] { return Core<Dim>(domain, options); });
    parallelFor(IndexRange(0, tiles, 8), [&](const auto& range) {
        request.stop();
        Core<Dim>& core = cores.local();
        std::vector<NearVoid<Dim>> near;
        for (std::size_t n = range.begin(); n < range.end(); ++n)
            made[n] = stampTile(voids, &entries[starts[n]], starts[n + 1] - starts[n], lattice,
                                core, options, near);
    });

    impl.lattice.emplace(lattice);
    impl.starts.push_back(0);
    for (std::size_t n = 0; n < tiles; ++n) {
        // A point may lie half a voxel beyond the centers of its tile.
        for (std::size_t i = starts[n]; i < starts[n + 1]; ++i)
            if (static_cast<double>(entries[i].lower) < std::max(h, options.join.reach(h)))
                impl.ellipsoids.push_back(entries[i].ellipsoid);
        if (impl.ellipsoids.size() == impl.starts.back()) continue;
        impl.tiles.push_back(entries[starts[n]].tile);
        impl.starts.push_back(impl.ellipsoids.size());
    }

    LevelSetBuilder builder(inside, outside);
    std::uint64_t voxels = 0;
    for (std::size_t n = 0; n < tiles; ++n) {
        voxels += made[n].voxels;
        if (made[n].leaf)
            builder.add(std::move(made[n].leaf));
        else if (made[n].inside)
            builder.addInside(lattice.firstVoxelOf(entries[starts[n]].tile), kTileSide);
    }
    Vec<3> origin;
    if constexpr (Dim == 3) origin = options.origin;
    impl.grid = builder.finish("voids", origin, h);
    impl.volume = static_cast<double>(voxels) * std::pow(h, Dim);
    callbacks.report("voids", 1, static_cast<double>(voids.size()));
    return stamped;
}

template <int Dim>
bool StampedVoids<Dim>::isIn(const std::vector<Ellipsoid<Dim>>& given, const Vec<Dim>& x) const {
    const auto& voids = impl_->repeated.empty() ? given : impl_->repeated;
    std::uint64_t tile = 0;
    if (!impl_->lattice || !impl_->lattice->find(x, tile)) return false;
    const auto found = std::lower_bound(impl_->tiles.begin(), impl_->tiles.end(), tile);
    if (found == impl_->tiles.end() || *found != tile) return false;
    const auto n = static_cast<std::size_t>(found - impl_->tiles.begin());
    std::vector<const Ellipsoid<Dim>*> near;
    for (std::size_t i = impl_->starts[n]; i < impl_->starts[n + 1]; ++i) {
        const Ellipsoid<Dim>& e = voids[impl_->ellipsoids[i]];
        if (!(impl_->join.strut > 0) && e.contains(x)) return true;
        near.push_back(&e);
    }
    return !impl_->join.isNone() && joinedDistance(near, x, impl_->join) < 0;
}

template <int Dim>
double joinedDistance(const std::vector<const Ellipsoid<Dim>*>& voids, const Vec<Dim>& x,
                      const VoidJoin& how) {
    const double reach = kBlendReach * how.blend;
    using Nearest = NearestVoids<Dim, double, std::uint32_t>;
    Nearest nearest;
    double sum = 0, least = std::numeric_limits<double>::infinity();
    for (const Ellipsoid<Dim>* e : voids) {
        const double d = e->signedDistance(x);
        if (how.blend > 0) sum += std::pow(std::max(0.0, 1 - d / reach), 4);
        least = std::min(least, d);
        nearest.add(d, e->id);
    }
    if (sum > 0) least = std::min(least, reach * (1 - std::sqrt(std::sqrt(sum))));
    if (!(how.strut > 0) || !(nearest.chance() < Nearest::below(how.strutShare))) return least;
    return roundedMax(least, how.strut - std::sqrt(nearest.squareFromLine()),
                      static_cast<float>(how.rounding()));
}

template <int Dim>
std::shared_ptr<const VdbGrid> StampedVoids<Dim>::grid() const {
    static_assert(Dim == 2 || Dim == 3);
    if (Dim == 2) throw ParameterError("voids of a plane have no level set in space; write .svg");
    // The same width outside as inside.
    return impl_->outside <= impl_->inside ? impl_->grid : narrowed(*impl_->grid, impl_->inside);
}

template <int Dim>
StampedVoids<Dim>::Sampler::Sampler(const StampedVoids& voids)
    : sample_(*voids.impl_->grid, voids.impl_->origin, voids.impl_->voxelSize,
              voids.impl_->outside) {}

template double joinedDistance(const std::vector<const Ellipsoid<2>*>&, const Vec<2>&,
                               const VoidJoin&);
template double joinedDistance(const std::vector<const Ellipsoid<3>*>&, const Vec<3>&,
                               const VoidJoin&);
template class StampedVoids<2>;
template class StampedVoids<3>;
template std::shared_ptr<const StampedVoids<2>> stampVoids(const std::vector<Ellipsoid<2>>&,
                                                           const Domain<2>&, const StampOptions<2>&,
                                                           const Callbacks&);
template std::shared_ptr<const StampedVoids<3>> stampVoids(const std::vector<Ellipsoid<3>>&,
                                                           const Domain<3>&, const StampOptions<3>&,
                                                           const Callbacks&);
}  // namespace vdbpack
