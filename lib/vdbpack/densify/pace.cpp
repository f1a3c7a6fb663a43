#include "vdbpack/densify/pace.h"

#include <algorithm>

namespace vdbpack {

namespace {

/// Standard deviation of the radii up to which spheres are nearly equal, in mean radii.
constexpr double kNarrowDeviation = 0.06;
/// The last paces of equal spheres, which do not leave them at random.
constexpr std::size_t kCrystallizing = 2;

bool areNearlyEqual(const std::vector<double>& radii, Ranks* ranks) {
    double sum = 0, squares = 0;
    for (const double r : radii) sum += r;
    sum = sumOver(ranks, sum);
    const double mean = sum / static_cast<double>(sumOver(ranks, std::uint64_t{radii.size()}));
    for (const double r : radii) squares += (r - mean) * (r - mean);
    squares = sumOver(ranks, squares);
    return squares <= kNarrowDeviation * kNarrowDeviation * mean * sum;
}

}  // namespace

// Gains measured on spheres of size ratio 2 in a box. Exchanges in each step find room three times
// as soon as those in every third one.
const Paces::Steps Paces::kWide{{{0.97, 0.07, 1, 0.01}, 0.018},
                                {{0.98, 0.15, 1, 0.01}, 0.032},
                                {{0.985, 0.2, 1, 0.01}, 0.036},
                                {{0.99, 0.3, 1, 0.01}, 0.045},
                                {{0.995, 0.4, 1, 0.01}, 1}};
// Equal spheres crystallize the less, the smaller the cap and the inertia are that suffice.
// Vertebra, radius 0.72 mm, from 0.576 to 0.60 at an inertia of 0.97: 0.5, 0.7, 1.0, 1.9 and 2.5 %
// in crystalline order at caps of 0.02, 0.04, 0.07, 0.15 and 0.3; to 0.61 at a cap of 0.02: 2.2,
// 1.7 and 3.1 % at 0.98, 0.99 and 0.995.
const Paces::Steps Paces::kEqual{
    {{0.97, 0.04}, 0.025},   {{0.98, 0.02}, 0.030},   {{0.99, 0.02}, 0.036}, {{0.995, 0.02}, 0.036},
    {{0.995, 0.03}, 0.0415}, {{0.997, 0.03}, 0.0435}, {{0.99, 0.20}, 1}};
const Paces::Steps Paces::kCircles{
    {{0.97, 0.07}, 0.02}, {{0.98, 0.07}, 0.045}, {{0.98, 0.15}, 0.05}, {{0.99, 0.20}, 1}};

Paces::Paces(int dim, const std::vector<double>& radii, Ranks* ranks)
    : steps_(!areNearlyEqual(radii, ranks) ? &kWide
             : dim == 3                    ? &kEqual
                                           : &kCircles) {}

std::size_t Paces::randomCount() const {
    return steps_->size() - (areEqualSpheres() ? kCrystallizing : 0);
}

std::size_t Paces::firstFor(double gain) const {
    std::size_t k = 0;
    while (k + 1 < randomCount() && gain > (*steps_)[k].gain) ++k;
    return k;
}

std::vector<RelaxationPace> Paces::from(std::size_t first, std::size_t last) const {
    std::vector<RelaxationPace> paces;
    for (std::size_t k = first; k < last; ++k) paces.push_back((*steps_)[k].pace);
    return paces;
}

int mostSteps(const RelaxationPace& pace) {
    return static_cast<int>(pace.spans / (1 - pace.inertia));
}

bool Jam::add(int step, double worst) {
    const auto window = static_cast<std::size_t>(step / span_);
    if (window == least_.size()) {
        if (isJammed()) return true;
        least_.push_back(worst);
    }
    least_.back() = std::min(least_.back(), worst);
    return false;
}

bool Jam::isJammed() const {
    const std::size_t n = least_.size();
    if (n < 7) return false;
    return least_[n - 1] > 0.4 * least_[n - 4] && std::min(least_[n - 1], least_[n - 2]) > 1e-3;
}

}  // namespace vdbpack
