#include "vdbpack/measure/morphometry/mean_intercept.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/core/symmetric.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace vdbpack {

namespace {

using Matrix = std::array<std::array<double, 3>, 3>;
using System = std::array<std::array<double, 7>, 6>;

/// Solves six linear equations (right-hand side in the last column) with partial pivoting.
std::array<double, 6> solve(System a) {
    for (std::size_t c = 0; c < 6; ++c) {
        std::size_t pivot = c;
        for (std::size_t r = c + 1; r < 6; ++r)
            if (std::abs(a[r][c]) > std::abs(a[pivot][c])) pivot = r;
        std::swap(a[c], a[pivot]);
        for (std::size_t r = c + 1; r < 6; ++r) {
            const double factor = a[r][c] / a[c][c];
            for (std::size_t k = c; k < 7; ++k) a[r][k] -= factor * a[c][k];
        }
    }
    std::array<double, 6> x{};
    for (std::size_t c = 6; c-- > 0;) {
        double sum = a[c][6];
        for (std::size_t k = c + 1; k < 6; ++k) sum -= a[c][k] * x[k];
        x[c] = sum / a[c][c];
    }
    return x;
}

}  // namespace

std::vector<Vec<3>> halfSphereDirections(int count) {
    const double turn = kPi * (3 - std::sqrt(5.0));  // the golden angle
    std::vector<Vec<3>> directions;
    for (int i = 0; i < count; ++i) {
        const double z = (i + 0.5) / count;
        const double r = std::sqrt(1 - z * z);
        directions.push_back({{r * std::cos(turn * i), r * std::sin(turn * i), z}});
    }
    return directions;
}

std::vector<double> crossingRates(const SurfaceDistance& surface,
                                  const std::vector<Vec<3>>& directions, int label) {
    std::array<double, 3> edges{};
    for (std::size_t l = 1; l < surface.edges.size(); ++l)
        for (std::size_t j = 0; j < 3; ++j)
            if (label == kAllLabels || label == static_cast<int>(l))
                edges[j] += surface.edges[l][j];
    const std::vector<SurfacePoint>& points = surface.points;
    // Sums over fixed ranges of points, added in order: the same for any number of threads.
    constexpr std::size_t kRun = 16384;
    const std::size_t n = directions.size();
    std::vector<float> ux(n), uy(n), uz(n);
    for (std::size_t i = 0; i < n; ++i) {
        ux[i] = static_cast<float>(directions[i][0]);
        uy[i] = static_cast<float>(directions[i][1]);
        uz[i] = static_cast<float>(directions[i][2]);
    }
    const std::size_t runs = (points.size() + kRun - 1) / kRun;
    std::vector<std::vector<double>> sums(runs);
    parallelFor(std::size_t{0}, runs, [&](std::size_t run) {
        std::vector<double>& sum = sums[run];
        sum.assign(n, 0.0);
        for (std::size_t p = run * kRun; p < std::min(points.size(), (run + 1) * kRun); ++p) {
            const SurfacePoint& s = points[p];
            if (!(s.area > 0) || (label != kAllLabels && label != s.label)) continue;
            const auto area = static_cast<float>(double{s.area} / edges[s.axis]);
            const float x = area * s.normal[0], y = area * s.normal[1], z = area * s.normal[2];
            for (std::size_t i = 0; i < n; ++i)
                sum[i] += static_cast<double>(std::abs(x * ux[i] + y * uy[i] + z * uz[i]));
        }
    });
    std::vector<double> rates(n, 0.0);
    for (const auto& sum : sums)
        for (std::size_t i = 0; i < n; ++i) rates[i] += sum[i];
    return rates;
}

