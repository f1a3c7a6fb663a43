#include "vdbpack/voids/stamp_memory.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/voids/tile_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Bytes of a leaf of a tree, of an entry (a void listed at a tile), and the number of level sets.
constexpr double kBytesPerLeaf = 2300, kBytesPerEntry = 24, kLevelSets = 4;

/// The number of tiles that the box of a void meets.
template <int Dim>
double entriesOf(const Ellipsoid<Dim>& e, const Box<Dim>& within, double reach, double side) {
    const Box<Dim> box = intersection(e.bounds().grown(reach), within);
    if (box.empty()) return 0;
    double tiles = 1;
    for (int d = 0; d < Dim; ++d) tiles *= box.size()[d] / side + 1;
    return tiles;
}

/// @param entriesIn(within, reach, side)  returns the number of entries.
template <int Dim, class Entries>
double bytesFor(const Domain<Dim>& domain, const StampOptions<Dim>& options,
                const Entries& entriesIn) {
    const double side = kTileSide * options.voxelSize, tile = std::pow(side, Dim);
    const double reach = std::max(kStampBand * options.voxelSize, options.reach);
    const double entries = entriesIn(domain.bounds().grown(reach), reach, side);
    // At most the leaves that the domain covers.
    const double leaves =
        std::min(entries, domain.volume() / tile + 2 * domain.wallArea() * side / tile + 27);
    return entries * kBytesPerEntry + leaves * kBytesPerLeaf * kLevelSets;
}

void requireMemory(double voids, double needed, double voxelSize) {
    const double there = availableMemory();
    if (!(needed > there)) return;
    throw ResourceError(fmt::format(
        "{:.0f} voids in voxels of {:.4g} mm may take {:.3g} GB of memory, and {:.3g} GB "
        "are available; give a larger `voids.voxelSize`, or clip the domain",
        voids, voxelSize, needed * 1e-9, there * 1e-9));
}

}  // namespace

template <int Dim>
double stampBytes(const std::vector<Ellipsoid<Dim>>& voids, const Domain<Dim>& domain,
                  const StampOptions<Dim>& options) {
    return bytesFor(domain, options, [&](const Box<Dim>& within, double reach, double side) {
        double entries = 0;
        for (const auto& e : voids) entries += entriesOf(e, within, reach, side);
        return entries;
    });
}

template <int Dim>
void requireStampMemory(const std::vector<Ellipsoid<Dim>>& voids, const Domain<Dim>& domain,
                        const StampOptions<Dim>& options) {
    requireMemory(static_cast<double>(voids.size()), stampBytes(voids, domain, options),
                  options.voxelSize);
}

template <int Dim>
void requireStampMemory(double count, const Ellipsoid<Dim>& one, const Domain<Dim>& domain,
                        const StampOptions<Dim>& options) {
    const auto bytes =
        bytesFor(domain, options, [&](const Box<Dim>& within, double reach, double side) {
            return count * entriesOf(one, within, reach, side);
        });
    requireMemory(count, bytes, options.voxelSize);
}

template double stampBytes(const std::vector<Ellipsoid<2>>&, const Domain<2>&,
                           const StampOptions<2>&);
template void requireStampMemory(const std::vector<Ellipsoid<2>>&, const Domain<2>&,
                                 const StampOptions<2>&);
template void requireStampMemory(double, const Ellipsoid<2>&, const Domain<2>&,
                                 const StampOptions<2>&);
template double stampBytes(const std::vector<Ellipsoid<3>>&, const Domain<3>&,
                           const StampOptions<3>&);
template void requireStampMemory(const std::vector<Ellipsoid<3>>&, const Domain<3>&,
                                 const StampOptions<3>&);
template void requireStampMemory(double, const Ellipsoid<3>&, const Domain<3>&,
                                 const StampOptions<3>&);

}  // namespace vdbpack
