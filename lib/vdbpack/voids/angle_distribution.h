// Angles drawn at random.
#pragma once

#include <string>

namespace vdbpack {

/// How an angle is drawn: one value, uniform, or normal within bounds.
class AngleDistribution {
public:
    /// Always 0.
    AngleDistribution() = default;

    /// Parses V, constant:V, uniform:A,B or normal:MEAN,SD,A,B (cut off at A and B). Each number is
    /// in radians, or in degrees with the suffix `deg`: "uniform:-10deg,10deg".
    /// @throws ParameterError if it is malformed, A > B, an angle beyond two full turns (as degrees
    ///         without their suffix mostly are), SD not positive, or nothing of a normal
    ///         distribution between A and B
    static AngleDistribution parse(const std::string& spec);

    /// The angle below which a share `u` in [0, 1] lies, rad. Thread-safe.
    double quantile(double u) const;

private:
    double lo_ = 0, hi_ = 0;        ///< rad
    double mean_ = 0, spread_ = 0;  ///< rad; spread 0: uniform
};

}  // namespace vdbpack
