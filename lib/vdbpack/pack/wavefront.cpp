#include "vdbpack/pack/wavefront.h"

#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/pack/block_lattice.h"
#include "vdbpack/pack/block_message.h"
#include "vdbpack/pack/exposed.h"
#include "vdbpack/pack/front/block_front.h"
#include "vdbpack/pack/kernel_settings.h"
#include "vdbpack/pack/radius_pool.h"

#include <tbb/concurrent_priority_queue.h>
#include <tbb/concurrent_queue.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <map>
#include <memory>
#include <mutex>

namespace vdbpack {

namespace {

/// Blocks in the order of a wavefront: each is filled once those that it builds on are done.
template <int Dim>
class Wavefront {
public:
    Wavefront(const Domain<Dim>& domain, const Domain<Dim>& outer, const PackOptions& options,
              const Callbacks& callbacks, const std::vector<Sphere<Dim>>& existing)
        : domain_(domain),
          outer_(outer),
          options_(options),
          callbacks_(callbacks),
          settings_(frontSettings(domain, options)),
          groups_(frontLengths<Dim>(options)),
          cell_(domain.cell()),
          lattice_(domain.bounds(), blockSide(domain, options, settings_), 2 * settings_.maxRadius,
                   settings_.quantum, cell_),
          blocks_(lattice_.size()),
          ranks_(options.ranks) {
        addExisting(existing);
        for (const Species& species : options.species)
            hasSpecies_ = hasSpecies_ || species.probability > 0;
        cancelled_ = [this] { return isStopped(); };
        expected_ = 0.6 * domain.volume() / settings_.meanBall;
        if (!options.local.any()) return;
        const LocalBalls<Dim> balls(outer, options.sizes, options.local);
        expected_ = 0.6 * domain.volume() / balls.mean(1, shellOf(options));
        if (groups_.size() > 1)
            for (std::uint32_t g = 0; g < groups_.size(); ++g)
                expectedOf_.push_back(0.6 * domain.volume() * balls.groupShare(g));
        findLengths();
    }

    PackResult<Dim> run() {
        callbacks_.report("pack", 0, 0);
        successors_.resize(lattice_.size());
        for (std::uint32_t b = 0; b < lattice_.size(); ++b) {
            std::vector<std::uint32_t> before = lattice_.poolDonors(b);
            for (const auto& n : lattice_.lowerNeighbors(b)) before.push_back(n.block);
            std::sort(before.begin(), before.end());
            before.erase(std::unique(before.begin(), before.end()), before.end());
            blocks_[b].waiting.store(static_cast<int>(before.size()));
            for (const std::uint32_t p : before) successors_[p].push_back(b);
            if (isOwn(b))
                for (const auto& n : lattice_.lowerNeighbors(b)) ++blocks_[n.block].readers;
        }
        if (ranks_) {
            fillWithOthers();
        } else {
            withThreads(options_.threads, [&] {
                tbb::task_group group;
                begin_ = [&](std::uint32_t b) { group.run([this, b] { process(b); }); };
                begin_(lattice_.order().front());
                group.wait();
            });
        }
        return collect();
    }

private:
    struct Block {
        std::atomic<int> waiting{0};
        std::atomic<int> readers{0};  // own blocks that are yet to build on it
        BlockSpheres<Dim> existing;
        BlockSpheres<Dim> placed;
        std::vector<RadiusPool> pools;  // empty once they have gone to another block
        std::unique_ptr<SpeciesQueue> further;
    };
    struct Thread {
        std::unique_ptr<BlockFront<Dim>> front;
        std::unique_ptr<DomainSampler<Dim>> sampler;
        std::unique_ptr<LocalLengths<Dim>> local;
        BlockSpheres<Dim> around;
    };

