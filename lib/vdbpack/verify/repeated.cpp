#include "vdbpack/verify/repeated.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdbpack {

template <int Dim>
RepeatedSpheres<Dim> repeatedSpheres(const std::vector<Sphere<Dim>>& spheres,
                                     const PeriodicCell<Dim>& cell) {
    double largest = 0;
    for (const auto& s : spheres) largest = std::max(largest, s.radius);
    RepeatedSpheres<Dim> all;
    all.spheres = spheres;
    for (std::size_t i = 0; i < spheres.size(); ++i)
        all.original.push_back(static_cast<std::uint32_t>(i));
    // Axis by axis: copies of copies fill the edges and corners.
    for (int d = 0; d < Dim; ++d) {
        if (!cell.wraps[static_cast<std::size_t>(d)]) continue;
        const double lo = cell.box.lo[d], hi = cell.box.hi[d], period = hi - lo;
        if (!(period >= 4 * largest))
            throw InputError(fmt::format(
                "the periodic cell is {} mm long, less than two diameters of the largest {}, {} "
                "mm: overlaps with images cannot be counted. Check the cell",
                period, Measure<Dim>::kSphere, 4 * largest));
        const std::size_t count = all.spheres.size();
        for (std::size_t i = 0; i < count; ++i) {
            double x = std::fmod(all.spheres[i].center[d] - lo, period);
            if (x < 0) x += period;
            // Where it was inside, not a digit is lost.
            const double was = all.spheres[i].center[d];
            x = lo <= was && was < hi ? was : lo + x;
            Sphere<Dim> s = all.spheres[i];
            s.center[d] = x;
            all.spheres[i] = s;
            const std::uint32_t original = all.original[i];
            const auto copyTo = [&](double to) {
                s.center[d] = to;
                all.spheres.push_back(s);
                all.original.push_back(original);
            };
            // It may touch one of the largest spheres whose center lies in the cell.
            const double reach = (s.radius + largest) * (1 + 1e-9);
            if (x - reach < lo) copyTo(x + period);
            if (x + reach > hi) copyTo(x - period);
        }
    }
    return all;
}

template RepeatedSpheres<2> repeatedSpheres(const std::vector<Sphere<2>>&, const PeriodicCell<2>&);
template RepeatedSpheres<3> repeatedSpheres(const std::vector<Sphere<3>>&, const PeriodicCell<3>&);

}  // namespace vdbpack
