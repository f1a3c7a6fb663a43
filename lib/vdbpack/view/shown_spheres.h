// Private to views: which spheres a view shows, and in which order.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/view/view.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// Places on a cubic lattice of 65536 steps along the longest side of a box.
struct Lattice {
    Vec<3> lo;
    double step = 0;  ///< mm

    explicit Lattice(const Box<3>& bounds);
    std::array<std::uint32_t, 3> at(const Vec<3>& x) const;
};

struct ShownSpheres {
    std::vector<std::uint32_t>
        rows;  ///< of the pack: outer, inner, buried ones, each along a curve
    std::vector<std::uint64_t> codes;  ///< Morton codes of their centers
    std::size_t outer = 0, inner = 0;  ///< numbers of the first two kinds
    double depth = 0;   ///< below a cut, mm: what lies deeper is hidden by what lies above it
    std::string words;  ///< on what is left out; empty: nothing
};

/// @param lattice  of all centers.
ShownSpheres shownSpheres(const std::vector<Sphere<3>>& spheres, const Lattice& lattice,
                          const ViewOptions& options);
/// All circles come into sight.
ShownSpheres shownSpheres(const std::vector<Sphere<2>>& circles, const Lattice& lattice,
                          const ViewOptions& options);

/// The center as a point of space.
Vec<3> inSpace(const Vec<3>& x);
Vec<3> inSpace(const Vec<2>& x);

}  // namespace vdbpack
