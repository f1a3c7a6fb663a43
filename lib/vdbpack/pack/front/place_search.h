// Finds the places in a block that could still take a sphere.
#pragma once

#include "vdbpack/pack/front/block_state.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A search through a block for places that no front has reached: centers with room for a sphere
/// of the mean radius.
///
/// Every sphere is stamped on a bitmap of cells in which it leaves no place; the few cells left
/// are halved until a place is found or excluded. None is left with room for 1.018 mean radii.
template <int Dim>
class PlaceSearch {
public:
    /// Starts over on the block as it stands. `state` must outlive the search.
    /// @param centersOnly  looks at the centers of the cells alone: quick, and enough to find a
    ///                     beginning in an empty block.
    void start(const BlockState<Dim>& state, bool centersOnly);

    /// The next place, by the state's spheres as they stand now. Cells passed are not looked at
    /// again: fill a place, or call `skip`, before asking for the next.
    /// @return false if there is none left.
    bool next(Vec<Dim>& place);
    /// Goes on with the cell after the one that held the last place.
    void skip() { left_ &= left_ - 1; }

private:
    void stampSpheres();
    void stampOutside();
    void stampOutside(const std::array<int, 3>& at, int edge);
    std::uint64_t* row(int j, int k) {
        return &covered_[(static_cast<std::size_t>(k) * static_cast<std::size_t>(steps_[1]) +
                          static_cast<std::size_t>(j)) *
                         rowWords_];
    }
    void openWord();
    bool nextWord();
    bool hasPlace(const Vec<Dim>& center, double edge, Vec<Dim>& place);

    const BlockState<Dim>* state_ = nullptr;
    bool centersOnly_ = false;
    double wanted_ = 0;                   ///< radius that a place must have, mm
    double mostRoom_ = 0;                 ///< room that none may be left with, mm
    double step_ = 0;                     ///< edge of a cell, mm
    std::array<int, 3> steps_;            ///< cells along each axis
    std::size_t rowWords_ = 0;            ///< 64-bit words of a row of cells
    std::vector<std::uint64_t> covered_;  ///< a bit a cell: certainly no place in it
    std::array<int, 3> at_{};             ///< word being looked at, by its first cell
    std::uint64_t left_ = 0;              ///< cells of that word that are left
    std::vector<std::uint32_t> nearby_;   ///< spheres that may reach into it
};

extern template class PlaceSearch<2>;
extern template class PlaceSearch<3>;

}  // namespace vdbpack
