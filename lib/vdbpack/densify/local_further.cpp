#include "vdbpack/densify/local_further.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/densify/relaxation.h"
#include "vdbpack/pack/local_sizes.h"

#include <cmath>
#include <iterator>

namespace vdbpack {

namespace {

/// Classes of factors for each power of two, and between two groups.
constexpr double kClasses = 8;
constexpr std::int32_t kGroup = 1 << 16, kMiddle = 1 << 15;
/// Ratio of the factors up to which a sphere may lie where another one is requested.
constexpr double kNearFactor = 1.2;

bool areNear(const LocalSize& a, const LocalSize& b) {
    return a.group == b.group && a.factor < kNearFactor * b.factor &&
           b.factor < kNearFactor * a.factor;
}

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
                                const DensifyOptions& options)
    : domain_(domain), options_(options) {
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

/// Spheres of a total volume (2D: area) of about `volume` mm^Dim: radii where the factor is 1, with
/// their classes.
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

template <int Dim>
void LocalFurther<Dim>::insert(double missing, const Domain<Dim>& inset, std::uint64_t stage,
                               LocalPack<Dim>& pack) const {
    PerThread<LocalSizeSampler<Dim>> samplers(
        [&] { return LocalSizeSampler<Dim>(domain_, *options_.local); });
    const auto belongs = [&](const Vec<Dim>& x, std::int32_t number) {
        return areNear(samplers.local().at(x), sizeOf(number));
    };
    // Factors differ a little from those of their classes: what is missing is added again.
    for (std::uint64_t round = 0; missing > 0; ++round) {
        const std::uint64_t turn = stage ^ (round << 32);
        RandomStream random = furtherStream(options_.seed, turn);
        const FurtherSpheres drawn = draw(missing, random);
        std::vector<double> radii;
        for (std::size_t k = 0; k < drawn.radii.size(); ++k)
            radii.push_back(drawn.radii[k] * sizeOf(drawn.regions[k]).factor);
        Relaxation<Dim> present(inset, grownBy(0.5 * options_.gap, pack.spheres), options_.fixed,
                                pack.classes, options_.seed, true);
        const auto found = present.vacancies(radii, drawn.regions, turn, belongs);
        for (std::size_t k = 0; k < found.size() && missing > 0; ++k) {
            LocalSize size = sizeOf(drawn.regions[k]);
            if (belongs(found[k].center, drawn.regions[k]))
                size = samplers.local().at(found[k].center);
            const auto radius = static_cast<float>(drawn.radii[k] * size.factor);
            pack.spheres.push_back({found[k].center, static_cast<double>(radius)});
            pack.classes.push_back(classOf(size));
            pack.relative.push_back(drawn.radii[k]);
            missing -= Measure<Dim>::ball(pack.spheres.back().radius);
        }
    }
}

/// Calls `visit(i, size)` for the spheres that lie where about their own size is requested.
template <int Dim>
template <class Visit>
void LocalFurther<Dim>::forEachAtHome(const LocalPack<Dim>& pack, const Visit& visit) const {
    const std::vector<LocalSize> sizes = localSizesOf(pack.spheres, domain_, *options_.local);
    for (std::size_t i = options_.fixed; i < pack.spheres.size(); ++i)
        if (areNear(sizes[i], sizeOf(pack.classes[i]))) visit(i, sizes[i]);
}

template <int Dim>
void LocalFurther<Dim>::fit(LocalPack<Dim>& pack) const {
    forEachAtHome(pack, [&](std::size_t i, const LocalSize& size) {
        pack.spheres[i].radius =
            static_cast<double>(static_cast<float>(pack.relative[i] * size.factor));
        pack.classes[i] = classOf(size);
    });
}

template <int Dim>
double LocalFurther<Dim>::misfit(const LocalPack<Dim>& pack) const {
    double squares = 0, count = 1;
    forEachAtHome(pack, [&](std::size_t i, const LocalSize& size) {
        const double off = pack.spheres[i].radius / (pack.relative[i] * size.factor) - 1;
        squares += off * off;
        ++count;
    });
    return std::sqrt(squares / count);
}

template class LocalFurther<2>;
template class LocalFurther<3>;

}  // namespace vdbpack
