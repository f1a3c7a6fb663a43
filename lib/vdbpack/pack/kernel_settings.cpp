#include "vdbpack/pack/kernel_settings.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/pack/packer.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// FrontSettings::lead and reach in largest radii. Box 200, radii 1 to 2, solid fraction in all /
/// of the interior: 0.6341 / 0.6411 at 0.5 and 1.5; 0.6371 / 0.6438 at 0.7 and 1.7; 0.6369 / 0.6436
/// at 1 and 1.4; 0.6346 / 0.6411 at 1 and 2. Of those the second scatters least in small domains.
constexpr double kLead = 0.7;
constexpr double kReach = 1.7;
/// FrontSettings::wallLead in largest radii. Box 120, radii 1 to 2, mean radius of the centers
/// within 3 mm of the walls ahead: 1.42 at 0, 1.48 at 0.7, 1.50 at 1, 1.52 at 1.5.
/// A slab of 5 mm: solid fraction 0.482 at 0, 0.492 at 1.
constexpr double kWallLead = 1;
/// FrontSettings::seamLead in largest radii. Cell of 134 mm, radii 1 to 2: 0.6416 at 0, with 0.633
/// within 4 mm of its faces and a mean radius of 1.507 there; 0.6418, 0.637 and 1.519 at 0.6;
/// 0.6419, 0.639 and 1.531 at 1.
constexpr double kSeamLead = 0.6;
/// SweepWaves::length in mean radii. Box 120, radii 1 to 2, solid fraction in all / of the
/// interior: 0.629 / 0.641 at 20, 0.631 / 0.643 at 28, 0.632 / 0.645 at 40. Hip, estimated moduli,
/// largest / smallest: 1.03 at 28, 1.04 at 36, 1.06 at 40, 1.07 at 56.
constexpr double kWaveLength = 36;
/// The most of it, in longest edges of the domain: of longer waves the pack shows a part.
constexpr double kMostOfDomain = 0.75;
/// Radii pending in a chain of blocks: one for so many spheres yet to place there, and for so many
/// of the pack, within bounds. Those pending at its end are never placed; a chain that has far more
/// of them at its beginning is denser there. Box 120, radii 1 to 2, and hip of 60,000 spheres,
/// solid fraction, Kolmogorov-Smirnov distance of the radii and offset of the center of mass in %:
/// 0.6314, 0.0007, 0.17 and 0.6156, 0.0014, 0.17 with at least 32 and one for 20; 0.6316, 0.0006,
/// 0.16 and 0.6164, 0.0012, 0.14 so; 0.6320, 0.0008, 0.20 and 0.6162, 0.0011, 0.19 with 32 to 384,
/// one for 10, and for 40 of the pack.
template <int Dim>
constexpr double kLeastPending = Dim == 3 ? 64 : 32;
constexpr double kMostPending = 192, kSpheresPerPending = 16, kSpheresOfPack = 80;
/// The least in packs of fewer spheres than that. Cell of 41 mm, radii 1 to 2, 2,800 spheres: 0.632
/// and 0.0065 with 64; 0.627 and 0.006 with 32.
constexpr double kSmallPack = 6000, kLeastOfSmall = 64;
/// Least radius for which sites are sought, in mean radii.
constexpr double kProbe = 0.62;

/// kReach at Effort::fast.
constexpr double kFastReach = 1.4;
/// In 3D, Effort::fast seeks sites for a sphere smaller than any, by this share of the difference
/// between the mean and the least radius: fewer bodies are in its reach, and the sites that it
/// misses are narrow. It also leaves out sites where only the smallest radii fit, this share of
/// them. Box 120, radii 1 to 2, instructions per sphere and solid fraction: 15,100 and 0.594; at
/// 0.5 and 0.1 16,000 and 0.599; with neither 20,400 and 0.614.
template <int Dim>
constexpr double kFastProbe = Dim == 3 ? 0.6 : 0;
template <int Dim>
constexpr double kFastShare = Dim == 3 ? 0.15 : 0;
/// Least radius for which Effort::fast seeks sites, in mean radii.
constexpr double kLeastFastProbe = 0.4;

/// Spheres larger than this many mean radii are few: they are not sought as neighbors.
constexpr double kCommon = 2;
/// In largest common radii; see FrontSettings::wideRadius.
constexpr double kWide = 1.5;

/// Largest ratio of the common radii for which spheres count as nearly equal: the fourth body of a
/// site says little about it then, and the number of near bodies orders the sites.
constexpr double kNearlyEqual = 1.25;
/// FrontSettings::crowdLead and nearGap of nearly equal spheres, in mean radii. Equal spheres in
/// box 60, solid fraction in all / of the interior: 0.578 / 0.598 without; 0.586 / 0.607 at 0.5 and
/// 0.7; 0.587 / 0.611 at 2 and 1; 0.578 / 0.604 at 1 and 1.4.
constexpr double kCrowdLead = 2, kNearGap = 1;
/// Their reach, in mean radii: at 2, spheres near a site are missed that are far from its pivot.
/// Vertebra, radius 0.72, interior: 0.607 at 2, 0.609 from 2.3 on.
constexpr double kCrowdReach = 2.4;
/// Edge of a block at Effort::dense, in blocks of the other efforts; of nearly equal spheres, which
/// no other setting makes denser, and of others. And pending radii, in those of the other efforts.
constexpr double kDenseCrowd = 3, kDenseBlock = 1.5, kDensePending = 2;

