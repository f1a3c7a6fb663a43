// Private to pack: the shape of a distribution of radii.
#pragma once

#include <vector>

namespace vdbpack {

/// Shares of radii by number, and their inverse, for each kind of distribution.
struct SizeShape {
    enum class Kind { uniform, normal, lognormal, discrete, massLinear };
    Kind kind = Kind::uniform;
    double lo = 0, hi = 0;           ///< mm
    double center = 0;               ///< mean; lognormal: median, mm
    double spread = 0;               ///< standard deviation, mm; lognormal: of ln r
    int dim = 3;                     ///< massLinear: mass goes with r^dim
    std::vector<double> radius;      ///< discrete: values; massLinear: nodes
    std::vector<double> cumulative;  ///< discrete: share up to and with; massLinear: share below
    std::vector<double> massSlope;   ///< massLinear: mass per mm on each interval
    double massTotal = 1;            ///< massLinear: number integral before normalization
    std::vector<double> quantiles;   ///< tabulated inverse for kinds without a formula
    double mean = 0;
    double ballMoment[4] = {};  ///< E[r^d]

    /// Share of radii <= r, or < r (`below`).
    double cdf(double r, bool below) const;
    /// The radius below which the share `u` in [0, 1] lies.
    double invert(double u) const;

    double bisect(double u, double from, double to) const;
    /// Tabulates quantiles and moments once the members above are set.
    void finish();
};

/// The integral of r^-dim from a to b: number of spheres per unit of mass that is spread evenly
/// over these radii.
double inversePower(double a, double b, int dim);

double normalCdf(double z);

}  // namespace vdbpack
