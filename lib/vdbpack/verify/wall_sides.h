// Private to verify: which side of a wall made of triangles (2D: segments) a point is on.
//
// Independent of the domain's inside tests on purpose: one checks the other.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/verify/wall_shape.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Counts where lines along one axis cross the wall, by bins across that axis.
///
/// A line through a shared edge or corner is counted by a half-open rule that depends on the edge
/// alone, so that for a wall whose edges all join an even number of pieces the parity is exact for
/// every point farther from the wall than rounding.
template <int Dim>
class WallCrossings {
public:
    /// @param pieces  must outlive this object.
    WallCrossings(const std::vector<WallPiece<Dim>>& pieces, int axis);

    struct Count {
        int above = 0, below = 0;
    };
    Count count(const Vec<Dim>& x) const;

private:
    /// Calls `visit(first, last)` for each run of bins that a piece's shadow meets.
    template <typename Visit>
    void forEachRun(const WallPiece<Dim>& piece, const Visit& visit) const;
    /// Calls `work(i)` for all pieces, in blocks; a block ends early once it returns false.
    template <typename Work>
    void forAllPieces(const Work& work) const;
    std::size_t clampedBin(double x, int i) const;
    void chooseBins();
    void fillBins();

    const std::vector<WallPiece<Dim>>& pieces_;
    int axis_;
    std::array<int, 2> across_{};  ///< the other axes; 2D: the first only
    Box<Dim> bounds_;
    std::array<std::size_t, 2> bins_{1, 1};
    std::array<double, 2> binSize_{1, 1};  ///< mm
    std::vector<std::uint32_t> start_, members_;
};

/// Which side of a wall a point is on, by parity: nested shells are cavities, whichever way they
/// face. Where some edge joins an odd number of pieces (2D: some end an odd number of segments),
/// lines to both sides along every axis vote, and a tie counts as outside.
template <int Dim>
class WallSides {
public:
    explicit WallSides(const std::vector<WallPiece<Dim>>& pieces);
    bool inside(const Vec<Dim>& x) const;
    /// Whether every edge (2D: end) joins an even number of pieces.
    bool closed() const { return closed_; }

private:
    bool closed_ = true;
    std::vector<WallCrossings<Dim>> axes_;
};

}  // namespace vdbpack
