// Private to verify and measure: distances to walls made of triangles (2D: segments).
//
// Written apart from the domain's distances on purpose: one checks the other.
#pragma once

#include "vdbpack/core/vec.h"
#include "vdbpack/verify/wall_shape.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Squared distance from `x` to a wall piece, mm²; relative error of the distance below 1e-7 of
/// the longest edge for slivers thinner than that, else rounding.
double squaredDistanceToPiece(const Vec<2>& x, const WallPiece<2>& piece);
double squaredDistanceToPiece(const Vec<3>& x, const WallPiece<3>& piece);

/// A tree of boxes over wall pieces: upright ones, or, where most pieces are long and thin, boxes
/// along their principal axes, since upright ones over a fan of such pieces overlap by thousands.
/// Immutable; shared between threads.
template <int Dim>
class WallTree {
public:
    /// @param pieces  finite, not empty.
    explicit WallTree(std::vector<WallPiece<Dim>> pieces);

    /// Points searched for together: four share each step of the way down the tree.
    static constexpr std::size_t kTogether = 4;
    using Points = std::array<Vec<Dim>, kTogether>;
    using Squares = std::array<double, kTogether>;

    /// Pieces by their number in `pieces`.
    using Pieces = std::array<std::uint32_t, kTogether>;
    static constexpr std::uint32_t kNone = 0xffffffff;
    static Pieces noPieces() { return {kNone, kNone, kNone, kNone}; }

    /// Squared distance to the nearest piece if that is less than `bound`, else `bound`, mm².
    double squaredDistance(const Vec<Dim>& x, double bound) const;
    /// The same for points near each other.
    /// @param nearest  becomes the nearest piece of each, unchanged where none is nearer than the
    ///                 bound. Those that were the nearest of points close by are looked at first:
    ///                 few are left to look at then.
    Squares squaredDistances(const Points& points, const Squares& bounds, Pieces& nearest) const;
    /// The pieces in the tree's order: near in the list means near in space.
    const std::vector<WallPiece<Dim>>& pieces() const { return pieces_; }

private:
    class Builder;
    class Search;
    struct Node {
        std::array<float, static_cast<std::size_t>(Dim)> lo, hi;  ///< rounded outward
        std::uint32_t first = 0;  ///< leaf: first piece; else the second child (the first is next)
        std::uint32_t count = 0;  ///< pieces of a leaf; 0: not a leaf
    };
    /// A disc, in space a flat cylinder, that holds all pieces of a node that has few: on a smooth
    /// wall it is far thinner than the box. From the tree's origin.
    struct Disc {
        std::array<float, static_cast<std::size_t>(Dim)> center, normal;
        float radius = 0;
        float half = -1;  ///< of its height; negative: there is no disc
    };
    /// A box along axes of its own.
    struct Frame {
        std::array<Vec<Dim>, static_cast<std::size_t>(Dim)> axes;
        Vec<Dim> center, half;
    };
    Vec<Dim> origin_;
    std::vector<WallPiece<Dim>> pieces_;
    std::vector<Node> nodes_;
    std::vector<Frame> frames_;  ///< of the nodes; empty: their upright boxes count
    std::vector<Disc> discs_;    ///< of the nodes; empty if frames are not
};

}  // namespace vdbpack
