#include "vdbpack/pack/wavefront.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/pack/block_lattice.h"
#include "vdbpack/pack/exposed.h"
#include "vdbpack/pack/front/block_front.h"
#include "vdbpack/pack/kernel_settings.h"
#include "vdbpack/pack/radius_pool.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>

namespace vdbpack {

namespace {

/// Blocks in the order of a wavefront: each is filled once those that it builds on are done.
template <int Dim>
class Wavefront {
public:
    Wavefront(const Domain<Dim>& domain, const PackOptions& options, const Callbacks& callbacks,
              const std::vector<Sphere<Dim>>& existing)
        : domain_(domain),
          options_(options),
          callbacks_(callbacks),
          settings_(frontSettings(domain, options)),
          lattice_(domain.bounds(), blockSide(domain, options, settings_), 2 * settings_.maxRadius,
                   settings_.quantum),
          blocks_(lattice_.size()) {
        addExisting(existing);
        for (const Species& species : options.species)
            hasSpecies_ = hasSpecies_ || species.probability > 0;
        cancelled_ = [this] { return isStopped(); };
        expected_ = 0.6 * domain.volume() / settings_.meanBall;
    }

    PackResult<Dim> run() {
        callbacks_.report("pack", 0, 0);
        std::vector<std::vector<std::uint32_t>> successors(lattice_.size());
        for (std::uint32_t b = 0; b < lattice_.size(); ++b) {
            auto before = lattice_.lowerNeighbors(b);
            const auto& donors = lattice_.poolDonors(b);
            before.insert(before.end(), donors.begin(), donors.end());
            std::sort(before.begin(), before.end());
            before.erase(std::unique(before.begin(), before.end()), before.end());
            blocks_[b].waiting.store(static_cast<int>(before.size()));
            for (const std::uint32_t p : before) successors[p].push_back(b);
        }
        successors_ = std::move(successors);
        withThreads(options_.threads, [&] {
            tbb::task_group group;
            group_ = &group;
            group.run([this] { process(lattice_.order().front()); });
            group.wait();
        });
        return collect();
    }

private:
    struct Block {
        std::atomic<int> waiting{0};
        BlockSpheres<Dim> existing;
        BlockSpheres<Dim> placed;
        std::unique_ptr<RadiusPool> pool;
        std::unique_ptr<SpeciesQueue> further;
    };
    struct Thread {
        std::unique_ptr<BlockFront<Dim>> front;
        std::unique_ptr<DomainSampler<Dim>> sampler;
        BlockSpheres<Dim> around;
    };

    /// Gives existing spheres to the blocks in whose reach they are.
    void addExisting(const std::vector<Sphere<Dim>>& existing) {
        const auto sampler = domain_.sampler();
        for (const Sphere<Dim>& grown : obstacles(existing)) {
            // Spheres that touch a sphere inside are inside. Sites on those that are far larger
            // than the spheres there are found from the others.
            const double radius = grown.radius - shellOf(options_);
            const bool open = radius <= 2 * settings_.maxRadius &&
                              !sampler->isWallCloser(grown.center, radius) &&
                              sampler->contains(grown.center);
            const double far = grown.radius + 2 * settings_.maxRadius;
            for (const std::uint32_t b :
                 lattice_.blocksIn(Box<Dim>{grown.center, grown.center}.grown(far))) {
                BlockSpheres<Dim>& here = blocks_[b].existing;
                if (open)
                    here.unexplored.push_back(static_cast<std::uint32_t>(here.spheres.size()));
                here.spheres.push_back(grown);
            }
        }
    }

    /// Existing spheres grown by the shell, without those that lie under others.
    std::vector<Sphere<Dim>> obstacles(std::vector<Sphere<Dim>> existing) const {
        if (existing.empty()) return existing;
        const double shell = shellOf(options_);
        for (Sphere<Dim>& s : existing) s.radius += shell;
        constexpr double kRounded = 1 - 1e-6;  // radii drawn are floats
        return exposedSpheres(std::move(existing), kRounded * (leastRadius(options_) + shell));
    }

