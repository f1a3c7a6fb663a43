#include "vdbpack/voids/stamp.h"

#include "vdbpack/core/count.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/level_set_builder.h"
#include "vdbpack/field/linear_sampler.h"
#include "vdbpack/voids/core_distance.h"
#include "vdbpack/voids/tile.h"
#include "vdbpack/voids/tile_entries.h"
#include "vdbpack/voids/tile_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

static_assert(LevelSetTile::kSide == kTileSide);

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
std::uint32_t cutAtCore(Tile<Dim>& tile, CoreDistance<Dim>& core, bool takeOut) {
    std::uint32_t voxels = 0;
    for (std::size_t i = 0; i < kTileVoxels<Dim>; ++i) {
        float& v = tile.values()[i];
        if (v >= (takeOut ? tile.outside() : 0)) continue;
        const Vec<Dim> x = tile.centerOf(i);
        const auto depth = std::max(v, static_cast<float>(core(x, static_cast<double>(v), i)));
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
bool hasStrut(const TileEntry* entries, std::size_t count, double upper,
              const StampOptions<Dim>& options) {
    return options.join.strut > 0 && count >= Dim &&
           static_cast<double>(entries[Dim - 1].lower) <
               upper + options.join.strutReach(options.voxelSize);
}

/// Stamps one tile with the voids of its entries.
/// @param near  a buffer.
template <int Dim>
Stamped stampTile(const std::vector<Ellipsoid<Dim>>& voids, const TileEntry* entries,
                  std::size_t count, const TileLattice<Dim>& lattice, CoreDistance<Dim>& core,
                  const StampOptions<Dim>& options, std::vector<NearVoid<Dim>>& near) {
    const double inside = kStampBand * options.voxelSize, outside = outsideOf(options);
    const double radius = lattice.radius();
    const std::uint64_t at = entries[0].tile;
    const Vec<Dim> middle = lattice.middleOf(at);
    Stamped result;
    bool apart = false, cut = false;
    // Without a shell, the core only decides which voxels are counted.
    core.turnTo(at);
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

    /// Lists the voids near each tile. @param begins  of the entries of each tile, and the end
    void keepNear(const std::vector<TileEntry>& entries, const std::vector<std::size_t>& begins) {
        // A point may lie half a voxel beyond the centers of its tile.
        const double near = std::max(voxelSize, join.reach(voxelSize));
        starts.push_back(0);
        for (std::size_t n = 0; n + 1 < begins.size(); ++n) {
            for (std::size_t i = begins[n]; i < begins[n + 1]; ++i)
                if (static_cast<double>(entries[i].lower) < near)
                    ellipsoids.push_back(entries[i].ellipsoid);
            if (ellipsoids.size() == starts.back()) continue;
            tiles.push_back(entries[begins[n]].tile);
            starts.push_back(ellipsoids.size());
        }
    }
};

template <int Dim>
std::shared_ptr<KnownCore<Dim>> unknownCore() {
    return std::make_shared<KnownCore<Dim>>();
}

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
    const TileLattice<Dim> lattice(domain.bounds(), options.voxelSize, options.origin);
    callbacks.report("voids", 0, 0);
    StopRequest request(callbacks.cancelled);
    request.stop();
    const std::vector<TileEntry> entries = listEntries(voids, lattice, reachOf(options));
    const std::vector<std::size_t> starts = startsOfTiles(entries);
    const std::size_t tiles = starts.size() - 1;

    std::vector<Stamped> made(tiles);
    PerThread<CoreDistance<Dim>> cores([&] { return CoreDistance<Dim>(domain, options); });
    parallelFor(IndexRange(0, tiles, 8), [&](const auto& range) {
        request.stop();
        CoreDistance<Dim>& core = cores.local();
        std::vector<NearVoid<Dim>> near;
        for (std::size_t n = range.begin(); n < range.end(); ++n)
            made[n] = stampTile(voids, &entries[starts[n]], starts[n + 1] - starts[n], lattice,
                                core, options, near);
    });

    impl.lattice.emplace(lattice);
    impl.keepNear(entries, starts);
    LevelSetBuilder builder(static_cast<float>(impl.inside), static_cast<float>(impl.outside));
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
    : sample_(std::make_unique<LinearSampler<Dim>>(*voids.impl_->grid, voids.impl_->origin,
                                                   voids.impl_->voxelSize, voids.impl_->outside)) {}

template <int Dim>
StampedVoids<Dim>::Sampler::~Sampler() = default;

template <int Dim>
double StampedVoids<Dim>::Sampler::operator()(const Vec<Dim>& x) {
    return (*sample_)(x);
}

#define VDBPACK_INSTANTIATE(Dim)                                                               \
    template double joinedDistance(const std::vector<const Ellipsoid<Dim>*>&, const Vec<Dim>&, \
                                   const VoidJoin&);                                           \
    template class StampedVoids<Dim>;                                                          \
    template std::shared_ptr<KnownCore<Dim>> unknownCore();                                    \
    template std::shared_ptr<const StampedVoids<Dim>> stampVoids(                              \
        const std::vector<Ellipsoid<Dim>>&, const Domain<Dim>&, const StampOptions<Dim>&,      \
        const Callbacks&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