    LocalLengths<Dim> localLengths() const {
        return {outer_, options_.local, groups_, shellOf(options_)};
    }
    /// Where sizes differ by place: the lengths of each block.
    void findLengths() {
        LocalLengths<Dim> local = localLengths();
        lengths_.reserve(lattice_.size());
        for (std::uint32_t b = 0; b < lattice_.size(); ++b) {
            Box<Dim> box = lattice_.own(b);
            const Box<Dim> search = lattice_.search(b);
            for (int d = 0; d < Dim; ++d) box.lo[d] = std::min(box.lo[d], search.lo[d]);
            lengths_.push_back(local.over(box));
        }
    }
    /// The largest radius in a block, mm.
    double maxRadiusOf(std::uint32_t b) const {
        return lengths_.empty() ? settings_.maxRadius : lengths_[b].maxRadius;
    }

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
            const Box<Dim> at{grown.center, grown.center};
            cell_.forEachShift(at, domain_.bounds().grown(far), [&](const Vec<Dim>& shift) {
                const Vec<Dim> center = grown.center + shift;
                for (const std::uint32_t b :
                     lattice_.blocksIn(Box<Dim>{center, center}.grown(far))) {
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
        for (Sphere<Dim>& s : existing) s = {cell_.wrapped(s.center), s.radius + shell};
        constexpr double kRounded = 1 - 1e-6;  // radii drawn are floats
        return exposedSpheres(std::move(existing), kRounded * (leastRadius(options_) + shell));
    }

    bool isOwn(std::uint32_t b) const { return ownerOf(b) == rank(); }
    int ownerOf(std::uint32_t b) const { return ranks_ ? lattice_.owner(b, ranks_->count()) : 0; }
    int rank() const { return ranks_ ? ranks_->rank() : 0; }

    void process(std::uint32_t b) {
        for (;;) {
            if (ranks_)
                fillOrFail(b);
            else if (!isStopped())
                fillBlock(b);
            if (ranks_) tellOthers(b);
            for (const auto& n : lattice_.lowerNeighbors(b))
                if (blocks_[n.block].readers.fetch_sub(1) == 1) forget(n.block);
            // One successor that became ready continues in this task: its neighborhood is in the
            // cache.
            const std::uint32_t next = release(b);
            ++filled_;
            if (next == BlockLattice<Dim>::kNone) return;
            if (ranks_) return begin_(next);
            b = next;
        }
    }

    /// Frees what of block `b` no other builds on any more.
    void forget(std::uint32_t b) {
        if (isOwn(b))
            std::vector<HandedSite<Dim>>().swap(blocks_[b].placed.sites);
        else
            blocks_[b].placed = {};
    }

    /// Begins the own blocks that waited for `b` alone, but for one. @return that one, or none
    std::uint32_t release(std::uint32_t b) {
        std::uint32_t next = BlockLattice<Dim>::kNone;
        for (const std::uint32_t s : successors_[b])
            if (isOwn(s) && blocks_[s].waiting.fetch_sub(1) == 1) {
                if (next != BlockLattice<Dim>::kNone) begin_(next);
                next = s;
            }
        return next;
    }

    /// Fills the own blocks while other ranks fill theirs; this thread alone sends and receives.
    void fillWithOthers() {
        const int threads =
            options_.threads > 0 ? options_.threads : tbb::info::default_concurrency();
        const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism,
                                          static_cast<std::size_t>(threads) + 1);
        tbb::task_arena arena(threads, 0);
        // Those first that come first in the order: others wait for them the longest.
        std::vector<std::uint32_t> place(lattice_.size());
        for (std::uint32_t k = 0; k < lattice_.size(); ++k) place[lattice_.order()[k]] = k;
        tbb::concurrent_priority_queue<std::uint32_t, std::greater<>> ready;
        begin_ = [&](std::uint32_t b) {
            ready.push(place[b]);
            arena.enqueue([&] {
                std::uint32_t first = 0;
                if (ready.try_pop(first)) process(lattice_.order()[first]);
            });
        };
        std::size_t own = 0;
        for (std::uint32_t b = 0; b < lattice_.size(); ++b) own += isOwn(b);
        const std::uint32_t first = lattice_.order().front();
        if (isOwn(first)) begin_(first);
        constexpr int kLeastPause = 50, kMostPause = 400;  // microseconds; a block takes 10,000
        int pause = kLeastPause;
        for (;;) {
            const bool done = filled_ == own;
            bool busy = false;
            std::pair<int, std::vector<std::byte>> out;
            while (outbox_.try_pop(out)) {
                ranks_->send(out.first, std::move(out.second));
                busy = true;
            }
            if (done && !busy) break;
            std::vector<std::byte> bytes;
            while (ranks_->receive(bytes)) {
                take(blockMessage<Dim>(bytes));
                busy = true;
            }
            // Looking for messages takes time from the threads that fill blocks.
            using Microseconds = std::chrono::microseconds;
            pause = busy ? kLeastPause : std::min(2 * pause, kMostPause);
            std::unique_lock<std::mutex> lock(posting_);
            if (!busy)
                posted_.wait_for(lock, Microseconds(pause), [&] { return !outbox_.empty(); });
        }
        if (failure_) std::rethrow_exception(failure_);
    }

    /// A block that fails counts as stopped, so that all ranks come to their ends.
    void fillOrFail(std::uint32_t b) {
        try {
            if (!isStopped()) fillBlock(b);
        } catch (...) {
            fail(std::current_exception());
        }
    }

    void fail(std::exception_ptr failure) {
        const std::lock_guard<std::mutex> lock(reporting_);
        if (!failure_) failure_ = std::move(failure);
        stopped_ = true;
    }

    /// What of block `b` the ranks need whose blocks build on it.
    void tellOthers(std::uint32_t b) {
        std::map<int, BlockMessage<Dim>> messages;
        std::map<int, std::vector<std::uint32_t>> readers;
        for (const std::uint32_t s : successors_[b])
            if (!isOwn(s)) readers[ownerOf(s)].push_back(s);
        Block& block = blocks_[b];
        for (const auto& [to, blocks] : readers) {
            BlockMessage<Dim> message;
            message.block = b;
            message.stopped = stopped_;
            message.placed = inReachOf(b, blocks);
            for (const std::uint32_t s : blocks) {
                const auto& donors = lattice_.poolDonors(s);
                if (block.pools.empty() ||
                    std::find(donors.begin(), donors.end(), b) == donors.end())
                    continue;
                message.pools.clear();
                for (const RadiusPool& pool : block.pools) message.pools.push_back(pool.state());
                if (block.further) message.further = block.further->state();
            }
            outbox_.push({to, toBytes(message)});
        }
        if (!readers.empty()) posted_.notify_one();
    }

    /// The spheres of block `b` in reach of others, and the sites on them that lie in those.
    BlockSpheres<Dim> inReachOf(std::uint32_t b, const std::vector<std::uint32_t>& readers) const {
        const BlockSpheres<Dim>& placed = blocks_[b].placed;
        BlockSpheres<Dim> some;
        std::vector<Box<Dim>> reaches;
        std::uint32_t bits = 0;
        // In a periodic cell a block may be the neighbor of another on two sides. Of a row that
        // takes over the pool alone, no block is a neighbor.
        for (const std::uint32_t s : readers)
            for (const auto& n : lattice_.lowerNeighbors(s)) {
                if (n.block != b) continue;
                bits |= neighborBit(n.offset);
                Box<Dim> reach = reachOf(s);
                reach.lo -= cell_.shift(n.laps);
                reach.hi -= cell_.shift(n.laps);
                // Shifts round.
                reaches.push_back(cell_.any() ? reach.grown(settings_.quantum) : reach);
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

    /// Takes in what another rank tells of one of its blocks.
    void take(BlockMessage<Dim> message) {
        Block& block = blocks_[message.block];
        block.placed = std::move(message.placed);
        if (!message.pools.empty()) {
            block.pools = radiusPools(options_, message.block);
            for (std::size_t g = 0; g < block.pools.size(); ++g)
                block.pools[g].restore(std::move(message.pools[g]));
        }
        if (message.further) {
            block.further = std::make_unique<SpeciesQueue>(options_.species, options_.seed,
                                                           message.block, shellOf(options_));
            block.further->restore(*message.further);
        }
        if (message.stopped) stopped_ = true;
        const std::uint32_t next = release(message.block);
        if (next != BlockLattice<Dim>::kNone) begin_(next);
    }

    /// Where a block meets spheres of others.
    Box<Dim> reachOf(std::uint32_t b) const {
        Box<Dim> reach = lattice_.own(b);
        const Box<Dim> search = lattice_.search(b);
        for (int d = 0; d < Dim; ++d) reach.lo[d] = std::min(reach.lo[d], search.lo[d]);
        if (!lengths_.empty()) {
            double most = maxRadiusOf(b);
            for (const auto& n : lattice_.lowerNeighbors(b))
                most = std::max(most, maxRadiusOf(n.block));
            return reach.grown(most + maxRadiusOf(b));
        }
        // Spheres of further species may lie across the upper faces of their block.
        return reach.grown((hasSpecies_ ? 3 : 2) * settings_.maxRadius);
    }

    /// Moves the pending radii and due spheres of earlier blocks to block `b`.
    /// @return false if one of those was interrupted.
    bool takePools(std::uint32_t b) {
        Block& block = blocks_[b];
        for (const std::uint32_t donor : lattice_.poolDonors(b)) {
            if (blocks_[donor].pools.empty()) return false;
            if (block.pools.empty()) {
                block.pools = std::move(blocks_[donor].pools);
                block.further = std::move(blocks_[donor].further);
            } else {
                for (std::size_t g = 0; g < block.pools.size(); ++g)
                    block.pools[g].absorb(blocks_[donor].pools[g]);
                if (block.further) block.further->absorb(*blocks_[donor].further);
            }
        }
        if (block.pools.empty()) block.pools = radiusPools(options_, b);
        if (!block.further && hasSpecies_)
            block.further = std::make_unique<SpeciesQueue>(options_.species, options_.seed, b,
                                                           shellOf(options_));
        const std::size_t pending = poolCapacity(options_, lattice_.endsPool(b));
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
    void collectAround(std::uint32_t b, const Box<Dim>& reach, BlockSpheres<Dim>& around) const {
        around.clear();
        const BlockSpheres<Dim>& existing = blocks_[b].existing;
        for (const auto& n : lattice_.lowerNeighbors(b)) {
            const std::uint32_t here = neighborBit(n.offset);
            const BlockSpheres<Dim>& placed = blocks_[n.block].placed;
            const Vec<Dim> shift = cell_.shift(n.laps);
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

    void fillBlock(std::uint32_t b) {
        Thread& thread = threads_.local();
        if (!thread.front) {
            thread.front = std::make_unique<BlockFront<Dim>>(settings_);
            thread.sampler = domain_.sampler();
            if (options_.local.any())
                thread.local = std::make_unique<LocalLengths<Dim>>(localLengths());
        }
        if (!takePools(b)) return;  // interrupted there
        Block& block = blocks_[b];
        collectAround(b, reachOf(b), thread.around);
        thread.front->fill({lattice_.own(b), lattice_.search(b), lattice_.laterBehind(b),
                            lengths_.empty() ? nullptr : &lengths_[b], thread.local.get()},
                           thread.around, block.pools, block.further.get(), *thread.sampler,
                           cancelled_, block.placed);
        // They stay to the end.
        block.placed.spheres.shrink_to_fit();
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
        // Ranks advance together.
        const auto all = static_cast<double>(count * (ranks_ ? ranks_->count() : 1));
        callbacks_.report("pack", std::min(1.0, all / expected_), all);
        if (callbacks_.isCancelled()) stopped_ = true;
    }

    PackResult<Dim> collect() {
        PackResult<Dim> result;
        result.blocks = lattice_.size();
        result.firstBlock = lattice_.own(0);
        result.longestChain = lattice_.longestChain();
        result.quantum = settings_.quantum;
        result.pack.cell = cell_;
        for (auto& thread : threads_)
            if (thread.front) result.fronts += thread.front->seeds();
        auto& spheres = result.pack.spheres;
        std::vector<std::uint64_t> counts(blocks_.size() + 1);
        std::size_t total = 0;
        for (std::uint32_t b = 0; b < blocks_.size(); ++b)
            if (isOwn(b)) total += counts[b] = blocks_[b].placed.spheres.size();
        counts.back() = stopped_;
        if (ranks_) ranks_->sum(counts);
        result.interrupted = counts.back() > 0;
        spheres.reserve(total);
        result.pack.order.reserve(total);
        constexpr std::size_t kReturnedAtOnce = std::size_t{1} << 26;  // bytes
        std::size_t freed = 0;
        std::int64_t order = 0;
        for (const std::uint32_t b : lattice_.order()) {
            const std::int64_t first = order;
            if (ranks_) result.pieces.push_back(first);
            order += static_cast<std::int64_t>(counts[b]);
            if (!isOwn(b)) continue;
            for (std::int64_t i = first; i < order; ++i) result.pack.order.push_back(i);
            const BlockSpheres<Dim>& placed = blocks_[b].placed;
            spheres.insert(spheres.end(), placed.spheres.begin(), placed.spheres.end());
            result.species.insert(result.species.end(), placed.species.begin(),
                                  placed.species.end());
            freed += placed.spheres.size() * sizeof(Sphere<Dim>);
            blocks_[b].placed = {};
            if (freed < kReturnedAtOnce) continue;
            returnFreedMemory();
            freed = 0;
        }
        if (ranks_) result.pieces.push_back(order);
        if (options_.maxCount > 0)
            for (std::int64_t& piece : result.pieces) piece = std::min(piece, options_.maxCount);
        if (const double shell = shellOf(options_); shell > 0)
            // Back to the float that was drawn.
            for (Sphere<Dim>& s : spheres)
                s.radius = static_cast<double>(static_cast<float>(s.radius - shell));
        auto& numbers = result.pack.order;
        if (options_.maxCount > 0)
            numbers.erase(std::lower_bound(numbers.begin(), numbers.end(), options_.maxCount),
                          numbers.end());
        spheres.resize(numbers.size());
        if (!options_.species.empty()) result.species.resize(spheres.size());
        return result;
    }

    const Domain<Dim>&domain_, &outer_;
    const PackOptions& options_;
    const Callbacks& callbacks_;
    FrontSettings<Dim> settings_;
    std::vector<FrontLengths> groups_;
    std::vector<FrontLengths> lengths_;  // of each block, where sizes differ by place
    PeriodicCell<Dim> cell_;
    BlockLattice<Dim> lattice_;
    std::vector<Block> blocks_;
    std::vector<std::vector<std::uint32_t>> successors_;
    tbb::enumerable_thread_specific<Thread> threads_;
    std::function<void(std::uint32_t)> begin_;  // starts a block whose neighbors are done
    Ranks* const ranks_;                        // null: this one fills all blocks
    tbb::concurrent_queue<std::pair<int, std::vector<std::byte>>> outbox_;
    std::mutex posting_;
    std::condition_variable posted_;      // to the outbox
    std::atomic<std::size_t> filled_{0};  // own blocks that are filled, and told of
    std::exception_ptr failure_;
    std::function<bool()> cancelled_;
    std::atomic<bool> stopped_{false};
    std::atomic<std::int64_t> count_{0};
    std::mutex reporting_;
    double expected_ = 1;
    std::vector<double> expectedOf_{};  // spheres of each of several groups of sizes
    bool hasSpecies_ = false;           ///< that are ever drawn
};

}  // namespace

template <int Dim>
PackResult<Dim> packBlocks(const Domain<Dim>& domain, const Domain<Dim>& outer,
                           const PackOptions& options, const Callbacks& callbacks,
                           const std::vector<Sphere<Dim>>& existing) {
    return Wavefront<Dim>(domain, outer, options, callbacks, existing).run();
}

template PackResult<2> packBlocks(const Domain<2>&, const Domain<2>&, const PackOptions&,
                                  const Callbacks&, const std::vector<Sphere<2>>&);
template PackResult<3> packBlocks(const Domain<3>&, const Domain<3>&, const PackOptions&,
                                  const Callbacks&, const std::vector<Sphere<3>>&);

}  // namespace vdbpack
