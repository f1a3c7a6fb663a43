// Private to measure: walls made of triangles (2D: segments), their distance and their two sides.
//
// Written apart from the domain's distances on purpose: one checks the other.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/vec.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A triangle (2D: a segment) by its corners, mm; orientation does not matter.
template <int Dim>
using WallPiece = std::array<Vec<Dim>, static_cast<std::size_t>(Dim)>;

/// Squared distance from `x` to a segment, mm².
template <int Dim>
double squaredDistanceToSegment(const Vec<Dim>& x, const Vec<Dim>& a, const Vec<Dim>& b);

/// Squared distance from `x` to a wall piece, mm²; relative error of the distance below 1e-7 of
/// the longest edge for slivers thinner than that, else rounding.
double squaredDistanceToPiece(const Vec<2>& x, const WallPiece<2>& piece);
double squaredDistanceToPiece(const Vec<3>& x, const WallPiece<3>& piece);

/// A tree of boxes over wall pieces. Immutable; shared between threads.
template <int Dim>
class WallTree {
public:
    /// @param pieces  finite, not empty.
    explicit WallTree(std::vector<WallPiece<Dim>> pieces);

    /// Squared distance to the nearest piece if that is less than `bound`, else `bound`, mm².
    double squaredDistance(const Vec<Dim>& x, double bound) const;
    /// The pieces in the tree's order: near in the list means near in space.
    const std::vector<WallPiece<Dim>>& pieces() const { return pieces_; }

private:
    struct Node {
        std::array<float, static_cast<std::size_t>(Dim)> lo, hi;  ///< rounded outward
        std::uint32_t first = 0;  ///< leaf: first piece; else the second child (the first is next)
        std::uint32_t count = 0;  ///< pieces of a leaf; 0: not a leaf
    };
    double squaredDistanceToBox(const Vec<Dim>& x, const Node& node) const;

    Vec<Dim> origin_;
    std::vector<WallPiece<Dim>> pieces_;
    std::vector<Node> nodes_;
};

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
    std::size_t clampedBin(double x, int i) const;

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

extern template class WallTree<2>;
extern template class WallTree<3>;
extern template class WallCrossings<2>;
extern template class WallCrossings<3>;
extern template class WallSides<2>;
extern template class WallSides<3>;

}  // namespace vdbpack
