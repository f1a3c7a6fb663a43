// Lists of ellipsoidal voids as tables.
#pragma once

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/units.h"

#include <string>
#include <vector>

namespace vdbpack {

/// Reads voids from a table with the columns x,y,z (center), a,b (half-axes: along the axis and
/// across it), theta_z,theta_x (angles of `axisOf`, rad) and ux,uy,uz (direction of the axis, of
/// any length), in any order; further columns are passed over.
///
/// Angles or direction may be missing, both where a = b (then the axis is z, 2D: x); where both are
/// given the direction counts, its sign aside. In 2D, z and uz may be missing: z is not looked at,
/// so a list for another height is cut at this one's.
///
/// @param file   separated by commas, semicolons, tabs or blanks; # begins a comment.
/// @param scale  mm in one unit of the file, > 0.
/// @return the voids in mm, in order; none if there are no rows. What `writeVoidList` wrote in mm
///         comes back exactly.
/// @throws InputError naming the line if a half-axis is not positive, a number not finite, angles
///         and direction differ by more than 1e-3 rad, or (2D) the axis leaves the plane by as much
/// @throws ParameterError, IoError
template <int Dim>
std::vector<Ellipsoid<Dim>> readVoidList(const std::string& file, double scale = 1);

/// The table that `readVoidList` reads, with all ten columns: lengths in `unit`, angles in rad.
///
/// In 2D the columns are those of the same void in space: z = `sliceHeight` (mm), theta_x = pi/2
/// and theta_z = phi + pi/2, so that `axisOf(theta_z, theta_x)` is (cos phi, sin phi, 0).
template <int Dim>
std::string voidListText(const std::vector<Ellipsoid<Dim>>& voids, Unit unit = Unit::millimeter,
                         double sliceHeight = 0);

/// Writes that table. @throws IoError
template <int Dim>
void writeVoidList(const std::vector<Ellipsoid<Dim>>& voids, const std::string& file,
                   Unit unit = Unit::millimeter, double sliceHeight = 0);

extern template std::vector<Ellipsoid<2>> readVoidList<2>(const std::string&, double);
extern template std::vector<Ellipsoid<3>> readVoidList<3>(const std::string&, double);
extern template std::string voidListText<2>(const std::vector<Ellipsoid<2>>&, Unit, double);
extern template std::string voidListText<3>(const std::vector<Ellipsoid<3>>&, Unit, double);
extern template void writeVoidList<2>(const std::vector<Ellipsoid<2>>&, const std::string&, Unit,
                                      double);
extern template void writeVoidList<3>(const std::vector<Ellipsoid<3>>&, const std::string&, Unit,
                                      double);

}  // namespace vdbpack
