// Checks of a pack: no overlap, inside its wall, requested sizes.
//
// Shares no code with the packer, with densify, nor with the domains' distances: of other folders
// it includes plain values (vectors, boxes, spheres, meshes) alone.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/verify/overlap.h"
#include "vdbpack/verify/protrusion.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

struct RadiusStatistics {
    double min = 0, mean = 0, max = 0, sd = 0;  ///< mm; all 0 for an empty pack
};

template <int Dim>
RadiusStatistics radiusStatistics(const std::vector<Sphere<Dim>>& spheres);

/// Kolmogorov-Smirnov distance between radii and a distribution: the largest difference between
/// the share of radii <= r and F(r), over all r.
///
/// @param radii      any order, ascending ones cost no sorting; 0 is returned if there are none.
/// @param cdf        F(r) = P(radius <= r); called from many threads.
/// @param cdfBefore  F(r-) = P(radius < r), where the distribution has atoms; empty: like `cdf`.
/// Radii are taken as known to 1e-6 of their value, so that a radius of a discrete distribution is
/// recognized after a trip through a file of 32-bit floats.
/// @param weightPower  each radius counts r^weightPower: 0 by number, 3 (2D: 2) by volume.
double ksDistance(std::vector<double> radii, const std::function<double(double)>& cdf,
                  const std::function<double(double)>& cdfBefore = {}, int weightPower = 0);

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

/// A checksum of the spheres that does not depend on their order: the sum modulo 2^64 over all
/// spheres of a mix of the bits of x, y, z, r (double, mm; -0 counts as 0; 2D: z is `sliceHeight`).
///
/// For one sphere: h = 0x9e3779b97f4a7c15; for each v of x, y, z, r: h = mix(h ^ bits(v)); with
/// mix(h): h ^= h >> 30, h *= 0xbf58476d1ce4e5b9, h ^= h >> 27, h *= 0x94d049bb133111eb,
/// h ^= h >> 31, all modulo 2^64. (mix is the finalizer of SplitMix64.)
template <int Dim>
std::uint64_t packHash(const Pack<Dim>& pack);

/// 16 hexadecimal digits, as reports show a hash.
std::string hashText(std::uint64_t hash);

}  // namespace vdbpack
