#include "vdbpack/voids/local_dilation.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/voids/dilated_pack.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace vdbpack {

namespace {

/// Side of the cube in which the relation is measured, and of the windows, in mean cells.
constexpr double kSampleSide = 6, kWindow = 3;
constexpr int kDilationRounds = 3;
/// Voxels along a mean cell, in the plane and in space, in which BV/TV by place is measured; larger
/// ones stay.
constexpr std::array<double, 2> kMeasuredVoxels{60, 10};
/// Points along the side of a cell, in the plane and in space; those that ask what is wanted.
constexpr std::array<int, 2> kPoints{24, 8};
constexpr int kAsked = 2;
/// Windows with a smaller share of their points in the domain are not corrected.
constexpr double kLeastShare = 0.02;
/// BV/TV that factors are sought for, and the smallest factor; smaller ones leave the void out.
constexpr double kLeastBvtv = 0.002, kMostBvtv = 0.999, kLeastFactor = 0.1;
/// Factors at which the relation is measured.
constexpr std::array<double, 14> kFactors{0.3,  0.5, 0.7,  0.8, 0.9, 0.95, 1.0,
                                          1.05, 1.1, 1.15, 1.2, 1.3, 1.4,  1.6};

/// BV/TV of a foam by the factor on all of its voids.
class Relation {
public:
    void add(double factor, double bvtv) {
        // Voxels and chance must not make it increase.
        points_.emplace_back(factor, std::min(bvtv, points_.back().second));
    }
    double leastBvtv() const { return points_.back().second; }
    double factorFor(double bvtv) const {
        std::size_t i = 1;
        while (i + 1 < points_.size() && points_[i].second > bvtv) ++i;
        const auto& [f0, b0] = points_[i - 1];
        const auto& [f1, b1] = points_[i];
        if (!(b0 > b1)) return f1;
        return f0 + (f1 - f0) * std::clamp((b0 - bvtv) / (b0 - b1), 0.0, 1.0);
    }

private:
    std::vector<std::pair<double, double>> points_{{0, 1}};
};

/// The length of a cell: that of a cube with the mean volume that a void has.
template <int Dim>
double meanCell(const Box<Dim>& box, const std::vector<Ellipsoid<Dim>>& voids) {
    std::size_t inside = 0;
    for (const auto& e : voids) inside += box.contains(e.center);
    return std::pow(box.volume() / static_cast<double>(std::max<std::size_t>(1, inside)),
                    1.0 / Dim);
}

template <int Dim>
Relation measuredRelation(const Box<Dim>& bounds, double cell,
                          const std::vector<Ellipsoid<Dim>>& voids, StampOptions<Dim> stamp,
                          const Callbacks& quiet) {
    const Box<Dim> box = intersection(
        bounds, Box<Dim>{bounds.center(), bounds.center()}.grown(0.5 * kSampleSide * cell));
    const auto domain = boxDomain(box);
    const VoidRegion<Dim> region{*domain};
    std::vector<Ellipsoid<Dim>> near;
    for (const auto& e : voids)
        if (box.grown(kFactors.back() * std::max(e.a, e.b)).contains(e.center)) near.push_back(e);
    stamp.shell = {};
    Relation relation;
    for (const double factor : kFactors) {
        const auto stamped = stampVoids(dilated(region, near, factor), *domain, stamp, quiet);
        relation.add(factor, std::max(0.0, 1 - stamped->volume() / box.volume()));
        if (relation.leastBvtv() < kLeastBvtv) break;
    }
    return relation;
}

/// What points in a part of the domain found.
struct Tally {
    double points = 0, solid = 0, wanted = 0;  ///< the last: the sum of what they want

