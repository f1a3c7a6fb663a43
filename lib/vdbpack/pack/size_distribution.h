// Radius distributions: what `--radius` asks for.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace vdbpack {

/// How the weights of a radius table count.
enum class WeightBy { count, volume };

/// A distribution of radii by number, mm. Immutable and cheap to copy.
class SizeDistribution {
public:
    /// Parses SPEC:
    ///   constant:R   uniform:A,B   normal:MEAN,SD,A,B   lognormal:MEDIAN,SIGMA,A,B
    ///   table:FILE   columns radius, weight; discrete; `weightBy` says what the weights count
    ///   psd:FILE     columns diameter, percent finer by mass; interpolated linearly
    /// normal and lognormal are truncated to [A, B]; SIGMA is the standard deviation of ln r.
    /// @param dim  2 or 3: mass (weight by volume) goes with r^dim.
    /// @throws ParameterError for a malformed SPEC, IoError or InputError for a bad file.
    static SizeDistribution parse(const std::string& spec, int dim,
                                  WeightBy weightBy = WeightBy::count);

    /// The radius below which the share `u` in [0, 1] of the spheres lies, mm. Always a 32-bit
    /// float value, so that files with float radii hold the pack exactly.
    double quantile(double u) const;
    /// Share of radii <= r by number.
    double cdf(double r) const;
    /// Share of radii < r by number; differs from `cdf` at the atoms of a discrete distribution.
    double cdfBelow(double r) const;

    double min() const;               ///< mm
    double max() const;               ///< mm
    double mean() const;              ///< mm, by number
    double meanBall(int dim) const;   ///< mean volume (2D: area) of a sphere, mm^dim
    const std::string& spec() const;  ///< as parsed; scaled ones say so

    /// The same shape with all radii times `factor` > 0. For formulas `spec()` is the formula with
    /// its lengths multiplied and rounded to six digits.
    SizeDistribution scaled(double factor) const;

private:
    struct Shape;
    SizeDistribution(std::shared_ptr<const Shape> shape, double factor)
        : shape_(std::move(shape)), factor_(factor) {}

    std::shared_ptr<const Shape> shape_;
    double factor_ = 1;
    std::string spec_;
};

/// Share of the spheres' volume (2D: area) that a distribution puts into the smallest ones: from
/// shares by number to shares by volume, as a table over 2^16 quantiles; exact to about 1e-5.
class VolumeShares {
public:
    VolumeShares(const SizeDistribution& sizes, int dim);
    /// @param share  of the spheres by number, such as `sizes.cdf(r)` or `sizes.cdfBelow(r)`.
    double operator()(double share) const;

private:
    std::vector<double> volume_;  ///< below each of equally many spheres, 0 to 1
};

}  // namespace vdbpack