/// Edge of a block in largest common radii. Shorter ones cost density (box 120, radii 1 to 2: total
/// 0.614 as one block, 0.613 at 20, 0.610 at 14), longer ones leave threads without work.
template <int Dim>
constexpr double kBlockSide = Dim == 3 ? 20 : 60;
/// Where sizes differ by place, edge and waves are those for the coarsest ones, or for this many
/// times the finest: blocks of fine spheres hold many.
constexpr double kCoarseBlocks = 3;

/// Between the streams of random numbers of two groups of sizes: more than there are blocks.
constexpr std::uint64_t kGroupStreams = std::uint64_t{1} << 40;

bool areNearlyEqual(const FrontLengths& settings) {
    return settings.commonRadius <= kNearlyEqual * settings.minRadius;
}

template <int Dim>
FrontLengths lengthsFor(const SizeDistribution& sizes, const PackOptions& options) {
    const double shell = shellOf(options);
    FrontLengths s;
    s.minRadius = sizes.min() + shell;
    s.meanRadius = sizes.mean() + shell;
    s.meanBall = ballWithShell<Dim>(sizes, 1, shell);
    // Radii are rounded to floats, the largest perhaps upwards.
    s.maxRadius = std::max(sizes.max(), sizes.quantile(1)) + shell;
    s.commonRadius = std::min(s.maxRadius, kCommon * s.meanRadius);
    s.wideRadius = kWide * s.commonRadius;
    // The probe finds all sites where it is the smallest radius; for wide distributions most
    // spheres are larger, and sites that only the smallest could reach are not worth the time.
    s.probe = std::max(s.minRadius, kProbe * s.meanRadius);
    const bool fast = options.effort == Effort::fast;
    if (fast && s.probe == s.minRadius)
        s.probe = std::max(kLeastFastProbe * s.meanRadius,
                           s.minRadius - kFastProbe<Dim> * (s.meanRadius - s.minRadius));
    s.reach = std::max(2.001 * s.probe, (fast ? kFastReach : kReach) * s.commonRadius);
    s.least = fast ? sizes.quantile(kFastShare<Dim>) + shell : 0;
    s.lead = fast || options.order == Order::fifo ? 0 : kLead * s.commonRadius;
    if (sweeps(options.order) && options.evenSizes) {
        s.wallLead = kWallLead * s.commonRadius;
        s.seamLead = kSeamLead * s.commonRadius;
    }
    if (Dim == 3 && areNearlyEqual(s) && !fast && sweeps(options.order)) {
        s.crowdLead = kCrowdLead * s.meanRadius;
        s.nearGap = kNearGap * s.meanRadius;
        s.reach = std::max(s.reach, kCrowdReach * s.meanRadius);
    }
    return s;
}

}  // namespace

double quantumFor(const PackOptions& options) {
    double mean = options.sizes.mean();
    if (options.local.any()) {
        for (std::size_t g = 0; g < options.local.groups(); ++g)
            mean = std::min(mean, options.local.sizesOf(g, options.sizes).mean());
        mean *= options.local.factors().least;
    }
    // Point grids of OpenVDB store 25 bits of a voxel's edge; voxels of up to 8 mean radii suit
    // them.
    return std::exp2(std::floor(std::log2(mean)) - 22);
}

double leastRadius(const PackOptions& options) {
    double least = options.sizes.min();
    for (const Species& species : options.species) least = std::min(least, species.sizes.min());
    if (!options.local.any()) return least;
    for (std::size_t g = 0; g < options.local.groups(); ++g)
        least = std::min(least, options.local.sizesOf(g, options.sizes).min());
    return least * options.local.factors().least;
}

double largestRadius(const PackOptions& options) {
    double largest = 0;
    for (std::size_t g = 0; g < options.local.groups(); ++g)
        largest = std::max(largest, options.local.sizesOf(g, options.sizes).quantile(1));
    return largest * options.local.factors().most;
}

template <int Dim>
std::vector<FrontLengths> frontLengths(const PackOptions& options) {
    std::vector<FrontLengths> groups;
    for (std::size_t g = 0; g < options.local.groups(); ++g)
        groups.push_back(lengthsFor<Dim>(options.local.sizesOf(g, options.sizes), options));
    return groups;
}

