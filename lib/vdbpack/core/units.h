// Units of length and axes in files; inside the library everything is mm.
#pragma once

#include "vdbpack/core/error.h"

#include <string>

namespace vdbpack {

/// The axes of the world that images are placed in: x to the left and y to the back of the patient
/// as in DICOM, or x to the right and y to the front as in NIfTI.
enum class ImageSpace { lps, ras };

enum class Unit { meter, centimeter, millimeter, micrometer };

/// Millimeters in one `unit`.
inline double millimetersPer(Unit unit) {
    switch (unit) {
        case Unit::meter:
            return 1000.0;
        case Unit::centimeter:
            return 10.0;
        case Unit::millimeter:
            return 1.0;
        case Unit::micrometer:
            return 0.001;
    }
    return 1.0;
}

/// The best double for `mm` in `unit`: divided by a whole number rather than multiplied by its
/// inexact inverse.
inline double fromMillimeters(double mm, Unit unit) {
    return unit == Unit::micrometer ? mm * 1000.0 : mm / millimetersPer(unit);
}
/// The mm that `fromMillimeters` makes `value` of. Where neighboring doubles do, the one with the
/// fewest binary digits: centers and radii of packs have few, and come back from files unchanged.
double toMillimeters(double value, Unit unit);

/// Beginning of the comment that names the unit in .stl, .ply and YADE files.
inline constexpr const char* kUnitComment = "unit of length: ";

/// "m", "cm", "mm" or "um".
inline const char* unitName(Unit unit) {
    switch (unit) {
        case Unit::meter:
            return "m";
        case Unit::centimeter:
            return "cm";
        case Unit::millimeter:
            return "mm";
        case Unit::micrometer:
            return "um";
    }
    return "mm";
}

/// The unit named `name` as `unitName` writes it.
/// @throws ParameterError for any other name.
inline Unit parseUnit(const std::string& name) {
    if (name == "m") return Unit::meter;
    if (name == "cm") return Unit::centimeter;
    if (name == "mm") return Unit::millimeter;
    if (name == "um") return Unit::micrometer;
    throw ParameterError("unit '" + name + "' is not known; use m, cm, mm or um");
}

}  // namespace vdbpack