    void add(double weight, const Tally& other) {
        points += weight * other.points;
        solid += weight * other.solid;
        wanted += weight * other.wanted;
    }
};

/// Cells over the box around a domain, in which BV/TV is measured by points.
template <int Dim>
class BvtvCells {
public:
    BvtvCells(const VoidRegion<Dim>& region, double cell,
              const std::function<double(const Vec<Dim>&)>& wanted)
        : region_(region), cell_(cell), box_(region.domain.bounds()) {
        std::size_t all = 1;
        for (int d = 0; d < Dim; ++d) {
            const auto at = static_cast<std::size_t>(d);
            count_[at] = std::max<std::int64_t>(1, std::llround(box_.size()[d] / cell_));
            side_[d] = box_.size()[d] / static_cast<double>(count_[at]);
            all *= static_cast<std::size_t>(count_[at]);
        }
        wanted_.resize(all);
        tallies_.resize(all);
        forEachCell([&](std::size_t i, const auto& isInside) {
            double sum = 0;
            int points = 0;
            forPoints(i, kAsked, [&](const Vec<Dim>& x) {
                if (!isInside(x)) return;
                sum += wanted(x);
                ++points;
            });
            wanted_[i] = points > 0 ? sum / points : wanted(centerOf(i));
        });
    }

    void measure(const StampedVoids<Dim>& voids) {
        using Sampler = typename StampedVoids<Dim>::Sampler;
        PerThread<Sampler> samplers([&] { return Sampler(voids); });
        forEachCell([&](std::size_t i, const auto& isInside) {
            Sampler& distance = samplers.local();
            Tally tally;
            forPoints(i, kPoints[Dim - 2], [&](const Vec<Dim>& x) {
                if (!isInside(x)) return;
                tally.points += 1;
                tally.solid += distance(x) >= 0;
            });
            tally.wanted = tally.points * wanted_[i];
            tallies_[i] = tally;
        });
    }

    /// What is found in the window around a point.
    Tally around(const Vec<Dim>& x) const {
        std::array<std::int64_t, 3> first{}, last{};
        Vec<Dim> lo, hi;
        for (int d = 0; d < Dim; ++d) {
            const auto at = static_cast<std::size_t>(d);
            const double middle = (x[d] - box_.lo[d]) / side_[d], half = 0.5 * kWindow;
            lo[d] = middle - half * cell_ / side_[d];
            hi[d] = middle + half * cell_ / side_[d];
            first[at] = std::max<std::int64_t>(0, static_cast<std::int64_t>(std::floor(lo[d])));
            last[at] = std::min(count_[at] - 1, static_cast<std::int64_t>(std::ceil(hi[d])) - 1);
            if (first[at] > last[at]) return {};
        }
        Tally sum;
        for (auto at = first;;) {
            double share = 1;
            std::size_t index = 0;
            for (int d = Dim; d-- > 0;) {
                const auto i = static_cast<std::size_t>(d);
                const auto k = static_cast<double>(at[i]);
                share *= std::min(k + 1, hi[d]) - std::max(k, lo[d]);
                index =
                    index * static_cast<std::size_t>(count_[i]) + static_cast<std::size_t>(at[i]);
            }
            sum.add(share, tallies_[index]);
            std::size_t d = 0;
            while (d < Dim && at[d] == last[d]) {
                at[d] = first[d];
                ++d;
            }
            if (d == Dim) return sum;
            ++at[d];
        }
    }

    /// Points of a whole window.
    static double pointsOfWindow() { return std::pow(kWindow * kPoints[Dim - 2], Dim); }

private:
    Vec<Dim> cornerOf(std::size_t i) const {
        Vec<Dim> x = box_.lo;
        for (int d = 0; d < Dim; ++d) {
            const auto n = static_cast<std::size_t>(count_[static_cast<std::size_t>(d)]);
            x[d] += static_cast<double>(i % n) * side_[d];
            i /= n;
        }
        return x;
    }
    Vec<Dim> centerOf(std::size_t i) const { return cornerOf(i) + side_ * 0.5; }

