#include "vdbpack/field/surface_level_set.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/field/vdb_init.h"

#include <fmt/format.h>
#include <openvdb/tools/Prune.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <vector>

namespace vdbpack {

namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using Leaf = FloatGrid::TreeType::LeafNodeType;

constexpr double kBandVoxels = 3;
/// Voxels along a block that is looked at as a whole first: a node of the tree.
constexpr int kBlock = 128;

/// The part of a grid in one block.
struct Block {
    bool inside = false;  ///< all of it
    std::vector<std::unique_ptr<Leaf>> leafs;
    std::vector<Coord> tiles;  ///< of the size of a leaf, inside
};

std::shared_ptr<const VdbGrid> sampled(const Domain<3>& domain, double h) {
    initializeOpenVdb();
    const Box<3> bounds = domain.bounds();
    const Vec<3> origin = fieldOrigin(bounds, h);
    const double band = kBandVoxels * h;
    const auto width = static_cast<float>(band);
    Coord lo, hi;
    for (int d = 0; d < 3; ++d) {
        const double first = std::floor((bounds.lo[d] - band - origin[d]) / h / kBlock);
        const double last = std::floor((bounds.hi[d] + band - origin[d]) / h / kBlock);
        if (!(std::max(std::fabs(first), std::fabs(last)) < 1e5))
            throw ResourceError(
                fmt::format("voxels of {:.4g} mm are too many for a domain of {:.4g} mm; "
                            "give larger ones",
                            h, bounds.size()[d]));
        lo[d] = static_cast<int>(first);
        hi[d] = static_cast<int>(last);
    }
    std::vector<Coord> blocks;
    for (int i = lo[0]; i <= hi[0]; ++i)
        for (int j = lo[1]; j <= hi[1]; ++j)
            for (int k = lo[2]; k <= hi[2]; ++k) blocks.emplace_back(i, j, k);
    std::vector<Block> made(blocks.size());
    tbb::enumerable_thread_specific<std::unique_ptr<DomainSampler<3>>> samplers(
        [&] { return domain.sampler(); });
    const auto centerOf = [&](const Coord& first, int side) {
        Vec<3> x = origin;
        for (int d = 0; d < 3; ++d) x[d] += (first[d] + 0.5 * (side - 1)) * h;
        return x;
    };
    const auto radiusOf = [&](int side) { return 0.5 * (side - 1) * h * std::sqrt(3.0); };
    const double deepest = -domain.fieldDepth() * (1 - 1e-9);
    // Known as deep as `reach`: where the field ends, from the wall itself.
    const auto distanceAt = [&](DomainSampler<3>& sampler, const Vec<3>& x, double reach) {
        const double field = sampler.signedDistance(x);
        if (field > deepest) return field;
        WallPoint<3> wall;
        return -(sampler.nearestWall(x, reach, wall) ? wall.distance : reach);
    };
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t n) {
        DomainSampler<3>& sampler = *samplers.local();
        Block& block = made[n];
        const Coord first(blocks[n][0] * kBlock, blocks[n][1] * kBlock, blocks[n][2] * kBlock);
        const double middle = distanceAt(sampler, centerOf(first, kBlock), radiusOf(kBlock) + band);
        if (middle - radiusOf(kBlock) >= band) return;
        block.inside = middle + radiusOf(kBlock) <= -band;
        if (block.inside) return;
        for (int i = 0; i < kBlock; i += 8)
            for (int j = 0; j < kBlock; j += 8)
                for (int k = 0; k < kBlock; k += 8) {
                    const Coord at = first.offsetBy(i, j, k);
                    const double near = distanceAt(sampler, centerOf(at, 8), radiusOf(8) + band);
                    if (near - radiusOf(8) >= band) continue;
                    if (near + radiusOf(8) <= -band) {
                        block.tiles.push_back(at);
                        continue;
                    }
                    auto leaf = std::make_unique<Leaf>(at, width, false);
                    bool inside = true, outside = true;
                    for (openvdb::Index v = 0; v < Leaf::SIZE; ++v) {
                        const Vec<3> x = centerOf(at + Leaf::offsetToLocalCoord(v), 1);
                        const auto d = static_cast<float>(
                            std::clamp(distanceAt(sampler, x, band), -band, band));
                        inside = inside && d <= -width;
                        outside = outside && d >= width;
                        if (std::fabs(d) < width)
                            leaf->setValueOn(v, d);
                        else
                            leaf->setValueOff(v, d);
                    }
                    if (inside)
                        block.tiles.push_back(at);
                    else if (!outside)
                        block.leafs.push_back(std::move(leaf));
                }
    });
    auto grid = FloatGrid::create(width);
    for (std::size_t n = 0; n < blocks.size(); ++n) {
        Block& block = made[n];
        if (block.inside)
            grid->tree().addTile(
                2, Coord(blocks[n][0] * kBlock, blocks[n][1] * kBlock, blocks[n][2] * kBlock),
                -width, false);
        for (const Coord& tile : block.tiles) grid->tree().addTile(1, tile, -width, false);
        for (auto& leaf : block.leafs) grid->tree().addLeaf(leaf.release());
    }
    openvdb::tools::prune(grid->tree());
    const auto transform = openvdb::math::Transform::createLinearTransform(h);
    transform->postTranslate(openvdb::Vec3d(origin[0], origin[1], origin[2]));
    grid->setTransform(transform);
    grid->setName("surface");
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    return std::make_shared<VdbGrid>(grid);
}

}  // namespace

std::shared_ptr<const VdbGrid> surfaceLevelSet(const Domain<3>& domain, double voxelSize) {
    if (!(voxelSize > 0 && std::isfinite(voxelSize)))
        throw ParameterError(fmt::format("voxel size {} mm must be positive", voxelSize));
    try {
        if (const auto* mesh = dynamic_cast<const MeshDomain*>(&domain))
            return mesh->gridOf(voxelSize);
        return sampled(domain, voxelSize);
    } catch (const std::bad_alloc&) {
        throw ResourceError(fmt::format(
            "not enough memory for a surface in voxels of {:.4g} mm; give larger ones", voxelSize));
    }
}

}  // namespace vdbpack
