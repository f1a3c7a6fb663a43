// The density of spheres in the files of DEM programs.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace vdbpack {

/// Densities of spheres, kg/m³.
struct SphereDensity {
    double all = 0;  ///< 0: not given
    std::map<std::int32_t, double> ofRegions;
};
/// Density of the spheres from the text of `density`: a number in kg/m³; bulk:D, the mass of all
/// spheres by the volume of the domain (2D: with area fractions, for discs); or 0=D,1=D, by region.
/// @param solidFraction  of the spheres in the domain; nothing if there is none.
/// @throws ParameterError for anything else, or bulk:D without a solid fraction.
SphereDensity particleDensity(const std::string& text, std::optional<double> solidFraction);

/// The same without knowing the solid fraction yet. @throws ParameterError
void checkDensity(const std::string& text);

/// Warns of densities that seem to be in another unit.
/// @param part  its name, if the density is set for one part; else empty.
void warnOfDensity(const std::string& text, const std::string& part, const Callbacks& callbacks);

/// Warns of regions of a pack for which `densities` has none, unless it is empty.
void warnOfMissingDensities(const PackAttributes& pack,
                            const std::map<std::int32_t, double>& densities,
                            const Callbacks& callbacks);

}  // namespace vdbpack
