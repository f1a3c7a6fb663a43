// Private to verify: which side of a wall made of triangles (2D: segments) centers are on.
//
// Independent of the domain's inside tests on purpose: one checks the other.
#pragma once

#include "vdbpack/core/sphere.h"
#include "vdbpack/verify/wall_shape.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Which side of a wall the centers of spheres are on, by the parity of the crossings of lines
/// along an axis: nested shells are cavities, whichever way they face.
///
/// A line through a shared edge or corner is counted by a half-open rule that depends on the edge
/// alone, so that for a wall whose edges all join an even number of pieces the parity is exact for
/// every center farther from the wall than rounding. Where some edge joins an odd number of pieces
/// (2D: some end an odd number of segments), lines to both sides along every axis vote, and a tie
/// counts as outside.
template <int Dim>
class WallSides {
public:
    /// Cost: linear in the pieces and in the centers that they lie above or below.
    /// @param pieces, spheres  finite.
    WallSides(const std::vector<WallPiece<Dim>>& pieces, const std::vector<Sphere<Dim>>& spheres);

    bool inside(std::size_t sphere) const { return inside_[sphere] != 0; }
    bool allInside() const { return std::find(inside_.begin(), inside_.end(), 0) == inside_.end(); }
    /// Whether every edge (2D: end) joins an even number of pieces.
    bool closed() const { return closed_; }

private:
    bool closed_ = true;
    std::vector<std::uint8_t> inside_;
};

}  // namespace vdbpack
