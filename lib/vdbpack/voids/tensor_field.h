// Private: interpolation of symmetric tensors at scattered points.
#pragma once

#include "vdbpack/core/tensor.h"
#include "vdbpack/core/vec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Tensors at scattered points, in a k-d tree.
class PointTensors {
public:
    static constexpr std::size_t kNeighbors = 12;

    using Sample = TensorSample;
    struct Near {
        double square = 0;  ///< of the distance, mm²
        std::uint32_t node = 0;
    };
    /// The nearest points, a heap with the farthest first.
    struct Nearest {
        std::array<Near, kNeighbors> near;
        std::size_t count = 0;  ///< less than kNeighbors only if there are fewer points
    };

    /// @param samples  finite, not empty. Samples at the same point are replaced by their mean;
    ///                 zero tensors are dropped unless all are zero.
    explicit PointTensors(std::vector<Sample> samples);

    /// The unit main axis of the tensor interpolated at `x`. Thread-safe.
    Vec<3> mainAxisAt(const Vec<3>& x) const;
    /// The tensor interpolated at `x`; each component lies within those of the samples.
    /// Thread-safe.
    Tensor at(const Vec<3>& x) const;
    Nearest nearest(const Vec<3>& x) const;

private:
    struct Node {
        Vec<3> x;
        std::uint32_t sample = 0;
        std::uint32_t dimension = 0;  ///< along which it splits its range
    };
    /// The nodes around a point, with weights that are not negative.
    struct Weighted {
        std::array<std::uint32_t, kNeighbors> node;
        std::array<double, kNeighbors> weight;
        std::size_t count = 0;
        std::uint32_t first = 0;  ///< the nearest node
    };
    Weighted weightedAt(const Vec<3>& x) const;
    void build(std::size_t first, std::size_t last);
    void search(const Vec<3>& x, std::size_t first, std::size_t last, Nearest& found) const;
    void offer(const Vec<3>& x, std::size_t node, Nearest& found) const;

    std::vector<Node> nodes_;
    std::vector<Tensor> tensors_;  ///< one a node
};

}  // namespace vdbpack
