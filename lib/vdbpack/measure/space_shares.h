// The spheres of all ranks by place: for measures that need the neighbors of a sphere.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/ranks.h"
#include "vdbpack/core/sphere.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Cuts space into parts with about as many spheres each, of which every rank works on one at a
/// time, so that it never holds more than some hundred thousand spheres of others.
///
/// Space is cut into slices across the first axis, one a round, and each slice into one part for
/// each rank. Nothing of this depends on how the spheres were packed. All members but `rounds` are
/// called by all ranks.
template <int Dim>
class SpaceShares {
public:
    struct Part {
        std::size_t own = 0;               ///< spheres with centers in the part, which come first
        std::vector<Sphere<Dim>> spheres;  ///< these, and those of other parts near them
        std::vector<std::int64_t> rows;    ///< of each sphere
        std::vector<std::uint8_t> shared;  ///< of each: 1 if several parts have it
        std::vector<float> depth;          ///< of each own sphere, if depths were given
    };

    /// Which spheres are near to which.
    struct Near {
        double slack;      ///< up to a gap of `slack` times the smaller radius,
        double reach = 0;  ///< and up to a distance of the centers, mm
        /// In which the spheres repeat, all with their centers in it: parts have images of spheres
        /// beyond its faces, too, with the row of what they are images of.
        PeriodicCell<Dim> cell{};
    };

    /// @param spheres  of this rank. @param rows  a number that goes with each.
    /// @param depth    of each sphere, mm; null: parts have none.
    /// @param perPart  own spheres of a part, about: 40 bytes each while they are sent, and as much
    ///                 again for their measures.
    SpaceShares(Ranks& ranks, const std::vector<Sphere<Dim>>& spheres,
                const std::vector<std::int64_t>& rows, const Near& near,
                const std::vector<float>* depth = nullptr, std::uint64_t perPart = 250'000);

    std::size_t rounds() const { return rounds_; }
    Part part(std::size_t round);
    /// Returns to each sphere the number that the last part found for it.
    /// @param found  of the own spheres of that part. @param numbers  of the spheres of this rank.
    void handBack(const std::vector<std::int32_t>& found, std::vector<std::int32_t>& numbers);

private:
    struct Sent {
        Sphere<Dim> sphere;
        std::int64_t row;
        std::uint32_t shared;
        float depth;
    };

    using Lists = std::vector<std::vector<Sent>>;  // to each rank

    double reachOf(const Sphere<Dim>& s) const;
    void send(std::size_t round, std::size_t i, const Vec<Dim>& shift, bool hasImages, Lists& own,
              Lists& near);
    /// Parts along an axis whose interval begins before `x`, less one.
    std::size_t cellAt(double x, int axis) const;

    Ranks& ranks_;
    const std::vector<Sphere<Dim>>& spheres_;
    const std::vector<std::int64_t>& rows_;
    const std::vector<float>* depth_;
    Near near_;
    double largest_ = 0;  // radius
    Box<Dim> bounds_;     // of the centers
    std::size_t rounds_ = 1;
    std::array<std::size_t, Dim> cells_{};        // along each axis: slices, and parts of a slice
    std::vector<std::vector<std::size_t>> sent_;  // spheres that each rank had as its own
    std::vector<std::size_t> received_;           // own spheres from each rank
};

}  // namespace vdbpack
