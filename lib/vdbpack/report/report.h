// The report of a run: the request, the result, and its verification.
#pragma once

#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/units.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/mass_offset.h"
#include "vdbpack/verify/verify.h"
#include "vdbpack/voids/void_report.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// What a run found for an option that was given as a word.
struct FoundValue {
    std::string option;  ///< long name: "threshold"
    std::string word;    ///< that it was given: "otsu"
    std::string value;   ///< a number, or several with commas, which give the same result
    std::string part{};  ///< of several parts, its name; empty: there is one
};
using FoundValues = std::vector<FoundValue>;

/// One of the domains of a pack of several parts.
struct PartReport {
    std::string name;
    std::string source;           ///< file or shape
    std::string requested;        ///< the size distribution
    std::uint64_t count = 0;      ///< spheres
    double volume = 0, area = 0;  ///< of the domain, mm³ and mm²
    double solidFraction = 0;
    std::optional<double> interior;  ///< deeper than three largest radii
    std::optional<double> bvtv;      ///< if voids were cut
    std::optional<double> ks{};      ///< distance of its sizes from those requested
    double protrusion = 0;           ///< largest, of its own wall, in radii
    double density = 0;              ///< of its spheres, kg/m³; 0: none is given, or one by region
    std::map<std::int32_t, double> densities{};  ///< by region, kg/m³; empty: one, or none
};

/// What the spheres of a part are made of: least, middle and largest of their own values.
struct MaterialReport {
    std::string part;                                ///< empty: a pack without parts
    std::optional<std::array<double, 3>> density{};  ///< kg/m³
    std::optional<std::array<double, 3>> modulus{};  ///< Young's modulus, MPa
};

/// All fields of the JSON report; lengths in mm, 2D: area for volume, circles for spheres.
struct Report {
    int dim = 3;
    std::string version;
    std::string task;     ///< the name of the command: "pack", "voids", "verify", ...
    std::string command;  ///< as it was given
    std::string axes;     ///< of the world of images: "LPS" or "RAS"; empty: unknown
    std::uint64_t seed = 0;
    /// That the recipe states whose run was repeated, if the result has another one.
    std::optional<std::uint64_t> repeatedHash;
    /// Names and values of the options in which the runs of a study differ.
    std::vector<std::pair<std::string, std::string>> varied;
    int threads = 0;                    ///< of each process
    int ranks = 1;                      ///< processes that shared the work
    std::uint64_t hash = 0;             ///< `packHash`, of lengths in mm
    Unit filesUnit = Unit::millimeter;  ///< of the lengths in the files that are written
    bool interrupted = false;

    FoundValues found;  ///< for options that were given as words
    DomainFacts domain;
    double volume = 0;  ///< of the domain, mm^dim
    double area = 0;    ///< of its wall, mm^(dim-1)

    std::uint64_t count = 0;
    std::string requested;  ///< the requested size distribution; empty: none
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

    /// Where sizes were requested by place: each group of them, held against the local factors.
    struct LocalGroup {
        std::string name;       ///< "all", or "shell" and "inside"
        std::string requested;  ///< the size distribution where the factor is 1
        std::uint64_t count = 0;
        double factorLeast = 1, factorMost = 1;  ///< at the centers of the spheres
        double ks = 0, ksByVolume = 0;           ///< of radii divided by the local factor
    };
    std::vector<LocalGroup> localSizes;

    std::optional<double> solidFractionTotal;
    std::optional<double> solidFractionInterior;
    std::optional<MassOffset> massOffset;  ///< nothing where the pack fills a part of the domain

    double contactTolerance = 1e-3;          ///< of the smaller radius
    std::optional<ContactNetwork> contacts;  ///< nothing without spheres

    std::uint64_t existing = 0;          ///< number of spheres that existed before, the first ones
    std::uint64_t inputOverlaps = 0;     ///< overlapping pairs of the input pack
    std::uint64_t inputProtrusions = 0;  ///< protruding spheres of the input pack

    std::optional<OverlapCheck> overlap;
    double requestedGap = 0;            ///< mm
    std::optional<double> smallestGap;  ///< between spheres, without pairs that existed before; mm
    std::optional<ProtrusionCheck> protrusion;

    /// The result of densifying; nothing if it was not requested.
    struct Densified {
        /// Gaps up to which contacts are counted, in smaller radii.
        static constexpr std::array<double, 3> kContactTolerances{1e-3, 1e-2, 5e-2};

        std::optional<double> requested;  ///< solid fraction; nothing: as dense as possible
        bool random = false;              ///< from random points, not from a front
        double before = 0, after = 0;
        std::uint64_t inserted = 0, steps = 0;
        int stages = 0;
        std::array<double, 3> contactsBefore{};  ///< coordination numbers without walls
        /// Nothing once interrupted.
        std::optional<std::array<double, 3>> contactsAfter;
        std::optional<double> solidLike;  ///< `solidLikeShare` afterwards
        double seconds = 0;
    };
    std::optional<Densified> densified;
    DeviceUse device;  ///< that moved spheres

    std::vector<PartReport> parts;           ///< empty: the pack has one domain
    std::uint64_t contactsBetweenParts = 0;  ///< pairs
    std::vector<InterfaceReport> interfaces;
    std::vector<MaterialReport> materials;  ///< where spheres have densities or moduli of their own

    std::optional<VoidReport> voids;  ///< nothing if neither voids nor a shell were requested

    struct Seconds {
        double mesh = 0, domain = 0, pack = 0, settle = 0, densify = 0, voids = 0, measure = 0,
               write = 0, total = 0;
        std::vector<std::pair<const char*, double>> stages() const {
            return {{"mesh", mesh},       {"domain", domain},   {"pack", pack},
                    {"settle", settle},   {"densify", densify}, {"voids", voids},
                    {"measure", measure}, {"write", write}};
        }
    } seconds;
    std::uint64_t peakMemoryBytes = 0;

    std::vector<std::string> warnings;

    /// Not in the JSON: the choices by default, a sentence each ("radius uniform:0.3,0.6, so
    /// that about 100,000 spheres fill the domain"), the written files, and how to repeat the run.
    std::vector<std::string> chosen;
    std::vector<std::string> files;
    std::string recipe;  ///< TOML that repeats the run; empty: none
};

/// A picture, and a view that takes its place where the browser can draw it.
struct PagePicture {
    std::string png;            ///< bytes of a file; empty: none
    int width = 0, height = 0;  ///< pixels
    std::string words;          ///< what it shows
    std::string viewStyle;      ///< for the head of the page, and
    std::string view;           ///< for the figure; empty: none
};

/// The checks that a pack does not pass. Overlaps and protrusions of the input pack do not count.
struct FailedChecks {
    bool overlap = false, protrusion = false;
    bool gap = false;  ///< smaller than requested by more than 10⁻⁶ of the smallest radius

    bool any() const { return overlap || protrusion || gap; }
};
FailedChecks failedChecks(const Report& report);

/// The keys that scripts rely on; null where there is no value.
nlohmann::ordered_json toJson(const Report& report);

/// 1234567 as "1,234,567".
std::string grouped(std::uint64_t n);

/// The summary: lines of at most 80 columns (unless a word is longer), ending with a newline.
std::string summary(const Report& report);

}  // namespace vdbpack
