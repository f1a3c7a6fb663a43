#include "vdbpack/verify/usable.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

template <int Dim>
void requireVerifiable(const std::vector<Sphere<Dim>>& spheres) {
    constexpr std::size_t kMost = 0xfffffffe;  // they are numbered in 32 bits
    if (spheres.size() > kMost)
        throw ResourceError(fmt::format("pack: {} {} are more than {}; split the pack",
                                        spheres.size(), Measure<Dim>::kSpheres, kMost));
    const auto bad = std::find_if(spheres.begin(), spheres.end(), [](const Sphere<Dim>& s) {
        double largest = s.radius;
        bool finite = std::isfinite(s.radius);
        for (const double c : s.center.c) {
            finite = finite && std::isfinite(c);
            largest = std::max(largest, std::abs(c));
        }
        return !finite || largest > kLargestVerified || s.radius < 1 / kLargestVerified;
    });
    if (bad == spheres.end()) return;
    throw InputError(fmt::format(
        "pack: {} number {} (counted from 0) at ({}) has radius {}: not a finite position and a "
        "positive radius (1e-30 to 1e30 mm); remove or correct it",
        Measure<Dim>::kSphere, bad - spheres.begin(), fmt::join(bad->center.c, ", "), bad->radius));
}

template void requireVerifiable<2>(const std::vector<Sphere<2>>&);
template void requireVerifiable<3>(const std::vector<Sphere<3>>&);

}  // namespace vdbpack
