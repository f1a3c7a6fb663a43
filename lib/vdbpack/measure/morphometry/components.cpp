#include "vdbpack/measure/morphometry/components.h"

#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/core/parallel.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

namespace {

/// Solid voxels next to each other along x, from `first` to before `end`.
struct Run {
    std::uint32_t first, end;
};

/// The runs of all rows, row by row: y fastest, then z.
struct Runs {
    std::vector<Run> runs;
    std::vector<std::size_t> start;  ///< first run of each row, and the end
};

Runs solidRuns(const VoxelImage& image) {
    const auto nx = static_cast<std::size_t>(image.size[0]);
    const auto ny = static_cast<std::size_t>(image.size[1]);
    const auto nz = static_cast<std::size_t>(image.size[2]);
    Runs all;
    all.start.assign(ny * nz + 1, 0);
    std::vector<std::vector<Run>> bySlice(nz);
    parallelFor(std::size_t{0}, nz, [&](std::size_t z) {
        std::vector<Run>& runs = bySlice[z];
        for (std::size_t row = z * ny; row < (z + 1) * ny; ++row) {
            const std::size_t before = runs.size();
            bool open = false;
            for (std::size_t x = 0; x < nx; ++x) {
                const std::size_t voxel = row * nx + x;
                const bool solid = image.distance[voxel] < 0 && image.inTotal(voxel);
                const auto at = static_cast<std::uint32_t>(x);
                if (solid && !open) runs.push_back({at, at});
                if (solid) runs.back().end = at + 1;
                open = solid;
            }
            all.start[row + 1] = runs.size() - before;
        }
    });
    for (std::size_t row = 0; row < ny * nz; ++row) all.start[row + 1] += all.start[row];
    all.runs.reserve(all.start.back());
    for (std::vector<Run>& runs : bySlice) {
        all.runs.insert(all.runs.end(), runs.begin(), runs.end());
        runs = {};
    }
    return all;
}

/// Joins the runs of two neighboring rows that touch or overlap, corners included.
void joinRows(const Runs& all, std::size_t a, std::size_t b, DisjointSets& sets) {
    std::size_t i = all.start[a], j = all.start[b];
    while (i < all.start[a + 1] && j < all.start[b + 1]) {
        const Run &p = all.runs[i], &q = all.runs[j];
        if (p.first <= q.end && q.first <= p.end)
            sets.join(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
        if (p.end < q.end)
            ++i;
        else
            ++j;
    }
}

}  // namespace

std::optional<double> largestComponentShare(const VoxelImage& image) {
    const Runs all = solidRuns(image);
    const auto ny = static_cast<std::size_t>(image.size[1]);
    const auto nz = static_cast<std::size_t>(image.size[2]);
    DisjointSets sets(all.runs.size());
    for (std::size_t z = 0; z < nz; ++z)
        for (std::size_t y = 0; y < ny; ++y) {
            const std::size_t row = z * ny + y;
            if (y > 0) joinRows(all, row, row - 1, sets);
            if (z == 0) continue;
            if (y > 0) joinRows(all, row, row - ny - 1, sets);
            joinRows(all, row, row - ny, sets);
            if (y + 1 < ny) joinRows(all, row, row - ny + 1, sets);
        }
    std::vector<std::uint64_t> voxels(all.runs.size(), 0);
    std::uint64_t total = 0;
    for (std::size_t i = 0; i < all.runs.size(); ++i) {
        const std::uint64_t length = all.runs[i].end - all.runs[i].first;
        voxels[sets.find(static_cast<std::uint32_t>(i))] += length;
        total += length;
    }
    if (total == 0) return std::nullopt;
    return static_cast<double>(*std::max_element(voxels.begin(), voxels.end())) /
           static_cast<double>(total);
}

}  // namespace vdbpack
