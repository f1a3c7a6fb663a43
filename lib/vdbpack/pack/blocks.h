// Private to pack: the blocks of a domain, and what each of them builds on.
#pragma once

#include "vdbpack/core/parallel.h"
#include "vdbpack/pack/block_lattice.h"
#include "vdbpack/pack/exposed.h"
#include "vdbpack/pack/front/block_front.h"
#include "vdbpack/pack/kernel_settings.h"
#include "vdbpack/pack/radius_pool.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

namespace vdbpack {

template <int Dim>
struct Block {
    std::atomic<int> waiting{0};
    std::atomic<int> readers{0};  // own blocks that are yet to build on it
    BlockSpheres<Dim> existing;
    BlockSpheres<Dim> placed;
    std::vector<RadiusPool> pools;  // empty once they have gone to another block
    std::unique_ptr<SpeciesQueue> further;
};

template <int Dim>
class Blocks {
public:
    /// @param domain    its wall moved inwards by the shell.
    /// @param outer     the domain itself.
    /// @param existing  as in `packSpheres`.
    Blocks(const Domain<Dim>& domain, const Domain<Dim>& outer, const PackOptions& options,
           const std::vector<Sphere<Dim>>& existing)
        : settings(frontSettings(domain, options)),
          cell(domain.cell()),
          lattice(domain.bounds(), blockSide(domain, options, settings), 2 * settings.maxRadius,
                  settings.quantum, cell),
          outer_(outer),
          options_(options),
          groups_(frontLengths<Dim>(options)),
          blocks_(lattice.size()) {
        addExisting(domain, existing);
        for (const Species& species : options.species)
            hasSpecies_ = hasSpecies_ || species.probability > 0;
        expected_ = 0.6 * domain.volume() / settings.meanBall;
        if (options.local.any()) addLocal(domain);
        countAhead(domain);
    }

    const FrontSettings<Dim> settings;
    const PeriodicCell<Dim> cell;
    const BlockLattice<Dim> lattice;

    Block<Dim>& operator[](std::uint32_t b) { return blocks_[b]; }
    std::size_t size() const { return blocks_.size(); }
    /// The block whose pools `b` takes over, or `BlockLattice::kNone`.
    std::uint32_t donorOf(std::uint32_t b) const { return donors_[b]; }
    /// Spheres that all blocks together are going to hold, about.
    double expected() const { return expected_; }

    LocalLengths<Dim> localLengths() const {
        return {outer_, options_.local, groups_, shellOf(options_)};
    }
    /// @param local  the lengths of one thread; null where sizes are the same everywhere.
    typename BlockFront<Dim>::Place place(std::uint32_t b, LocalLengths<Dim>* local) const {
        return {lattice.own(b), lattice.search(b), lattice.laterBehind(b),
                lengths_.empty() ? nullptr : &lengths_[b], local};
    }

    /// Moves the pending radii and due spheres of an earlier block to block `b`.
    /// @return false if that was interrupted.
    bool takePools(std::uint32_t b) {
        Block<Dim>& block = blocks_[b];
        if (const std::uint32_t donor = donors_[b]; donor != BlockLattice<Dim>::kNone) {
            if (blocks_[donor].pools.empty()) return false;
            block.pools = std::move(blocks_[donor].pools);
            block.further = std::move(blocks_[donor].further);
        } else {
            block.pools = radiusPools(options_, b);
        }
        if (!block.further && hasSpecies_)
            block.further = std::make_unique<SpeciesQueue>(options_.species, options_.seed, b,
                                                           shellOf(options_));
        const std::size_t pending = poolCapacity<Dim>(options_, ahead_[b], expected_);
        for (std::size_t g = 0; g < block.pools.size(); ++g)
            block.pools[g].setCapacity(
                expectedOf_.empty() || options_.pending > 0
                    ? pending
                    : pendingOfGroup(pending, expectedOf_[g]),
                groups_[g].wideRadius - (options_.local.any() ? shellOf(options_) : 0));
        return true;
    }

