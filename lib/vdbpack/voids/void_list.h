// Voids as files: lists of ellipsoids, and patterns of cells.
#pragma once

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/units.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// Reads voids from a table with the columns x,y,z (center), a,b (half-axes: along the axis and
/// across it), theta_z,theta_x (angles of `axisOf`, rad) and ux,uy,uz (direction of the axis, of
/// any length), in any order; other columns are ignored.
///
/// Each void needs angles or a direction unless a = b (then the axis is z, 2D: x); the direction is
/// used if both are given. In 2D, z and uz may be missing; z is ignored, so a list written for
/// another slice height can be read.
///
/// @param file   columns separated by commas, semicolons, tabs or blanks; # begins a comment.
/// @param scale  mm in one unit of the file, > 0; times the unit that a comment above the names of
///               the columns states ("# unit of length: cm").
/// @return the voids in mm, in the order of the rows; empty if there are no rows. Voids that
///         `writeVoidList` wrote in mm are read back exactly.
/// @throws InputError with the line if a half-axis is not positive, a number not finite, angles and
///         direction differ by more than 1e-3 rad, or (2D) the axis leaves the plane by more than
///         that
/// @throws ParameterError, IoError
template <int Dim>
std::vector<Ellipsoid<Dim>> readVoidList(const std::string& file, double scale = 1);

/// The voids as a table for `readVoidList`, with all ten columns: lengths in `unit`, which a
/// comment states if it is not mm, angles in rad.
///
/// In 2D the columns describe the same void in space: z = `sliceHeight` (mm), theta_x = pi/2
/// and theta_z = phi + pi/2, so that `axisOf(theta_z, theta_x)` is (cos phi, sin phi, 0).
template <int Dim>
std::string voidListText(const std::vector<Ellipsoid<Dim>>& voids, Unit unit = Unit::millimeter,
                         double sliceHeight = 0);

/// Writes this table to a file. @throws IoError
template <int Dim>
void writeVoidList(const std::vector<Ellipsoid<Dim>>& voids, const std::string& file,
                   Unit unit = Unit::millimeter, double sliceHeight = 0);

/// Cells of a box that contain a void (1) or none (0).
struct VoidMatrix {
    std::array<int, 3> size{};        ///< cells along x, y and z; a single layer applies to all z
    std::vector<std::uint8_t> cells;  ///< 0 or 1; x fastest, then y, then z, each upward

    /// Whether cell `i` along +x, `j` along +y, `k` along +z contains a void; each in [0, size).
    bool at(int i, int j, int k) const {
        const auto row = static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) +
                         static_cast<std::size_t>(j);
        return cells[row * static_cast<std::size_t>(size[0]) + static_cast<std::size_t>(i)] != 0;
    }
};

/// Reads a matrix of 0 and 1 as printed on paper: columns along x, the first row at the top
/// (largest y). Digits may be separated by blanks, tabs, commas or semicolons, or by nothing; #
/// begins a comment. Blank lines separate layers, the first layer at the lowest z.
///
/// @throws InputError with the line if there are other characters, no cells, rows of different
///         lengths or layers with different numbers of rows
/// @throws IoError
VoidMatrix readVoidMatrix(const std::string& file);

}  // namespace vdbpack
