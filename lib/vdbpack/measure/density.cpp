#include "vdbpack/measure/density.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/sampling.h"
#include "vdbpack/measure/contacts.h"

#include <fmt/format.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <functional>
#include <vector>

namespace vdbpack {

namespace {

/// Directions from a center to the points sampled where the field ends before `depth` plus a
/// radius.
template <int Dim>
std::vector<Vec<Dim>> probeDirections() {
    std::vector<Vec<Dim>> directions;
    for (int code = 0; code < (Dim == 2 ? 9 : 27); ++code) {
        const Vec<Dim> v = [&] {
            Vec<Dim> w;
            for (int i = 0, rest = code; i < Dim; ++i, rest /= 3) w[i] = rest % 3 - 1;
            return w;
        }();
        const double n = squaredLength(v);
        if (n == 1 || n == Dim) directions.push_back(normalized(v));
    }
    return directions;
}

template <int Dim>
double totalMeasure(const std::vector<Sphere<Dim>>& spheres) {
    // The deterministic form: the same digits for any number of threads.
    return tbb::parallel_deterministic_reduce(
        IndexRange(0, spheres.size(), 4096), 0.0,
        [&](const IndexRange& block, double sum) {
            for (std::size_t i = block.begin(); i < block.end(); ++i)
                sum += Measure<Dim>::ball(spheres[i].radius);
            return sum;
        },
        std::plus<>());
}

/// Points in all spheres that cross a depth: they give the fraction to some 5e-5.
constexpr double kPoints = 6e5;

/// The part of a sphere that lies deeper than a depth.
enum Part : unsigned char { none, whole, crossing };

/// @param deep  `depth`, less what rounding of the field may take off.
template <int Dim>
std::vector<unsigned char> partsDeeperThan(double depth, double deep,
                                           const std::vector<Sphere<Dim>>& spheres,
                                           const Domain<Dim>& domain, Samplers<Dim>& samplers) {
    const double known = domain.fieldDepth();
    std::vector<unsigned char> part(spheres.size());
    const auto probes = probeDirections<Dim>();
    parallelFor(IndexRange(0, spheres.size(), 512), [&](const IndexRange& block) {
        auto& sampler = samplers.local();
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            const Sphere<Dim>& s = spheres[i];
            const double d = -sampler.signedDistance(s.center);
            part[i] = crossing;
            if (d >= depth + s.radius) {
                part[i] = whole;
            } else if (d >= known * (1 - 1e-6)) {
                // The region within `depth` of a wall is round at the scale of `depth`: what
                // slips between the probes is a cap of 2 % of a sphere at most.
                const bool all = std::all_of(probes.begin(), probes.end(), [&](const Vec<Dim>& n) {
                    return -sampler.signedDistance(s.center + n * s.radius) >= deep;
                });
                if (all) part[i] = whole;
            } else if (d + s.radius < deep) {
                part[i] = none;
            }
        }
    });
    return part;
}

/// Volume of the parts of spheres that lie deeper than `depth`.
template <int Dim>
double coveredDeeperThan(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                         double depth, const SphereRows& rows) {
    // A field that ends at `depth` is clamped there: rounding must not decide.
    const double deep = depth * (1 - 1e-6);
    Samplers<Dim> samplers(domain);
    const auto part = partsDeeperThan(depth, deep, spheres, domain, samplers);
    const auto crossings = static_cast<double>(
        sumOver(rows.ranks, static_cast<std::uint64_t>(std::count(
                                part.begin(), part.end(), static_cast<unsigned char>(crossing)))));
    const auto points =
        static_cast<std::size_t>(std::clamp(kPoints / std::max(crossings, 1.0), 16.0, 1000.0));
    const BallPoints<Dim> ball(16384 + points);
    const double own = tbb::parallel_deterministic_reduce(
        IndexRange(0, spheres.size(), 512), 0.0,
        [&](const IndexRange& block, double sum) {
            auto& sampler = samplers.local();
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                if (part[i] == none) continue;
                double share = 1;
                if (part[i] == crossing) {
                    std::size_t inside = 0;
                    ball.visit(spheres[i], rows[i], points, [&](const Vec<Dim>& x) {
                        inside += -sampler.signedDistance(x) >= deep;
                    });
                    share = static_cast<double>(inside) / static_cast<double>(points);
                }
                sum += share * Measure<Dim>::ball(spheres[i].radius);
            }
            return sum;
        },
        std::plus<>());
    return sumOver(rows.ranks, own);
}

}  // namespace