/// The largest of a length anywhere, within `kCoarseBlocks`.
/// @param finest  lengths where sizes are finest.
template <int Dim>
static double coarsest(const PackOptions& options, const FrontLengths& finest,
                       double FrontLengths::*length) {
    double most = finest.*length;
    if (!options.local.any()) return most;
    for (const FrontLengths& group : frontLengths<Dim>(options))
        most = std::max(most,
                        group.scaled(options.local.factors().most, shellOf(options), Dim).*length);
    return std::min(most, kCoarseBlocks * finest.*length);
}

template <int Dim>
FrontSettings<Dim> frontSettings(const Domain<Dim>& domain, const PackOptions& options) {
    const double shell = shellOf(options);
    FrontSettings<Dim> s;
    const std::vector<FrontLengths> groups = frontLengths<Dim>(options);
    static_cast<FrontLengths&>(s) = groups.front();
    if (options.local.any()) {
        for (const FrontLengths& group : groups)
            if (group.meanRadius < s.meanRadius) static_cast<FrontLengths&>(s) = group;
        static_cast<FrontLengths&>(s) = s.scaled(options.local.factors().least, shell, Dim);
        s.maxRadius = largestRadius(options) + shell;
    }
    s.order = options.order;
    s.evenSizes = options.evenSizes;
    s.sweep = Box<Dim>::filled(1 / std::sqrt(static_cast<double>(Dim)));
    // Waves leave less room for the large spheres of further species.
    const bool alone = std::none_of(options.species.begin(), options.species.end(),
                                    [](const Species& other) { return other.probability > 0; });
    if (options.order == Order::waves && alone && !areNearlyEqual(s)) {
        const Vec<Dim> size = domain.bounds().size();
        s.waves.length =
            std::min(kWaveLength * coarsest<Dim>(options, s, &FrontLengths::meanRadius),
                     kMostOfDomain * *std::max_element(size.c.begin(), size.c.end()));
        // Others for each seed.
        RandomStream random(options.seed ^ 0x7761766573ull, 0);
        for (int d = 0; d < Dim; ++d)
            s.waves.start[d] = domain.bounds().lo[d] - random.uniform() * s.waves.length;
    }
    if (options.order == Order::center || options.order == Order::fifo)
        s.middle = largestBall(domain).center;
    for (const Species& species : options.species)
        s.maxRadius = std::max(s.maxRadius, species.sizes.quantile(1) + shell);
    s.quantum = quantumFor(options);
    s.fieldError = domain.facts().voxelSize;
    s.fieldDepth = domain.fieldDepth();
    return s;
}

template <int Dim>
double blockSide(const Domain<Dim>& domain, const PackOptions& options,
                 const FrontSettings<Dim>& settings) {
    if (!sweeps(options.order)) {
        const Vec<Dim> size = domain.bounds().size();
        return 2 * *std::max_element(size.c.begin(), size.c.end());
    }
    const double common = coarsest<Dim>(options, settings, &FrontLengths::commonRadius);
    const double wide = options.effort != Effort::dense        ? 1
                        : Dim == 3 && areNearlyEqual(settings) ? kDenseCrowd
                                                               : kDenseBlock;
    return std::max(8 * settings.maxRadius,
                    options.blockSide > 0 ? options.blockSide : wide * kBlockSide<Dim> * common);
}

template <int Dim>
std::size_t poolCapacity(const PackOptions& options, double ahead, double expected) {
    if (options.pending > 0) return options.pending;
    const double more = options.effort == Effort::dense ? kDensePending : 1;
    const double least = expected < kSmallPack ? kLeastOfSmall : kLeastPending<Dim>;
    return static_cast<std::size_t>(
        std::clamp(std::min(ahead / kSpheresPerPending, expected / kSpheresOfPack), least,
                   more * kMostPending));
}

std::size_t pendingOfGroup(std::size_t usual, double expected) {
    constexpr double kLeast = 12, kShare = 1.0 / 600;
    return std::min(usual, static_cast<std::size_t>(std::max(kLeast, kShare * expected)));
}

std::vector<RadiusPool> radiusPools(const PackOptions& options, std::uint32_t stream) {
    const double shell = options.local.any() ? 0 : shellOf(options);
    std::vector<RadiusPool> pools;
    for (std::size_t g = 0; g < options.local.groups(); ++g)
        pools.emplace_back(options.local.sizesOf(g, options.sizes), options.seed,
                           g * kGroupStreams + stream, 0, shell);
    return pools;
}

template std::size_t poolCapacity<2>(const PackOptions&, double, double);
template std::size_t poolCapacity<3>(const PackOptions&, double, double);
template std::vector<FrontLengths> frontLengths<2>(const PackOptions&);
template std::vector<FrontLengths> frontLengths<3>(const PackOptions&);
template FrontSettings<2> frontSettings(const Domain<2>&, const PackOptions&);
template FrontSettings<3> frontSettings(const Domain<3>&, const PackOptions&);
template double blockSide(const Domain<2>&, const PackOptions&, const FrontSettings<2>&);
template double blockSide(const Domain<3>&, const PackOptions&, const FrontSettings<3>&);

}  // namespace vdbpack
