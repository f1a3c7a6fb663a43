#include "vdbpack/pack/radius_pool.h"

#include <algorithm>

namespace vdbpack {

namespace {

/// A pool whose capacity has fallen has one radius less after so many that were taken: its small
/// radii would all be placed side by side otherwise.
constexpr std::uint64_t kTakenPerLess = 3;

}  // namespace

RadiusPool::RadiusPool(const SizeDistribution& sizes, std::uint64_t seed, std::uint64_t stream,
                       std::size_t capacity, double shell)
    : sizes_(sizes),
      shell_(shell),
      mean_(sizes.mean() + shell),
      share_(RandomStream(seed, stream).bits()),
      capacity_(capacity),
      limit_(capacity) {}

std::size_t RadiusPool::countUpTo(double r) const {
    return static_cast<std::size_t>(std::upper_bound(radii_.begin(), radii_.end(), r) -
                                    radii_.begin());
}

double RadiusPool::next() {
    share_ += kGoldenStep;
    return sizes_.quantile(static_cast<double>(share_ >> 11) * 0x1p-53) + shell_;
}

void RadiusPool::add(double r) {
    radii_.insert(std::upper_bound(radii_.begin(), radii_.end(), r), r);
}

/// Counts a radius that leaves the pool (`times` 1) or comes back (-1).
void RadiusPool::count(double r, double times) {
    given_.count += times;
    given_.excess += times * (r - mean_);
}

double RadiusPool::draw() {
    const double r = next();
    count(r, 1);
    return r;
}

void RadiusPool::giveBack(double r) {
    count(r, -1);
    add(r);
}

void RadiusPool::fill() {
    while (radii_.size() < limit_ || countUpTo(common_) < capacity_) add(next());
}

void RadiusPool::take(std::size_t k) {
    count(radii_[k], 1);
    radii_.erase(radii_.begin() + static_cast<std::ptrdiff_t>(k));
    if (limit_ > capacity_ && static_cast<std::uint64_t>(given_.count) % kTakenPerLess == 0)
        --limit_;
    fill();
}

void RadiusPool::refill() {
    fill();
    // The slack covers atoms that were rounded up to a float.
    while (radii_.front() > sizes_.mean() * (1 + 1e-6) + shell_) add(next());
}

}  // namespace vdbpack
