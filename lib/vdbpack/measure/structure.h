// What `vdb_pack measure` reports of a pack's structure: profiles, g(r), regions.
#pragma once

#include "vdbpack/measure/density.h"
#include "vdbpack/measure/pair_correlation.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// A layer of a domain by depth.
struct RegionFraction {
    std::string name;          ///< "cortical" (the shell), "trabecular" (what it encloses)
    double volume = 0;         ///< mm³ (2D: mm²)
    double solidFraction = 0;  ///< covered by spheres
    std::uint64_t count = 0;   ///< spheres centered in it
    double meanRadius = 0;     ///< theirs, mm; 0: there are none
};

struct Structure {
    std::optional<DensityProfile> profile;
    std::optional<LocalFraction> local;
    std::optional<PairCorrelation> pairCorrelation;
    std::optional<double> crystalline;  ///< as `solidLikeShare`
    int dim = 3;
    double meanDiameter = 0;  ///< mm
    double shell = 0;         ///< thickness of the shell that separates the regions, mm; 0: none
    std::vector<RegionFraction> regions;
};

/// Under `profile`, `localFraction`, `pairCorrelation`, `crystalline` and `regions`; null where
/// there is none.
void addTo(nlohmann::ordered_json& report, const Structure& structure);

/// As text: lines of at most 80 columns with labels, ending with a newline.
std::string summary(const Structure& structure);

}  // namespace vdbpack
