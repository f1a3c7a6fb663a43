// What a pack can be proven to be: free of overlap, inside its wall, of the sizes asked for.
//
// Shares no code with the packer, nor with the domains' exact distances.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// Overlaps and protrusions above this share of a radius are counted.
inline constexpr double kVerifyTolerance = 1e-6;
/// How many of the worst pairs and spheres are named.
inline constexpr std::size_t kWorstNamed = 10;

struct OverlapPair {
    std::size_t i = 0, j = 0;  ///< indices into the pack, i < j
    double overlap = 0;        ///< share of the smaller radius
};

struct OverlapCheck {
    double max = 0;           ///< largest (r_i + r_j - distance) / min(r_i, r_j); 0 without overlap
    std::uint64_t pairs = 0;  ///< pairs above `kVerifyTolerance`
    bool complete = true;     ///< false: hopeless pack, counting stopped, `pairs` is a lower bound
    std::vector<OverlapPair> worst;  ///< up to `kWorstNamed` of them, by falling overlap
};

/// All overlaps of a pack, by one pass over a list of cells in double; any mix of sizes.
///
/// Cost: about 0.2 microseconds a sphere on two threads. Counting stops at 200 pairs a sphere.
/// @throws InputError naming a sphere whose position or radius is not a usable number.
template <int Dim>
OverlapCheck checkOverlap(const std::vector<Sphere<Dim>>& spheres);

struct ProtrudingSphere {
    std::size_t i = 0;      ///< index into the pack
    double protrusion = 0;  ///< share of its radius; above 1: the center is outside
};

struct ProtrusionCheck {
    double max = 0;                    ///< largest (r - inner distance to the wall) / r; 0 without
    std::uint64_t spheres = 0;         ///< spheres above `kVerifyTolerance`
    std::uint64_t centersOutside = 0;  ///< of those
    bool closed = true;  ///< false: the wall has open edges, so that the side was put to the vote
    std::vector<ProtrudingSphere> worst;  ///< up to `kWorstNamed` of them, by falling protrusion
};

/// Protrusion through the triangles of a mesh, cut by `clips`.
///
/// The inner distance is exact, and negative for a center outside. A center is inside if a line
/// from it crosses the mesh an odd number of times: nested shells bound cavities, whichever way
/// they face. With edges that join an odd number of triangles, six lines along the axes vote.
/// @param mesh  in the pack's coordinates, mm; need not be welded.
/// @throws InputError for an empty mesh or one with unusable vertices or indices, or as
/// `checkOverlap`.
///
/// Cost: about 2 microseconds a sphere and 1 a triangle on two threads.
ProtrusionCheck checkProtrusion(const std::vector<Sphere<3>>& spheres, const TriangleMesh& mesh,
                                const std::vector<HalfSpace<3>>& clips = {});

/// A straight piece of a planar wall, mm.
struct WallSegment {
    Vec<2> a, b;
};

/// The same in the plane; the segments' directions and order do not matter.
ProtrusionCheck checkProtrusion(const std::vector<Sphere<2>>& circles,
                                const std::vector<WallSegment>& wall,
                                const std::vector<HalfSpace<2>>& clips = {});

/// Where the plane z = `height` cuts a mesh: closed curves if the mesh is closed. Triangles that
/// lie in the plane count as below it. @throws InputError for indices out of range.
std::vector<WallSegment> sliceSegments(const TriangleMesh& mesh, double height);

/// A wall given by numbers; kept apart from `Domain`, which it checks.
template <int Dim>
struct Shape {
    enum class Kind { box, ball, cylinder };

    Kind kind = Kind::box;
    Box<Dim> box;                       ///< kind box
    Vec<Dim> center;                    ///< kind ball, cylinder; mm
    double radius = 0;                  ///< kind ball, cylinder; mm
    double height = 0;                  ///< kind cylinder (3D, about z through `center`); mm
    std::vector<HalfSpace<Dim>> clips;  ///< further cuts

