#include "vdbpack/voids/table_lattice.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Planes nearer to one another than this share of the extent are the same, written with few
/// digits.
constexpr double kSamePlane = 1e-6;

/// The distinct ones of coordinates, rising.
std::vector<double> planesOf(std::vector<double> coordinates) {
    std::sort(coordinates.begin(), coordinates.end());
    const double least = kSamePlane * (coordinates.back() - coordinates.front());
    std::vector<double> planes;
    for (const double c : coordinates)
        if (planes.empty() || c - planes.back() > least) planes.push_back(c);
    return planes;
}

std::size_t nearest(const std::vector<double>& planes, double c) {
    const auto above = std::upper_bound(planes.begin(), planes.end(), c);
    if (above == planes.begin()) return 0;
    const auto at = static_cast<std::size_t>(above - planes.begin()) - 1;
    return at + 1 < planes.size() && planes[at + 1] - c < c - planes[at] ? at + 1 : at;
}

}  // namespace

std::optional<TableLattice> TableLattice::from(
    const std::vector<std::pair<Vec<3>, double>>& numbers) {
    TableLattice lattice;
    std::size_t nodes = 1;
    for (std::size_t d = 0; d < 3; ++d) {
        std::vector<double> coordinates;
        coordinates.reserve(numbers.size());
        for (const auto& point : numbers) coordinates.push_back(point.first.c[d]);
        auto& planes = lattice.planes_[d] = planesOf(std::move(coordinates));
        if (planes.size() > numbers.size() / nodes) return std::nullopt;
        nodes *= planes.size();
        for (std::size_t i = 1; i < planes.size(); ++i) {
            const double step = planes[i] - planes[i - 1];
            lattice.step_ = lattice.step_ > 0 ? std::min(lattice.step_, step) : step;
        }
    }
    if (nodes != numbers.size()) return std::nullopt;
    lattice.values_.resize(nodes);
    std::vector<char> isKnown(nodes, 0);
    for (const auto& [x, number] : numbers) {
        std::size_t node = 0;
        for (std::size_t d = 3; d-- > 0;)
            node = node * lattice.planes_[d].size() + nearest(lattice.planes_[d], x.c[d]);
        if (isKnown[node] != 0) return std::nullopt;
        isKnown[node] = 1;
        lattice.values_[node] = number;
    }
    return lattice;
}

double TableLattice::at(const Vec<3>& x) const {
    std::array<std::size_t, 3> first{}, next{};
    std::array<double, 3> share{};
    for (std::size_t d = 0; d < 3; ++d) {
        const auto& planes = planes_[d];
        const double c = std::clamp(x.c[d], planes.front(), planes.back());
        const auto above = std::upper_bound(planes.begin(), planes.end(), c) - planes.begin();
        next[d] = std::min(static_cast<std::size_t>(above), planes.size() - 1);
        first[d] = next[d] > 0 ? next[d] - 1 : 0;
        if (next[d] > first[d])
            share[d] = (c - planes[first[d]]) / (planes[next[d]] - planes[first[d]]);
    }
    double sum = 0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
        double weight = 1;
        std::size_t node = 0;
        for (std::size_t d = 3; d-- > 0;) {
            const bool far = (corner >> d & 1) != 0;
            weight *= far ? share[d] : 1 - share[d];
            node = node * planes_[d].size() + (far ? next[d] : first[d]);
        }
        if (weight > 0) sum += weight * values_[node];
    }
    return sum;
}

}  // namespace vdbpack
