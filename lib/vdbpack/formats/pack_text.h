// Private: texts in pack files: units and what XML needs.
#pragma once

#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/units.h"
#include "vdbpack/formats/format_words.h"

#include <optional>
#include <string>
#include <string_view>

namespace vdbpack {

/// `text` as one line of text or attribute of an XML file.
std::string escapedXml(std::string_view text);

/// The unit in a comment such as "unit of length: mm"; `unit` is untouched in any other comment.
/// @return false if it names a unit that is not known.
bool parseUnitComment(std::string_view comment, Unit& unit);

/// Meters in one `unit`, as USD names units.
double metersPer(Unit unit);

/// A periodic cell as files note it under `kCellKey`; empty where no axis wraps.
std::string cellText(const PeriodicCell<3>& cell);
/// The cell in such a text. @param unit  of the text. @return nothing if it holds none.
std::optional<PeriodicCell<3>> parseCellText(std::string_view text, Unit unit);

/// The unit of length of LAMMPS's `units` si, cgs or micro; `unit` is untouched for the others,
/// whose lengths (angstrom, reduced) are none of ours.
void takeLammpsUnits(std::string_view style, Unit& unit);

}  // namespace vdbpack
