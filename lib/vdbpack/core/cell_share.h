// How much of a cell of a lattice lies behind a surface that is interpolated between its corners.
#pragma once

#include <algorithm>
#include <cmath>

namespace vdbpack {

/// The share of a cell in which what is linear along each axis between its corners is at most 0,
/// to 0.01, and better where the surface is flat: by lines along the axis where the values change
/// most, each of them exact.
/// @param corner  values, numbered by x + 2 y + 4 z.
template <int Dim>
double shareBelowZero(const float (&corner)[1 << Dim]) {
    constexpr int kLines = 3, kAll = Dim == 3 ? kLines * kLines : kLines;
    constexpr int kCorners = 1 << Dim;
    int below = 0;
    for (const float value : corner) below += value <= 0;
    if (below == 0 || below == kCorners) return below / kCorners;
    int along = 0;
    float most = -1;
    for (int step = 1; step < kCorners; step *= 2) {
        float change = 0;
        for (int i = 0; i < kCorners; ++i) change += (i & step) != 0 ? corner[i] : -corner[i];
        if (std::abs(change) > most) {
            most = std::abs(change);
            along = step;
        }
    }
    const int u = along == kCorners / 2 ? 1 : 2 * along, v = kCorners - 1 - along - u;
    float share = 0;
    for (int line = 0; line < kAll; ++line) {
        const float s = (static_cast<float>(line % kLines) + 0.5f) / kLines;
        const float t = (static_cast<float>(line / kLines) + 0.5f) / kLines;
        const auto end = [&](int from) {
            const float low = corner[from] + s * (corner[from + u] - corner[from]);
            if (Dim == 2) return low;
            const float high = corner[from + v] + s * (corner[from + u + v] - corner[from + v]);
            return low + t * (high - low);
        };
        const float a = end(0), b = end(along);
        const float low = std::min(a, b), high = std::max(a, b);
        if (low <= 0) share += high <= 0 ? 1 : low / (low - high);
    }
    return static_cast<double>(share) / kAll;
}

}  // namespace vdbpack
