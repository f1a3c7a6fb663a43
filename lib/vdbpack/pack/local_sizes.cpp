#include "vdbpack/pack/local_sizes.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/sphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace vdbpack {

double LocalSizes::largest(const SizeDistribution& sizes) const {
    const double all = shellSizes ? std::max(sizes.max(), shellSizes->max()) : sizes.max();
    return all * factors().most;
}

LocalSizes::Factors LocalSizes::factors() const {
    if (!factor) return {};
    return {factor->all().least, factor->all().most};
}

namespace {

/// Points along the longest side of a domain at which sizes are sampled, and classes of factors
/// for each power of two.
constexpr int kSamples = 40;
constexpr double kClasses = 16;

}  // namespace

template <int Dim>
LocalSizeSampler<Dim>::LocalSizeSampler(const Domain<Dim>& domain, const LocalSizes& sizes)
    : sizes_(sizes), cell_(domain.cell()), wraps_(cell_.any()) {
    if (sizes.shellSizes) shell_.emplace(domain, sizes.shell);
}

template <int Dim>
void LocalSizeSampler<Dim>::addGroups(const Vec<Dim>& x, double distance, Range& range) {
    if (!shell_) return;
    const double depth = shell_->depth(inCell(x)), off = distance + shell_->error();
    range.inner = depth + off > sizes_.shell.least();
    range.shell = depth - off <= sizes_.shell.most();
}

template <int Dim>
typename LocalSizeSampler<Dim>::Range LocalSizeSampler<Dim>::within(const Box<Dim>& box) {
    Range range;
    if (sizes_.factor) {
        const auto [least, most] = sizes_.factor->within(box);
        range.least = least;
        range.most = most;
    }
    addGroups(box.center(), 0.5 * length(box.size()), range);
    return range;
}

template <int Dim>
typename LocalSizeSampler<Dim>::Range LocalSizeSampler<Dim>::around(const Vec<Dim>& x,
                                                                    double distance) {
    Range range;
    if (sizes_.factor) {
        const Vec<Dim> here = inCell(x);
        const auto [least, most] = sizes_.factor->within(Box<Dim>{here, here}.grown(distance));
        range.least = least;
        range.most = most;
    }
    addGroups(x, distance, range);
    return range;
}

template <int Dim>
bool LocalSizeSampler<Dim>::isConstant(const Vec<Dim>& x, double distance) {
    if (sizes_.factor) {
        const Vec<Dim> here = inCell(x);
        if (!sizes_.factor->isConstant(Box<Dim>{here, here}.grown(distance))) return false;
    }
    Range range;
    range.shell = !range.inner;
    addGroups(x, distance * std::sqrt(static_cast<double>(Dim)), range);
    return range.inner != range.shell;
}

template <int Dim>
LocalBalls<Dim>::LocalBalls(const Domain<Dim>& domain, const SizeDistribution& sizes,
                            const LocalSizes& local) {
    if (!local.any()) {
        shares_.push_back({sizes, 1, 1, 0});
        return;
    }
    const auto inside = domain.sampler();
    LocalSizeSampler<Dim> sampler(domain, local);
    const Box<Dim> bounds = domain.bounds();
    const Vec<Dim> size = bounds.size();
    const double step = *std::max_element(size.c.begin(), size.c.end()) / kSamples;
    std::array<int, 3> n{1, 1, 1};
    for (std::size_t d = 0; d < Dim; ++d)
        n[d] = std::max(1, static_cast<int>(std::ceil(size.c[d] / step)));
    struct Class {
        double points = 0, logs = 0;
    };
    std::map<std::pair<std::uint32_t, int>, Class> classes;
    double all = 0;
    for (int k = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i) {
                const std::array<int, 3> at{i, j, k};
                Vec<Dim> x;
                for (std::size_t d = 0; d < Dim; ++d)
                    x.c[d] = bounds.lo.c[d] + (at[d] + 0.5) / n[d] * size.c[d];
                if (inside->signedDistance(x) >= 0) continue;
                const LocalSize here = sampler.at(x);
                const double log = std::log2(here.factor);
                Class& c = classes[{here.group, static_cast<int>(std::floor(kClasses * log))}];
                ++c.points;
                c.logs += log;
                ++all;
            }
    for (const auto& [key, c] : classes)
        shares_.push_back({local.sizesOf(key.first, sizes), std::exp2(c.logs / c.points),
                           c.points / all, key.first});
    if (shares_.empty()) shares_.push_back({sizes, local.factors().most, 1, 0});
}

template <int Dim>
double LocalBalls<Dim>::mean(double scale, double layer) const {
    if (shares_.size() == 1) {
        const Share& s = shares_.front();
        if (scale * s.factor == 1 && layer == 0) return s.sizes.meanBall(Dim);
        return ballWithShell<Dim>(s.sizes, scale * s.factor, layer);
    }
    double spheres = 0;
    for (const Share& s : shares_)
        spheres += s.weight / ballWithShell<Dim>(s.sizes, scale * s.factor, layer);
    return 1 / spheres;
}

template <int Dim>
double LocalBalls<Dim>::groupShare(std::uint32_t group) const {
    double spheres = 0;
    for (const Share& s : shares_)
        if (s.group == group) spheres += s.weight / ballWithShell<Dim>(s.sizes, s.factor, 0);
    return spheres;
}

template <int Dim>
std::vector<LocalSize> localSizesOf(const std::vector<Sphere<Dim>>& spheres,
                                    const Domain<Dim>& domain, const LocalSizes& sizes) {
    std::vector<LocalSize> all(spheres.size());
    parallelFor(IndexRange(0, spheres.size(), 2048), [&](const IndexRange& part) {
        LocalSizeSampler<Dim> sampler(domain, sizes);
        for (std::size_t i = part.begin(); i < part.end(); ++i)
            all[i] = sampler.at(spheres[i].center);
    });
    return all;
}

template <int Dim>
double ballWithShell(const SizeDistribution& sizes, double scale, double shell) {
    const double mean = scale * sizes.mean(), square = scale * scale * sizes.meanBall(2) / kPi;
    if constexpr (Dim == 2)
        return kPi * (square + shell * (2 * mean + shell));
    else
        return scale * scale * scale * sizes.meanBall(3) +
               4.0 / 3.0 * kPi * shell * (3 * square + shell * (3 * mean + shell));
}

#define VDBPACK_INSTANTIATE(Dim)                                                         \
    template class LocalSizeSampler<Dim>;                                                \
    template class LocalBalls<Dim>;                                                      \
    template std::vector<LocalSize> localSizesOf(const std::vector<Sphere<Dim>>&,        \
                                                 const Domain<Dim>&, const LocalSizes&); \
    template double ballWithShell<Dim>(const SizeDistribution&, double, double);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
