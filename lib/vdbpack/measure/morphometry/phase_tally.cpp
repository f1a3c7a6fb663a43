#include "vdbpack/measure/morphometry/phase_tally.h"

#include "vdbpack/measure/morphometry/labels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

void Tally::add(const Tally& other) {
    voxels += other.voxels;
    sum += other.sum;
    squares += other.squares;
    max = std::max(max, other.max);
}

std::optional<LengthStatistics> Tally::statistics(double voxelSize) const {
    if (voxels == 0 || !(max > 0)) return std::nullopt;
    const double n = static_cast<double>(voxels);
    const double mean = sum / n;
    return LengthStatistics{mean * voxelSize,
                            std::sqrt(std::max(squares / n - mean * mean, 0.0)) * voxelSize,
                            max * voxelSize};
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
    tbb::parallel_for(std::size_t{0}, slices, [&](std::size_t z) {
        auto& sums = bySlice[z];
        sums.resize(labels);
        for (std::size_t voxel = z * slice; voxel < (z + 1) * slice; ++voxel) {
            PhaseTallies& phases = sums[static_cast<std::size_t>(labelOf(image, voxel))];
            Tally& t = image.distance[voxel] < 0 ? phases.solid : phases.pores;
            ++t.voxels;
            if (thickness.empty()) continue;
            const double value = static_cast<double>(thickness[voxel]);
            t.sum += value;
            t.squares += value * value;
            t.max = std::max(t.max, value);
        }
    });
    std::vector<PhaseTallies> total(labels);
    for (const auto& sums : bySlice)
        for (std::size_t label = 1; label < labels; ++label) total[label].add(sums[label]);
    return total;
}

}  // namespace vdbpack
