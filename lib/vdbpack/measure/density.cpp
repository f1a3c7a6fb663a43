#include "vdbpack/measure/density.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/measure/cell_levels.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>

namespace vdbpack {

namespace {

using Blocks = tbb::blocked_range<std::size_t>;

/// A sampler a thread.
template <int Dim>
class Samplers {
public:
    explicit Samplers(const Domain<Dim>& domain)
        : samplers_([&domain] { return domain.sampler(); }) {}
    DomainSampler<Dim>& local() { return *samplers_.local(); }

private:
    tbb::enumerable_thread_specific<std::unique_ptr<DomainSampler<Dim>>> samplers_;
};

/// The additive recurrence of lowest discrepancy in `Dim` dimensions, shifted at random.
/// Source: Roberts (2018), "The unreasonable effectiveness of quasirandom sequences": steps are
/// powers of 1/g, where g^(Dim+1) = g + 1.
template <int Dim>
class Spread {
public:
    explicit Spread(std::uint64_t seed) {
        RandomStream stream(0, seed);
        for (int i = 0; i < Dim; ++i) at_[i] = stream.uniform();
    }
    /// The next point of the unit cube.
    const Vec<Dim>& next() {
        constexpr double g = Dim == 2 ? 1.32471795724474602596 : 1.22074408460575947536;
        double step = 1;
        for (int i = 0; i < Dim; ++i) {
            step /= g;
            at_[i] += step;
            if (at_[i] >= 1) at_[i] -= 1;
        }
        return at_;
    }

private:
    Vec<Dim> at_;
};

/// The unit cube onto the unit ball (2D: disc), volumes in proportion.
template <int Dim>
Vec<Dim> ballPoint(const Vec<Dim>& u) {
    if constexpr (Dim == 2) {
        const double r = std::sqrt(u[0]), a = 2 * kPi * u[1];
        return {{r * std::cos(a), r * std::sin(a)}};
    } else {
        const double r = std::cbrt(u[0]), a = 2 * kPi * u[1], z = 1 - 2 * u[2];
        const double s = std::sqrt(std::max(0.0, 1 - z * z));
        return {{r * s * std::cos(a), r * s * std::sin(a), r * z}};
    }
}

/// Directions from a center to the points asked where the field is too shallow to tell.
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
        Blocks(0, spheres.size(), 4096), 0.0,
        [&](const Blocks& block, double sum) {
            for (std::size_t i = block.begin(); i < block.end(); ++i)
                sum += Measure<Dim>::ball(spheres[i].radius);
            return sum;
        },
        std::plus<>());
}

}  // namespace

template <int Dim>
double solidFraction(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain) {
    const double measure = domain.measure();
    if (!(measure > 0))
        throw InputError(fmt::format("domain: its {} is {} {}; give a domain with an inside",
                                     Measure<Dim>::kVolume, measure, Measure<Dim>::kVolumeUnit));
    return totalMeasure(spheres) / measure;
}

