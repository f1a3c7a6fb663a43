#include "bench_ranks.h"

#include "bench_clock.h"

#include "vdbpack/core/ranks.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/pack/block_lattice.h"
#include "vdbpack/pack/kernel_settings.h"
#include "vdbpack/pack/packer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <queue>
#include <thread>
#include <utility>
#include <vector>

using namespace vdbpack;

namespace {

constexpr double kSide = 200;  // of the paper's cube, mm

PackOptions cubeOptions(int threads, double edge = 0) {
    PackOptions options(SizeDistribution::parse("uniform:1,2", 3));
    options.threads = threads;
    options.blockSide = edge;
    return options;
}

std::shared_ptr<const Domain<3>> cube(double side) {
    return boxDomain<3>({{}, {{side, side, side}}});
}

/// The blocks of a cube with those options, as the packer lays them out.
BlockLattice<3> latticeOf(double side, const PackOptions& options) {
    const auto domain = cube(side);
    const auto settings = frontSettings<3>(*domain, options);
    return {domain->bounds(), blockSide<3>(*domain, options, settings), 2 * settings.maxRadius,
            settings.quantum};
}

/// Counts what another connection sends.
class CountedRanks : public Ranks {
public:
    explicit CountedRanks(Ranks& counted) : ranks_(counted) {}
    int rank() const override { return ranks_.rank(); }
    int count() const override { return ranks_.count(); }
    void send(int to, Bytes message) override {
        ++messages;
        bytes += message.size();
        ranks_.send(to, std::move(message));
    }
    bool receive(Bytes& message) override { return ranks_.receive(message); }
    void sum(std::vector<std::uint64_t>& numbers) override { ranks_.sum(numbers); }
    std::vector<Bytes> exchange(std::vector<Bytes> toEach) override {
        return ranks_.exchange(std::move(toEach));
    }
    std::uint64_t messages = 0, bytes = 0;

private:
    Ranks& ranks_;
};

/// Times of the blocks of a cube on one thread, s, and what was packed.
struct BlockTimes {
    std::vector<double> seconds;
    double total = 0, mean = 0, spread = 0;  // s, s, share of the mean
    double spheres = 0, solidFraction = 0;
};

BlockTimes measureBlocks(double side, double edge) {
    const auto domain = cube(side);
    BlockTimes times;
    double last = now();
    Callbacks callbacks;
    callbacks.progress = [&](const Progress& p) {  // after each block
        const double at = now();
        if (p.count > 0) times.seconds.push_back(at - last);
        last = at;
    };
    times.total = secondsOf([&] {
        const auto pack = packSpheres(*domain, cubeOptions(1, edge), callbacks).pack;
        times.spheres = static_cast<double>(pack.spheres.size());
        for (const auto& s : pack.spheres) times.solidFraction += Measure<3>::ball(s.radius);
    });
    times.solidFraction /= domain->volume();
    for (const double s : times.seconds) times.mean += s;
    times.mean /= static_cast<double>(times.seconds.size());
    for (const double s : times.seconds) times.spread += (s - times.mean) * (s - times.mean);
    times.spread = std::sqrt(times.spread / static_cast<double>(times.seconds.size())) / times.mean;
    return times;
}

/// The time that ranks take for all blocks, in times of a mean block.
class Schedule {
public:
    explicit Schedule(const BlockLattice<3>& lattice)
        : lattice_(lattice), successors_(lattice.size()), before_(lattice.size()) {
        for (std::uint32_t b = 0; b < lattice.size(); ++b) {
            std::vector<std::uint32_t> lower;
            for (const auto& n : lattice.lowerNeighbors(b)) lower.push_back(n.block);
            std::sort(lower.begin(), lower.end());
            lower.erase(std::unique(lower.begin(), lower.end()), lower.end());
            before_[b] = static_cast<std::uint16_t>(lower.size());
            for (const std::uint32_t p : lower) successors_[p].push_back(b);
        }
    }

