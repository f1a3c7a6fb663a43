// Lists of ellipsoidal voids as tables.
#pragma once

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/units.h"

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
/// @param scale  mm in one unit of the file, > 0.
/// @return the voids in mm, in the order of the rows; empty if there are no rows. Voids that
///         `writeVoidList` wrote in mm are read back exactly.
/// @throws InputError with the line if a half-axis is not positive, a number not finite, angles and
///         direction differ by more than 1e-3 rad, or (2D) the axis leaves the plane by more than
///         that
/// @throws ParameterError, IoError
template <int Dim>
std::vector<Ellipsoid<Dim>> readVoidList(const std::string& file, double scale = 1);

/// The voids as a table for `readVoidList`, with all ten columns: lengths in `unit`, angles in rad.
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

}  // namespace vdbpack
