// Histograms of the radii of a pack and of the requested distribution.
#pragma once

#include "vdbpack/core/ranks.h"

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace vdbpack {

struct RadiusHistogram {
    double low = 0, width = 0;          ///< begin of the first bin, and width of each; mm
    std::vector<std::uint64_t> counts;  ///< radii in each bin
    std::vector<double> requested;      ///< requested share in each; empty: no request
};

/// Equal bins from the smallest to the largest of the radii and of `range`; no bins if there are no
/// radii. Radii are taken as known to 1e-6 of their value, as `ksDistance` takes them.
///
/// @param askedBelow  requested share of radii < r; empty: none.
/// @param range       smallest and largest requested radius, mm; unused without `askedBelow`.
/// @param bins        > 0.
/// @param ranks       that have radii, and all call this; null: this one alone.
RadiusHistogram radiusHistogram(const std::vector<double>& radii,
                                const std::function<double(double)>& askedBelow = {},
                                std::pair<double, double> range = {}, int bins = 40,
                                Ranks* ranks = nullptr);

}  // namespace vdbpack
