#include "vdbpack/voids/tensor_field.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/symmetric.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

constexpr std::size_t kLeaf = 8;  ///< ranges of at most so many nodes are searched linearly
constexpr std::size_t kParallel = 1 << 15;  ///< ranges of more nodes are built in parallel
constexpr double kReach = 1.001;            ///< cutoff, per distance of the farthest neighbor
constexpr double kRidge = 0.01;  ///< per spread; limits slopes across flat layers of points

}  // namespace

PointTensors::PointTensors(std::vector<Sample> samples) {
    std::sort(samples.begin(), samples.end(),
              [](const Sample& a, const Sample& b) { return a.x.c < b.x.c; });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < samples.size();) {
        std::size_t end = i + 1;
        while (end < samples.size() && samples[end].x == samples[i].x) ++end;
        Sample mean{samples[i].x, {}};
        for (std::size_t k = i; k < end; ++k)
            addScaled(mean.tensor, 1 / static_cast<double>(end - i), samples[k].tensor);
        samples[kept++] = mean;
        i = end;
    }
    samples.resize(kept);
    const auto informed = std::stable_partition(
        samples.begin(), samples.end(), [](const Sample& s) { return magnitude(s.tensor) > 0; });
    if (informed != samples.begin()) samples.erase(informed, samples.end());

    nodes_.reserve(samples.size());
    for (const auto& s : samples)
        nodes_.push_back({s.x, static_cast<std::uint32_t>(nodes_.size()), 0});
    build(0, nodes_.size());
    // In the order of the tree, so that neighbors in space are close in memory.
    tensors_.reserve(samples.size());
    for (const auto& node : nodes_) tensors_.push_back(samples[node.sample].tensor);
}

void PointTensors::build(std::size_t first, std::size_t last) {
    if (last - first <= kLeaf) return;
    Box<3> box;
    for (std::size_t i = first; i < last; ++i) box.add(nodes_[i].x);
    const Vec<3> size = box.size();
    int d = 0;
    for (int i = 1; i < 3; ++i)
        if (size[i] > size[d]) d = i;
    const std::size_t middle = first + (last - first) / 2;
    const auto at = [this](std::size_t i) {
        return nodes_.begin() + static_cast<std::ptrdiff_t>(i);
    };
    std::nth_element(at(first), at(middle), at(last), [d](const Node& a, const Node& b) {
        return a.x[d] < b.x[d] || (a.x[d] == b.x[d] && a.sample < b.sample);
    });
    nodes_[middle].dimension = static_cast<std::uint32_t>(d);
    const auto below = [&] { build(first, middle); };
    const auto above = [&] { build(middle + 1, last); };
    if (last - first > kParallel) {
        tbb::parallel_invoke(below, above);
    } else {
        below();
        above();
    }
}

void PointTensors::offer(const Vec<3>& x, std::size_t node, Nearest& found) const {
    const auto nearer = [](const Near& a, const Near& b) { return a.square < b.square; };
    const double square = squaredLength(nodes_[node].x - x);
    const auto begin = found.near.begin();
    if (found.count == kNeighbors) {
        if (!(square < begin->square)) return;
        std::pop_heap(begin, found.near.end(), nearer);
        --found.count;
    }
    found.near[found.count++] = {square, static_cast<std::uint32_t>(node)};
    std::push_heap(begin, begin + static_cast<std::ptrdiff_t>(found.count), nearer);
}

void PointTensors::search(const Vec<3>& x, std::size_t first, std::size_t last,
                          Nearest& found) const {
    if (last - first <= kLeaf) {
        for (std::size_t i = first; i < last; ++i) offer(x, i, found);
        return;
    }
    const std::size_t middle = first + (last - first) / 2;
    const auto d = static_cast<int>(nodes_[middle].dimension);
    const double beyond = x[d] - nodes_[middle].x[d];
    offer(x, middle, found);
    if (beyond < 0)
        search(x, first, middle, found);
    else
        search(x, middle + 1, last, found);
    if (found.count == kNeighbors && beyond * beyond >= found.near[0].square) return;
    if (beyond < 0)
        search(x, middle + 1, last, found);
    else
        search(x, first, middle, found);
}