std::vector<double> voxelCrossingRates(const VoxelImage& image,
                                       const std::vector<Vec<3>>& directions, int label) {
    // Distance of lines: close enough that many lines cross each void.
    constexpr double kApart = 2 * kVoxelStep;
    Vec<3> middle;
    double reach = 0;
    for (int d = 0; d < 3; ++d) {
        middle[d] = 0.5 * static_cast<double>(image.size[static_cast<std::size_t>(d)] - 1);
        reach += middle[d] * middle[d];
    }
    reach = std::sqrt(reach);
    const auto nx = static_cast<std::size_t>(image.size[0]);
    const auto ny = static_cast<std::size_t>(image.size[1]);
    std::vector<double> rates(directions.size());
    parallelFor(std::size_t{0}, directions.size(), [&](std::size_t i) {
        const Vec<3>& u = directions[i];
        const Vec<3> other = std::fabs(u[0]) < 0.6 ? Vec<3>{{1, 0, 0}} : Vec<3>{{0, 1, 0}};
        const Vec<3> e = normalized(cross(u, other)), g = cross(u, e);
        std::int64_t steps = 0, changes = 0;
        for (double a = -reach; a <= reach; a += kApart)
            for (double b = -reach; b <= reach; b += kApart) {
                const Vec<3> on = middle + e * a + g * b;
                // The part of the line between the outermost voxel centers.
                double from = -reach, to = reach;
                for (int d = 0; d < 3; ++d) {
                    const double hi = 2 * middle[d];
                    if (std::fabs(u[d]) < 1e-12) {
                        if (on[d] < 0 || on[d] > hi) to = from - 1;
                        continue;
                    }
                    const double t0 = -on[d] / u[d], t1 = (hi - on[d]) / u[d];
                    from = std::max(from, std::min(t0, t1));
                    to = std::min(to, std::max(t0, t1));
                }
                bool before = false, started = false;
                for (double t = from; t <= to; t += kVoxelStep) {
                    const Vec<3> p = on + u * t;
                    std::size_t at[3];
                    for (int d = 0; d < 3; ++d)
                        at[d] =
                            static_cast<std::size_t>(std::clamp(p[d], 0.0, 2 * middle[d]) + 0.5);
                    const std::size_t voxel = (at[2] * ny + at[1]) * nx + at[0];
                    if (!isLabeled(image, voxel, label)) {
                        started = false;
                        continue;
                    }
                    const bool now = image.distance[voxel] < 0;
                    if (started) {
                        ++steps;
                        changes += now != before;
                    }
                    before = now;
                    started = true;
                }
            }
        rates[i] = steps > 0
                       ? static_cast<double>(changes) / (kVoxelStep * static_cast<double>(steps))
                       : 0.0;
    });
    return rates;
}

std::optional<Anisotropy> fitAnisotropy(const std::vector<Vec<3>>& directions,
                                        const std::vector<double>& rates, double voxelSize) {
    double largest = 0;
    for (const double rate : rates) largest = std::max(largest, rate);
    if (!(largest > 0)) return std::nullopt;
    // Unknowns M_xx, M_yy, M_zz, M_xy, M_xz, M_yz in units of the largest rate squared.
    System normal{};
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const Vec<3>& u = directions[i];
        const double q = rates[i] * rates[i] / (largest * largest);
        // Lines along plates cross nothing, and their relative error is meaningless.
        const double weight = 1 / std::max(q, 1e-4);
        const std::array<double, 7> row{u[0] * u[0],
                                        u[1] * u[1],
                                        u[2] * u[2],
                                        2 * u[0] * u[1],
                                        2 * u[0] * u[2],
                                        2 * u[1] * u[2],
                                        q};
        for (std::size_t a = 0; a < 6; ++a)
            for (std::size_t b = 0; b < 7; ++b) normal[a][b] += weight * weight * row[a] * row[b];
    }
    const auto m = solve(normal);
    const auto eigen =
        eigenSystem<3>({{{{m[0], m[3], m[4]}}, {{m[3], m[1], m[5]}}, {{m[4], m[5], m[2]}}}});
    Anisotropy result;
    const double unit = largest * largest / (voxelSize * voxelSize);
    for (std::size_t i = 0; i < 3; ++i) {
        // The smallest value belongs to the longest intercept.
        const std::size_t k = 2 - i;
        result.eigenvalues[i] = std::max(eigen.values.c[k], 0.0) * unit;
        if (result.eigenvalues[i] > 0)
            result.meanInterceptLengths[i] = 1 / std::sqrt(result.eigenvalues[i]);
        result.axes[i] = eigen.vectors[k];
    }
    const double low = result.eigenvalues[0], high = result.eigenvalues[2];
    result.degree = 1 - low / high;
    if (low > 0) result.ratio = std::sqrt(high / low);
    return result;
}

}  // namespace vdbpack
