// The report of a run: what was asked, what was reached, how it was checked.
#pragma once

#include "vdbpack/domain/domain.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/verify.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// All fields of the JSON report; lengths in mm, 2D: area for volume, circles for spheres.
struct Report {
    int dim = 3;
    std::string version;
    std::string task;     ///< "pack", "verify" or "measure"
    std::string command;  ///< as it was given
    std::uint64_t seed = 0;
    int threads = 0;
    std::uint64_t hash = 0;  ///< `packHash`
    bool interrupted = false;

    DomainFacts domain;
    double volume = 0;  ///< of the domain, mm^dim
    double area = 0;    ///< of its wall, mm^(dim-1)

    std::uint64_t count = 0;
    std::string requested;  ///< the size distribution as it was written; empty: none
    RadiusStatistics radius;
    std::optional<double> ks;
    std::optional<double> ksByVolume;  ///< each sphere by its volume (2D: area)
    /// The same of the spheres whose centers are at most two largest radii from the wall.
    struct WallSizes {
        double depth = 0;  ///< mm
        std::uint64_t count = 0;
        double ks = 0, ksByVolume = 0;
    };
    std::optional<WallSizes> wallSizes;

    std::optional<double> solidFractionTotal;
    std::optional<double> solidFractionInterior;

    double contactTolerance = 1e-3;          ///< of the smaller radius
    std::optional<ContactNetwork> contacts;  ///< nothing without spheres

    std::uint64_t existing = 0;          ///< spheres among them that stood already, the first ones
    std::uint64_t givenOverlaps = 0;     ///< overlapping pairs among those
    std::uint64_t givenProtrusions = 0;  ///< and those that stick out

    std::optional<OverlapCheck> overlap;
    double gapAsked = 0;                ///< mm
    std::optional<double> smallestGap;  ///< between spheres, two that stood already apart; mm
    std::optional<ProtrusionCheck> protrusion;

    std::uint64_t voidCount = 0;
    std::optional<double> bvtv;
    std::uint64_t culled = 0;

    struct Seconds {
        double mesh = 0, domain = 0, pack = 0, voids = 0, measure = 0, write = 0, total = 0;
    } seconds;
    std::uint64_t peakMemoryBytes = 0;

    /// Not in the JSON: what was chosen by default, a sentence each ("radius uniform:0.3,0.6, so
    /// that about 100,000 spheres fill the domain"), and the files that were written.
    std::vector<std::string> chosen;
    std::vector<std::string> files;
};

/// Whether the spheres keep the gap asked for, to 10⁻⁶ of the smallest radius.
bool keepsGap(const Report& report);

/// The keys that scripts rely on; null where there is no value.
nlohmann::ordered_json toJson(const Report& report);

/// For people: lines of at most 80 columns (unless a word is longer), ending with a newline.
std::string summary(const Report& report);

}  // namespace vdbpack
