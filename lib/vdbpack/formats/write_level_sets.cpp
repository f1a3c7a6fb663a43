// OpenVDB files of level sets, as they are or as fog, and of the grids that other writers add.
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/field/band_width.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/vdb_init.h"
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/pack_view.h"
#include "vdbpack/formats/vdb_stream.h"

#include <fmt/format.h>
#include <openvdb/Grid.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/io.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>
#include <memory>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

namespace vdbpack {

namespace {

/// Writes to a given stream: OpenVDB's own classes open files themselves and do not notice a full
/// disk.
class GridArchive : public openvdb::io::Archive {
public:
    void writeTo(std::ostream& stream, const openvdb::GridCPtrVec& grids) {
        setCompression(hasBloscCompression()
                           ? openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK
                           : openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
        write(stream, grids, /*seekable=*/true);
    }
};

/// A level set whose leaves are compressed by all threads, a part of the tree at a time. The bytes
/// are those that OpenVDB writes leaf by leaf.
class ParallelGrid : public openvdb::FloatGrid {
public:
    /// Shares the tree and the transform of a grid.
    explicit ParallelGrid(openvdb::FloatGrid& grid)
        : openvdb::FloatGrid(grid, openvdb::ShallowCopy()) {}

    void writeBuffers(std::ostream& stream) const override {
        constexpr std::size_t kLeaves = 256, kParts = 64;  // of up to 0.6 MB each
        std::vector<const TreeType::LeafNodeType*> leaves;
        tree().getNodes(leaves);
        auto compression = openvdb::io::getStreamMetadataPtr(stream);
        std::array<std::string, kParts> parts;
        for (std::size_t first = 0; first < leaves.size(); first += kLeaves * kParts) {
            parallelFor(std::size_t{0}, kParts, [&](std::size_t p) {
                const std::size_t from = std::min(first + p * kLeaves, leaves.size());
                const std::size_t to = std::min(from + kLeaves, leaves.size());
                std::ostringstream part;
                if (compression) openvdb::io::setStreamMetadataPtr(part, compression);
                for (std::size_t k = from; k < to; ++k)
                    leaves[k]->writeBuffers(part, saveFloatAsHalf());
                parts[p] = part.str();
            });
            for (const std::string& part : parts)
                stream.write(part.data(), static_cast<std::streamsize>(part.size()));
        }
    }
};

/// A copy of the level set with a tree of its own, lengths of its transform in `unit`.
openvdb::FloatGrid::Ptr copyIn(const VdbGrid& levelSet, Unit unit, const std::string& file) {
    requireVdbVoxel(voxelSizeOf(levelSet), unit, file);
    const auto grid = levelSet.grid->deepCopy();
    grid->setTransform(levelSet.grid->transform().copy());
    grid->transform().postScale(fromMillimeters(1.0, unit));
    return grid;
}

void scaleValues(openvdb::FloatTree& tree, double scale) {
    const auto scaled = [scale](float value) {
        return static_cast<float>(scale * static_cast<double>(value));
    };
    openvdb::tree::LeafManager<openvdb::FloatTree> leaves(tree);
    leaves.foreach ([&scaled](openvdb::FloatTree::LeafNodeType& leaf, std::size_t) {
        for (auto v = leaf.beginValueAll(); v; ++v) v.setValue(scaled(*v));
    });
    auto tile = tree.beginValueAll();
    tile.setMaxDepth(openvdb::FloatTree::ValueAllIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) tile.setValue(scaled(*tile));
    tree.root().setBackground(scaled(tree.background()), /*updateChildNodes=*/false);
}

/// The level set in `unit`; shares the tree of `levelSet` if that is mm.
openvdb::FloatGrid::Ptr levelSetIn(const VdbGrid& levelSet, Unit unit, const std::string& file) {
    openvdb::FloatGrid::Ptr grid;
    if (unit == Unit::millimeter) {
        grid = levelSet.grid->copy();
    } else {
        grid = copyIn(levelSet, unit, file);
        scaleValues(grid->tree(), fromMillimeters(1.0, unit));
    }
    grid->setName(levelSet.grid->getName());
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    return grid;
}

}  // namespace

void writeGrids(const PackWriteOptions& options, const std::vector<openvdb::GridBase::Ptr>& others,
                OutputFile& out) {
    openvdb::GridCPtrVec grids;
    const auto add = [&](const openvdb::GridBase::Ptr& grid) {
        grid->insertMeta(kUnitKey, openvdb::StringMetadata(unitName(options.unit)));
        if (!options.generator.empty())
            grid->insertMeta(kGeneratorKey, openvdb::StringMetadata(options.generator));
        const auto levelSet = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
        if (levelSet)
            grids.push_back(std::make_shared<ParallelGrid>(*levelSet));
        else
            grids.push_back(grid);
    };
    for (const auto& set : options.levelSets)
        if (set && set->grid) add(levelSetIn(*set, options.unit, out.path()));
    for (const auto& grid : others) add(grid);

    // A stream that throws on failure, to report a full disk.
    std::ofstream stream;
    errno = 0;
    try {
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        stream.open(out.temporaryPath(), std::ios::binary | std::ios::trunc);
        GridArchive().writeTo(stream, grids);
        stream.close();
    } catch (const std::exception& e) {
        const int cause = errno;
        // The destructor must not throw again.
        stream.exceptions(std::ios::goodbit);
        if (isShortage(e)) throw;
        throw IoError(
            fmt::format("{}: writing failed: {}; a previous file of that name is unchanged",
                        out.path(), cause != 0 ? std::strerror(cause) : e.what()));
    }
}

void writeLevelSets(const std::string& file, const PackWriteOptions& options) {
    OutputFile out(file);
    initializeOpenVdb();
    writeGrids(options, {}, out);
    out.commit();
}

void writeFog(const VdbGrid& levelSet, const std::string& file, const PackWriteOptions& options) {
    OutputFile out(file);
    initializeOpenVdb();
    // Values are fractions of the depth of the band, without a unit; voxels have one.
    const auto grid = copyIn(levelSet, options.unit, file);
    makeFog(*grid);
    grid->setName("density");
    PackWriteOptions alone = options;
    alone.levelSets.clear();
    writeGrids(alone, {grid}, out);
    out.commit();
}

}  // namespace vdbpack