    static Shape ofBox(const Box<Dim>& box);
    static Shape ofBall(double radius, const Vec<Dim>& center = {});
    static Shape ofCylinder(double radius, double height, const Vec<Dim>& center = {});

    /// Distance to the nearest wall for a point inside, mm; negative outside (there exact for a
    /// box, a ball and a cylinder, and at most the true distance in size once clipped).
    double innerDistance(const Vec<Dim>& x) const;
};

/// The plane z = `height` of a shape; nothing if the plane misses it.
std::optional<Shape<2>> sliceShape(const Shape<3>& shape, double height);

/// Protrusion through the wall of a shape.
/// @throws ParameterError for a clip whose normal is zero or not finite, or as `checkOverlap`.
template <int Dim>
ProtrusionCheck checkProtrusion(const std::vector<Sphere<Dim>>& spheres, const Shape<Dim>& shape);

struct RadiusStatistics {
    double min = 0, mean = 0, max = 0, sd = 0;  ///< mm; all 0 for an empty pack
};

template <int Dim>
RadiusStatistics radiusStatistics(const std::vector<Sphere<Dim>>& spheres);

/// Kolmogorov-Smirnov distance between radii and a distribution: the largest difference between
/// the share of radii <= r and F(r), over all r.
///
/// @param radii      any order, ties welcome; 0 is returned if there are none.
/// @param cdf        F(r) = P(radius <= r); called from many threads.
/// @param cdfBefore  F(r-) = P(radius < r), where the distribution has atoms; empty: like `cdf`.
/// Radii are taken as known to 1e-6 of their value, so that a radius of a discrete distribution is
/// recognized after a trip through a file of 32-bit floats.
/// @param weightPower  each radius counts r^weightPower: 0 by number, 3 (2D: 2) by volume.
double ksDistance(std::vector<double> radii, const std::function<double(double)>& cdf,
                  const std::function<double(double)>& cdfBefore = {}, int weightPower = 0);

/// A checksum of the spheres that does not depend on their order: the sum modulo 2^64 over all
/// spheres of a mix of the bits of x, y, z, r (double, mm; -0 counts as 0; 2D: z is `sliceHeight`).
///
/// For one sphere: h = 0x9e3779b97f4a7c15; for each v of x, y, z, r: h = mix(h ^ bits(v)); with
/// mix(h): h ^= h >> 30, h *= 0xbf58476d1ce4e5b9, h ^= h >> 27, h *= 0x94d049bb133111eb,
/// h ^= h >> 31, all modulo 2^64. (mix is SplitMix64's finalizer, see rng.h.)
template <int Dim>
std::uint64_t packHash(const Pack<Dim>& pack);

/// 16 hexadecimal digits, as reports show a hash.
std::string hashText(std::uint64_t hash);

/// The checks of one pack together.
struct VerifyResult {
    std::uint64_t count = 0;
    RadiusStatistics radius;
    std::uint64_t hash = 0;
    OverlapCheck overlap;
    std::optional<ProtrusionCheck> protrusion;  ///< absent: no domain was given
    std::optional<double> ks;                   ///< absent: no sizes were asked for
    double ksLimit = 1;                         ///< largest `ks` that passes

    bool passed() const;
};

/// Fills in all that needs no domain and no size distribution.
/// @throws InputError as `checkOverlap`.
template <int Dim>
VerifyResult verifyPack(const Pack<Dim>& pack);

/// Keys as in the report; the worst pairs and spheres with ids, positions and radii under `worst`.
template <int Dim>
nlohmann::ordered_json toJson(const VerifyResult& result, const Pack<Dim>& pack);

/// For people: one line a check, then the worst pairs and spheres by id. Ends with a newline.
template <int Dim>
std::string describe(const VerifyResult& result, const Pack<Dim>& pack);

}  // namespace vdbpack