template <int Dim>
std::optional<double> interiorFraction(const std::vector<Sphere<Dim>>& spheres,
                                       const Domain<Dim>& domain, double depth) {
    const double known = domain.fieldDepth();
    if (!(depth >= 0) || depth > known * (1 + 1e-6))
        throw ParameterError(
            fmt::format("interior fraction: depth {} mm is not within 0 to {} mm, "
                        "the depth of the field; make the field deeper",
                        depth, known));
    requireUsable(spheres);
    const double measure = domain.measureDeeperThan(depth);
    if (!(measure > 1e-9 * domain.measure())) return std::nullopt;

    // A field that ends at `depth` says no more than "at least": the ulp must not decide.
    const double deep = depth * (1 - 1e-6);
    enum Part : unsigned char { none, whole, crossing };
    std::vector<unsigned char> part(spheres.size());
    Samplers<Dim> samplers(domain);
    const auto probes = probeDirections<Dim>();
    tbb::parallel_for(Blocks(0, spheres.size(), 512), [&](const Blocks& block) {
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
    const auto crossings = static_cast<double>(
        std::count(part.begin(), part.end(), static_cast<unsigned char>(crossing)));
    const int points = static_cast<int>(std::clamp(4e6 / std::max(crossings, 1.0), 16.0, 1000.0));
    const double covered = tbb::parallel_deterministic_reduce(
        Blocks(0, spheres.size(), 512), 0.0,
        [&](const Blocks& block, double sum) {
            auto& sampler = samplers.local();
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                if (part[i] == none) continue;
                double share = 1;
                if (part[i] == crossing) {
                    Spread<Dim> spread(i);
                    int inside = 0;
                    for (int k = 0; k < points; ++k) {
                        const Vec<Dim> x =
                            spheres[i].center + ballPoint<Dim>(spread.next()) * spheres[i].radius;
                        if (-sampler.signedDistance(x) >= deep) ++inside;
                    }
                    share = static_cast<double>(inside) / points;
                }
                sum += share * Measure<Dim>::ball(spheres[i].radius);
            }
            return sum;
        },
        std::plus<>());
    return covered / measure;
}

template <int Dim>
PlaceCheck<Dim> findPlaces(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                           double radius, std::uint64_t samplePoints) {
    if (!(radius > 0) || !std::isfinite(radius))
        throw ParameterError(fmt::format("places: radius {} mm is not positive; give one", radius));
    if (samplePoints == 0) throw ParameterError("places: 0 sample points see nothing; give some");
    requireUsable(spheres);
    const Box<Dim> bounds = domain.bounds();
    const double measure = domain.measure();
    PlaceCheck<Dim> none;
    if (bounds.empty() || !(measure > 0) || !(bounds.measure() > 0)) return none;

    // Points are spread block by block, so that those asked about together are near each other.
    constexpr double kBlockPoints = 4096;
    const double wanted =
        static_cast<double>(samplePoints) * std::clamp(bounds.measure() / measure, 1.0, 1e4);
    const double edge =
        std::pow(bounds.measure() * std::min(1.0, kBlockPoints / wanted), 1.0 / Dim);
    std::array<std::size_t, static_cast<std::size_t>(Dim)> count{};
    std::size_t blockCount = 1;
    Vec<Dim> blockSize;
    for (int i = 0; i < Dim; ++i) {
        const double size = bounds.hi[i] - bounds.lo[i];
        auto& n = count[static_cast<std::size_t>(i)];
        n = static_cast<std::size_t>(std::clamp(std::ceil(size / edge), 1.0, 65536.0));
        blockSize[i] = size / static_cast<double>(n);
        blockCount *= n;
    }
    const auto pointsABlock =
        static_cast<std::uint64_t>(std::ceil(wanted / static_cast<double>(blockCount)));
    const double halfDiagonal = 0.5 * length(blockSize) * (1 + 1e-9);

    const CellLevels<Dim> cells(spheres);
    Samplers<Dim> samplers(domain);
    tbb::enumerable_thread_specific<PlaceCheck<Dim>> found;
    const auto nearestSphere = [&](const Vec<Dim>& x, double reach) {
        double nearest = reach;
        cells.forEachNear(x, reach, [&](std::uint32_t, const Sphere<Dim>& s) {
            nearest = std::min(nearest, length(x - s.center) - s.radius);
            return true;
        });
        return nearest;
    };
    /// Whether no sphere and no wall is closer than `reach`.
    const auto isFree = [&](DomainSampler<Dim>& sampler, const Vec<Dim>& x, double reach) {
        const bool farFromSpheres =
            cells.forEachNear(x, reach, [&](std::uint32_t, const Sphere<Dim>& s) {
                const double closest = s.radius + reach;
                return squaredLength(x - s.center) >= closest * closest;
            });
        WallPoint<Dim> wall;
        return farFromSpheres && !(reach > 0 && sampler.nearestWall(x, reach, wall));
    };
    tbb::parallel_for(Blocks(0, blockCount, 1), [&](const Blocks& range) {
        auto& sampler = samplers.local();
        auto& mine = found.local();
        for (std::size_t b = range.begin(); b < range.end(); ++b) {
            Vec<Dim> corner;
            std::size_t rest = b;
            for (int i = 0; i < Dim; ++i) {
                const auto n = count[static_cast<std::size_t>(i)];
                corner[i] = bounds.lo[i] + static_cast<double>(rest % n) * blockSize[i];
                rest /= n;
            }
            const Vec<Dim> middle = corner + blockSize * 0.5;
            WallPoint<Dim> wall;
            const bool crossed = sampler.nearestWall(middle, halfDiagonal, wall);
            if (!crossed && !sampler.contains(middle)) continue;
            Spread<Dim> spread(b);
            for (std::uint64_t k = 0; k < pointsABlock; ++k) {
                Vec<Dim> x = spread.next();
                for (int i = 0; i < Dim; ++i) x[i] = corner[i] + x[i] * blockSize[i];
                const double enough = std::min(mine.largest, radius);
                const bool covered =
                    !cells.forEachNear(x, enough, [&](std::uint32_t, const Sphere<Dim>& s) {
                        const double closest = s.radius + enough;
                        return squaredLength(x - s.center) >= closest * closest;
                    });
                if (covered) continue;
                if (crossed && !(sampler.signedDistance(x) < 0)) continue;
                if (enough > 0 && sampler.nearestWall(x, enough, wall)) continue;
                // The field takes some pockets of air for bone.
                if (crossed && !sampler.contains(x)) continue;
                if (mine.largest >= radius) {
                    ++mine.places;
                    if (!isFree(sampler, x, mine.largest)) continue;
                }
                // A new largest: its clearance, by doubling what is searched.
                double reach = std::max({2 * mine.largest, radius / 8, 1e-6 * halfDiagonal});
                double clearance = reach;
                for (;; reach *= 2) {
                    clearance = nearestSphere(x, reach);
                    if (sampler.nearestWall(x, clearance, wall)) clearance = wall.distance;
                    if (clearance < reach || reach > 4 * length(bounds.size())) break;
                }
                if (mine.largest < radius && clearance >= radius) ++mine.places;
                if (clearance > mine.largest) {
                    mine.largest = clearance;
                    mine.at = x;
                }
            }
        }
    });
    PlaceCheck<Dim> result;
    for (const auto& f : found) {
        result.places += f.places;
        const auto key = [](const PlaceCheck<Dim>& p) {
            return std::make_tuple(p.largest, p.at.c);
        };
        if (key(f) > key(result)) {
            result.largest = f.largest;
            result.at = f.at;
        }
    }
    result.spacing = std::pow(
        bounds.measure() / (static_cast<double>(blockCount) * static_cast<double>(pointsABlock)),
        1.0 / Dim);
    return result;
}

#define VDBPACK_INSTANTIATE(Dim)                                                                  \
    template double solidFraction<Dim>(const std::vector<Sphere<Dim>>&, const Domain<Dim>&);      \
    template std::optional<double> interiorFraction<Dim>(const std::vector<Sphere<Dim>>&,         \
                                                         const Domain<Dim>&, double);             \
    template PlaceCheck<Dim> findPlaces<Dim>(const std::vector<Sphere<Dim>>&, const Domain<Dim>&, \
                                             double, std::uint64_t);

VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)

}  // namespace vdbpack