template <int Dim>
double solidFraction(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                     Ranks* ranks) {
    const double volume = domain.volume();
    if (!(volume > 0))
        throw InputError(fmt::format("domain: its {} is {} {}; give a domain with an inside",
                                     Measure<Dim>::kVolume, volume, Measure<Dim>::kVolumeUnit));
    return sumOver(ranks, totalMeasure(spheres)) / volume;
}

template <int Dim>
double unionShare(const std::vector<Sphere<Dim>>& spheres, const PeriodicCell<Dim>& cell) {
    std::vector<std::vector<std::uint32_t>> overlapping(spheres.size());
    double crossings = 0;
    for (const Contact& contact : listContacts(spheres, 0, cell)) {
        if (contact.gap >= 0) continue;
        for (const std::uint32_t i : {contact.i, contact.j}) crossings += overlapping[i].empty();
        overlapping[contact.i].push_back(contact.j);
        overlapping[contact.j].push_back(contact.i);
    }
    if (crossings == 0) return 1;
    const auto points = static_cast<std::size_t>(std::clamp(kPoints / crossings, 16.0, 20000.0));
    const BallPoints<Dim> ball(16384 + points);
    double sum = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        // A point in n spheres counts as 1 / n of each.
        double covered = 0;
        if (overlapping[i].empty())
            covered = static_cast<double>(points);
        else
            ball.visit(spheres[i], i, points, [&](const Vec<Dim>& x) {
                int inside = 1;
                for (const std::uint32_t j : overlapping[i])
                    inside += squaredLength(cell.nearest(x - spheres[j].center)) <
                              spheres[j].radius * spheres[j].radius;
                covered += 1.0 / inside;
            });
        sum += covered / static_cast<double>(points) * Measure<Dim>::ball(spheres[i].radius);
    }
    return sum / totalMeasure(spheres);
}

template <int Dim>
std::optional<double> interiorFraction(const std::vector<Sphere<Dim>>& spheres,
                                       const Domain<Dim>& domain, double depth,
                                       const SphereRows& rows) {
    const double known = domain.fieldDepth();
    if (!(depth >= 0) || depth > known * (1 + 1e-6))
        throw ParameterError(
            fmt::format("interior fraction: depth {} mm is not within 0 to {} mm, "
                        "the depth of the field; make the field deeper",
                        depth, known));
    requireUsable(spheres);
    const double volume = domain.volumeDeeperThan(depth);
    if (!(volume > 1e-9 * domain.volume())) return std::nullopt;
    return coveredDeeperThan(spheres, domain, depth, rows) / volume;
}

template double unionShare(const std::vector<Sphere<2>>&, const PeriodicCell<2>&);
template double unionShare(const std::vector<Sphere<3>>&, const PeriodicCell<3>&);
template double solidFraction<2>(const std::vector<Sphere<2>>&, const Domain<2>&, Ranks*);
template double solidFraction<3>(const std::vector<Sphere<3>>&, const Domain<3>&, Ranks*);
template std::optional<double> interiorFraction<2>(const std::vector<Sphere<2>>&, const Domain<2>&,
                                                   double, const SphereRows&);
template std::optional<double> interiorFraction<3>(const std::vector<Sphere<3>>&, const Domain<3>&,
                                                   double, const SphereRows&);

}  // namespace vdbpack
