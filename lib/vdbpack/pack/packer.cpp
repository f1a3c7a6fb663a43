#include "vdbpack/pack/packer.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/inset_domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/pack/kernel_settings.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/pack/wavefront.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

namespace vdbpack {

namespace {

/// Largest ratio of the factors on radii within a domain.
constexpr double kMostFactors = 20;

void requireValid(const PackOptions& options) {
    if (!(options.gap >= 0 && std::isfinite(options.gap)))
        throw ParameterError(
            fmt::format("gap {} mm: must be finite and not negative", options.gap));
    double further = 0;
    for (const Species& s : options.species) {
        if (!(s.probability >= 0 && s.depth >= 0)) further = 2;
        further += s.probability;
    }
    if (options.local.any() && !options.species.empty())
        throw ParameterError(
            "sizes by place and further species cannot be combined; cut voids afterwards instead");
    if (const auto [least, most] = options.local.factors();
        !(least > 0 && most <= kMostFactors * least))
        throw ParameterError(
            fmt::format("factors on radii from {:g} to {:g}: must be positive, and the largest at "
                        "most {:g} times the smallest",
                        least, most, kMostFactors));
    if (!(further < 1) || options.species.size() > 255)
        throw ParameterError(
            fmt::format("{} further species of probability {} in all: probabilities must not be "
                        "negative and add up to less than 1",
                        options.species.size(), further));
}

template <int Dim>
void requireCountable(const Domain<Dim>& domain, const Domain<Dim>& outer,
                      const PackOptions& options) {
    const SizeDistribution& sizes = options.sizes;
    const double expected = domain.volume() / LocalBalls<Dim>(outer, sizes, options.local).mean();
    const double most = 2e9 * (options.ranks ? options.ranks->count() : 1);
    if (!(expected < most))
        throw ResourceError(fmt::format(
            "radii of mean {:.3g} mm would give about {:.2g} {}; the limit is {:.3g}: give larger "
            "radii or check the unit of the domain",
            sizes.mean(), 0.6 * expected, Measure<Dim>::kSpheres, 0.5 * most));
}

/// Refuses what the front of a periodic cell cannot do.
template <int Dim>
void requirePeriodic(const PeriodicCell<Dim>& cell, const PackOptions& options,
                     const std::vector<Sphere<Dim>>& existing, const Callbacks& callbacks) {
    if (!sweeps(options.order))
        throw ParameterError("`order`: a periodic cell is packed in the order sweep or waves");
    if (!options.species.empty())
        throw ParameterError(
            "a periodic cell takes spheres of one species; cut voids afterwards instead");
    double largest = largestRadius(options);
    for (const Sphere<Dim>& s : existing) largest = std::max(largest, s.radius);
    requireLongCell(cell, largest + shellOf(options));
    const auto outside = std::count_if(existing.begin(), existing.end(), [&](const auto& s) {
        return cell.wrapped(s.center) != s.center;
    });
    if (outside > 0)
        callbacks.warn(fmt::format(
            "{} of {} existing {} have their centers outside the periodic cell, and their images "
            "in it count; check that they were packed in this cell",
            outside, existing.size(), Measure<Dim>::kSpheres));
}

/// Whether the bounds of a domain could hold the smallest radius.
template <int Dim>
bool fitsBounds(const Domain<Dim>& domain, const PackOptions& options) {
    const Vec<Dim> size = domain.bounds().size();
    return leastRadius(options) <=
           0.5 * *std::min_element(size.c.begin(), size.c.end()) * (1 + 1e-9);
}

/// Refuses a field that ends too near to the wall, where the front could not begin: found before
/// the front, that would refuse fields in which it can.
template <int Dim>
void requireDeepField(const Domain<Dim>& domain, const PackOptions& options, bool fits) {
    const double largest = largestRadius(options);
    if (fits && domain.fieldDepth() < largest)
        throw InputError(fmt::format(
            "the distance field of the domain ends {:.4g} mm below its wall, too near for {} of "
            "radius {:.4g} mm; make the domain for these radii (`fieldFor`)",
            domain.fieldDepth(), Measure<Dim>::kSpheres, largest));
}

/// Without the radii that fit nowhere in a thin domain: pending for ever, they would leave no
/// others to choose from.
/// @param domain  its wall moved inwards by the shell.
template <int Dim>
PackOptions withFittingSizes(const Domain<Dim>& domain, PackOptions options) {
    const double shell = shellOf(options);
    if (!options.local.any() && !holdsBall(domain, largestRadius(options) + shell))
        options.sizes = options.sizes.upTo(largestBall(domain).radius - shell);
    return options;
}

/// A sphere of the smallest radius in the middle of the largest ball of a domain that seems to hold
/// none: a ball hardly larger than that is easily missed by a search in cells.
/// @param fits  whether the bounds of the domain could hold it.
/// @throws InputError naming the largest ball if that is too small.
template <int Dim>
Sphere<Dim> onlySphere(const Domain<Dim>& domain, const Domain<Dim>& outer,
                       const PackOptions& options, double quantum, bool fits) {
    Sphere<Dim> ball = largestBall(domain);
    ball.radius -= shellOf(options);
    const LocalSize size = LocalSizeSampler<Dim>(outer, options.local).at(ball.center);
    const double smallest = options.local.sizesOf(size.group, options.sizes).quantile(0);
    Sphere<Dim> only{ball.center, static_cast<double>(static_cast<float>(smallest * size.factor))};
    for (int d = 0; d < Dim; ++d)
        only.center[d] = std::nearbyint(ball.center[d] / quantum) * quantum;
    WallPoint<Dim> wall;
    if (fits && ball.radius > 0 &&
        !domain.sampler()->nearestWall(only.center, only.radius + shellOf(options), wall))
        return only;
    const std::string kept =
        options.gap > 0 ? fmt::format(" with a gap of {:g} mm to the wall", options.gap) : "";
    if (!(ball.radius > 0))
        throw InputError(
            fmt::format("no {} fits{}: give a smaller gap or check the unit of the domain",
                        Measure<Dim>::kSphere, kept));
    std::string at;
    for (int d = 0; d < Dim; ++d)
        at += fmt::format("{}{:.6g}", d ? ", " : "", only.center[d] + 0.0);
    throw InputError(fmt::format(
        "no {} of radius {:.6g} mm or more fits{}: the largest that fits has radius {:.6g} mm, at "
        "({}); give smaller radii or check the unit of the domain",
        Measure<Dim>::kSphere, options.local.any() ? only.radius : options.sizes.min(), kept,
        ball.radius, at));
}

}  // namespace

FieldOptions fieldFor(const SizeDistribution& sizes) {
    return FieldOptions::forRadii(sizes.min(), sizes.max(), sizes.mean());
}

std::shared_ptr<const MeshDomain> meshDomain(TriangleMesh mesh, const SizeDistribution& sizes,
                                             const Callbacks& callbacks) {
    return meshDomain(std::move(mesh), fieldFor(sizes), callbacks);
}

template <int Dim>
PackResult<Dim> packSpheres(const Domain<Dim>& outer, const PackOptions& options,
                            const Callbacks& callbacks, const std::vector<Sphere<Dim>>& existing) {
    requireValid(options);
    std::unique_ptr<Domain<Dim>> inset;
    if (options.gap > 0) inset = insetDomain(outer, shellOf(options));
    const Domain<Dim>& domain = inset ? *inset : outer;
    requireCountable(domain, outer, options);
    if (const auto cell = domain.cell(); cell.any())
        requirePeriodic(cell, options, existing, callbacks);
    PackResult<Dim> result;
    result.quantum = quantumFor(options);
    // Blocks for radii that no part of a thin domain can hold would be many, and all empty.
    const bool fits = fitsBounds(domain, options);
    if (fits)
        result = packBlocks(domain, outer, withFittingSizes(domain, options), callbacks, existing);
    const std::uint64_t count = sumOver(options.ranks, std::uint64_t{result.pack.spheres.size()});
    if (count == 0 && !result.interrupted) requireDeepField(domain, options, fits);
    if (count == 0 && !result.interrupted && existing.empty()) {
        const Sphere<Dim> only = onlySphere(domain, outer, options, result.quantum, fits);
        if (options.ranks) result.pieces = {0, 1};
        if (options.ranks && !options.ranks->isFirst()) return result;
        result.pack.spheres.push_back(only);
        result.pack.order.push_back(0);
    }
    return result;
}

template PackResult<2> packSpheres(const Domain<2>&, const PackOptions&, const Callbacks&,
                                   const std::vector<Sphere<2>>&);
template PackResult<3> packSpheres(const Domain<3>&, const PackOptions&, const Callbacks&,
                                   const std::vector<Sphere<3>>&);

}  // namespace vdbpack
