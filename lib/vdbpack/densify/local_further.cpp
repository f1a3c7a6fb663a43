#include "vdbpack/densify/local_further.h"

#include "vdbpack/core/error.h"
#include "vdbpack/pack/local_sizes.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace vdbpack {

namespace {

/// Classes of factors for each power of two, and between two groups.
constexpr double kClasses = 8;
constexpr std::int32_t kGroup = 1 << 16, kMiddle = 1 << 15;

}  // namespace

template <int Dim>
std::int32_t LocalFurther<Dim>::classOf(const LocalSize& size) {
    return static_cast<std::int32_t>(size.group) * kGroup + kMiddle +
           static_cast<std::int32_t>(std::lround(kClasses * std::log2(size.factor)));
}

template <int Dim>
LocalSize LocalFurther<Dim>::sizeOf(std::int32_t number) {
    return {std::exp2((number % kGroup - kMiddle) / kClasses),
            static_cast<std::uint32_t>(number / kGroup)};
}

template <int Dim>
LocalFurther<Dim>::LocalFurther(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
                                const DensifyOptions& options) {
    const std::vector<LocalSize> sizes = localSizesOf(spheres, domain, *options.local);
    groups_.resize(options.local->groups());
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        classes_.push_back(classOf(sizes[i]));
        relative_.push_back(spheres[i].radius / sizes[i].factor);
        if (i < options.fixed) continue;
        Group& group = groups_[sizes[i].group];
        radii_.push_back(relative_.back());
        group.spheres.push_back({spheres[i].center, radii_.back()});
        const double ball = Measure<Dim>::ball(spheres[i].radius);
        group.volumes[classes_.back()] += ball;
        volume_ += ball;
    }
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        groups_[g].options.sizes = options.local->sizesOf(g, *options.sizes);
        sizes_.emplace_back(groups_[g].spheres, groups_[g].options);
    }
}

template <int Dim>
FurtherSpheres LocalFurther<Dim>::draw(double volume, RandomStream& random) const {
    FurtherSpheres all;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        // Each class receives its share of the volume; by number that is more of finer spheres.
        std::map<std::int32_t, double> due;
        double sum = 0;
        for (const auto& [number, have] : groups_[g].volumes)
            sum += due[number] = volume * have / volume_ / std::pow(sizeOf(number).factor, Dim);
        if (!(sum > 0)) continue;
        const FurtherSpheres drawn = sizes_[g].draw(sum, random);
        // In the order of the shares, as evenly as can be.
        double rest = random.uniform() * Measure<Dim>::ball(drawn.radii.front());
        auto at = due.begin();
        for (const double radius : drawn.radii) {
            const double ball = Measure<Dim>::ball(radius);
            while (rest + 0.5 * ball > at->second && std::next(at) != due.end())
                rest -= (at++)->second;
            rest += ball;
            all.radii.push_back(radius);
            all.regions.push_back(at->first);
        }
    }
    return all;
}

template class LocalFurther<2>;
template class LocalFurther<3>;

}  // namespace vdbpack
