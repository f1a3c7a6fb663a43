// Directions that vary in space, such as those of principal stresses.
#pragma once

#include "vdbpack/core/box.h"

#include <memory>
#include <string>

namespace vdbpack {

/// A field of directions without sign: u and -u are the same.
class DirectionField {
public:
    virtual ~DirectionField() = default;
    /// The box that the field covers, mm; infinite along z for a field of the plane.
    virtual Box<3> bounds() const = 0;
    /// The unit direction at `x` (mm); its sign has no meaning. Beyond the data, the direction of
    /// the nearest data. Thread-safe.
    virtual Vec<3> at(const Vec<3>& x) const = 0;
};

/// Reads a field from a .vdb file or a table (.csv, .tsv, .txt).
///
/// The values are either directions, whose length and sign have no meaning, or symmetric tensors
/// (stress, fabric), whose direction is the eigenvector of the eigenvalue of largest magnitude
/// (tension before compression at equal magnitude). Between the given points, directions u are
/// interpolated as u⊗u, tensors by component; the main axis of the result is the direction.
///
/// Tables have named columns in any order, separated by commas, semicolons, tabs or blanks: x,y,z
/// and either ux,uy,uz (or dx,dy,dz or vx,vy,vz) or sxx,syy,szz,sxy,syz,sxz (or s11 ..., S.S11 ...
/// as Abaqus writes, sx ..., sigma_xx ..., stress_xx ...). Points may lie anywhere; several values
/// at one point, as at nodes shared by elements, are averaged. Rows of zero stress have no
/// direction and are ignored. A plane is fitted to the 12 nearest points, weighted by (1/d -
/// 1/d_12)², d = distance (Franke, Nielson (1980), 10.1002/nme.1620151110, who fit quadrics), so
/// that linear fields are reproduced. A table without z is a field of the plane, the same at any
/// height; uz, szz, syz and sxz may then be missing and are 0. The field covers the box around the
/// points, grown on each side by a tenth of its length or a hundredth of its longest side,
/// whichever is larger.
///
/// .vdb files hold one field (of float or double), as
/// - a grid of vectors: directions,
/// - two grids of vectors NAME_diagonal (xx, yy, zz) and NAME_offdiagonal (xy, yz, xz), or
/// - six scalar grids whose names end in xx, yy, zz, xy, yz, xz (stress.xx ..., sxx ...): tensors;
///   OpenVDB registers no type of grid for these.
/// Components are along the axes of space: the grid's transform, any linear one, positions the
/// voxels but does not rotate the values. Inactive and zero voxels are ignored; the others of the
/// eight voxels around a point are weighted trilinearly. The field covers the box around the voxels
/// that are used, grown by one voxel.
///
/// @param scale  mm in one unit of the file, > 0.
/// @throws InputError with the line or voxel if a value is not finite or a direction in a table is
///         zero, or if columns, grids or all directions are missing
/// @throws ParameterError for files of other types, IoError, ResourceError
///
/// Cost: a million points in a table are read in about a second; a query takes microseconds.
std::shared_ptr<const DirectionField> readDirectionField(const std::string& file, double scale = 1);

}  // namespace vdbpack
