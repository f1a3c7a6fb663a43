// Random distributions of angles.
#pragma once

#include <string>

namespace vdbpack {

/// A distribution of angles: a constant, uniform, or normal within bounds.
class AngleDistribution {
public:
    /// Always 0.
    AngleDistribution() = default;

    /// Parses V, constant:V, uniform:A,B or normal:MEAN,SD,A,B (truncated to [A, B]). Each number
    /// is in radians, or in degrees with the suffix `deg`: "uniform:-10deg,10deg".
    /// @throws ParameterError if the text is malformed, A > B, an angle exceeds two full turns (a
    ///         sign of degrees without their suffix), SD is not positive, or the normal
    ///         distribution has no share in [A, B]
    static AngleDistribution parse(const std::string& spec);

    /// The quantile at `u` in [0, 1], rad. Thread-safe.
    double quantile(double u) const;

private:
    double lo_ = 0, hi_ = 0;        ///< rad
    double mean_ = 0, spread_ = 0;  ///< rad; spread 0: uniform
};

}  // namespace vdbpack
