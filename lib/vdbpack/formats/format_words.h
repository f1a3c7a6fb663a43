// Private: words that the writers note in files and the readers take back.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/units.h"
#include "vdbpack/io/stated_unit.h"

#include <string_view>

namespace vdbpack {

inline constexpr const char* kGeneratorKey = "generator";
/// What the generator of a pack says of its origin (`generatorWith`), or any text with it.
PackOrigin originIn(std::string_view generator);

/// The periodic cell: axes that wrap, lower and upper corner, as "xyz 0 0 0 10 10 10".
inline constexpr const char* kCellKey = "periodic_cell";

/// The names of parts, where the format has texts: one each, or one a line. Formats with comments
/// have one a line, as "# part 0: femur".
inline constexpr const char* kPartNamesKey = "part_names";

/// What the title of our LAMMPS data files records about the numbers below.
inline constexpr const char* kLammpsIdShift = "atom = id + 1";
inline constexpr const char* kLammpsTypeIs = "type = ";        // a formula of `Materials`, "+ 1"
inline constexpr const char* kLammpsBoundary = "; boundary ";  // p or f of each axis follow
inline constexpr const char* kLammpsDensity = "; density ";    // its unit follows, or
inline constexpr const char* kLammpsGiven = "as it was given";
inline constexpr const char* kLammpsBonded = "hybrid sphere bond";

/// Of a YADE file: what its materials are (`Materials::formula`), where they are not regions.
inline constexpr std::string_view kYadeMaterials = "# matId = ";

/// Before the lengths of a cell that is periodic along all axes, as YADE's SpherePack writes them.
inline constexpr std::string_view kYadeCell = "##PERIODIC::";
/// The column of the clumps of spheres; -1 for a sphere that is in none.
inline constexpr const char* kYadeClump = "clumpId";

/// The column of .xyz files for chemical elements, and its word for spheres without one, which is
/// a symbol that ASE knows.
inline constexpr std::string_view kXyzSpecies = "species";
inline constexpr std::string_view kXyzNoSpecies = "X";

}  // namespace vdbpack
