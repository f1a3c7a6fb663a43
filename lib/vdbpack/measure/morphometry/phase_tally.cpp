#include "vdbpack/measure/morphometry/phase_tally.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/measure/morphometry/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace vdbpack {

namespace {

constexpr double kBinsPerVoxel = 32;
/// Thicker ones share the last class: in an image thousands of voxels long and a few wide a ball of
/// the solid may be as large as the image is long.
constexpr std::size_t kMostBins = std::size_t{1} << 20;
constexpr int kSteps = 100;  // between quantiles

using Bins = std::vector<std::uint32_t>;  // an image has fewer than 2^32 voxels

void count(Bins& bins, double thickness) {
    const std::size_t bin =
        std::min(static_cast<std::size_t>(thickness * kBinsPerVoxel), kMostBins - 1);
    if (bin >= bins.size()) bins.resize(bin + 1);
    ++bins[bin];
}

void addTo(Bins& bins, const Bins& other) {
    if (other.size() > bins.size()) bins.resize(other.size());
    for (std::size_t i = 0; i < other.size(); ++i) bins[i] += other[i];
}

/// By label, those of the solid and of the pores.
using LabelBins = std::vector<std::array<Bins, 2>>;

/// In voxels, see `LengthStatistics`.
std::vector<double> quantilesOf(const Tally& t) {
    std::vector<double> result;
    std::size_t bin = 0;
    double before = 0;  // voxels in the classes before `bin`
    for (int step = 0; step <= kSteps; ++step) {
        const double rank = static_cast<double>(t.voxels) * step / kSteps;
        while (bin + 1 < t.bins.size() && (t.bins[bin] == 0 || before + t.bins[bin] < rank))
            before += t.bins[bin++];
        const double part = (rank - before) / t.bins[bin];
        result.push_back(
            std::clamp((static_cast<double>(bin) + part) / kBinsPerVoxel, t.min, t.max));
    }
    result.back() = t.max;
    return result;
}

}  // namespace

void Tally::add(const Tally& other) {
    voxels += other.voxels;
    sum += other.sum;
    squares += other.squares;
    max = std::max(max, other.max);
    min = std::min(min, other.min);
    addTo(bins, other.bins);
}

std::optional<LengthStatistics> Tally::statistics(double voxelSize) const {
    if (voxels == 0 || !(max > 0)) return std::nullopt;
    const double n = static_cast<double>(voxels);
    const double mean = sum / n;
    LengthStatistics s;
    s.mean = mean * voxelSize;
    s.sd = std::sqrt(std::max(squares / n - mean * mean, 0.0)) * voxelSize;
    s.max = max * voxelSize;
    s.quantiles = quantilesOf(*this);
    for (double& q : s.quantiles) q *= voxelSize;
    return s;
}

void PhaseTallies::add(const PhaseTallies& other) {
    solid.add(other.solid);
    pores.add(other.pores);
}

std::vector<PhaseTallies> tallyPhases(const VoxelImage& image,
                                      const std::vector<float>& thickness) {
    const auto slices = static_cast<std::size_t>(image.size[2]);
    const std::size_t slice = image.voxels() / slices;
    const std::size_t labels = labelCount(image);
    // Sums of slices, added in order.
    std::vector<std::vector<PhaseTallies>> bySlice(slices);
    // Counts are the same in any order.
    PerThread<LabelBins> byThread([&] { return LabelBins(labels); });
    parallelFor(std::size_t{0}, slices, [&](std::size_t z) {
        auto& sums = bySlice[z];
        sums.resize(labels);
        LabelBins& bins = byThread.local();
        for (std::size_t voxel = z * slice; voxel < (z + 1) * slice; ++voxel) {
            const auto label = static_cast<std::size_t>(labelOf(image, voxel));
            const bool solid = image.distance[voxel] < 0;
            Tally& t = solid ? sums[label].solid : sums[label].pores;
            ++t.voxels;
            if (thickness.empty()) continue;
            const double value = static_cast<double>(thickness[voxel]);
            t.sum += value;
            t.squares += value * value;
            t.max = std::max(t.max, value);
            t.min = std::min(t.min, value);
            if (label != 0) count(bins[label][solid ? 0 : 1], value);
        }
    });
    std::vector<PhaseTallies> total(labels);
    for (const auto& sums : bySlice)
        for (std::size_t label = 1; label < labels; ++label) total[label].add(sums[label]);
    for (const LabelBins& bins : byThread)
        for (std::size_t label = 1; label < labels; ++label) {
            addTo(total[label].solid.bins, bins[label][0]);
            addTo(total[label].pores.bins, bins[label][1]);
        }
    return total;
}

}  // namespace vdbpack
