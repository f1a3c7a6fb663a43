#include "vdbpack/measure/bond_order.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/parallel.h"

#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <functional>

namespace vdbpack {

namespace {

constexpr double kBond = 0.8;  // gap, in smaller radii
constexpr double kAlike = 0.7;
template <int Dim>
constexpr int kEnough = Dim == 3 ? 7 : 4;

/// The real spherical harmonics of degree 6 of a unit vector, scaled so that their squares add up
/// to 1 (2D: the sixth circular ones).
template <int Dim>
std::array<double, BondOrder<Dim>::kComponents> harmonics(const Vec<Dim>& n) {
    if constexpr (Dim == 2) {
        const std::complex<double> sixth = std::pow(std::complex<double>(n[0], n[1]), 6);
        return {sixth.real(), sixth.imag()};
    } else {
        const double z = n[2], zz = z * z;
        // Derivatives of the Legendre polynomial of degree 6.
        const double legendre[7] = {(231 * zz * zz * zz - 315 * zz * zz + 105 * zz - 5) / 16,
                                    z * (1386 * zz * zz - 1260 * zz + 210) / 16,
                                    (6930 * zz * zz - 3780 * zz + 210) / 16,
                                    z * (27720 * zz - 7560) / 16,
                                    (83160 * zz - 7560) / 16,
                                    166320 * z / 16,
                                    166320.0 / 16};
        // (6 - m)! / (6 + m)!, twice that from m = 1 on.
        static const std::array<double, 7> scale = [] {
            std::array<double, 7> s{};
            double ratio = 1;
            for (int m = 0; m < 7; ++m) {
                if (m > 0) ratio /= (6.0 + m) * (7.0 - m);
                s[static_cast<std::size_t>(m)] = std::sqrt(m > 0 ? 2 * ratio : ratio);
            }
            return s;
        }();
        std::array<double, 13> y{};
        y[0] = legendre[0];
        double re = 1, im = 0;
        for (std::size_t m = 1; m < 7; ++m) {
            const double next = re * n[0] - im * n[1];
            im = re * n[1] + im * n[0];
            re = next;
            y[2 * m - 1] = scale[m] * legendre[m] * re;
            y[2 * m] = scale[m] * legendre[m] * im;
        }
        return y;
    }
}

/// The spheres, with all images that bonds join.
template <int Dim>
SpheresWithImages<Dim> withBonded(const std::vector<Sphere<Dim>>& spheres,
                                  const PeriodicCell<Dim>& cell) {
    double largest = 0;
    for (const Sphere<Dim>& s : spheres) largest = std::max(largest, s.radius);
    return withImages(spheres, cell, (1 + kBond) * largest * (1 + 1e-9));
}

/// Calls `visit(j, offset of center j)` for the bonds of sphere i.
template <int Dim, class Visit>
void forEachBond(const CellLevels<Dim>& cells, const std::vector<Sphere<Dim>>& spheres,
                 std::size_t i, const Visit& visit) {
    const Sphere<Dim>& s = spheres[i];
    cells.forEachNear(
        s.center, (1 + kBond) * s.radius, [&](std::uint32_t j, const Sphere<Dim>& other) {
            if (j == i) return true;
            const double reach = s.radius + other.radius + kBond * std::min(s.radius, other.radius);
            const Vec<Dim> to = other.center - s.center;
            if (squaredLength(to) < reach * reach) visit(j, to);
            return true;
        });
}

template <int Dim>
BondOrder<Dim> bondOrder(const std::vector<Sphere<Dim>>& spheres, std::size_t own,
                         const CellLevels<Dim>& cells) {
    BondOrder<Dim> order;
    order.direction.resize(own);
    order.strength.resize(own);
    parallelFor(IndexRange(0, own, 256), [&](const IndexRange& part) {
        for (std::size_t i = part.begin(); i < part.end(); ++i) {
            std::array<double, BondOrder<Dim>::kComponents> sum{};
            int bonds = 0;
            forEachBond(cells, spheres, i, [&](std::uint32_t, const Vec<Dim>& to) {
                const auto y = harmonics<Dim>(normalized(to));
                for (std::size_t c = 0; c < y.size(); ++c) sum[c] += y[c];
                ++bonds;
            });
            double square = 0;
            for (const double v : sum) square += v * v;
            const double length = std::sqrt(square);
            order.strength[i] = bonds > 0 ? static_cast<float>(length / bonds) : 0;
            for (std::size_t c = 0; c < sum.size(); ++c)
                order.direction[i][c] = length > 0 ? static_cast<float>(sum[c] / length) : 0;
        }
    });
    return order;
}

/// How many of the first `own` spheres are in crystalline order.
/// @param sourceOf  which of those in `order` a sphere is one of.
template <int Dim, class SourceOf>
std::uint64_t countSolidLike(const CellLevels<Dim>& cells, const std::vector<Sphere<Dim>>& spheres,
                             std::size_t own, const BondOrder<Dim>& order,
                             const SourceOf& sourceOf) {
    return tbb::parallel_reduce(
        IndexRange(0, own, 256), std::uint64_t(0),
        [&](const IndexRange& part, std::uint64_t sum) {
            for (std::size_t i = part.begin(); i < part.end(); ++i) {
                int alike = 0;
                forEachBond(cells, spheres, i, [&](std::uint32_t j, const Vec<Dim>&) {
                    const auto &a = order.direction[i], &b = order.direction[sourceOf(j)];
                    double product = 0;
                    for (std::size_t c = 0; c < a.size(); ++c)
                        product += static_cast<double>(a[c]) * static_cast<double>(b[c]);
                    if (product > kAlike) ++alike;
                });
                if (alike >= kEnough<Dim>) ++sum;
            }
            return sum;
        },
        std::plus<>());
}

}  // namespace

template <int Dim>
BondOrder<Dim> bondOrder(const std::vector<Sphere<Dim>>& spheres, const PeriodicCell<Dim>& cell) {
    requireUsable(spheres);
    if (!cell.any()) return bondOrder(spheres, spheres.size(), CellLevels<Dim>(spheres, kBond));
    const auto all = withBonded(spheres, cell);
    return bondOrder(all.spheres, all.own, CellLevels<Dim>(all.spheres, kBond));
}

template <int Dim>
double solidLikeShare(const std::vector<Sphere<Dim>>& given, const PeriodicCell<Dim>& cell) {
    requireUsable(given);
    if (given.empty()) return 0;
    SpheresWithImages<Dim> repeated;
    if (cell.any()) repeated = withBonded(given, cell);
    const std::vector<Sphere<Dim>>& spheres = cell.any() ? repeated.spheres : given;
    const CellLevels<Dim> cells(spheres, kBond);
    const auto order = bondOrder(spheres, given.size(), cells);
    const auto count = countSolidLike(
        cells, spheres, given.size(), order,
        [&](std::uint32_t j) -> std::size_t { return cell.any() ? repeated.source[j] : j; });
    return static_cast<double>(count) / static_cast<double>(given.size());
}

template <int Dim>
std::uint64_t solidLikeOfPart(const std::vector<Sphere<Dim>>& spheres, std::size_t own) {
    if (own == 0) return 0;
    const CellLevels<Dim> cells(spheres, kBond);
    const auto order = bondOrder(spheres, spheres.size(), cells);
    return countSolidLike(cells, spheres, own, order, [](std::uint32_t j) { return j; });
}

double bondReach(double largest) {
    return (2 + kBond) * largest;
}

template std::uint64_t solidLikeOfPart(const std::vector<Sphere<2>>&, std::size_t);
template std::uint64_t solidLikeOfPart(const std::vector<Sphere<3>>&, std::size_t);
template BondOrder<2> bondOrder(const std::vector<Sphere<2>>&, const PeriodicCell<2>&);
template BondOrder<3> bondOrder(const std::vector<Sphere<3>>&, const PeriodicCell<3>&);
template double solidLikeShare(const std::vector<Sphere<2>>&, const PeriodicCell<2>&);
template double solidLikeShare(const std::vector<Sphere<3>>&, const PeriodicCell<3>&);

}  // namespace vdbpack
