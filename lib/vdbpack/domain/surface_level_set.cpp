#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/level_set_builder.h"
#include "vdbpack/field/smallest_voxel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

constexpr double kBandVoxels = 3;
constexpr int kBlock = LevelSetBuilder::kLargeSide;  ///< voxels along a cube looked at first
constexpr int kTile = LevelSetTile::kSide;

/// Distances to the wall of a domain on the lattice of its level set; one per thread.
class LatticeSampler {
public:
    LatticeSampler(const Domain<3>& domain, const Vec<3>& origin, double voxelSize)
        : sampler_(domain.sampler()),
          origin_(origin),
          voxelSize_(voxelSize),
          deepest_(-domain.fieldDepth() * (1 - 1e-9)) {}

    Vec<3> centerOf(const VoxelIndex& first, int side) const {
        Vec<3> x = origin_;
        for (int d = 0; d < 3; ++d)
            x[d] += (first[static_cast<std::size_t>(d)] + 0.5 * (side - 1)) * voxelSize_;
        return x;
    }
    /// Known as deep as `reach`; where the field ends, from the wall itself.
    double distanceAt(const Vec<3>& x, double reach) {
        const double field = sampler_->signedDistance(x);
        if (field > deepest_) return field;
        WallPoint<3> wall;
        return -(sampler_->nearestWall(x, reach, wall) ? wall.distance : reach);
    }
    /// Of the centers of the voxels in a cube: whether they all lie at least `band` outside (1) or
    /// inside (-1), else 0.
    int sideOf(const VoxelIndex& first, int side, double band) {
        const double radius = 0.5 * (side - 1) * voxelSize_ * std::sqrt(3.0);
        const double middle = distanceAt(centerOf(first, side), radius + band);
        if (middle - radius >= band) return 1;
        return middle + radius <= -band ? -1 : 0;
    }

private:
    std::unique_ptr<DomainSampler<3>> sampler_;
    Vec<3> origin_;
    double voxelSize_;
    double deepest_;
};

/// The part of a level set in one cube of `kBlock` voxels.
struct Block {
    VoxelIndex first{};
    bool inside = false;  ///< all of it
    std::vector<LevelSetTile> tiles;
    std::vector<VoxelIndex> insideTiles;
};

/// The blocks that cover the bounds of a domain and the band around it.
std::vector<Block> coveringBlocks(const Box<3>& bounds, const Vec<3>& origin, double voxelSize) {
    const double band = kBandVoxels * voxelSize;
    VoxelIndex lo{}, hi{};
    for (int d = 0; d < 3; ++d) {
        const double first = std::floor((bounds.lo[d] - band - origin[d]) / voxelSize / kBlock);
        const double last = std::floor((bounds.hi[d] + band - origin[d]) / voxelSize / kBlock);
        if (!(std::max(std::fabs(first), std::fabs(last)) < 1e5))
            throw ResourceError(fmt::format(
                "voxels of {:.4g} mm are too many for a domain of {:.4g} mm; give larger ones",
                voxelSize, bounds.size()[d]));
        lo[static_cast<std::size_t>(d)] = static_cast<int>(first);
        hi[static_cast<std::size_t>(d)] = static_cast<int>(last);
    }
    std::vector<Block> blocks;
    for (int i = lo[0]; i <= hi[0]; ++i)
        for (int j = lo[1]; j <= hi[1]; ++j)
            for (int k = lo[2]; k <= hi[2]; ++k) {
                blocks.emplace_back();
                blocks.back().first = {i * kBlock, j * kBlock, k * kBlock};
            }
    return blocks;
}

/// Adds the tile at `first` to a block, unless all of its voxels lie outside.
void sampleTile(LatticeSampler& sampler, const VoxelIndex& first, double band, Block& block) {
    const int side = sampler.sideOf(first, kTile, band);
    if (side > 0) return;
    if (side < 0) {
        block.insideTiles.push_back(first);
        return;
    }
    const auto width = static_cast<float>(band);
    LevelSetTile tile(first, width);
    std::bitset<LevelSetTile::kVoxels> active;
    bool inside = true, outside = true;
    float* const values = tile.values();
    for (std::size_t v = 0; v < LevelSetTile::kVoxels; ++v) {
        const int n = static_cast<int>(v);
        const Vec<3> x =
            sampler.centerOf(offsetBy(first, n / (kTile * kTile), n / kTile % kTile, n % kTile), 1);
        const auto d = static_cast<float>(std::clamp(sampler.distanceAt(x, band), -band, band));
        inside = inside && d <= -width;
        outside = outside && d >= width;
        values[v] = d;
        active[v] = std::fabs(d) < width;
    }
    if (outside) return;
    if (inside) {
        block.insideTiles.push_back(first);
        return;
    }
    tile.setActive(active);
    block.tiles.push_back(std::move(tile));
}

void sampleBlock(LatticeSampler& sampler, double band, Block& block) {
    const int side = sampler.sideOf(block.first, kBlock, band);
    block.inside = side < 0;
    if (side != 0) return;
    for (int i = 0; i < kBlock; i += kTile)
        for (int j = 0; j < kBlock; j += kTile)
            for (int k = 0; k < kBlock; k += kTile)
                sampleTile(sampler, offsetBy(block.first, i, j, k), band, block);
}

std::shared_ptr<const VdbGrid> sampled(const Domain<3>& domain, double voxelSize) {
    const Vec<3> origin = fieldOrigin(domain.bounds(), voxelSize);
    const double band = kBandVoxels * voxelSize;
    std::vector<Block> blocks = coveringBlocks(domain.bounds(), origin, voxelSize);
    PerThread<LatticeSampler> samplers([&] { return LatticeSampler(domain, origin, voxelSize); });
    parallelFor(std::size_t{0}, blocks.size(),
                [&](std::size_t n) { sampleBlock(samplers.local(), band, blocks[n]); });
    const auto width = static_cast<float>(band);
    LevelSetBuilder builder(width, width);
    for (Block& block : blocks) {
        if (block.inside) builder.addInside(block.first, kBlock);
        for (const VoxelIndex& tile : block.insideTiles) builder.addInside(tile, kTile);
        for (LevelSetTile& tile : block.tiles) builder.add(std::move(tile));
    }
    return builder.finish("surface", origin, voxelSize);
}

}  // namespace

std::shared_ptr<const VdbGrid> surfaceLevelSet(const Domain<3>& domain, double voxelSize) {
    if (!(voxelSize >= kSmallestVoxel && std::isfinite(voxelSize)))
        throw ParameterError(
            fmt::format("voxel size {} mm must be at least {} mm, in a domain in "
                        "proportion",
                        voxelSize, kSmallestVoxel));
    try {
        if (const auto* mesh = dynamic_cast<const MeshDomain*>(&domain))
            return mesh->gridOf(voxelSize);
        if (const PeriodicCell<3> cell = domain.cell(); cell.any())
            return sampled(*boxDomain(cell.box), voxelSize);
        return sampled(domain, voxelSize);
    } catch (const std::bad_alloc&) {
        throw ResourceError(fmt::format(
            "not enough memory for a surface in voxels of {:.4g} mm; give larger ones", voxelSize));
    }
}

}  // namespace vdbpack
