// Distributions of radii as a text names them, before the dimension is known.
#pragma once

#include "vdbpack/pack/size_distribution.h"

#include <memory>
#include <optional>
#include <string>

namespace vdbpack {

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

}  // namespace vdbpack