    /// Collects the spheres that `b` builds on: those of finished neighbors, with their sites in
    /// `b`, and existing ones.
    void collectAround(std::uint32_t b, BlockSpheres<Dim>& around) const {
        const Box<Dim> reach = reachOf(b);
        around.clear();
        const BlockSpheres<Dim>& existing = blocks_[b].existing;
        for (const auto& n : lattice.lowerNeighbors(b)) {
            const std::uint32_t here = neighborBit(n.offset);
            const BlockSpheres<Dim>& placed = blocks_[n.block].placed;
            const Vec<Dim> shift = cell.shift(n.laps);
            auto site = placed.sites.begin();
            for (std::size_t i = 0; i < placed.spheres.size(); ++i) {
                const Vec<Dim> center = placed.spheres[i].center + shift;
                if (!reach.contains(center)) continue;
                const auto at = static_cast<std::uint32_t>(around.spheres.size());
                around.spheres.push_back({center, placed.spheres[i].radius});
                for (; site != placed.sites.end() && site->pivot <= i; ++site)
                    if (site->pivot == i && site->neighbor == here) {
                        around.sites.push_back(site->movedBy(shift));
                        around.sites.back().pivot = at;
                    }
            }
        }
        for (const std::uint32_t u : existing.unexplored)
            around.unexplored.push_back(u + static_cast<std::uint32_t>(around.spheres.size()));
        around.spheres.insert(around.spheres.end(), existing.spheres.begin(),
                              existing.spheres.end());
    }

    /// The spheres of block `b` in reach of others, and the sites on them that lie in those.
    BlockSpheres<Dim> inReachOf(std::uint32_t b, const std::vector<std::uint32_t>& readers) const {
        const BlockSpheres<Dim>& placed = blocks_[b].placed;
        BlockSpheres<Dim> some;
        std::vector<Box<Dim>> reaches;
        std::uint32_t bits = 0;
        // In a periodic cell a block may be the neighbor of another on two sides.
        for (const std::uint32_t s : readers)
            for (const auto& n : lattice.lowerNeighbors(s)) {
                if (n.block != b) continue;
                bits |= neighborBit(n.offset);
                Box<Dim> reach = reachOf(s);
                reach.lo -= cell.shift(n.laps);
                reach.hi -= cell.shift(n.laps);
                // Shifts round.
                reaches.push_back(cell.any() ? reach.grown(settings.quantum) : reach);
            }
        auto site = placed.sites.begin();
        for (std::size_t i = 0; i < placed.spheres.size(); ++i) {
            const bool near = std::any_of(reaches.begin(), reaches.end(), [&](const Box<Dim>& box) {
                return box.contains(placed.spheres[i].center);
            });
            const auto at = static_cast<std::uint32_t>(some.spheres.size());
            if (near) some.spheres.push_back(placed.spheres[i]);
            for (; site != placed.sites.end() && site->pivot <= i; ++site)
                if (near && site->pivot == i && (site->neighbor & bits) != 0) {
                    some.sites.push_back(*site);
                    some.sites.back().pivot = at;
                }
        }
        return some;
    }

private:
    /// Where a block grows and searches.
    Box<Dim> boxOf(std::uint32_t b) const {
        Box<Dim> box = lattice.own(b);
        const Box<Dim> search = lattice.search(b);
        for (int d = 0; d < Dim; ++d) box.lo[d] = std::min(box.lo[d], search.lo[d]);
        return box;
    }
    /// The largest radius in a block, mm.
    double maxRadiusOf(std::uint32_t b) const {
        return lengths_.empty() ? settings.maxRadius : lengths_[b].maxRadius;
    }

    /// What differs where sizes differ by place.
    void addLocal(const Domain<Dim>& domain) {
        const LocalBalls<Dim> balls(outer_, options_.sizes, options_.local);
        expected_ = 0.6 * domain.volume() / balls.mean(1, shellOf(options_));
        if (groups_.size() > 1)
            for (std::uint32_t g = 0; g < groups_.size(); ++g)
                expectedOf_.push_back(0.6 * domain.volume() * balls.groupShare(g));
        LocalLengths<Dim> local = localLengths();
        lengths_.reserve(lattice.size());
        for (std::uint32_t b = 0; b < lattice.size(); ++b) lengths_.push_back(local.over(boxOf(b)));
    }

    /// Points of a grid in a block that lie in the domain, as a share.
    /// @param across  points along each edge.
    static double shareInside(const Box<Dim>& own, int across, DomainSampler<Dim>& sampler) {
        const int points = across * across * (Dim == 3 ? across : 1);
        int inside = 0;
        for (int k = 0; k < points; ++k) {
            Vec<Dim> x = own.lo;
            for (int d = 0, rest = k; d < Dim; ++d, rest /= across)
                x[d] += own.size()[d] * (rest % across + 0.5) / across;
            inside += sampler.signedDistance(x) < 0 ? 1 : 0;
        }
        return static_cast<double>(inside) / points;
    }

