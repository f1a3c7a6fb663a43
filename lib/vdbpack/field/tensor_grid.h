// Fields of directions or symmetric tensors in .vdb files.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/tensor.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

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
