#include "vdbpack/measure/morphometry/euler.h"

#include "vdbpack/core/parallel.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

namespace {

/// Shares are k / n of a cell for n up to 8 voxels around it, halved up to three times.
constexpr int kUnit = 840 * 8;

/// Cells that belong to the total volume, with their signs.
struct Sums {
    std::int64_t whole = 0;
    std::int64_t share = 0;  // in 1 / kUnit

    /// @param around  solid voxels around the cell: in the total volume, and 16 times all.
    /// @param planes  faces of the image that the cell lies in.
    void add(int sign, int around, int planes) {
        const int in = around & 15, all = around >> 4;
        if (in == 0) return;
        whole += sign;
        share += sign * (in == all ? kUnit >> planes : (kUnit / all * in) >> planes);
    }
};

/// A row of voxels with an empty one at both ends: 17 for solid in the part, 16 for other solid, 0
/// for none.
void loadRow(const VoxelImage& image, int label, std::int64_t y, std::int64_t z,
             std::vector<std::uint8_t>& row) {
    const auto n = static_cast<std::size_t>(image.size[0]);
    row.assign(n + 2, 0);
    if (y < 0 || z < 0 || y >= image.size[1] || z >= image.size[2]) return;
    const std::size_t first = static_cast<std::size_t>(z * image.size[1] + y) * n;
    const bool walled = !image.depth.empty();
    for (std::size_t x = 0; x < n; ++x) {
        if (!(image.distance[first + x] < 0)) continue;
        const bool total = image.inTotal(first + x);
        if (!total && walled) continue;
        row[x + 1] = total && isLabeled(image, first + x, label) ? 17 : 16;
    }
}

}  // namespace

EulerNumbers eulerNumbers(const VoxelImage& image, int label) {
    const auto nx = static_cast<std::size_t>(image.size[0]);
    const std::int64_t ny = image.size[1], nz = image.size[2];
    std::vector<Sums> sums(static_cast<std::size_t>(nz) + 1);
    parallelFor(std::int64_t{0}, nz + 1, [&](std::int64_t z) {
        Sums sum;
        // The four rows around the corners (x, y, z): a and b below, a and c before.
        std::vector<std::uint8_t> a, b, c, d;
        loadRow(image, label, -1, z - 1, b);
        loadRow(image, label, -1, z, d);
        const int onZ = z == 0 || z == nz;
        for (std::int64_t y = 0; y <= ny; ++y) {
            a.swap(b);
            c.swap(d);
            loadRow(image, label, y, z - 1, b);
            loadRow(image, label, y, z, d);
            const int onY = y == 0 || y == ny;
            for (std::size_t x = 0; x <= nx; ++x) {
                const int onX = x == 0 || x == nx;
                const int bd = b[x] + d[x], cd = c[x] + d[x];
                const int bd1 = b[x + 1] + d[x + 1], cd1 = c[x + 1] + d[x + 1];
                const int ab = a[x] + b[x], ab1 = a[x + 1] + b[x + 1];
                if (ab + cd + ab1 + cd1 == 0) continue;
                // The corner itself and the cells that start at it, by the axes they extend along.
                sum.add(1, ab + cd + ab1 + cd1, onX + onY + onZ);
                sum.add(-1, ab1 + cd1, onY + onZ);  // x
                sum.add(-1, bd + bd1, onX + onZ);   // y
                sum.add(-1, cd + cd1, onX + onY);   // z
                sum.add(1, bd1, onZ);               // xy
                sum.add(1, cd1, onY);               // xz
                sum.add(1, d[x] + d[x + 1], onX);   // yz
                sum.add(-1, d[x + 1], 0);           // xyz
            }
        }
        sums[static_cast<std::size_t>(z)] = sum;
    });
    Sums total;
    for (const Sums& s : sums) {
        total.whole += s.whole;
        total.share += s.share;
    }
    return {static_cast<double>(total.whole), static_cast<double>(total.share) / kUnit};
}

}  // namespace vdbpack
