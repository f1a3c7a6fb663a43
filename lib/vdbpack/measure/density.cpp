#include "vdbpack/measure/density.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/measure/sampling.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>

namespace vdbpack {

namespace {

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
    const double volume = domain.volume();
    if (!(volume > 0))
        throw InputError(fmt::format("domain: its {} is {} {}; give a domain with an inside",
                                     Measure<Dim>::kVolume, volume, Measure<Dim>::kVolumeUnit));
    return totalMeasure(spheres) / volume;
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
    const double volume = domain.volumeDeeperThan(depth);
    if (!(volume > 1e-9 * domain.volume())) return std::nullopt;

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
    return covered / volume;
}

template <int Dim>
PlaceCheck<Dim> findPlaces(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                           double radius, std::uint64_t samplePoints) {
    if (!(radius > 0) || !std::isfinite(radius))
        throw ParameterError(fmt::format("places: radius {} mm is not positive; give one", radius));
    if (samplePoints == 0) throw ParameterError("places: 0 sample points see nothing; give some");
    requireUsable(spheres);
    const Box<Dim> bounds = domain.bounds();
    const double volume = domain.volume();
    PlaceCheck<Dim> none;
    if (bounds.empty() || !(volume > 0) || !(bounds.measure() > 0)) return none;

    // Points are spread block by block, so that those asked about together are near each other.
    constexpr double kBlockPoints = 4096;
    const double wanted =
        static_cast<double>(samplePoints) * std::clamp(bounds.measure() / volume, 1.0, 1e4);
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

template <int Dim>
DensityProfile densityProfile(const std::vector<Sphere<Dim>>& spheres, const Domain<Dim>& domain,
                              double width, double deepest) {
    const double known = domain.fieldDepth();
    if (!(width > 0 && deepest >= width) || deepest > known * (1 + 1e-6))
        throw ParameterError(
            fmt::format("profile: bins of {} mm down to {} mm; give a positive width and a depth "
                        "from that to {} mm, the depth of the field",
                        width, deepest, known));
    requireUsable(spheres);
    const auto count = static_cast<std::size_t>(std::floor(deepest / width * (1 + 1e-9)));
    if (count > 100000)
        throw ParameterError(
            fmt::format("profile: {} bins are more than the 100000 that it may have; give wider "
                        "ones than {} mm",
                        count, width));
    // Those that a bin may hold a part of.
    Samplers<Dim> samplers(domain);
    const double end = static_cast<double>(count) * width;
    const double rough = std::max(domain.facts().voxelSize, 1e-9 * width);
    std::vector<unsigned char> near(spheres.size());
    tbb::parallel_for(Blocks(0, spheres.size(), 512), [&](const Blocks& block) {
        auto& sampler = samplers.local();
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            const double d = -sampler.signedDistance(spheres[i].center);
            near[i] = d >= known * (1 - 1e-6) || d - spheres[i].radius < end;
        }
    });
    const auto crossing = static_cast<double>(std::count(near.begin(), near.end(), 1));
    const int points = static_cast<int>(std::clamp(1.2e7 / std::max(crossing, 1.0), 16.0, 1000.0));
    struct Sum {
        std::vector<double> covered, variance;
    };
    const auto sum = tbb::parallel_deterministic_reduce(
        Blocks(0, spheres.size(), 8192), Sum{},
        [&](const Blocks& block, Sum mine) {
            mine.covered.resize(count);
            mine.variance.resize(count);
            auto& sampler = samplers.local();
            std::vector<int> hits(count);
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                if (!near[i]) continue;
                Spread<Dim> spread(i);
                std::size_t first = count, last = 0;
                for (int k = 0; k < points; ++k) {
                    const Vec<Dim> x =
                        spheres[i].center + ballPoint<Dim>(spread.next()) * spheres[i].radius;
                    // Where the field takes a hair of a sphere for outside, it is at the wall.
                    double d = -sampler.signedDistance(x);
                    if (d < -rough) continue;
                    d = std::max(0.0, d);
                    const double bin = d / width;
                    if (!(bin < static_cast<double>(count))) continue;
                    const auto b = static_cast<std::size_t>(bin);
                    first = std::min(first, b);
                    last = std::max(last, b);
                    ++hits[b];
                }
                const double ball = Measure<Dim>::ball(spheres[i].radius);
                for (std::size_t b = first; b <= last && b < count; ++b) {
                    const double share = static_cast<double>(hits[b]) / points;
                    hits[b] = 0;
                    mine.covered[b] += share * ball;
                    mine.variance[b] += share * (1 - share) / points * ball * ball;
                }
            }
            return mine;
        },
        [&](Sum a, const Sum& b) {
            if (a.covered.empty()) return b;
            for (std::size_t k = 0; k < b.covered.size(); ++k) {
                a.covered[k] += b.covered[k];
                a.variance[k] += b.variance[k];
            }
            return a;
        });
    DensityProfile profile;
    profile.width = width;
    double outer = domain.volumeDeeperThan(0);
    for (std::size_t b = 0; b < count; ++b) {
        const double inner =
            domain.volumeDeeperThan(std::min(static_cast<double>(b + 1) * width, known));
        const double part = outer - inner;
        outer = inner;
        if (!(part > 1e-9 * domain.volume())) break;
        const bool any = !sum.covered.empty();
        profile.volume.push_back(part);
        profile.fraction.push_back(any ? sum.covered[b] / part : 0);
        profile.error.push_back(any ? std::sqrt(sum.variance[b]) / part : 0);
    }
    return profile;
}

