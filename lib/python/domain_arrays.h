// Meshes, images and level sets from arrays of numpy.
#pragma once

#include "arrays.h"

#include "vdbpack/field/dense_level_set.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/image/image.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>

namespace vdbpack {

/// @param arrays  vertices and faces.
inline std::shared_ptr<const TriangleMesh> meshOf(const py::tuple& arrays) {
    const DoubleArray points = DoubleArray::ensure(arrays[0]);
    const IndexArray corners = wholeNumbers(arrays[1], "faces");
    if (!points || points.ndim() != 2 || points.shape(1) != 3)
        throw ParameterError("vertices: an array of numbers of shape (N, 3) is needed");
    if (corners.ndim() != 2 || corners.shape(1) != 3)
        throw ParameterError("faces: an array of whole numbers of shape (M, 3) is needed");
    auto mesh = std::make_shared<TriangleMesh>();
    const auto n = points.shape(0);
    if (n > std::numeric_limits<std::uint32_t>::max())
        throw ParameterError("vertices: at most 2^32 can be taken");
    for (py::ssize_t i = 0; i < n; ++i) {
        mesh->vertices.push_back({{points.at(i, 0), points.at(i, 1), points.at(i, 2)}});
        for (const double c : mesh->vertices.back().c)
            if (!std::isfinite(c))
                throw InputError(fmt::format("vertices: row {} is not finite", i));
    }
    for (py::ssize_t t = 0; t < corners.shape(0); ++t) {
        std::array<std::uint32_t, 3> triangle{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int64_t v = corners.at(t, static_cast<py::ssize_t>(k));
            if (v < 0 || v >= n)
                throw InputError(
                    fmt::format("faces: row {} names vertex {}, and there are {}", t, v, n));
            triangle[k] = static_cast<std::uint32_t>(v);
        }
        mesh->triangles.push_back(triangle);
    }
    if (mesh->triangles.empty()) throw InputError("faces: there are none");
    return mesh;
}

/// The type of 64-bit numbers that 32 bits hold. @throws InputError for larger ones
inline std::int32_t fitting(const py::array& values) {
    for (const char* end : {"min", "max"}) {
        const auto extreme = values.attr(end)().cast<double>();
        if (extreme < -0x1p31 || extreme >= 0x1p31)
            throw InputError(fmt::format("image: {} does not fit into 32 bits", extreme));
    }
    return 0;
}

/// @param arrays  values, and the matrix from indices to mm in the world of DICOM (LPS), 4 x 4.
inline std::shared_ptr<const Image> imageOf(const py::tuple& arrays) {
    const py::array values = py::array::ensure(arrays[0]);
    const DoubleArray affine = DoubleArray::ensure(arrays[1]);
    if (!values || !affine) throw ParameterError("image: arrays of numbers are needed");
    if (values.ndim() != 3) throw ParameterError("image: an array of three dimensions is needed");
    if (affine.ndim() != 2 || affine.shape(0) != 4 || affine.shape(1) != 4)
        throw ParameterError("affine: a matrix of shape (4, 4) is needed");
    auto image = std::make_shared<Image>();
    for (std::size_t d = 0; d < 3; ++d) {
        const auto axis = static_cast<py::ssize_t>(d);
        image->grid.size[d] = static_cast<std::size_t>(values.shape(axis));
        if (image->grid.size[d] == 0) throw InputError("image: it has no voxels");
        for (std::size_t row = 0; row < 3; ++row)
            image->grid.step[d].c[row] = affine.at(static_cast<py::ssize_t>(row), axis);
        image->grid.origin.c[d] = affine.at(axis, 3);
    }
    if (!(std::fabs(image->grid.signedVoxelVolume()) > 0) ||
        !std::isfinite(image->grid.signedVoxelVolume()) ||
        !std::isfinite(squaredLength(image->grid.origin)))
        throw InputError("affine: its axes lie in one plane, or are not finite");
    // The first index is the fastest in memory.
    const auto take = [&](auto type, NumberType voxels) {
        using T = decltype(type);
        const py::array_t<T, py::array::f_style | py::array::forcecast> packed(values);
        const std::size_t bytes = sizeof(T) * image->grid.voxels();
        image->type = voxels;
        image->bytes = voxelMemory(bytes);
        if (!image->bytes) throw ResourceError("image: no memory for a copy of it");
        std::memcpy(image->bytes.get(), packed.data(), bytes);
    };
    const char kind = values.dtype().kind();
    const auto size = values.dtype().itemsize();
    if (kind == 'b' || (kind == 'u' && size == 1))
        take(std::uint8_t{}, NumberType::u8);
    else if (kind == 'u' && size == 2)
        take(std::uint16_t{}, NumberType::u16);
    else if (kind == 'i' && size <= 2)
        take(std::int16_t{}, NumberType::i16);
    else if (kind == 'u' && size == 4)
        take(std::uint32_t{}, NumberType::u32);
    else if (kind == 'i' || kind == 'u')
        take(fitting(values), NumberType::i32);
    else if (kind == 'f' && size == 4)
        take(float{}, NumberType::f32);
    else if (kind == 'f')
        take(double{}, NumberType::f64);
    else
        throw ParameterError("image: an array of numbers is needed");
    image->format = "array";
    return image;
}

/// @param given  values, spacing and origin.
inline std::shared_ptr<const VdbGrid> levelSetIn(const py::tuple& given) {
    const FloatArray values = FloatArray::ensure(given[0]);
    if (!values || values.ndim() != 3)
        throw ParameterError("level set: an array of numbers of three dimensions is needed");
    DenseLevelSet dense;
    for (std::size_t d = 0; d < 3; ++d)
        dense.size[d] = static_cast<std::size_t>(values.shape(static_cast<py::ssize_t>(d)));
    dense.spacing = given[1].cast<double>();
    dense.origin = {given[2].cast<std::array<double, 3>>()};
    if (!std::isfinite(squaredLength(dense.origin)))
        throw ParameterError("origin: its coordinates must be finite");
    dense.values.assign(values.data(), values.data() + values.size());
    return levelSetOf(dense, "surface");
}

}  // namespace vdbpack