PointTensors::Nearest PointTensors::nearest(const Vec<3>& x) const {
    Nearest found;
    search(x, 0, nodes_.size(), found);
    return found;
}

PointTensors::Weighted PointTensors::weightedAt(const Vec<3>& x) const {
    const Nearest found = nearest(x);
    const std::size_t n = found.count;
    const auto first =
        std::min_element(found.near.begin(), found.near.begin() + static_cast<std::ptrdiff_t>(n),
                         [](const Near& a, const Near& b) { return a.square < b.square; });
    const double unit = std::sqrt(first->square);
    Weighted result;
    result.first = first->node;
    if (!(unit > 0)) {
        result.node[0] = first->node;
        result.weight[0] = 1;
        result.count = 1;
        return result;
    }

    // The cutoff lies slightly beyond the farthest neighbor: otherwise all weights would vanish
    // where all neighbors are equally far. With fewer points no cutoff is needed.
    const double cut = n < kNeighbors ? 0 : unit / (kReach * std::sqrt(found.near[0].square));
    std::array<double, kNeighbors> weights{};
    std::array<Vec<3>, kNeighbors> to;  // from `x`, later from the center
    double total = 0;
    Vec<3> center;
    for (std::size_t i = 0; i < n; ++i) {
        weights[i] = std::pow(unit / std::sqrt(found.near[i].square) - cut, 2);
        to[i] = nodes_[found.near[i].node].x - x;
        total += weights[i];
        center += to[i] * weights[i];
    }
    center *= 1 / total;

    // Fitting a plane to the values by weighted least squares adds a slope to the weights, along
    // the vector from the center to `x`. The vector is limited to the spread of the points.
    Matrix<3> spread{};
    double trace = 0;
    for (std::size_t i = 0; i < n; ++i) {
        to[i] -= center;
        for (std::size_t d = 0; d < 3; ++d) spread[d] += to[i] * (to[i].c[d] * weights[i] / total);
        trace += squaredLength(to[i]) * weights[i] / total;
    }
    Vec<3> slope;
    if (trace > 0) {
        for (std::size_t d = 0; d < 3; ++d) spread[d].c[d] += kRidge * trace;
        const Vec<3> way = -center * std::min(1.0, std::sqrt(trace / squaredLength(center)));
        const Vec<3> across = cross(spread[1], spread[2]);
        slope = Vec<3>{{dot(way, across), dot(way, cross(spread[2], spread[0])),
                        dot(way, cross(spread[0], spread[1]))}} *
                (1 / dot(spread[0], across));
    }
    for (std::size_t i = 0; i < n; ++i) {
        // Negative weights could give a direction unlike that of any point.
        result.weight[i] = weights[i] * std::max(0.0, 1 + dot(slope, to[i]));
        result.node[i] = found.near[i].node;
    }
    result.count = n;
    return result;
}

Vec<3> PointTensors::mainAxisAt(const Vec<3>& x) const {
    const Weighted near = weightedAt(x);
    Tensor sum{};
    double size = 0;
    for (std::size_t i = 0; i < near.count; ++i) {
        const Tensor& t = tensors_[near.node[i]];
        addScaled(sum, near.weight[i], t);
        size += near.weight[i] * magnitude(t);
    }
    // Tension and compression can cancel.
    return magnitude(sum) > 1e-12 * size ? mainAxis(sum) : mainAxis(tensors_[near.first]);
}

Tensor PointTensors::at(const Vec<3>& x) const {
    const Weighted near = weightedAt(x);
    double total = 0;
    for (std::size_t i = 0; i < near.count; ++i) total += near.weight[i];
    if (!(total > 0)) return tensors_[near.first];
    Tensor sum{};
    for (std::size_t i = 0; i < near.count; ++i)
        addScaled(sum, near.weight[i] / total, tensors_[near.node[i]]);
    return sum;
}

}  // namespace vdbpack
