// Units of length in files; inside the library everything is mm.
#pragma once

#include "vdbpack/core/error.h"

#include <string>

namespace vdbpack {

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
