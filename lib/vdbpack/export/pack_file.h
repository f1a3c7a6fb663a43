// Pack files: written and read by the extension of their name.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/units.h"

#include <memory>
#include <string>
#include <variant>

namespace vdbpack {

class VdbGrid;

/// Length of an edge of the point grid's voxels in a .vdb file, mm times `scale`: a power of two,
/// about 8 points a voxel. Positions that are whole multiples of 2^-25 of it survive the file's
/// 32-bit offsets unchanged.
/// @param count, measure  spheres, and volume (2D: area) that they fill, mm^Dim.
double pointVoxelSize(double count, double measure, int dim);

struct PackWriteOptions {
    Unit unit = Unit::millimeter;  ///< of what is written
    std::string generator;         ///< program and version, recorded where the format can
    /// Written beside the points as `surface` in a .vdb; may be null.
    std::shared_ptr<const VdbGrid> surface;
    /// Voxel edge of the point grid, mm; 0: from the pack's bounds.
    double pointVoxel = 0;
};

/// Writes a pack; the format by prefix ("yade:f.txt") or extension: .vdb .vtp .ply .csv.
/// Whole or absent. @throws ParameterError (unknown format), IoError
template <int Dim>
void writePack(const Pack<Dim>& pack, const std::string& file, const PackWriteOptions& options);

/// Whether `file` names a format that `writePack` knows. @throws ParameterError if not,
/// with the list of formats: ask before hours of work.
void checkPackFormat(const std::string& file);

struct PackReadOptions {
    Unit unit = Unit::millimeter;  ///< of the file, unless the file records its own
    std::string gridName;          ///< .vdb: the point grid; empty: the first one
};

/// Reads a pack in mm. @throws IoError, InputError (with line or offset)
Pack<3> readPack(const std::string& file, const PackReadOptions& options = {});

/// The same spheres as circles, where all lie at one height. @throws InputError otherwise.
Pack<2> asCircles(const Pack<3>& pack);

}  // namespace vdbpack
