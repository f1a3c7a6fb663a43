#include "vdbpack/pack/wavefront.h"

#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/pack/block_message.h"
#include "vdbpack/pack/blocks.h"

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
          options_(options),
          callbacks_(callbacks),
          blocks_(domain, outer, options, existing),
          lattice_(blocks_.lattice),
          ranks_(options.ranks) {
        cancelled_ = [this] { return isStopped(); };
    }

    PackResult<Dim> run() {
        callbacks_.report("pack", 0, 0);
        successors_.resize(lattice_.size());
        for (std::uint32_t b = 0; b < lattice_.size(); ++b) {
            std::vector<std::uint32_t> before;
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
    struct Thread {
        std::unique_ptr<BlockFront<Dim>> front;
        std::unique_ptr<DomainSampler<Dim>> sampler;
        std::unique_ptr<LocalLengths<Dim>> local;
        BlockSpheres<Dim> around;
    };

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
        tbb::concurrent_priority_queue<std::uint32_t, std::greater<>> ready;
        begin_ = [&](std::uint32_t b) {
            ready.push(lattice_.place(b));
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
        Block<Dim>& block = blocks_[b];
        for (const auto& [to, blocks] : readers) {
            BlockMessage<Dim> message;
            message.block = b;
            message.stopped = stopped_;
            message.placed = blocks_.inReachOf(b, blocks);
            for (const std::uint32_t s : blocks) {
                if (block.pools.empty() || blocks_.donorOf(s) != b) continue;
                message.pools.clear();
                for (const RadiusPool& pool : block.pools) message.pools.push_back(pool.state());
                if (block.further) message.further = block.further->state();
            }
            outbox_.push({to, toBytes(message)});
        }
        if (!readers.empty()) posted_.notify_one();
    }

    /// Takes in what another rank tells of one of its blocks.
    void take(BlockMessage<Dim> message) {
        Block<Dim>& block = blocks_[message.block];
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

    void fillBlock(std::uint32_t b) {
        Thread& thread = threads_.local();
        if (!thread.front) {
            thread.front = std::make_unique<BlockFront<Dim>>(blocks_.settings);
            thread.sampler = domain_.sampler();
            if (options_.local.any())
                thread.local = std::make_unique<LocalLengths<Dim>>(blocks_.localLengths());
        }
        if (!blocks_.takePools(b)) return;  // interrupted there
        Block<Dim>& block = blocks_[b];
        blocks_.collectAround(b, thread.around);
        thread.front->fill(blocks_.place(b, thread.local.get()), thread.around, block.pools,
                           block.further.get(), *thread.sampler, cancelled_, block.placed);
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
        callbacks_.report("pack", std::min(1.0, all / blocks_.expected()), all);
        if (callbacks_.isCancelled()) stopped_ = true;
    }

    PackResult<Dim> collect() {
        PackResult<Dim> result;
        result.blocks = lattice_.size();
        result.firstBlock = lattice_.own(0);
        result.longestChain = lattice_.longestChain();
        result.quantum = blocks_.settings.quantum;
        result.pack.cell = blocks_.cell;
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

    const Domain<Dim>& domain_;
    const PackOptions& options_;
    const Callbacks& callbacks_;
    Blocks<Dim> blocks_;
    const BlockLattice<Dim>& lattice_;
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
