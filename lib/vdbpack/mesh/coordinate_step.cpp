#include "vdbpack/mesh/coordinate_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace vdbpack {

namespace {

/// Rounding that a multiplication by the unit and its undoing leave, as a share.
constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
/// Powers of ten that are tried.
constexpr int kFinest = -9, kCoarsest = 6;

/// Calls `f(x)` for each coordinate in the unit of the file until it is false.
template <class F>
bool all(const TriangleMesh& mesh, double unit, F f) {
    for (const Vec<3>& v : mesh.vertices)
        for (const double c : v.c)
            if (!f(c / unit)) return false;
    return true;
}

}  // namespace

double coordinateStep(const TriangleMesh& mesh, double unit) {
    double largest = 0, step = 0;
    const bool floats = all(mesh, unit, [&](double x) {
        largest = std::max(largest, std::fabs(x));
        return std::fabs(x - static_cast<double>(static_cast<float>(x))) <=
               kRounding * std::fabs(x);
    });
    if (floats) {
        const auto top = static_cast<float>(largest);
        step = static_cast<double>(std::nextafter(top, std::numeric_limits<float>::infinity())) -
               static_cast<double>(top);
    }
    for (int k = kCoarsest; k >= kFinest; --k) {
        const double ten = std::pow(10.0, k);
        if (ten <= step) break;
        if (all(mesh, unit, [ten](double x) {
                const double n = x / ten;
                return std::fabs(n - std::nearbyint(n)) <= kRounding * std::fabs(n);
            })) {
            step = ten;
            break;
        }
    }
    return step * unit;
}

double medianEdge(const TriangleMesh& mesh) {
    constexpr std::size_t kMost = 10000;
    std::vector<double> edges;
    const std::size_t stride = mesh.triangles.size() / kMost + 1;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += stride)
        for (std::size_t k = 0; k < 3; ++k)
            edges.push_back(length(mesh.vertices[mesh.triangles[i][k]] -
                                   mesh.vertices[mesh.triangles[i][(k + 1) % 3]]));
    if (edges.empty()) return 0;
    const auto middle = edges.begin() + static_cast<std::ptrdiff_t>(edges.size() / 2);
    std::nth_element(edges.begin(), middle, edges.end());
    return *middle;
}

}  // namespace vdbpack