template <int Dim>
std::optional<LocalFraction> localFraction(const std::vector<Sphere<Dim>>& spheres,
                                           const Domain<Dim>& domain, double edge) {
    if (!(edge > 0) || !std::isfinite(edge))
        throw ParameterError(
            fmt::format("local fraction: cells of {} mm; give a positive edge", edge));
    requireUsable(spheres);
    const Box<Dim> bounds = domain.bounds();
    std::array<std::size_t, static_cast<std::size_t>(Dim)> n{};
    double cells = 1;
    for (int d = 0; d < Dim; ++d) cells *= std::max(1.0, std::floor(bounds.size()[d] / edge));
    if (!(cells < 1e8))
        throw ParameterError(
            fmt::format("local fraction: {:.3g} cells are too many; give an edge larger than {} mm",
                        cells, edge));
    std::size_t total = 1;
    Vec<Dim> corner;
    for (int d = 0; d < Dim; ++d) {
        const double fit = std::floor(bounds.size()[d] / edge * (1 + 1e-9));
        if (fit < 1) return std::nullopt;
        n[static_cast<std::size_t>(d)] = static_cast<std::size_t>(fit);
        total *= static_cast<std::size_t>(fit);
        corner[d] = bounds.center()[d] - 0.5 * fit * edge;  // in the middle of the bounds
    }
    const auto cellAt = [&](const Vec<Dim>& x) {
        std::size_t cell = 0;
        for (int d = Dim - 1; d >= 0; --d) {
            const double at = std::floor((x[d] - corner[d]) / edge);
            const auto size = n[static_cast<std::size_t>(d)];
            if (!(at >= 0 && at < static_cast<double>(size))) return total;
            cell = cell * size + static_cast<std::size_t>(at);
        }
        return cell;
    };
    // In whole parts of a cell, so that the sum does not depend on the order.
    const double unit = 0x1p-40 * std::pow(edge, Dim);
    std::vector<std::atomic<std::int64_t>> covered(total);
    constexpr int kPoints = 32;
    tbb::parallel_for(Blocks(0, spheres.size(), 512), [&](const Blocks& block) {
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            const Sphere<Dim>& s = spheres[i];
            const double ball = Measure<Dim>::ball(s.radius);
            const auto add = [&](std::size_t cell, double volume) {
                if (cell < total)
                    covered[cell].fetch_add(std::llround(volume / unit), std::memory_order_relaxed);
            };
            Vec<Dim> lo = s.center, hi = s.center;
            for (int d = 0; d < Dim; ++d) lo[d] -= s.radius, hi[d] += s.radius;
            const std::size_t home = cellAt(lo);
            if (home < total && home == cellAt(hi)) {
                add(home, ball);
                continue;
            }
            Spread<Dim> spread(i);
            for (int k = 0; k < kPoints; ++k)
                add(cellAt(s.center + ballPoint<Dim>(spread.next()) * s.radius), ball / kPoints);
        }
    });
    Samplers<Dim> samplers(domain);
    std::vector<unsigned char> inside(total);
    const double halfDiagonal = 0.5 * edge * std::sqrt(static_cast<double>(Dim));
    tbb::parallel_for(Blocks(0, total, 64), [&](const Blocks& block) {
        auto& sampler = samplers.local();
        for (std::size_t c = block.begin(); c < block.end(); ++c) {
            Vec<Dim> x = corner;
            std::size_t rest = c;
            for (int d = 0; d < Dim; ++d) {
                const auto size = n[static_cast<std::size_t>(d)];
                x[d] += (static_cast<double>(rest % size) + 0.5) * edge;
                rest /= size;
            }
            inside[c] = sampler.contains(x) && !sampler.isWallCloser(x, halfDiagonal);
        }
    });
    LocalFraction result;
    result.edge = edge;
    double sum = 0, squares = 0;
    for (std::size_t c = 0; c < total; ++c) {
        if (!inside[c]) continue;
        const double f = static_cast<double>(covered[c].load()) * 0x1p-40;
        sum += f;
        squares += f * f;
        ++result.cells;
    }
    if (result.cells == 0) return std::nullopt;
    const auto m = static_cast<double>(result.cells);
    result.mean = sum / m;
    result.sd = std::sqrt(std::max(0.0, squares / m - result.mean * result.mean));
    return result;
}

#define VDBPACK_INSTANTIATE(Dim)                                                                  \
    template double solidFraction<Dim>(const std::vector<Sphere<Dim>>&, const Domain<Dim>&);      \
    template std::optional<double> interiorFraction<Dim>(const std::vector<Sphere<Dim>>&,         \
                                                         const Domain<Dim>&, double);             \
    template PlaceCheck<Dim> findPlaces<Dim>(const std::vector<Sphere<Dim>>&, const Domain<Dim>&, \
                                             double, std::uint64_t);                              \
    template DensityProfile densityProfile<Dim>(const std::vector<Sphere<Dim>>&,                  \
                                                const Domain<Dim>&, double, double);              \
    template std::optional<LocalFraction> localFraction<Dim>(const std::vector<Sphere<Dim>>&,     \
                                                             const Domain<Dim>&, double);

VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)

}  // namespace vdbpack
