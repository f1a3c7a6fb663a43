#include "vdbpack/io/text.h"
#include "vdbpack/pack/size_distribution.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace vdbpack {

/// In 2D and 3D, by count and by volume.
struct SizeRequest::Read {
    using ByWeight = std::array<SizeDistribution, 2>;
    std::array<ByWeight, 2> sizes;
};

SizeRequest::SizeRequest(SizeDistribution sizes)
    : read_(std::make_shared<const Read>(Read{{{{sizes, sizes}, {sizes, sizes}}}})) {}

SizeRequest SizeRequest::parse(const std::string& spec) {
    if (spec.empty()) return {};
    const auto read = [&](int dim, WeightBy by) { return SizeDistribution::parse(spec, dim, by); };
    const SizeDistribution usual = read(3, WeightBy::count);
    if (startsWith(spec, "psd:")) {
        const SizeDistribution plane = read(2, WeightBy::count);
        SizeRequest request;
        request.read_ = std::make_shared<const Read>(Read{{{{plane, plane}, {usual, usual}}}});
        return request;
    }
    if (!startsWith(spec, "table:")) return usual;
    SizeRequest request;
    request.read_ = std::make_shared<const Read>(
        Read{{{{usual, read(2, WeightBy::volume)}, {usual, read(3, WeightBy::volume)}}}});
    return request;
}

std::string SizeRequest::spec() const {
    return empty() ? std::string() : in(3).spec();
}

const SizeDistribution& SizeRequest::in(int dim, WeightBy weightBy) const {
    assert(!empty());
    return read_->sizes[dim == 2 ? 0 : 1][weightBy == WeightBy::count ? 0 : 1];
}

std::optional<SizeDistribution> SizeRequest::find(int dim, WeightBy weightBy) const {
    if (empty()) return std::nullopt;
    return in(dim, weightBy);
}

SizeRequest SizeRequest::scaled(double factor) const {
    if (empty()) return {};
    Read read = *read_;
    for (auto& byWeight : read.sizes)
        for (SizeDistribution& sizes : byWeight) sizes = sizes.scaled(factor);
    SizeRequest request;
    request.read_ = std::make_shared<const Read>(std::move(read));
    return request;
}

void warnOfUnusedWeights(WeightBy weightBy, const std::vector<const SizeRequest*>& sizes,
                         const Callbacks& callbacks) {
    const bool used = std::any_of(sizes.begin(), sizes.end(), [](const SizeRequest* one) {
        return startsWith(one->spec(), "table:");
    });
    if (weightBy == WeightBy::volume && !used)
        callbacks.warn(
            "`weightBy` volume has no effect: it is for the weights of a table of radii "
            "(table:FILE); formulas are by number, grading curves by mass");
}

}  // namespace vdbpack
