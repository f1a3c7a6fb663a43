// Private to measure: volumes and local thicknesses by label and phase.
#pragma once

#include "vdbpack/field/voxel_image.h"
#include "vdbpack/measure/morphometry/morphometry.h"

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace vdbpack {

/// Over the voxels of one phase of one label.
struct Tally {
    std::uint64_t voxels = 0;
    double sum = 0, squares = 0, max = 0;  // of the thickness, voxels
    double min = std::numeric_limits<double>::infinity();
    std::vector<std::uint32_t> bins;  ///< voxels by thickness, in classes of 1/32 voxel

    void add(const Tally& other);
    /// Nothing where there is no voxel or no surface.
    std::optional<LengthStatistics> statistics(double voxelSize) const;
};

struct PhaseTallies {
    Tally solid, pores;
    std::uint64_t voxels() const { return solid.voxels + pores.voxels; }
    void add(const PhaseTallies& other);
};

/// One entry a label; that of label 0 is empty.
/// @param thickness  one value a voxel, voxels; empty: none.
/// The same for any number of threads, each of which has histograms of its own. Cost: 3
/// ns a voxel on two threads (22 ms for 200³ voxels).
std::vector<PhaseTallies> tallyPhases(const VoxelImage& image, const std::vector<float>& thickness);

}  // namespace vdbpack
