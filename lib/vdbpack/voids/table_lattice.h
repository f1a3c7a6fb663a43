// Private to voids: numbers of a table at the nodes of a lattice.
#pragma once

#include "vdbpack/core/box.h"

#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace vdbpack {

/// Numbers at the nodes of a complete lattice, whose planes may lie unevenly: linear along each
/// axis in between, and as at the border beyond.
class TableLattice {
public:
    /// @param numbers  points (mm) and numbers, in any order.
    /// @return nothing where the points are no complete lattice, each node once.
    static std::optional<TableLattice> from(const std::vector<std::pair<Vec<3>, double>>& numbers);

    double at(const Vec<3>& x) const;
    /// Least distance of two planes, mm; 0 for a single node.
    double step() const { return step_; }

private:
    std::array<std::vector<double>, 3> planes_;  ///< along each axis, rising, mm
    std::vector<double> values_;                 ///< x runs fastest
    double step_ = 0;
};

}  // namespace vdbpack
