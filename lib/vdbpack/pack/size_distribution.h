// Distributions of radii.
#pragma once

#include "vdbpack/core/progress.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

struct SizeShape;

/// What the weights of a table of radii count: spheres, or their volume (2D: area).
enum class WeightBy { count, volume };

/// A distribution of radii by number, mm. Immutable and cheap to copy.
///
///     SizeDistribution::uniform(1, 2)
///     SizeDistribution::parse("lognormal:1,0.5,0.3,3", 3)
class SizeDistribution {
public:
    // All lengths in mm, from 1e-9 to 1e9; anything else is a ParameterError.

    /// One radius for all.
    static SizeDistribution constant(double radius);
    /// Radii spread evenly over [a, b], 0 < a <= b.
    static SizeDistribution uniform(double a, double b);
    /// Normal with `mean` and standard deviation `sd` > 0, truncated to [a, b].
    /// @throws ParameterError also if the range holds less than 1e-9 of it.
    static SizeDistribution normal(double mean, double sd, double a, double b);
    /// Log-normal with `median`, and the standard deviation `sigma` > 0 of ln r; truncated to
    /// [a, b].
    /// @throws ParameterError also if the range holds less than 1e-9 of it.
    static SizeDistribution lognormal(double median, double sigma, double a, double b);
    /// Discrete: `weights[i]` >= 0 (with any sum) of `radii[i]`, in any order.
    /// @param weightBy  what the weights count.
    /// @param dim       2 or 3: volume goes with r^dim.
    /// @throws ParameterError also for lists that are empty or differ in length.
    static SizeDistribution table(const std::vector<double>& radii,
                                  const std::vector<double>& weights,
                                  WeightBy weightBy = WeightBy::count, int dim = 3);
    /// A grading curve (sieve analysis): `percentFiner[i]` of the mass, 0 to 100, is in spheres
    /// smaller than `diameters[i]`; linear in between, none outside.
    /// @param dim  2 or 3: mass goes with r^dim.
    /// @throws ParameterError also for fewer than two points, or if percent finer does not rise.
    static SizeDistribution sieve(const std::vector<double>& diameters,
                                  const std::vector<double>& percentFiner, int dim = 3);

    /// The same from a text:
    ///   constant:R   uniform:A,B   normal:MEAN,SD,A,B   lognormal:MEDIAN,SIGMA,A,B
    ///   table:FILE   columns radius (or diameter), weight
    ///   psd:FILE     columns diameter (or radius), percent finer (or coarser) by mass
    /// Columns go by their names, which may end in a unit (diameter_um, "d [mm]").
    /// @param dim       2 or 3, as in `table` and `sieve`.
    /// @param weightBy  of table:FILE.
    /// @throws ParameterError for a malformed text, IoError or InputError for a bad file.
    static SizeDistribution parse(const std::string& spec, int dim,
                                  WeightBy weightBy = WeightBy::count);

    /// The radius below which the share `u` in [0, 1] of the spheres lies, mm. Always a 32-bit
    /// float value, so that files with float radii store the pack exactly.
    double quantile(double u) const;
    /// Share of radii <= r by number.
    double cdf(double r) const;
    /// Share of radii < r by number; differs from `cdf` at the atoms of a discrete distribution.
    double cdfBelow(double r) const;

    double min() const;              ///< mm
    double max() const;              ///< mm
    double mean() const;             ///< mm, by number
    double meanBall(int dim) const;  ///< mean volume (2D: area) of a sphere, mm^dim
    /// The text as parsed, or one that `parse` accepts (except for tables not from a file).
    const std::string& spec() const;

    /// The same shape with all radii times `factor` > 0. For formulas `spec()` is the formula with
    /// its lengths multiplied and rounded to six digits.
    SizeDistribution scaled(double factor) const;
    /// Its radii that are no larger than `most` mm; all of them where these are less than a
    /// millionth. Of a table or grading curve 4096 radii of equal weight.
    SizeDistribution upTo(double most) const;
    /// With the lengths of formulas rounded to six digits, so that `spec()` states them exactly.
    SizeDistribution rounded() const;

private:
    SizeDistribution(SizeShape shape, std::string spec);
    static SizeDistribution bell(bool logarithmic, double center, double spread, double a,
                                 double b);

    std::shared_ptr<const SizeShape> shape_;
    double factor_ = 1;
    std::string base_;  ///< spec at factor 1
    std::string spec_;
};

/// From shares by number to shares by volume (2D: area): the share of the spheres' volume that is
/// in the smallest ones, from a table of 2^16 quantiles; exact to about 1e-5.
class VolumeShares {
public:
    VolumeShares(const SizeDistribution& sizes, int dim);
    /// @param share  of the spheres by number, such as `sizes.cdf(r)` or `sizes.cdfBelow(r)`.
    double operator()(double share) const;

private:
    std::vector<double> volume_;  ///< below each of equally many spheres, 0 to 1
};

/// A distribution of radii, read from its text once, for two and three dimensions. Formulas are the
/// same in both; a table by volume and a grading curve depend on the dimension. Immutable and cheap
/// to copy.
class SizeRequest {
public:
    /// Nothing is requested.
    SizeRequest() = default;
    /// The same distribution in both dimensions.
    SizeRequest(SizeDistribution sizes);  // NOLINT: wherever a distribution is requested
    /// @param spec  as for `SizeDistribution::parse`; files are read here. Empty: nothing.
    /// @throws as `SizeDistribution::parse`
    static SizeRequest parse(const std::string& spec);

    bool empty() const { return !read_; }
    /// The text; empty: nothing is requested.
    std::string spec() const;
    /// The distribution in a dimension, 2 or 3. Not for an empty request.
    /// @param weightBy  of table:FILE.
    const SizeDistribution& in(int dim, WeightBy weightBy = WeightBy::count) const;
    /// The same; nothing for an empty request.
    std::optional<SizeDistribution> find(int dim, WeightBy weightBy = WeightBy::count) const;
    /// All radii times `factor` > 0.
    SizeRequest scaled(double factor) const;

private:
    struct Read;
    std::shared_ptr<const Read> read_;
};

/// Warns of weights by volume where none of the distributions is a table of weights.
void warnOfUnusedWeights(WeightBy weightBy, const std::vector<const SizeRequest*>& sizes,
                         const Callbacks& callbacks);

}  // namespace vdbpack