    template <class Visit>
    void forPoints(std::size_t cell, int perSide, const Visit& visit) const {
        const Vec<Dim> corner = cornerOf(cell);
        const int all = static_cast<int>(std::lround(std::pow(perSide, Dim)));
        for (int k = 0; k < all; ++k) {
            Vec<Dim> x = corner;
            for (int d = 0, rest = k; d < Dim; ++d, rest /= perSide)
                x[d] += (rest % perSide + 0.5) / perSide * side_[d];
            visit(x);
        }
    }

    /// Calls `visit(cell, whether a point lies in the part that may have voids)` in parallel.
    template <class Visit>
    void forEachCell(const Visit& visit) const {
        parallelFor(IndexRange(0, wanted_.size(), 16), [&](const auto& range) {
            const Domain<Dim>& envelope = region_.domain.envelope();
            const auto outer = envelope.sampler();
            const auto inner = &envelope == &region_.domain ? nullptr : region_.domain.sampler();
            const auto isInside = [&](const Vec<Dim>& x) {
                return region_.shell.isDeeper(x, -outer->signedDistance(x)) &&
                       (!inner || inner->signedDistance(x) < 0);
            };
            for (std::size_t i = range.begin(); i < range.end(); ++i) visit(i, isInside);
        });
    }

    const VoidRegion<Dim>& region_;
    double cell_;
    Box<Dim> box_;
    std::array<std::int64_t, 3> count_{1, 1, 1};
    Vec<Dim> side_;
    std::vector<double> wanted_;  ///< mean in each cell
    std::vector<Tally> tallies_;
};

double logit(double share) {
    const double s = std::clamp(share, kLeastBvtv, kMostBvtv);
    return std::log(s / (1 - s));
}

}  // namespace

template <int Dim>
std::vector<double> localDilation(const VoidRegion<Dim>& region,
                                  const std::vector<Ellipsoid<Dim>>& voids,
                                  const std::function<double(const Vec<Dim>&)>& wanted,
                                  const StampOptions<Dim>& fine, const Callbacks& callbacks) {
    Callbacks quiet;
    quiet.cancelled = callbacks.cancelled;
    const double cell = meanCell(region.domain.bounds(), voids);
    StampOptions<Dim> stamp = fine;
    stamp.voxelSize = std::max(fine.voxelSize, cell / kMeasuredVoxels[Dim - 2]);
    const Relation relation = measuredRelation(region.domain.bounds(), cell, voids, stamp, quiet);
    BvtvCells<Dim> cells(region, cell, wanted);
    callbacks.stopIfCancelled();
    // What is aimed at, as a logit, so that solid and voids are alike.
    std::vector<double> aims(voids.size()), factors(voids.size());
    const auto forVoids = [&](const auto& visit) {
        parallelFor(std::size_t{0}, voids.size(), [&](std::size_t i) {
            visit(i);
            const double factor = relation.factorFor(1 / (1 + std::exp(-aims[i])));
            factors[i] = factor < kLeastFactor ? 0 : factor;
        });
    };
    forVoids([&](std::size_t i) { aims[i] = logit(wanted(voids[i].center)); });
    for (int round = 0; round < kDilationRounds; ++round) {
        cells.measure(*stampVoids(dilated(region, voids, 1, factors), region.domain, stamp, quiet));
        callbacks.stopIfCancelled();
        forVoids([&](std::size_t i) {
            const Tally window = cells.around(voids[i].center);
            if (window.points < kLeastShare * cells.pointsOfWindow()) return;
            aims[i] += logit(window.wanted / window.points) - logit(window.solid / window.points);
            aims[i] = std::clamp(aims[i], logit(0), logit(1));
        });
    }
    return factors;
}

template std::vector<double> localDilation(const VoidRegion<2>&, const std::vector<Ellipsoid<2>>&,
                                           const std::function<double(const Vec<2>&)>&,
                                           const StampOptions<2>&, const Callbacks&);
template std::vector<double> localDilation(const VoidRegion<3>&, const std::vector<Ellipsoid<3>>&,
                                           const std::function<double(const Vec<3>&)>&,
                                           const StampOptions<3>&, const Callbacks&);

}  // namespace vdbpack
