// A recipe in, a result out: the order of a whole run, in one place.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/measure/report.h"
#include "vdbpack/measure/verify.h"
#include "vdbpack/recipe.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace vdbpack {

/// What a search for empty places found.
struct PlacesLeft {
    double largest = 0;         ///< largest clearance of a sample point to wall and spheres, mm
    double radius = 0;          ///< 1.02 mean radii, mm
    std::uint64_t count = 0;    ///< sample points with a clearance of `radius` or more
    std::uint64_t samples = 0;  ///< points asked for, spread over the domain
};

struct RunResult {
    Report report;
    std::optional<PlacesLeft> places;  ///< if asked for
    std::variant<Pack<3>, Pack<2>> pack;
    bool passed = false;  ///< the checks found no overlap and no protrusion
};

/// The report as JSON; where a check failed, the spheres at fault under `worst`.
nlohmann::ordered_json toJson(const RunResult& run);
/// For people: what failed and which spheres are at fault, a line each; empty if all passed.
std::string failures(const RunResult& run);

/// Domain, pack, measure, check, write: the whole of `vdb_pack pack`.
///
/// Outputs are checked before the work and written whole or not at all; a pack that fails its own
/// check is written all the same (nothing is lost) and `passed` is false.
/// @throws ParameterError, InputError, IoError, ResourceError
RunResult runPack(const PackRecipe& recipe, const Callbacks& callbacks = {});

struct VerifyRecipe {
    std::string pack;  ///< file, any format that readPack knows
    Unit packUnit = Unit::millimeter;
    std::string packGrid;  ///< point grid in a .vdb; empty: the first
    DomainRecipe domain;   ///< `source` empty: overlaps and sizes only
    std::string radius;    ///< SPEC to hold the radii against; empty: none
    WeightBy weightBy = WeightBy::count;
    double gap = 0;  ///< least distance that the spheres must keep from one another, mm
    double contactTolerance = 1e-3;
    std::uint64_t placeSamples = 0;  ///< points at which to look for places left; 0: none
    int threads = 0;
};

/// Checks any pack with code that the packer has no part in: the whole of `vdb_pack verify`.
RunResult runVerify(const VerifyRecipe& recipe, const Callbacks& callbacks = {});

}  // namespace vdbpack
