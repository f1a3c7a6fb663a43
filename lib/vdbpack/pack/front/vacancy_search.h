// Finds the vacancies that fronts have left in a block.
#pragma once

#include "vdbpack/pack/front/block_state.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// A search through a block for vacancies: centers with room for a sphere of the mean radius that
/// no front has reached.
///
/// Every sphere marks, on a bitmap of cells, those that it leaves without a vacancy; each of the
/// few other cells is halved until a vacancy is found or excluded. After a complete search there is
/// no room for 1.018 mean radii.
template <int Dim>
class VacancySearch {
public:
    /// Starts over on the block as it is now. `state` must outlive the search.
    /// @param centersOnly  tests the centers of the cells alone: quick, and enough to start
    ///                     the first front in an empty block.
    void start(const BlockState<Dim>& state, bool centersOnly);

    /// Finds the next vacancy among the spheres that `state` has now. Cells that were passed are
    /// not searched again: fill a vacancy, or call `skip`, before the next call.
    /// @return false if there is none left.
    bool next(Vec<Dim>& vacancy);
    /// Continues with the cell after the one of the last vacancy.
    void skip() { left_ &= left_ - 1; }

private:
    void stampSpheres();
    bool isShallower(const Vec<Dim>& x, double depth, double least);
    void stampOutside();
    void stampOutside(const std::array<int, 3>& at, int edge, double mostRoom);
    std::uint64_t* row(int j, int k) {
        return &covered_[(static_cast<std::size_t>(k) * static_cast<std::size_t>(steps_[1]) +
                          static_cast<std::size_t>(j)) *
                         rowWords_];
    }
    /// Whether a sphere is closer to `x` than `gap`, mm.
    bool covers(std::uint32_t i, const Vec<Dim>& x, double gap) const {
        const Sphere<Dim>& s = state_->spheres[i];
        const double reach = s.radius + gap;
        return reach > 0 && squaredLength(s.center - x) < reach * reach;
    }
    void openWord();
    bool nextWord();
    bool findIn(const Vec<Dim>& center, double edge, Vec<Dim>& vacancy);

    const BlockState<Dim>* state_ = nullptr;
    bool centersOnly_ = false;
    /// Room that a vacancy must have in a cell, mm: that of the finest sizes requested at its
    /// center, which want `own`, and beside it.
    double finestIn(const Vec<Dim>& center, double edge, double own) const;

    double wanted_ = 0;                   ///< room that a vacancy must have in the current cell, mm
    bool straddles_ = false;              ///< whether other sizes begin in it
    double step_ = 0;                     ///< edge of a cell, mm
    std::array<int, 3> steps_;            ///< cells along each axis
    std::size_t rowWords_ = 0;            ///< 64-bit words of a row of cells
    std::vector<std::uint64_t> covered_;  ///< a bit a cell: certainly no vacancy in it
    std::array<int, 3> at_{};             ///< first cell of the current word
    std::uint64_t left_ = 0;              ///< cells of that word yet to be searched
    std::vector<std::uint32_t> nearby_;   ///< spheres that may reach into it
};

}  // namespace vdbpack
