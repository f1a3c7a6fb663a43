// Tables of materials.
#pragma once

#include "vdbpack/formats/pack_file.h"

#include <string>

namespace vdbpack {

/// Writes the materials of a pack as .csv, a row for each number up to the last that occurs:
/// `material` (from 0, as in YADE files; LAMMPS types are one more), `part`, `region` and
/// `density_class` (0 where the pack has no such column), `spheres` (their number),
/// `density_kg_m3` (the mean by volume, empty where the unit of a given density is unknown) and, if
/// the pack has a column of it, `modulus_MPa` (likewise the mean), and `part_name` where parts have
/// names. Whole or absent. @throws ParameterError, IoError
template <int Dim>
void writeMaterials(const Pack<Dim>& pack, const std::string& file,
                    const PackWriteOptions& options);

}  // namespace vdbpack
