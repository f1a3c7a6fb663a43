// Checks of a pack: no overlap, inside its wall, requested sizes.
//
// Shares no code with the packer, with densify, nor with the domains' distances: of other folders
// it includes plain values (vectors, boxes, spheres, meshes) alone.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/verify/overlap.h"
#include "vdbpack/verify/pack_hash.h"
#include "vdbpack/verify/protrusion.h"
#include "vdbpack/verify/sizes.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace vdbpack {

/// The checks of one pack together.
struct VerifyResult {
    std::uint64_t count = 0;
    RadiusStatistics radius;
    std::uint64_t hash = 0;
    OverlapCheck overlap;
    std::optional<ProtrusionCheck> protrusion;  ///< absent: no domain was given
    std::optional<double> ks;                   ///< absent: no sizes were requested
    double ksLimit = 1;                         ///< largest `ks` that passes

    bool passed() const;
};

/// The checks that need no domain and no size distribution.
/// @throws InputError as `checkOverlap`.
template <int Dim>
VerifyResult verifyPack(const Pack<Dim>& pack);

/// The same with its protrusion from the inside of a mesh, or of a shape.
/// @throws InputError as `checkOverlap` and `checkProtrusion`.
VerifyResult verifyPack(const Pack<3>& pack, const TriangleMesh& wall);
template <int Dim>
VerifyResult verifyPack(const Pack<Dim>& pack, const WallShape<Dim>& wall);

/// One check as text: a line with its verdict, then the worst pairs or spheres by id, a line each.
template <int Dim>
std::string describe(const OverlapCheck& check, const Pack<Dim>& pack);
template <int Dim>
std::string describe(const ProtrusionCheck& check, const Pack<Dim>& pack);

/// The worst pairs or spheres of a check, with ids, positions and radii.
template <int Dim>
nlohmann::ordered_json worstJson(const OverlapCheck& check, const Pack<Dim>& pack);
template <int Dim>
nlohmann::ordered_json worstJson(const ProtrusionCheck& check, const Pack<Dim>& pack);

/// Keys as in the report; `worstJson` under `worst` of each check.
template <int Dim>
nlohmann::ordered_json toJson(const VerifyResult& result, const Pack<Dim>& pack);

/// As text: one line per check, then the worst pairs and spheres by id. Ends with a newline.
template <int Dim>
std::string describe(const VerifyResult& result, const Pack<Dim>& pack);

}  // namespace vdbpack
