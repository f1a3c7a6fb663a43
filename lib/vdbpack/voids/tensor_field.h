// Private: interpolation of symmetric tensors at scattered points.
#pragma once

#include "vdbpack/core/vec.h"
#include "vdbpack/voids/direction_field.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace vdbpack {

/// Components xx, yy, zz, xy, yz, xz.
using Tensor = std::array<double, 6>;

/// u⊗u of the direction `u` scaled to length one; zero for zero.
Tensor dyad(const Vec<3>& u);
/// The eigenvector to the eigenvalue of largest magnitude, of length one.
Vec<3> mainAxis(const Tensor& t);
void addScaled(Tensor& sum, double weight, const Tensor& t);
/// The largest magnitude of a component.
double magnitude(const Tensor& t);

/// Tensors at scattered points, in a k-d tree.
class PointTensors {
public:
    static constexpr std::size_t kNeighbors = 12;

    struct Sample {
        Vec<3> x;
        Tensor tensor{};
    };
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
    Nearest nearest(const Vec<3>& x) const;

private:
    struct Node {
        Vec<3> x;
        std::uint32_t sample = 0;
        std::uint32_t dimension = 0;  ///< along which it splits its range
    };
    void build(std::size_t first, std::size_t last);
    void search(const Vec<3>& x, std::size_t first, std::size_t last, Nearest& found) const;
    void offer(const Vec<3>& x, std::size_t node, Nearest& found) const;

    std::vector<Node> nodes_;
    std::vector<Tensor> tensors_;  ///< one a node
};

/// The field in a .vdb file, see `readDirectionField`.
std::shared_ptr<const DirectionField> readVdbDirections(const std::string& file, double scale);

}  // namespace vdbpack
