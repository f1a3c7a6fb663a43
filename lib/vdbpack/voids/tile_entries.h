// Private to stamping: which voids reach into which tiles.
#pragma once

#include "vdbpack/core/parallel.h"
#include "vdbpack/voids/tile.h"
#include "vdbpack/voids/tile_lattice.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Mean number of entries that are sorted together.
inline constexpr std::size_t kEntriesPerPart = 64;

/// A void and a tile that it reaches: sorted by tile, then the nearest void first, after which most
/// others can be skipped.
struct TileEntry {
    std::uint64_t tile;
    float lower;
    std::uint32_t ellipsoid;

    friend bool operator<(const TileEntry& a, const TileEntry& b) {
        if (a.tile != b.tile) return a.tile < b.tile;
        return a.lower != b.lower ? a.lower < b.lower : a.ellipsoid < b.ellipsoid;
    }
};

/// Where the entries of each tile begin, and the end.
inline std::vector<std::size_t> startsOfTiles(const std::vector<TileEntry>& entries) {
    std::vector<std::size_t> starts;
    for (std::size_t i = 0; i < entries.size(); ++i)
        if (i == 0 || entries[i].tile != entries[i - 1].tile) starts.push_back(i);
    starts.push_back(entries.size());
    return starts;
}

/// All pairs of voids and tiles that they reach, sorted.
template <int Dim>
std::vector<TileEntry> listEntries(const std::vector<Ellipsoid<Dim>>& voids,
                                   const TileLattice<Dim>& lattice, double outside) {
    PerThread<std::vector<TileEntry>> found;
    const double radius = lattice.radius();
    parallelFor(IndexRange(0, voids.size(), 64), [&](const auto& range) {
        auto& mine = found.local();
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            lattice.forEach(
                voids[i].bounds().grown(outside), [&](std::uint64_t tile, const Vec<Dim>& middle) {
                    const double lower = boundsAt(voids[i], middle, radius).lower;
                    if (lower < outside)
                        mine.push_back(
                            {tile, static_cast<float>(lower), static_cast<std::uint32_t>(i)});
                });
    });
    // Distributes entries to parts of the lattice, in any order, and sorts each part.
    std::size_t count = 0;
    for (const auto& part : found) count += part.size();
    const std::size_t parts = count / kEntriesPerPart + 1;
    std::vector<std::atomic<std::size_t>> next(parts + 1);
    const auto forEachFound = [&](const auto& visit) {
        for (const std::vector<TileEntry>& mine : found)
            forAll(mine.size(), [&](std::size_t i) {
                visit(mine[i], next[lattice.partOf(mine[i].tile, parts)]);
            });
    };
    forEachFound([](const TileEntry&, std::atomic<std::size_t>& at) {
        at.fetch_add(1, std::memory_order_relaxed);
    });
    std::size_t before = 0;
    for (auto& at : next) before += at.exchange(before);
    std::vector<TileEntry> all(count);
    forEachFound([&](const TileEntry& e, std::atomic<std::size_t>& at) {
        all[at.fetch_add(1, std::memory_order_relaxed)] = e;
    });
    // next[part] is now the end of the part.
    parallelFor(IndexRange(0, parts), [&](const auto& range) {
        for (std::size_t part = range.begin(); part < range.end(); ++part) {
            const auto from = static_cast<std::ptrdiff_t>(part == 0 ? 0 : next[part - 1].load());
            const auto to = static_cast<std::ptrdiff_t>(next[part].load());
            std::sort(all.begin() + from, all.begin() + to);
        }
    });
    return all;
}

}  // namespace vdbpack
