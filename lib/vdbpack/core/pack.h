// A set of spheres with what is known about each of them.
#pragma once

#include "vdbpack/core/sphere.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// A further column of a pack file (material, clump, ...), kept and written again.
/// Numbers are in `numbers`; a column with any cell that is not a number is in `texts`.
struct Column {
    std::string name;
    std::vector<double> numbers;     ///< one a sphere, or empty
    std::vector<std::string> texts;  ///< one a sphere, or empty
};

/// Spheres (2D: circles) in mm, as arrays of equal length.
///
/// Every attribute is either empty or has one value a sphere, in the order of `spheres`.
template <int Dim>
struct Pack {
    std::vector<Sphere<Dim>> spheres;
    std::vector<std::int64_t> id;        ///< name of the sphere in files; empty: its index
    std::vector<std::int32_t> region;    ///< 0 cortical, 1 trabecular
    std::vector<std::int64_t> order;     ///< when the sphere was placed, counted from 0
    std::vector<float> depth;            ///< distance of the center to the wall, mm
    std::vector<std::int32_t> contacts;  ///< touching spheres and walls
    std::vector<Column> columns;         ///< whatever else the file held
    double sliceHeight = 0;              ///< 2D: the z written for every circle, mm
};

}  // namespace vdbpack
