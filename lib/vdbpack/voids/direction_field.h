// Directions that vary from place to place, such as those of principal stresses.
#pragma once

#include "vdbpack/core/box.h"

#include <memory>
#include <string>

namespace vdbpack {

/// A field of directions without sign: u and -u are the same.
class DirectionField {
public:
    virtual ~DirectionField() = default;
    /// The box that the field covers, mm; infinite along z if it is one of the plane.
    virtual Box<3> bounds() const = 0;
    /// The direction at `x` (mm), of length one, its sign of no meaning. Where there is nothing,
    /// that of places nearby. Thread-safe.
    virtual Vec<3> at(const Vec<3>& x) const = 0;
};

/// Reads a field from a .vdb file or a table (.csv, .tsv, .txt).
///
/// The values are either directions, whose length and sign mean nothing, or symmetric tensors
/// (stress, fabric), whose direction is the eigenvector to the eigenvalue of largest magnitude: at
/// equal magnitude, tension before compression. Between the places given, directions u are
/// interpolated as u⊗u, tensors by their components; the main axis of the result is the direction.
///
/// Tables have named columns in any order, separated by commas, semicolons, tabs or blanks: x,y,z
/// and either ux,uy,uz (or dx,dy,dz or vx,vy,vz) or sxx,syy,szz,sxy,syz,sxz (or s11 ..., S.S11 ...
/// as Abaqus writes, sx ..., sigma_xx ..., stress_xx ...). Points may lie anywhere; those given
/// more than once, as at nodes that elements share, count once with their mean. Rows without any
/// stress tell no direction and are passed over. A plane is fitted to the 12 nearest points, which
/// are weighted by (1/d - 1/d_12)², d = distance (Franke, Nielson (1980), 10.1002/nme.1620151110;
/// they fit quadrics), so that a field that is linear is met. A table without z is a field of the
/// plane, the same at any height; uz, szz, syz and sxz may then be missing and count as 0. The
/// field covers the box around the points, grown on each side by a tenth of its length or a
/// hundredth of the longest.
///
/// .vdb files hold one field (of float or double), as
/// - a grid of vectors: directions,
/// - two grids of vectors NAME_diagonal (xx, yy, zz) and NAME_offdiagonal (xy, yz, xz), or
/// - six scalar grids whose names end in xx, yy, zz, xy, yz, xz (stress.xx ..., sxx ...): tensors;
///   OpenVDB registers no type of grid for these.
/// Components are those along the axes of space: the grid's transform, of any linear kind, places
/// the voxels but does not turn the values. Inactive and zero voxels tell nothing; of the eight
/// around a place the others are weighted trilinearly. The field covers the box around the voxels
/// that tell something, grown by a voxel.
///
/// @param scale  mm in one unit of the file, > 0.
/// @throws InputError naming line or voxel if a value is not finite or a direction in a table zero,
///         or if columns or grids are missing or there is no direction at all
/// @throws ParameterError for other kinds of files, IoError, ResourceError
///
/// Cost: a million points in a table are read in about a second; a query takes microseconds.
std::shared_ptr<const DirectionField> readDirectionField(const std::string& file, double scale = 1);

}  // namespace vdbpack
