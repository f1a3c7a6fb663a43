// Density and cost of densified packs.
#pragma once

#include <string>
#include <vector>

/// Packs and densifies domains and prints a row for each: solid fractions before and after,
/// seconds, microseconds of processor per sphere, and the results of the checks.
/// @param words  DOMAIN[@UNIT]=FRACTION[=SPEC[=COUNT]] each, such as "box:120,120,120=0.645",
/// "hip.obj@m=0.63=uniform:1,2=349748" (radii scaled to the count) or "rect:600,600=max"; none: a
/// list of shapes. "struts:R" is a lattice of tubes of radius R, mm.
/// @param quick  the list with smaller domains.
void benchDensify(int threads, bool quick, std::vector<std::string> words);
