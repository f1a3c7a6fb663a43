// Private: texts in pack files: units and what XML needs.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/core/units.h"
#include "vdbpack/formats/format_words.h"
#include "vdbpack/io/input_file.h"

#include <initializer_list>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// `text` as one line of text or attribute of an XML file.
std::string escapedXml(std::string_view text);

/// The unit that a file calls `name`.
/// @param where  the file, and the line where it has lines. @throws InputError for another name.
Unit unitNamed(std::string_view name, const std::string& where);

/// The unit in a comment such as "unit of length: mm"; `unit` for any other comment.
/// @throws InputError as `unitNamed`.
Unit unitIn(std::string_view comment, Unit unit, const InputFile& file);

/// A periodic cell as files note it under `kCellKey`; empty where no axis wraps.
std::string cellText(const PeriodicCell<3>& cell);
/// The cell in such a text. @param unit  of the text. @throws InputError if it holds none.
PeriodicCell<3> cellIn(std::string_view text, Unit unit, const std::string& where);

/// The names of the parts of a pack, a line each.
std::string partLines(const PackAttributes& pack);
/// The same as comments, "# part 0: femur".
std::string partComments(const PackAttributes& pack);
/// Takes the next name from such a comment. @return whether it is one
bool takePartComment(std::string_view line, std::vector<std::string>& names);

/// The box of particles that a file of a simulation states.
struct StatedBox {
    PeriodicCell<3> cell;   ///< mm
    bool hasFlags = false;  ///< the file says which faces are periodic
    bool isTilted = false;
};
/// Gives the pack that cell, whose walls are moved out to whole spheres; warns where it cannot.
void takeCell(Pack<3>& pack, const StatedBox& box, const std::string& file,
              const Callbacks& callbacks);

/// Makes names different from each other and from names that are taken, by a number at the end.
class UniqueNames {
public:
    explicit UniqueNames(std::initializer_list<std::string> taken = {}) : taken_(taken) {}
    std::string operator()(const std::string& name);

private:
    std::set<std::string> taken_;  ///< in small letters
};

/// `name` with '_' for all but letters of ASCII, digits and '_'.
std::string identifierOf(std::string_view name);

/// The unit of length of LAMMPS's `units` si, cgs or micro; `unit` is untouched for the others,
/// whose lengths (angstrom, reduced) are none of ours.
/// @return whether it is one of these.
bool takeLammpsUnits(std::string_view style, Unit& unit);

/// The unit of density that goes with a unit of length in files of LAMMPS: how many kg/m³ make one,
/// a whole number, so that the best double results as for lengths; and its name.
struct DensityUnit {
    double size;
    const char* name;
};
DensityUnit densityUnit(Unit unit);
/// Makes the column `density` of a file in that unit one of kg/m³ under `kDensityColumn`.
void convertDensity(Pack<3>& pack, Unit unit);

}  // namespace vdbpack
