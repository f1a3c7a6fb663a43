#include "vdbpack/pack/packer.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/inset_domain.h"
#include "vdbpack/pack/block_lattice.h"
#include "vdbpack/pack/exposed.h"
#include "vdbpack/pack/front/block_front.h"
#include "vdbpack/pack/radius_pool.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>

namespace vdbpack {

namespace {

/// Pending radii that a row of blocks holds: more raise the density a little, but those of the
/// last rows are never placed.
std::size_t poolCapacity(const PackOptions& options) {
    if (options.pending > 0) return options.pending;
    return options.effort == Effort::dense ? 256 : 64;
}
/// The same for a block whose pool goes nowhere.
std::size_t lastCapacity(const PackOptions& options) {
    if (options.pending > 0) return options.pending;
    return options.effort == Effort::dense ? 128 : 64;
}

/// FrontSettings::lead and reach in largest radii. Box 200, radii 1 to 2, total / interior:
/// 0.6341 / 0.6411 at 0.5 and 1.5; 0.6371 / 0.6438 at 0.7 and 1.7; 0.6369 / 0.6436 at 1 and 1.4;
/// 0.6346 / 0.6411 at 1 and 2. Of those the second scatters least in small domains.
constexpr double kLead = 0.7;
constexpr double kReach = 1.7;
/// Least radius for which sites are sought, in mean radii.
constexpr double kProbe = 0.62;

/// kReach at Effort::fast.
constexpr double kFastReach = 1.4;
/// Effort::fast seeks sites, in 3D, for a sphere smaller than any, by this share of what the mean
/// radius exceeds the least by: fewer bodies are in its reach, and the sites that it misses are
/// narrow ones. It also leaves places alone where only the smallest of the radii fit, a share of
/// them. Box 120, radii 1 to 2, instructions a sphere and total: 15,100 and 0.594; at 0.5 and 0.1
/// 16,000 and 0.599; with neither 20,400 and 0.614.
template <int Dim>
constexpr double kFastProbe = Dim == 3 ? 0.6 : 0;
template <int Dim>
constexpr double kFastShare = Dim == 3 ? 0.15 : 0;
/// The former goes down to this many mean radii.
constexpr double kLeastFastProbe = 0.4;

/// Spheres larger than this many mean radii are few: no neighbors are sought for them beforehand.
constexpr double kCommon = 2;
/// In largest common radii; see FrontSettings::wideRadius.
constexpr double kWide = 1.5;

/// Edge of a block in largest common radii. Shorter ones cost density (box 120, radii 1 to 2: total
/// 0.614 as one block, 0.613 at 20, 0.610 at 14), longer ones leave threads without work.
template <int Dim>
constexpr double kBlockSide = Dim == 3 ? 20 : 60;

/// Mean volume (2D: area) of spheres with radii times `scale` and a shell.
template <int Dim>
double ballWithShell(const SizeDistribution& sizes, double scale, double shell) {
    const double mean = scale * sizes.mean(), square = scale * scale * sizes.meanBall(2) / kPi;
    if constexpr (Dim == 2)
        return kPi * (square + shell * (2 * mean + shell));
    else
        return scale * scale * scale * sizes.meanBall(3) +
               4.0 / 3.0 * kPi * shell * (3 * square + shell * (3 * mean + shell));
}

/// Point grids hold 25 bits of a voxel's edge, and a voxel of up to 8 mean radii suits them; mm.
double quantumFor(const SizeDistribution& sizes) {
    return std::exp2(std::floor(std::log2(sizes.mean())) - 22);
}

double leastRadius(const PackOptions& options) {
    double least = options.sizes.min();
    for (const Species& species : options.species) least = std::min(least, species.sizes.min());
    return least;
}

template <int Dim>
double thinnest(const Box<Dim>& box) {
    double least = std::numeric_limits<double>::infinity();
    for (int d = 0; d < Dim; ++d) least = std::min(least, box.size()[d]);
    return least;
}

/// Packs radii grown by a shell of half the gap into a domain whose wall is moved inwards by as
/// much: where those do not overlap, the spheres inside keep the gap.
template <int Dim>
class Wavefront {
public:
    Wavefront(const Domain<Dim>& domain, const PackOptions& options, const Callbacks& callbacks,
              const std::vector<Sphere<Dim>>& existing)
        : domain_(domain),
          options_(options),
          callbacks_(callbacks),
          settings_(makeSettings(domain, options)),
          lattice_(domain.bounds(), side(domain, options, settings_), 2 * settings_.maxRadius,
                   settings_.quantum),
          blocks_(lattice_.size()) {
        const auto sampler = domain.sampler();
        for (const Sphere<Dim>& grown : obstacles(existing, options)) {
            // What rests on a sphere inside is inside. Places on those that are far larger than
            // what rests there are found from the others.
            const double radius = grown.radius - shellOf(options);
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

    static double shellOf(const PackOptions& options) { return 0.5 * options.gap; }

    static double side(const Domain<Dim>& domain, const PackOptions& options,
                       const FrontSettings<Dim>& settings) {
        if (options.order != Order::sweep) {
            const Vec<Dim> size = domain.bounds().size();
            return 2 * *std::max_element(size.c.begin(), size.c.end());
        }
        return std::max(8 * settings.maxRadius, options.blockSide > 0
                                                    ? options.blockSide
                                                    : kBlockSide<Dim> * settings.commonRadius);
    }

    /// What stands, grown by the shell, without what lies under the rest of it.
    std::vector<Sphere<Dim>> obstacles(std::vector<Sphere<Dim>> existing,
                                       const PackOptions& options) const {
        if (existing.empty()) return existing;
        const double shell = shellOf(options);
        for (Sphere<Dim>& s : existing) s.radius += shell;
        constexpr double kRounded = 1 - 1e-6;  // radii are, to floats
        return exposedSpheres(std::move(existing), kRounded * (leastRadius(options) + shell));
    }

    static FrontSettings<Dim> makeSettings(const Domain<Dim>& domain, const PackOptions& options) {
        const SizeDistribution& sizes = options.sizes;
        const double shell = shellOf(options);
        FrontSettings<Dim> s;
        s.order = options.order;
        s.sweep = Box<Dim>::filled(1 / std::sqrt(static_cast<double>(Dim)));
        if (options.order == Order::center || options.order == Order::fifo)
            s.middle = largestPlace(domain).center;
        s.minRadius = sizes.min() + shell;
        s.meanRadius = sizes.mean() + shell;
        s.meanBall = ballWithShell<Dim>(sizes, 1, shell);
        // Radii are rounded to floats, the largest perhaps upwards.
        s.maxRadius = std::max(sizes.max(), sizes.quantile(1)) + shell;
        s.commonRadius = std::min(s.maxRadius, kCommon * s.meanRadius);
        s.wideRadius = kWide * s.commonRadius;
        for (const Species& species : options.species)
            s.maxRadius = std::max(s.maxRadius, species.sizes.quantile(1) + shell);
        // The probe finds all sites where it is the smallest radius; for wide distributions most
        // spheres are larger, and what only the smallest could reach is not worth the time.
        s.probe = std::max(s.minRadius, kProbe * s.meanRadius);
        const bool fast = options.effort == Effort::fast;
        if (fast && s.probe == s.minRadius)
            s.probe = std::max(kLeastFastProbe * s.meanRadius,
                               s.minRadius - kFastProbe<Dim> * (s.meanRadius - s.minRadius));
        s.reach = std::max(2.001 * s.probe, (fast ? kFastReach : kReach) * s.commonRadius);
        s.least = fast ? sizes.quantile(kFastShare<Dim>) + shell : 0;
        s.lead = fast || options.order == Order::fifo ? 0 : kLead * s.commonRadius;
        s.quantum = quantumFor(sizes);
        s.fieldError = domain.facts().voxelSize;
        s.fieldDepth = domain.fieldDepth();
        return s;
    }

    void process(std::uint32_t b) {
        for (;;) {
            if (!isStopped()) fillBlock(b);
            // One successor that became ready goes on in this task: its neighborhood is warm.
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

    void fillBlock(std::uint32_t b) {
        Thread& thread = threads_.local();
        if (!thread.front) {
            thread.front = std::make_unique<BlockFront<Dim>>(settings_);
            thread.sampler = domain_.sampler();
        }
        Block& block = blocks_[b];
        for (const std::uint32_t donor : lattice_.poolDonors(b)) {
            if (!blocks_[donor].pool) return;  // interrupted there
            if (!block.pool) {
                block.pool = std::move(blocks_[donor].pool);
                block.further = std::move(blocks_[donor].further);
            } else {
                block.pool->absorb(*blocks_[donor].pool);
                if (block.further) block.further->absorb(*blocks_[donor].further);
            }
        }
        if (!block.pool)
            block.pool = std::make_unique<RadiusPool>(options_.sizes, options_.seed, b,
                                                      poolCapacity(options_), shellOf(options_));
        if (!block.further && hasSpecies_)
            block.further = std::make_unique<SpeciesQueue>(options_.species, options_.seed, b,
                                                           shellOf(options_));
        block.pool->setCapacity(
            lattice_.endsPool(b) ? lastCapacity(options_) : poolCapacity(options_),
            settings_.wideRadius);
        const Box<Dim> own = lattice_.own(b);
        const Box<Dim> search = lattice_.search(b);
        Box<Dim> reach = own;
        for (int d = 0; d < Dim; ++d) reach.lo[d] = std::min(reach.lo[d], search.lo[d]);
        // Spheres of further species may lie across the upper faces of their block.
        reach = reach.grown((hasSpecies_ ? 3 : 2) * settings_.maxRadius);
        thread.around.clear();
        for (const std::uint32_t n : lattice_.lowerNeighbors(b)) {
            const std::uint32_t here = neighborBit(lattice_.offset(n, b));
            const BlockSpheres<Dim>& placed = blocks_[n].placed;
            auto site = placed.sites.begin();
            for (std::size_t i = 0; i < placed.spheres.size(); ++i) {
                if (!reach.contains(placed.spheres[i].center)) continue;
                const auto at = static_cast<std::uint32_t>(thread.around.spheres.size());
                thread.around.spheres.push_back(placed.spheres[i]);
                for (; site != placed.sites.end() && site->pivot <= i; ++site)
                    if (site->pivot == i && site->neighbor == here) {
                        thread.around.sites.push_back(*site);
                        thread.around.sites.back().pivot = at;
                    }
            }
        }
        for (const std::uint32_t u : block.existing.unexplored)
            thread.around.unexplored.push_back(
                u + static_cast<std::uint32_t>(thread.around.spheres.size()));
        thread.around.spheres.insert(thread.around.spheres.end(), block.existing.spheres.begin(),
                                     block.existing.spheres.end());
        thread.front->fill(own, search, thread.around, *block.pool, block.further.get(),
                           *thread.sampler, cancelled_, block.placed);
        // Stopped within it, what stands there is final all the same: no neighbor has begun.
        report(block.placed.spheres.size());
    }

    /// Asked from within blocks as well, of which there may be just one. Callbacks are called one
    /// at a time: where another thread is at it, its answer will do for the next time.
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
            // To the float that was drawn.
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
PackResult<Dim> packSpheres(const Domain<Dim>& outer, const PackOptions& options,
                            const Callbacks& callbacks, const std::vector<Sphere<Dim>>& existing) {
    if (!(options.gap >= 0 && std::isfinite(options.gap)))
        throw ParameterError(
            fmt::format("gap {} mm: must be finite and not negative", options.gap));
    double further = 0;
    for (const Species& s : options.species) {
        if (!(s.probability >= 0 && s.depth >= 0)) further = 2;
        further += s.probability;
    }
    if (!(further < 1) || options.species.size() > 255)
        throw ParameterError(
            fmt::format("{} further species of probability {} in all: probabilities must not be "
                        "negative and add up to less than 1",
                        options.species.size(), further));
    std::unique_ptr<Domain<Dim>> inset;
    if (options.gap > 0) inset = insetDomain(outer, 0.5 * options.gap);
    const Domain<Dim>& domain = inset ? *inset : outer;
    const double expected = domain.volume() / options.sizes.meanBall(Dim);
    if (!(expected < 2e9))
        throw ResourceError(fmt::format(
            "radii of mean {:.3g} mm would give about {:.2g} {}; the limit is 1e9: ask for larger "
            "radii or check the unit of the domain",
            options.sizes.mean(), 0.6 * expected, Measure<Dim>::kSpheres));
    PackResult<Dim> result;
    result.quantum = quantumFor(options.sizes);
    // Blocks for radii that no part of a thin domain can hold would be many, and all empty.
    const bool fits = leastRadius(options) <= 0.5 * thinnest(domain.bounds()) * (1 + 1e-9);
    if (fits) {
        Wavefront<Dim> wavefront(domain, options, callbacks, existing);
        result = wavefront.run();
    }
    if (result.pack.spheres.empty() && !result.interrupted && existing.empty()) {
        Sphere<Dim> place = largestPlace(domain);
        place.radius -= 0.5 * options.gap;
        // A place hardly larger than the smallest sphere is easily missed by a search in cells.
        Sphere<Dim> only{place.center, options.sizes.quantile(0)};
        for (int d = 0; d < Dim; ++d)
            only.center[d] = std::nearbyint(place.center[d] / result.quantum) * result.quantum;
        WallPoint<Dim> wall;
        if (fits && place.radius > 0 &&
            !domain.sampler()->nearestWall(only.center, only.radius + 0.5 * options.gap, wall)) {
            result.pack.spheres.push_back(only);
            result.pack.order.push_back(0);
            return result;
        }
        std::string at;
        for (int d = 0; d < Dim; ++d)
            at += fmt::format("{}{:.6g}", d ? ", " : "", only.center[d] + 0.0);
        const std::string kept =
            options.gap > 0 ? fmt::format(" with a gap of {:g} mm to the wall", options.gap) : "";
        if (!(place.radius > 0))
            throw InputError(
                fmt::format("no {} fits{}: ask for a smaller gap or check the unit of "
                            "the domain",
                            Measure<Dim>::kSphere, kept));
        throw InputError(fmt::format(
            "no {} of radius {:.6g} mm or more fits{}: the largest place has radius {:.6g} mm, at "
            "({}); ask for smaller radii or check the unit of the domain",
            Measure<Dim>::kSphere, options.sizes.min(), kept, place.radius, at));
    }
    return result;
}

template <int Dim>
Sphere<Dim> largestPlace(const Domain<Dim>& domain) {
    const auto sampler = domain.sampler();
    const Box<Dim> bounds = domain.bounds();
    Sphere<Dim> best{bounds.center(), -std::numeric_limits<double>::infinity()};
    const double longest = [&] {
        double l = 0;
        for (int d = 0; d < Dim; ++d) l = std::max(l, bounds.size()[d]);
        return l;
    }();
    // Field clamped where it is deep: then the exact distance decides.
    const auto depthAt = [&](const Vec<Dim>& x) {
        const double field = -sampler->signedDistance(x);
        if (field < 0) return field;
        WallPoint<Dim> wall;
        return sampler->nearestWall(x, longest, wall) ? wall.distance : field;
    };
    constexpr int kSteps = Dim == 3 ? 48 : 256;
    int n[3] = {1, 1, 1};
    for (int d = 0; d < Dim && longest > 0; ++d)
        n[d] = std::max(1, static_cast<int>(std::ceil(kSteps * bounds.size()[d] / longest)));
    for (int k = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i) {
                const int at[3] = {i, j, k};
                Vec<Dim> x;
                for (int d = 0; d < Dim; ++d)
                    x[d] = bounds.lo[d] + (at[d] + 0.5) / n[d] * bounds.size()[d];
                if (-sampler->signedDistance(x) <= std::min(best.radius, domain.fieldDepth() * 0.9))
                    continue;
                const double depth = depthAt(x);
                if (depth > best.radius) best = {x, depth};
            }
    // Uphill by steps away from the nearest wall (subgradients of the depth), which zigzag along
    // a ridge between walls to where it ends; steps halve, each length starting from the best.
    constexpr int kStepsOfALength = 32;
    for (double step = longest / kSteps; best.radius > 0 && step > 1e-8 * best.radius;
         step *= 0.5) {
        Vec<Dim> x = best.center;
        for (int k = 0; k < kStepsOfALength; ++k) {
            WallPoint<Dim> wall;
            if (!sampler->nearestWall(x, longest, wall) || !(wall.distance > 0)) break;
            x += (step / wall.distance) * (x - wall.point);
            const double depth = depthAt(x);
            if (!(depth > 0)) break;
            if (depth > best.radius) best = {x, depth};
        }
    }
    return best;
}

template <int Dim>
double scaleForCount(const Domain<Dim>& domain, const PackOptions& options, double count,
                     const Callbacks& callbacks, const std::vector<Sphere<Dim>>& existing) {
    if (!(count >= 1 && std::isfinite(count)))
        throw ParameterError(
            fmt::format("target count {}: must be a number of spheres, 1 or more", count));
    const double shell = 0.5 * options.gap;
    const double guess = Dim == 3 ? 0.58 : 0.8;
    const double most = guess * domain.volume() / ballWithShell<Dim>(options.sizes, 0, shell);
    if (!(count < most))
        throw ParameterError(
            fmt::format("{:.0f} {} cannot keep a gap of {:g} mm in this domain, however small they "
                        "are: at most "
                        "about {:.0f} can; ask for fewer or for a smaller gap",
                        count, Measure<Dim>::kSpheres, options.gap, most));
    // Where `n` spheres with their shells fill that fraction of the domain.
    const auto scaleFor = [&](double fraction, double n) {
        const double ball = fraction * domain.volume() / n;
        double lo = 0, hi = std::pow(ball / options.sizes.meanBall(Dim), 1.0 / Dim);
        for (int i = 0; shell > 0 && i < 100; ++i) {
            const double middle = 0.5 * (lo + hi);
            (ballWithShell<Dim>(options.sizes, middle, shell) < ball ? lo : hi) = middle;
        }
        return hi;
    };
    PackOptions trial = options;
    trial.maxCount = 0;
    Callbacks quiet = callbacks;
    quiet.progress = nullptr;
    const auto fractionAt = [&](double scale) {
        trial.sizes = options.sizes.scaled(scale);
        const auto result = packSpheres(domain, trial, quiet, existing);
        double sum = 0;
        for (const auto& s : result.pack.spheres) sum += Measure<Dim>::ball(s.radius + shell);
        return sum / domain.volume();
    };
    // Room beside what stands already.
    double taken = 0;
    const auto sampler = domain.sampler();
    for (const auto& s : existing)
        if (sampler->signedDistance(s.center) < 0) taken += Measure<Dim>::ball(s.radius + shell);
    const double room = guess * std::max(0.05, 1 - taken / domain.volume());
    // Solid fraction against the scale: f = a - b s, since a layer as thick as the radii is
    // packed worse along the wall. Two trials with 1/20 and 1/5 of the spheres give a and b.
    const double coarse = scaleFor(room, std::max(count / 20, 50.0));
    const double fine = scaleFor(room, std::max(count / 5, 100.0));
    if (callbacks.isCancelled()) return fine;
    const double f1 = fractionAt(coarse);
    if (callbacks.isCancelled()) return fine;
    const double f2 = fractionAt(fine);
    const double slope = coarse > fine ? (f2 - f1) / (coarse - fine) : 0.0;
    double scale = scaleFor(std::clamp(f2, 0.01, 0.9), count);
    for (int i = 0; i < 20; ++i) {
        const double fraction = std::clamp(f2 + slope * (fine - scale), 0.01, 0.9);
        scale = scaleFor(fraction, count);
    }
    return scale;
}

template PackResult<2> packSpheres(const Domain<2>&, const PackOptions&, const Callbacks&,
                                   const std::vector<Sphere<2>>&);
template PackResult<3> packSpheres(const Domain<3>&, const PackOptions&, const Callbacks&,
                                   const std::vector<Sphere<3>>&);
template double scaleForCount(const Domain<2>&, const PackOptions&, double, const Callbacks&,
                              const std::vector<Sphere<2>>&);
template double scaleForCount(const Domain<3>&, const PackOptions&, double, const Callbacks&,
                              const std::vector<Sphere<3>>&);
template Sphere<2> largestPlace(const Domain<2>&);
template Sphere<3> largestPlace(const Domain<3>&);

}  // namespace vdbpack