    /// List scheduling: a free thread takes the block of its rank that comes first in the order.
    /// @param times  of blocks, in times of a mean block; taken in turn.
    /// @param latency  of a message, in the same.
    double run(int ranks, int threads, const std::vector<double>& times, double latency) const {
        struct Event {
            double at;
            std::uint32_t block;
            bool isEnd;  // or it may begin
            bool operator>(const Event& other) const { return at > other.at; }
        };
        using Waiting = std::priority_queue<std::uint32_t, std::vector<std::uint32_t>,
                                            std::greater<>>;  // places of blocks that may begin
        std::priority_queue<Event, std::vector<Event>, std::greater<>> events;
        std::vector<Waiting> waiting(static_cast<std::size_t>(ranks));
        std::vector<int> idle(static_cast<std::size_t>(ranks), threads);
        std::vector<std::uint16_t> left = before_;
        std::vector<float> ready(lattice_.size());
        double end = 0;
        const auto begin = [&](std::size_t rank, double at) {
            while (idle[rank] > 0 && !waiting[rank].empty()) {
                const std::uint32_t place = waiting[rank].top();
                waiting[rank].pop();
                --idle[rank];
                events.push({at + times[place % times.size()], lattice_.order()[place], true});
            }
        };
        events.push({0, lattice_.order().front(), false});
        while (!events.empty()) {
            const Event event = events.top();
            events.pop();
            const int owner = lattice_.owner(event.block, ranks);
            const auto rank = static_cast<std::size_t>(owner);
            if (!event.isEnd) {
                waiting[rank].push(lattice_.place(event.block));
                begin(rank, event.at);
                continue;
            }
            end = event.at;
            ++idle[rank];
            for (const std::uint32_t s : successors_[event.block]) {
                const bool here = lattice_.owner(s, ranks) == owner;
                const double known = event.at + (here ? 0 : latency);
                ready[s] = std::max(ready[s], static_cast<float>(known));
                if (--left[s] == 0)
                    events.push({std::max(event.at, static_cast<double>(ready[s])), s, false});
            }
            begin(rank, event.at);
        }
        return end;
    }

private:
    const BlockLattice<3>& lattice_;
    std::vector<std::vector<std::uint32_t>> successors_;
    std::vector<std::uint16_t> before_;
};

/// Half the time that a message takes there and back between the first two ranks, s.
double latencyOf(Ranks& ranks) {
    constexpr int kTimes = 200;
    const Ranks::Bytes message(90'000);
    const auto wait = [&] {
        Ranks::Bytes bytes;
        while (!ranks.receive(bytes)) std::this_thread::sleep_for(std::chrono::microseconds(20));
    };
    const double seconds = secondsOf([&] {
        for (int k = 0; k < kTimes && ranks.rank() < 2; ++k) {
            if (ranks.rank() == 0) ranks.send(1, message);
            wait();
            if (ranks.rank() == 1) ranks.send(0, message);
        }
    });
    return gathered(&ranks, std::vector<double>{0.5 * seconds / kTimes}).front().front();
}

}  // namespace

namespace {

std::vector<double> inMeans(const BlockTimes& times) {
    std::vector<double> shares;
    for (const double s : times.seconds) shares.push_back(s / times.mean);
    return shares;
}

/// Efficiency for cubes of so many spheres on so many cores, against one core with usual blocks.
void printTable(const BlockTimes& times, const BlockTimes& usual, double edge, double most) {
    constexpr int kThreads = 16;
    constexpr double kLatency = 100e-6;
    const std::array<int, 5> cores{16, 64, 256, 1024, 4096};
    const double perSphere = times.total / times.spheres;
    fmt::print("\nblocks of {:.1f} mm: efficiency by cores, predicted\n",
               latticeOf(kSide, cubeOptions(1, edge)).own(0).size()[0]);
    fmt::print("{:>9} {:>10} {:>8}", "spheres", "blocks", "chain");
    for (const int c : cores) fmt::print(" {:>6}", c);
    fmt::print("\n");
    for (double count = 1e8; count <= most; count *= 10) {
        const double side = kSide * std::cbrt(count / times.spheres);
        const auto lattice = latticeOf(side, cubeOptions(1, edge));
        const Schedule schedule(lattice);
        const double alone =
            static_cast<double>(lattice.size()) * usual.total / usual.spheres / perSphere;
        fmt::print("{:>9.0e} {:>10} {:>8}", count, lattice.size(), lattice.longestChain());
        for (const int c : cores) {
            const double span =
                schedule.run(c / kThreads, kThreads, inMeans(times), kLatency / times.mean);
            fmt::print(" {:>6.2f}", alone / (span * c));
            std::fflush(stdout);
        }
        fmt::print("\n");
    }
}

void benchAlone(bool quick) {
    fmt::print("cube of {:.0f} mm, radii 1 to 2 mm, one thread\n", kSide);
    fmt::print("{:>9} {:>8} {:>13} {:>9} {:>8} {:>14} {:>16}\n", "edge, mm", "blocks",
               "spheres each", "ms each", "spread", "solid fraction", "us per sphere");
    const std::array<double, 4> edges{0, 29, 22, 16};
    std::vector<BlockTimes> times;
    for (const double edge : edges) {
        times.push_back(measureBlocks(kSide, edge));
        const BlockTimes& t = times.back();
        const auto lattice = latticeOf(kSide, cubeOptions(1, edge));
        fmt::print("{:>9.1f} {:>8} {:>13.0f} {:>9.2f} {:>8.2f} {:>14.4f} {:>16.2f}\n",
                   lattice.own(0).size()[0], lattice.size(),
                   t.spheres / static_cast<double>(lattice.size()), 1e3 * t.mean, t.spread,
                   t.solidFraction, 1e6 * t.total / t.spheres);
    }
    fmt::print(
        "\nmodel: ranks of 16 threads, a message takes 0.1 ms; efficiency against one core "
        "with blocks of {:.0f} mm\n",
        latticeOf(kSide, cubeOptions(1)).own(0).size()[0]);
    for (std::size_t k = 0; k < edges.size(); ++k) {
        if (quick && k > 1) break;
        // Small blocks for as many spheres as the memory of this machine describes.
        printTable(times[k], times.front(), edges[k], quick ? 1e8 : k == 0 ? 1e10 : 1e9);
    }
}

/// Does the work of the first rank, while the others wait without taking its time.
template <class Work>
void whileOthersSleep(Ranks& ranks, const Work& work) {
    if (ranks.isFirst()) {
        work();
        for (int r = 1; r < ranks.count(); ++r) ranks.send(r, {});
    }
    Ranks::Bytes none;
    while (!ranks.isFirst() && !ranks.receive(none))
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

void benchTogether(int threads, Ranks& ranks) {
    // The least of each, taken in turn: other work on this machine hits all of them alike.
    constexpr int kRounds = 25;
    const auto domain = cube(kSide);
    const int all = threads * ranks.count();
    CountedRanks counted(ranks);
    PackOptions options = cubeOptions(threads);
    options.ranks = &counted;
    BlockTimes times;
    double latency = 1e9, alone = 1e9, together = 1e9;  // alone: one process, as many threads
    for (int round = 0; round < kRounds; ++round) {
        latency = std::min(latency, latencyOf(ranks));
        whileOthersSleep(ranks, [&] {
            BlockTimes again = measureBlocks(kSide, 0);
            if (round == 0 || again.total < times.total) times = std::move(again);
            alone = std::min(alone, secondsOf([&] { packSpheres(*domain, cubeOptions(all)); }));
        });
        anyOver(&ranks, false);
        counted.messages = counted.bytes = 0;
        const double seconds = secondsOf([&] { packSpheres(*domain, options); });
        together = std::min(together, maxOver(&ranks, seconds));
    }
    const std::uint64_t messages = sumOver(&ranks, counted.messages);
    const std::uint64_t bytes = sumOver(&ranks, counted.bytes);
    if (!ranks.isFirst()) return;
    const auto lattice = latticeOf(kSide, options);
    const Schedule schedule(lattice);
    const auto predicted = [&](int count, int each) {
        return times.mean * schedule.run(count, each, inMeans(times), latency / times.mean);
    };
    fmt::print("cube of {:.0f} mm: {} blocks of {:.2f} ms on one thread, messages {:.0f} us\n",
               kSide, lattice.size(), 1e3 * times.mean, 1e6 * latency);
    fmt::print("{:>6} {:>8} {:>12} {:>13}\n", "ranks", "threads", "measured, s", "predicted, s");
    fmt::print("{:>6} {:>8} {:>12.3f} {:>13.3f}\n", 1, all, alone, predicted(1, all));
    fmt::print("{:>6} {:>8} {:>12.3f} {:>13.3f}\n", ranks.count(), threads, together,
               predicted(ranks.count(), threads));
    fmt::print("{:.2f} messages a block, {:.1f} bytes a sphere\n",
               static_cast<double>(messages) / static_cast<double>(lattice.size()),
               static_cast<double>(bytes) / times.spheres);
}

}  // namespace

void benchRanks(int threads, bool quick, Ranks* ranks) {
    if (ranks)
        benchTogether(threads, *ranks);
    else
        benchAlone(quick);
}
