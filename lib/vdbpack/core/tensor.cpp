#include "vdbpack/core/tensor.h"

#include "vdbpack/core/symmetric.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

constexpr double kTiny = 1e-290;  ///< numbers below have no reciprocal

}  // namespace

Tensor dyad(const Vec<3>& u) {
    // Squares of large components would overflow.
    const double most = std::max({std::fabs(u[0]), std::fabs(u[1]), std::fabs(u[2])});
    if (!(most > 0)) return {};
    if (most < kTiny) return dyad(u * (1 / kTiny));
    const Vec<3> n = normalized(u * (1 / most));
    return {n[0] * n[0], n[1] * n[1], n[2] * n[2], n[0] * n[1], n[1] * n[2], n[0] * n[2]};
}

Vec<3> mainAxis(const Tensor& t) {
    const double size = magnitude(t);
    if (size > 0 && size < kTiny) {
        Tensor larger{};
        addScaled(larger, 1 / kTiny, t);
        return mainAxis(larger);
    }
    const double f = size > 0 ? 1 / size : 1;
    const Matrix<3> m{{{{t[0] * f, t[3] * f, t[5] * f}},
                       {{t[3] * f, t[1] * f, t[4] * f}},
                       {{t[5] * f, t[4] * f, t[2] * f}}}};
    const auto eigen = eigenSystem<3>(m);
    return -eigen.values[2] > eigen.values[0] * (1 + 1e-12) ? eigen.vectors[2] : eigen.vectors[0];
}

void addScaled(Tensor& sum, double weight, const Tensor& t) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * t[i];
}

double magnitude(const Tensor& t) {
    double most = 0;
    for (const double c : t) most = std::max(most, std::fabs(c));
    return most;
}

}  // namespace vdbpack
