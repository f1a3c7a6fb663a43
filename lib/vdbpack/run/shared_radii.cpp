#include "vdbpack/run/shared_radii.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Solid fraction far from walls, about; and how thick the layer along a wall would be, in mean
/// radii, if all that spheres fill less of a part lay empty in it. Box of 80 mean radii: 0.253.
constexpr double kFarFromWalls = 0.6, kEmptyLayer = 0.25;
/// Least share of a thin part that counts as filled.
constexpr double kLeastShare = 0.3;

}  // namespace

SharedRadii::SharedRadii(const PackRecipe& recipe, Parts& parts) : shared_(parts.size()) {
    const double target = recipe.targetCount > 0  ? recipe.targetCount
                          : recipe.radius.empty() ? kDefaultCount
                                                  : 0;
    for (const Part& part : parts) shells_.push_back(part.recipe.shellRadius);
    if (!(target > 0)) return;
    double volume = 0, largest = 0;
    std::vector<DomainSource::Left> left(parts.size());
    for (std::size_t k = 0; k < parts.size(); ++k) {
        PackRecipe& part = parts[k].recipe;
        const bool sameCount = part.targetCount == recipe.targetCount;
        shared_[k] = part.radius.spec() == recipe.radius.spec() &&
                     part.weightBy == recipe.weightBy && sameCount;
        // Radii of a part's own stay as they are: the count is for the others.
        if (!shared_[k] && sameCount && !part.radius.empty()) part.targetCount = 0;
        if (!shared_[k]) continue;
        left[k] = parts[k].source->left();
        volume += left[k].volume;
        if (left[k].volume <= largest) continue;
        largest = left[k].volume;
        first_ = k;
    }
    if (!(largest > 0)) return;
    target_ = target;
    PackRecipe& first = parts[first_].recipe;
    const SizeDistribution sizes = requestedSizes(first, 3).sizes;
    asked_ = sizes.mean();
    const double radius = asked_ * std::cbrt(kFarFromWalls * volume / (target * sizes.meanBall(3)));
    double all = 0, leading = 0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        const double filled = std::max(left[k].volume - kEmptyLayer * radius * left[k].area,
                                       kLeastShare * left[k].volume);
        all += filled;
        if (k == first_) leading = filled;
    }
    first.targetCount = std::max(1.0, std::round(target * leading / all));
}

void SharedRadii::warnOfUnused(const PackRecipe& recipe, const Callbacks& callbacks) const {
    if (target_ == 0 && recipe.targetCount > 0)
        callbacks.warn(fmt::format(
            "`targetCount` {:.0f} has no effect: each part has radii of its own, which stay; leave "
            "out the `radius` of parts whose radii may be scaled",
            recipe.targetCount));
}

std::vector<std::size_t> SharedRadii::order() const {
    std::vector<std::size_t> all(shared_.size());
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = k;
    if (!all.empty())
        std::rotate(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(first_),
                    all.begin() + static_cast<std::ptrdiff_t>(first_) + 1);
    return all;
}

void SharedRadii::prepare(PackRecipe& part, std::size_t k) const {
    if (!shared_[k] || !found_) return;
    part.radius = *found_;
    part.targetCount = 0;
    part.shellRadius = shells_[k].scaled(found_->mean() / asked_);
}

void SharedRadii::take(const SizeDistribution& sizes, std::size_t k) {
    if (leads(k)) found_ = sizes;
}

double SharedRadii::count(const std::vector<std::unique_ptr<Run<3>>>& runs) const {
    double sum = 0;
    for (std::size_t k = 0; k < runs.size(); ++k)
        if (shared_[k] && runs[k]) sum += static_cast<double>(runs[k]->report.count);
    return sum;
}

void SharedRadii::scaleFor(double count) {
    found_ = found_->scaled(std::cbrt(count / target_)).rounded();
}

std::string SharedRadii::chosen() const {
    return fmt::format("radii {} mm, for about {:.0f} {} in all parts", found_->spec(), target_,
                       Measure<3>::kSpheres);
}

}  // namespace vdbpack
