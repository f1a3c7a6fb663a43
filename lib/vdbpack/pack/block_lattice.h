// The blocks of a domain and the order in which they may be filled.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/periodic_cell.h"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace vdbpack {

/// Blocks on a lattice fixed to the domain, filled as a wavefront.
///
/// Block (i, j, k) has rank i + 2 j + 4 k, so that it never shares its rank with one of its 26
/// neighbors, and waits for those of lower rank: every front starts from finished blocks and
/// none grow towards each other. A row is a line of blocks along the first axis. The weights 1, 2,
/// 4 go to the axes from the longest to the shortest.
///
/// Along an axis that wraps, the first and the last blocks are neighbors too, but ranks do not
/// wrap: the first block starts from nothing, and the last one from spheres on both sides. Ranks of
/// neighbors across a face may be equal; of those the one with the lower number comes first. So
/// the order of the blocks stays one without cycles.
template <int Dim>
class BlockLattice {
public:
    static constexpr std::uint32_t kNone = 0xffffffffu;

    /// @param bounds   of the domain, mm.
    /// @param side     wanted edge of a block, mm: the domain is cut evenly into blocks of about
    ///                 that edge.
    /// @param lag      how far the search for vacancies lags behind the front, mm.
    /// @param quantum  faces are multiples of this power of two, mm.
    /// @param cell     of the domain: at least two blocks along the axes that wrap.
    BlockLattice(const Box<Dim>& bounds, double side, double lag, double quantum,
                 const PeriodicCell<Dim>& cell = {});

    std::size_t size() const { return order_.size(); }
    /// Blocks on the longest chain of dependencies: the least time, in blocks, on any number of
    /// threads.
    std::size_t longestChain() const { return chain_; }

    /// Where block `b` grows, and where it leaves no vacancy; see BlockFront::fill.
    Box<Dim> own(std::uint32_t b) const;
    Box<Dim> search(std::uint32_t b) const;
    /// The neighbors (`neighborBit`) that lie behind block `b` along some axis, ahead along none,
    /// and yet come later: those across a face of the cell.
    std::uint32_t laterBehind(std::uint32_t b) const;
    /// Blocks that grow or search within `box`, mm.
    std::vector<std::uint32_t> blocksIn(const Box<Dim>& box) const;
    /// A neighbor of a block, or an image of one.
    struct Neighbor {
        std::uint32_t block;
        std::array<int, Dim> offset;            ///< of the block as seen from it: -1, 0 or 1
        typename PeriodicCell<Dim>::Laps laps;  ///< cells by which its image is shifted
    };
    /// Finished neighbors of `b`, in a fixed order. Of two blocks along an axis that wraps, each is
    /// the neighbor of the other on both sides.
    std::vector<Neighbor> lowerNeighbors(std::uint32_t b) const;
    /// Of each block, the lower neighbor that hands its pool of pending radii to it, or none: each
    /// hands it to one, so that few pools are left at the end.
    /// @param share  of each block that lies in the domain: blocks without any get the pools that
    ///               others do not need.
    std::vector<std::uint32_t> poolDonors(const std::vector<double>& share) const;
    /// Which of `ranks` fills block `b`. A row stays on one of them, and neighboring rows go to
    /// different ones in turn (as columns of cells in transport sweeps: Koch, Baker, Alcouffe
    /// 1992).
    int owner(std::uint32_t b, int ranks) const;
    /// All blocks by rank: an order that meets every dependency.
    const std::vector<std::uint32_t>& order() const { return order_; }
    /// The place of block `b` in it.
    std::uint32_t place(std::uint32_t b) const { return place_[b]; }

private:
    using Index = std::array<int, Dim>;
    Index indexOf(std::uint32_t b) const;
    std::uint32_t blockAt(const Index& i) const;
    int rank(const Index& i) const;
    /// Calls `visit(Neighbor)` for all neighbors of a block.
    template <class Visit>
    void forEachNeighbor(std::uint32_t b, const Visit& visit) const;
    void orderBlocks();
    void findChain();

    std::array<bool, Dim> wraps_{};
    Vec<Dim> lo_;
    Vec<Dim> hi_ = Box<Dim>::filled(std::numeric_limits<double>::infinity());  // where it wraps
    Vec<Dim> side_;
    double lag_ = 0;
    Index count_{};
    Index weight_{};
    std::array<std::size_t, Dim> axes_{};  // by falling number of blocks
    std::size_t chain_ = 0;
    std::vector<std::uint32_t> order_;
    std::vector<std::uint32_t> place_;  // of each block in the order
};

}  // namespace vdbpack
