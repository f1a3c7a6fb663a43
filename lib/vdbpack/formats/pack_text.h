// Private: texts in pack files: units and what XML needs.
#pragma once

#include "vdbpack/core/units.h"
#include "vdbpack/formats/format_words.h"

#include <string>
#include <string_view>

namespace vdbpack {

/// `text` as one line of text or attribute of an XML file.
std::string escapedXml(std::string_view text);

/// The unit in a comment such as "unit of length: mm"; `unit` is untouched in any other comment.
/// @return false if it names a unit that is not known.
bool parseUnitComment(std::string_view comment, Unit& unit);

/// The unit of length of LAMMPS's `units` si, cgs or micro; `unit` is untouched for the others,
/// whose lengths (angstrom, reduced) are none of ours.
void takeLammpsUnits(std::string_view style, Unit& unit);

}  // namespace vdbpack