    void process(std::uint32_t b) {
        for (;;) {
            if (!isStopped()) fillBlock(b);
            // One successor that became ready continues in this task: its neighborhood is in the
            // cache.
            std::uint32_t next = BlockLattice<Dim>::kNone;
            for (const std::uint32_t s : successors_[b])
                if (blocks_[s].waiting.fetch_sub(1) == 1) {
                    if (next != BlockLattice<Dim>::kNone)
                        group_->run([this, next] { process(next); });
                    next = s;
                }
            if (next == BlockLattice<Dim>::kNone) return;
            b = next;
        }
    }

    /// Moves the pending radii and due spheres of earlier blocks to block `b`.
    /// @return false if one of those was interrupted.
    bool takePools(std::uint32_t b) {
        Block& block = blocks_[b];
        for (const std::uint32_t donor : lattice_.poolDonors(b)) {
            if (!blocks_[donor].pool) return false;
            if (!block.pool) {
                block.pool = std::move(blocks_[donor].pool);
                block.further = std::move(blocks_[donor].further);
            } else {
                block.pool->absorb(*blocks_[donor].pool);
                if (block.further) block.further->absorb(*blocks_[donor].further);
            }
        }
        if (!block.pool)
            block.pool = std::make_unique<RadiusPool>(
                options_.sizes, options_.seed, b, poolCapacity(options_, false), shellOf(options_));
        if (!block.further && hasSpecies_)
            block.further = std::make_unique<SpeciesQueue>(options_.species, options_.seed, b,
                                                           shellOf(options_));
        block.pool->setCapacity(poolCapacity(options_, lattice_.endsPool(b)), settings_.wideRadius);
        return true;
    }

    /// Collects the spheres that `b` builds on: those of finished neighbors, with their sites in
    /// `b`, and existing ones.
    void collectAround(std::uint32_t b, const Box<Dim>& reach, BlockSpheres<Dim>& around) const {
        around.clear();
        const BlockSpheres<Dim>& existing = blocks_[b].existing;
        for (const std::uint32_t n : lattice_.lowerNeighbors(b)) {
            const std::uint32_t here = neighborBit(lattice_.offset(n, b));
            const BlockSpheres<Dim>& placed = blocks_[n].placed;
            auto site = placed.sites.begin();
            for (std::size_t i = 0; i < placed.spheres.size(); ++i) {
                if (!reach.contains(placed.spheres[i].center)) continue;
                const auto at = static_cast<std::uint32_t>(around.spheres.size());
                around.spheres.push_back(placed.spheres[i]);
                for (; site != placed.sites.end() && site->pivot <= i; ++site)
                    if (site->pivot == i && site->neighbor == here) {
                        around.sites.push_back(*site);
                        around.sites.back().pivot = at;
                    }
            }
        }
        for (const std::uint32_t u : existing.unexplored)
            around.unexplored.push_back(u + static_cast<std::uint32_t>(around.spheres.size()));
        around.spheres.insert(around.spheres.end(), existing.spheres.begin(),
                              existing.spheres.end());
    }

    void fillBlock(std::uint32_t b) {
        Thread& thread = threads_.local();
        if (!thread.front) {
            thread.front = std::make_unique<BlockFront<Dim>>(settings_);
            thread.sampler = domain_.sampler();
        }
        if (!takePools(b)) return;  // interrupted there
        Block& block = blocks_[b];
        const Box<Dim> own = lattice_.own(b);
        const Box<Dim> search = lattice_.search(b);
        Box<Dim> reach = own;
        for (int d = 0; d < Dim; ++d) reach.lo[d] = std::min(reach.lo[d], search.lo[d]);
        // Spheres of further species may lie across the upper faces of their block.
        reach = reach.grown((hasSpecies_ ? 3 : 2) * settings_.maxRadius);
        collectAround(b, reach, thread.around);
        thread.front->fill(own, search, thread.around, *block.pool, block.further.get(),
                           *thread.sampler, cancelled_, block.placed);
        // Spheres of an interrupted block are final as well: no neighbor has begun.
        report(block.placed.spheres.size());
    }

