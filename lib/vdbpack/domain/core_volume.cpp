#include "vdbpack/domain/core_volume.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/inset_domain.h"
#include "vdbpack/domain/intersection_domain.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// Cells along the longest side of a domain, where the volume of a cavity in the shell is counted,
/// and along that of the blocks of cells that are counted in parallel.
constexpr double kMostCells = 1024, kLocalCells = 128;
constexpr int kBlocks = 16;

/// Measures what lies in the shell of the envelope but not in the domain.
template <int Dim>
class CavityInShell {
public:
    CavityInShell(const Domain<Dim>& domain, double shell)
        : domain_(domain.sampler()),
          envelope_(domain.envelope().sampler()),
          shell_(shell),
          error_(domain.facts().voxelSize) {}

    /// Volume within a box, mm^Dim: halves it where the boundary may pass, `levels` times at most.
    double volumeIn(const Vec<Dim>& center, const Vec<Dim>& half, int levels) {
        const double outside = signedDistance(center), radius = length(half) + error_;
        double volume = 1;
        for (int d = 0; d < Dim; ++d) volume *= 2 * half[d];
        if (outside > radius) return 0;
        if (outside < -radius) return volume;
        if (levels == 0) return outside < 0 ? volume : 0;
        double sum = 0;
        for (int part = 0; part < 1 << Dim; ++part) {
            Vec<Dim> x = center;
            for (int d = 0; d < Dim; ++d) x[d] += (part >> d & 1 ? 0.5 : -0.5) * half[d];
            sum += volumeIn(x, half * 0.5, levels - 1);
        }
        return sum;
    }

private:
    /// Where the walls of both are the same, no point lies in between.
    double signedDistance(const Vec<Dim>& x) {
        const double outside = envelope_->signedDistance(x);
        return std::max({-domain_->signedDistance(x), outside, -outside - shell_});
    }

    std::unique_ptr<DomainSampler<Dim>> domain_, envelope_;
    double shell_, error_;
};

/// The sum of `volumeIn` over blocks of a box, in parallel.
/// @param cells   along the longest side, at the most. @param least  side of a cell at least, mm.
/// @param parts   one a thread.
template <int Dim, class Part>
double summedOver(const Box<Dim>& box, double cells, double least, PerThread<Part>& parts) {
    const Vec<Dim> half = box.size() * (0.5 / kBlocks);
    double cell = 0;
    for (int d = 0; d < Dim; ++d) cell = std::max(cell, 2 * half[d]);
    const double finest = std::max(cell * kBlocks / cells, least);
    int levels = 0;
    for (; cell > finest; cell *= 0.5) ++levels;
    constexpr std::size_t kAll = Dim == 3 ? kBlocks * kBlocks * kBlocks : kBlocks * kBlocks;
    std::vector<double> sums(kAll);
    parallelFor(std::size_t{0}, kAll, [&](std::size_t n) {
        Vec<Dim> center = box.lo;
        std::size_t rest = n;
        for (int d = 0; d < Dim; ++d, rest /= kBlocks)
            center[d] += (2.0 * static_cast<double>(rest % kBlocks) + 1) * half[d];
        sums[n] = parts.local().volumeIn(center, half, levels);
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

template <int Dim>
double cavityInShell(const Domain<Dim>& domain, double shell) {
    PerThread<CavityInShell<Dim>> cavities([&] { return CavityInShell<Dim>(domain, shell); });
    return summedOver(domain.envelope().bounds(), kMostCells, 0.5 * domain.facts().voxelSize,
                      cavities);
}

/// Measures the part of a domain deeper than a shell whose thickness varies.
template <int Dim>
class LocalCore {
public:
    LocalCore(const Domain<Dim>& domain, const ShellThickness& shell)
        : envelope_(domain.envelope().sampler()),
          domain_(&domain.envelope() == &domain ? nullptr : domain.sampler()),
          shell_(shell),
          error_(domain.facts().voxelSize) {}

    /// As that of CavityInShell.
    double volumeIn(const Vec<Dim>& center, const Vec<Dim>& half, int levels) {
        const double outer = envelope_->signedDistance(center);
        const double inner = domain_ ? domain_->signedDistance(center) : outer;
        const double radius = length(half) + error_;
        double volume = 1;
        for (int d = 0; d < Dim; ++d) volume *= 2 * half[d];
        if (std::max(outer + shell_.least(), inner) > radius) return 0;
        if (std::max(outer + shell_.most(), inner) < -radius) return volume;
        if (levels == 0) {
            // The part of the cell behind a plane at that distance.
            const double outside = std::max(outer + shell_.at(center), inner);
            const double side = std::pow(volume, 1.0 / Dim);
            return volume * std::clamp(0.5 - outside / side, 0.0, 1.0);
        }
        double sum = 0;
        for (int part = 0; part < 1 << Dim; ++part) {
            Vec<Dim> x = center;
            for (int d = 0; d < Dim; ++d) x[d] += (part >> d & 1 ? 0.5 : -0.5) * half[d];
            sum += volumeIn(x, half * 0.5, levels - 1);
        }
        return sum;
    }

private:
    std::unique_ptr<DomainSampler<Dim>> envelope_;
    std::unique_ptr<DomainSampler<Dim>> domain_;  // null: the same
    const ShellThickness& shell_;
    double error_;
};

template <int Dim>
double localCoreVolume(const Domain<Dim>& domain, const ShellThickness& shell) {
    PerThread<LocalCore<Dim>> cores([&] { return LocalCore<Dim>(domain, shell); });
    return summedOver(domain.bounds(), Dim == 3 ? kLocalCells : kMostCells, 0.0, cores);
}

}  // namespace

template <int Dim>
double coreVolume(const Domain<Dim>& domain, const ShellThickness& shell) {
    if (!shell.any()) return domain.volume();
    if (!shell.isUniform()) return localCoreVolume(domain, shell);
    const double depth = shell.most();
    const Domain<Dim>& envelope = domain.envelope();
    if (&envelope == &domain) return domain.volumeDeeperThan(depth);
    const double cavities = envelope.volume() - domain.volume();
    return std::max(
        0.0, envelope.volumeDeeperThan(depth) - (cavities - cavityInShell<Dim>(domain, depth)));
}

template <int Dim>
std::shared_ptr<const Domain<Dim>> coreDomain(const Domain<Dim>& domain, double shell) {
    if (!(shell > 0)) return nullptr;
    std::shared_ptr<const Domain<Dim>> inset = insetDomain(domain.envelope(), shell);
    if (&domain.envelope() == &domain) return inset;
    // Not owned.
    const std::shared_ptr<const Domain<Dim>> all(std::shared_ptr<void>(), &domain);
    return intersectionDomain<Dim>(std::move(inset), all);
}

template double coreVolume(const Domain<2>&, const ShellThickness&);
template double coreVolume(const Domain<3>&, const ShellThickness&);
template std::shared_ptr<const Domain<2>> coreDomain(const Domain<2>&, double);
template std::shared_ptr<const Domain<3>> coreDomain(const Domain<3>&, double);

}  // namespace vdbpack
