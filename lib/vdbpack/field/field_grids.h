// Fields of numbers, directions and symmetric tensors in .vdb files.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/tensor.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// Numbers on the active voxels of the first grid of floats or doubles in a file. Thread-safe.
class ScalarGrid {
public:
    /// @param scale  mm in one unit of the file.
    /// @param fault  what is wrong with a value; empty: nothing.
    /// @throws IoError, ResourceError; InputError with the voxel, also for a faulty value.
    ScalarGrid(const std::string& file, double scale,
               const std::function<std::string(double)>& fault);
    ~ScalarGrid();

    /// The box around the active voxels, a voxel wider on each side, mm.
    const Box<3>& bounds() const;
    /// Shortest edge of a voxel, mm.
    double step() const;
    /// Places (mm) and values of some voxels, which represent the others from afar.
    const std::vector<std::pair<Vec<3>, double>>& samples() const;
    /// Trilinear between the centers of the active ones of the eight voxels around `x` (mm);
    /// nothing where none is.
    std::optional<double> at(const Vec<3>& x) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Tensors on the voxels of one grid or of several; a direction u is the tensor u⊗u. What grids a
/// file may have: see `readDirectionField`. Thread-safe.
class TensorGrid {
public:
    /// @param scale  mm in one unit of the file.
    /// @throws IoError, InputError, ResourceError.
    TensorGrid(const std::string& file, double scale);
    ~TensorGrid();

    /// The box around the voxels that are not zero, a voxel wider on each side, mm.
    const Box<3>& bounds() const;
    /// Tensors of some voxels, which represent the others from afar.
    const std::vector<TensorSample>& samples() const;
    /// Trilinear between the centers of the voxels; nothing where the eight around `x` are zero or
    /// cancel.
    std::optional<Tensor> at(const Vec<3>& x) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace vdbpack