    /// Called from within blocks as well, since there may be just one. Callbacks are called one at
    /// a time: while another thread calls one, its answer serves the next time.
    bool isStopped() {
        if (stopped_.load(std::memory_order_relaxed)) return true;
        if (!callbacks_.cancelled) return false;
        const std::unique_lock<std::mutex> lock(reporting_, std::try_to_lock);
        if (lock.owns_lock() && callbacks_.isCancelled()) stopped_ = true;
        return stopped_;
    }

    void report(std::size_t placed) {
        const std::int64_t count = count_ += static_cast<std::int64_t>(placed);
        const std::lock_guard<std::mutex> lock(reporting_);
        callbacks_.report("pack", std::min(1.0, static_cast<double>(count) / expected_),
                          static_cast<double>(count));
        if (callbacks_.isCancelled()) stopped_ = true;
    }

    PackResult<Dim> collect() {
        PackResult<Dim> result;
        result.blocks = lattice_.size();
        result.firstBlock = lattice_.own(0);
        result.longestChain = lattice_.longestChain();
        result.quantum = settings_.quantum;
        result.interrupted = stopped_;
        for (auto& thread : threads_)
            if (thread.front) result.fronts += thread.front->seeds();
        auto& spheres = result.pack.spheres;
        std::size_t total = 0;
        for (const auto& block : blocks_) total += block.placed.spheres.size();
        spheres.reserve(total);
        for (const std::uint32_t b : lattice_.order()) {
            const BlockSpheres<Dim>& placed = blocks_[b].placed;
            spheres.insert(spheres.end(), placed.spheres.begin(), placed.spheres.end());
            result.species.insert(result.species.end(), placed.species.begin(),
                                  placed.species.end());
            blocks_[b].placed = {};
        }
        if (const double shell = shellOf(options_); shell > 0)
            // Back to the float that was drawn.
            for (Sphere<Dim>& s : spheres)
                s.radius = static_cast<double>(static_cast<float>(s.radius - shell));
        if (options_.maxCount > 0 && spheres.size() > static_cast<std::size_t>(options_.maxCount))
            spheres.resize(static_cast<std::size_t>(options_.maxCount));
        if (!options_.species.empty()) result.species.resize(spheres.size());
        result.pack.order.resize(spheres.size());
        for (std::size_t i = 0; i < spheres.size(); ++i)
            result.pack.order[i] = static_cast<std::int64_t>(i);
        return result;
    }

    const Domain<Dim>& domain_;
    const PackOptions& options_;
    const Callbacks& callbacks_;
    FrontSettings<Dim> settings_;
    BlockLattice<Dim> lattice_;
    std::vector<Block> blocks_;
    std::vector<std::vector<std::uint32_t>> successors_;
    tbb::enumerable_thread_specific<Thread> threads_;
    tbb::task_group* group_ = nullptr;
    std::function<bool()> cancelled_;
    std::atomic<bool> stopped_{false};
    std::atomic<std::int64_t> count_{0};
    std::mutex reporting_;
    double expected_ = 1;
    bool hasSpecies_ = false;  ///< that are ever drawn
};

}  // namespace

template <int Dim>
PackResult<Dim> packBlocks(const Domain<Dim>& domain, const PackOptions& options,
                           const Callbacks& callbacks, const std::vector<Sphere<Dim>>& existing) {
    return Wavefront<Dim>(domain, options, callbacks, existing).run();
}

template PackResult<2> packBlocks(const Domain<2>&, const PackOptions&, const Callbacks&,
                                  const std::vector<Sphere<2>>&);
template PackResult<3> packBlocks(const Domain<3>&, const PackOptions&, const Callbacks&,
                                  const std::vector<Sphere<3>>&);

}  // namespace vdbpack
