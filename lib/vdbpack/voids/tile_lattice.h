// Private to voids: the tiles of voxels that cover a domain.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/error.h"
#include "vdbpack/field/lattice_edge.h"
#include "vdbpack/voids/tile.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdbpack {

/// Half-width of the band of stamped voids, voxels.
inline constexpr double kStampBand = 3;
/// Tiles along each axis, so that a key fits 64 bits.
inline constexpr std::int64_t kMostTiles = std::int64_t{1} << 21;

/// The tiles that cover a domain.
template <int Dim>
class TileLattice {
public:
    TileLattice(const Box<Dim>& bounds, double voxelSize, const Vec<Dim>& origin)
        : h_(voxelSize), origin_(origin) {
        const double margin = 2 * kStampBand * h_;
        for (int d = 0; d < Dim; ++d) {
            const auto at = static_cast<std::size_t>(d);
            const double lo = tileOf(bounds.lo[d] - margin, d);
            const double hi = tileOf(bounds.hi[d] + margin, d);
            if (!(hi - lo < static_cast<double>(kMostTiles) &&
                  std::max(std::fabs(lo), std::fabs(hi)) < 1e8))
                throw ResourceError(fmt::format(
                    "voxels of {:.4g} mm would take {:.3g} tiles of eight along a domain of {:.4g} "
                    "mm; give a larger `voids.voxelSize`",
                    h_, hi - lo, bounds.hi[d] - bounds.lo[d]));
            first_[at] = static_cast<std::int64_t>(lo);
            count_[at] = static_cast<std::int64_t>(hi - lo) + 1;
        }
    }

    /// Distance from the middle of a tile to its farthest voxel center, mm.
    double radius() const { return 0.5 * (kTileSide - 1) * h_ * std::sqrt(double{Dim}); }
    double tiles() const {
        double n = 1;
        for (std::size_t d = 0; d < Dim; ++d) n *= static_cast<double>(count_[d]);
        return n;
    }
    /// The index of the part, of `parts` parts of the lattice, that contains a tile; rises with it.
    std::size_t partOf(std::uint64_t tile, std::size_t parts) const {
        const auto t = indexOf(tile);
        double n = 0;
        for (std::size_t d = 0; d < Dim; ++d)
            n = n * static_cast<double>(count_[d]) + static_cast<double>(t[d]);
        return static_cast<std::size_t>(n / tiles() * static_cast<double>(parts));
    }
    /// Calls `visit(tile, its middle)` for the tiles that meet a box.
    template <class Visit>
    void forEach(const Box<Dim>& box, const Visit& visit) const {
        std::array<std::int64_t, 3> lo{}, hi{};
        for (int d = 0; d < Dim; ++d) {
            const auto at = static_cast<std::size_t>(d);
            const double last = static_cast<double>(count_[at] - 1);
            const auto index = [&](double x) {
                return static_cast<std::int64_t>(
                    std::clamp(tileOf(x, d) - static_cast<double>(first_[at]), -1.0, last + 1));
            };
            lo[at] = std::max<std::int64_t>(index(box.lo[d]), 0);
            hi[at] = std::min(index(box.hi[d]), count_[at] - 1);
        }
        std::array<std::int64_t, 3> t{};
        for (t[0] = lo[0]; t[0] <= hi[0]; ++t[0])
            for (t[1] = lo[1]; t[1] <= hi[1]; ++t[1])
                for (t[2] = lo[2]; t[2] <= hi[2]; ++t[2]) visit(key(t), middle(t));
    }
    /// The tile that contains a point; false if there is none.
    bool find(const Vec<Dim>& x, std::uint64_t& tile) const {
        std::array<std::int64_t, 3> t{};
        for (int d = 0; d < Dim; ++d) {
            const auto at = static_cast<std::size_t>(d);
            const double index = tileOf(x[d], d) - static_cast<double>(first_[at]);
            if (!(index >= 0 && index < static_cast<double>(count_[at]))) return false;
            t[at] = static_cast<std::int64_t>(index);
        }
        tile = key(t);
        return true;
    }
    Vec<Dim> middleOf(std::uint64_t tile) const { return middle(indexOf(tile)); }
    Vec<Dim> firstCenterOf(std::uint64_t tile) const {
        Vec<Dim> x = middleOf(tile);
        for (int d = 0; d < Dim; ++d) x[d] -= 0.5 * (kTileSide - 1) * h_;
        return x;
    }
    VoxelIndex firstVoxelOf(std::uint64_t tile) const {
        const auto t = indexOf(tile);
        VoxelIndex at{};
        for (std::size_t d = 0; d < Dim; ++d)
            at[d] = static_cast<int>((first_[d] + t[d]) * kTileSide);
        return at;
    }

private:
    double tileOf(double x, int d) const {
        return std::floor(((x - origin_[d]) / h_ + 0.5) / kTileSide);
    }
    std::uint64_t key(const std::array<std::int64_t, 3>& t) const {
        std::uint64_t k = 0;
        for (std::size_t d = 0; d < Dim; ++d)
            k = k * static_cast<std::uint64_t>(kMostTiles) + static_cast<std::uint64_t>(t[d]);
        return k;
    }
    std::array<std::int64_t, 3> indexOf(std::uint64_t tile) const {
        std::array<std::int64_t, 3> t{};
        for (std::size_t d = Dim; d-- > 0;) {
            t[d] = static_cast<std::int64_t>(tile % static_cast<std::uint64_t>(kMostTiles));
            tile /= static_cast<std::uint64_t>(kMostTiles);
        }
        return t;
    }
    Vec<Dim> middle(const std::array<std::int64_t, 3>& t) const {
        Vec<Dim> x;
        for (int d = 0; d < Dim; ++d) {
            const auto at = static_cast<std::size_t>(d);
            x[d] = origin_[d] +
                   (static_cast<double>((first_[at] + t[at]) * kTileSide) + 0.5 * (kTileSide - 1)) *
                       h_;
        }
        return x;
    }

    double h_;
    Vec<Dim> origin_;
    std::array<std::int64_t, 3> first_{}, count_{};
};

}  // namespace vdbpack