    /// The share of a block that lies in the domain, about.
    static double shareInside(const Box<Dim>& own, DomainSampler<Dim>& sampler) {
        constexpr int kAcross = 4, kThin = 8;  // the part that lies inside may be thin
        const double share = shareInside(own, kAcross, sampler);
        const Vec<Dim> middle = (own.lo + own.hi) * 0.5;
        if (share > 0 || !sampler.isWallCloser(middle, 0.5 * length(own.size()))) return share;
        return shareInside(own, kThin, sampler);
    }

    /// About how many spheres are yet to be placed while each block is filled, there and in the
    /// blocks that get the pool afterwards.
    void countAhead(const Domain<Dim>& domain) {
        ahead_.assign(lattice.size(), 0);
        parallelFor(IndexRange(0, lattice.size(), 64), [&](const IndexRange& range) {
            const auto sampler = domain.sampler();
            for (std::size_t b = range.begin(); b != range.end(); ++b) {
                ahead_[b] = shareInside(lattice.own(static_cast<std::uint32_t>(b)), *sampler);
            }
        });
        donors_ = lattice.poolDonors(ahead_);
        const double inside = std::accumulate(ahead_.begin(), ahead_.end(), 0.0);
        for (double& count : ahead_) count *= expected_ / std::max(1e-9, inside);
        const std::vector<double> here = ahead_;
        for (auto b = lattice.order().rbegin(); b != lattice.order().rend(); ++b) {
            if (donors_[*b] != BlockLattice<Dim>::kNone) ahead_[donors_[*b]] += ahead_[*b];
            ahead_[*b] -= here[*b] / 2;  // half of its own, on average
        }
    }

    /// Gives existing spheres to the blocks in whose reach they are.
    void addExisting(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& existing) {
        const auto sampler = domain.sampler();
        for (const Sphere<Dim>& grown : obstacles(existing)) {
            // Spheres that touch a sphere inside are inside. Sites on those that are far larger
            // than the spheres there are found from the others.
            const double radius = grown.radius - shellOf(options_);
            const bool open = radius <= 2 * settings.maxRadius &&
                              !sampler->isWallCloser(grown.center, radius) &&
                              sampler->contains(grown.center);
            const double far = grown.radius + 2 * settings.maxRadius;
            const Box<Dim> at{grown.center, grown.center};
            cell.forEachShift(at, domain.bounds().grown(far), [&](const Vec<Dim>& shift) {
                const Vec<Dim> center = grown.center + shift;
                for (const std::uint32_t b :
                     lattice.blocksIn(Box<Dim>{center, center}.grown(far))) {
                    BlockSpheres<Dim>& here = blocks_[b].existing;
                    if (open)
                        here.unexplored.push_back(static_cast<std::uint32_t>(here.spheres.size()));
                    here.spheres.push_back({center, grown.radius});
                }
            });
        }
    }

    /// Existing spheres grown by the shell, without those that lie under others.
    std::vector<Sphere<Dim>> obstacles(std::vector<Sphere<Dim>> existing) const {
        if (existing.empty()) return existing;
        const double shell = shellOf(options_);
        for (Sphere<Dim>& s : existing) s = {cell.wrapped(s.center), s.radius + shell};
        constexpr double kRounded = 1 - 1e-6;  // radii drawn are floats
        return exposedSpheres(std::move(existing), kRounded * (leastRadius(options_) + shell));
    }

    /// Where a block meets spheres of others.
    Box<Dim> reachOf(std::uint32_t b) const {
        const Box<Dim> reach = boxOf(b);
        if (!lengths_.empty()) {
            double most = maxRadiusOf(b);
            for (const auto& n : lattice.lowerNeighbors(b))
                most = std::max(most, maxRadiusOf(n.block));
            return reach.grown(most + maxRadiusOf(b));
        }
        // Spheres of further species may lie across the upper faces of their block.
        return reach.grown((hasSpecies_ ? 3 : 2) * settings.maxRadius);
    }

    const Domain<Dim>& outer_;
    const PackOptions& options_;
    std::vector<FrontLengths> groups_;
    std::vector<FrontLengths> lengths_;  // of each block, where sizes differ by place
    std::vector<Block<Dim>> blocks_;
    double expected_ = 1;
    std::vector<std::uint32_t> donors_;  ///< BlockLattice::poolDonors
    std::vector<double> ahead_;          ///< of each block; see countAhead
    std::vector<double> expectedOf_;     // spheres of each of several groups of sizes
    bool hasSpecies_ = false;            ///< that are ever drawn
};

}  // namespace vdbpack
