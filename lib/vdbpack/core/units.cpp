#include "vdbpack/core/units.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace vdbpack {

namespace {

/// The lowest binary digit of a double that is set, among the 52 that are stored.
std::uint64_t lowestDigit(double v) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &v, sizeof bits);
    bits |= std::uint64_t{1} << 52;
    return bits & (~bits + 1);
}

}  // namespace

double toMillimeters(double value, Unit unit) {
    if (unit == Unit::millimeter) return value;
    constexpr double kMost = std::numeric_limits<double>::infinity();
    const double near = unit == Unit::micrometer ? value / 1000.0 : value * millimetersPer(unit);
    double best = near;
    std::uint64_t digit = 0;
    for (const double mm : {near, std::nextafter(near, -kMost), std::nextafter(near, kMost)})
        if (fromMillimeters(mm, unit) == value && lowestDigit(mm) > digit) {
            best = mm;
            digit = lowestDigit(mm);
        }
    return best;
}

}  // namespace vdbpack
