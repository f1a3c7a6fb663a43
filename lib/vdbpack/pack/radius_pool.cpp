#include "vdbpack/pack/radius_pool.h"

#include <algorithm>

namespace vdbpack {

namespace {
/// 2^64 / golden ratio: the additive step with the most even spread.
constexpr std::uint64_t kGoldenStep = 0x9e3779b97f4a7c15ull;
}  // namespace

RadiusPool::RadiusPool(const SizeDistribution& sizes, std::uint64_t seed, std::uint64_t stream,
                       std::size_t capacity, double shell)
    : sizes_(sizes),
      shell_(shell),
      share_(RandomStream(seed, stream).bits()),
      capacity_(capacity) {}

std::size_t RadiusPool::countUpTo(double r) const {
    return static_cast<std::size_t>(std::upper_bound(radii_.begin(), radii_.end(), r) -
                                    radii_.begin());
}

void RadiusPool::draw() {
    share_ += kGoldenStep;
    const double r = sizes_.quantile(static_cast<double>(share_ >> 11) * 0x1p-53) + shell_;
    radii_.insert(std::upper_bound(radii_.begin(), radii_.end(), r), r);
}

void RadiusPool::fill() {
    while (radii_.size() < capacity_ || countUpTo(common_) < capacity_) draw();
}

void RadiusPool::take(std::size_t k) {
    radii_.erase(radii_.begin() + static_cast<std::ptrdiff_t>(k));
    fill();
}

void RadiusPool::refill() {
    fill();
    // The slack covers atoms that were rounded up to a float.
    while (radii_.front() > sizes_.mean() * (1 + 1e-6) + shell_) draw();
}

void RadiusPool::absorb(RadiusPool& other) {
    const auto middle = static_cast<std::ptrdiff_t>(radii_.size());
    radii_.insert(radii_.end(), other.radii_.begin(), other.radii_.end());
    std::inplace_merge(radii_.begin(), radii_.begin() + middle, radii_.end());
    other.radii_.clear();
}

}  // namespace vdbpack
