// Narrow bands against distances to all triangles and winding numbers.
#include "support/band_oracle.h"
#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/field/narrow_band.h"

#include <random>

namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// The box between two corners; each side of its triangles divided in two, `times` times.
TriangleMesh fineBox(const Vec<3>& lo, const Vec<3>& hi, int times) {
    TriangleMesh mesh = boxMesh(lo, hi);
    for (int i = 0; i < times; ++i) mesh = subdivided(mesh);
    return mesh;
}

/// Moves each coordinate at random by at most `most`.
TriangleMesh shaken(TriangleMesh mesh, double most, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> shift(-most, most);
    for (auto& v : mesh.vertices)
        for (int i = 0; i < 3; ++i) v[i] += shift(random);
    return mesh;
}

/// A box whose vertices are moved at random: convex and concave edges, saddles, slivers.
TriangleMesh crumpled(int times, unsigned seed) {
    return shaken(fineBox({{-5, -5, -5}}, {{5, 5, 5}}, times), 3.5 / (1 << times), seed);
}

struct Case {
    std::string name;
    TriangleMesh mesh;
    double voxelSize;
    Vec<3> origin{};
    int facing = 1;  ///< 0: unknown
};

std::vector<Case> degenerateCases() {
    std::vector<Case> all;
    TriangleMesh split = boxMesh({{-4.2, -4.2, -4.2}}, {{4.1, 4.1, 4.1}});
    {
        // A vertex on a side of the first triangle, closed by a triangle without area.
        const Triangle t = split.triangles[0];
        split.vertices.push_back((split.vertices[t[0]] + split.vertices[t[1]]) * 0.5);
        const auto middle = static_cast<std::uint32_t>(split.vertices.size() - 1);
        split.triangles[0] = {t[0], middle, t[2]};
        split.triangles.push_back({middle, t[1], t[2]});
        split.triangles.push_back({t[0], t[1], middle});
    }
    all.push_back({"a T-junction closed by a triangle without area", split, 0.5});
    TriangleMesh doubled = crumpled(2, 3);
    const Triangle t = doubled.triangles[5];
    doubled.triangles.insert(doubled.triangles.end(), {t, {t[0], t[2], t[1]}});
    all.push_back({"a triangle three times, once flipped", doubled, 0.6, {}, 0});
    // Two triangles on each other: its edges are folded back, and no lattice plane is parallel.
    TriangleMesh folded;
    folded.vertices = {{{11.375, 11.3125, 0}}, {{11.125, 11.8125, 0}}, {{1.3125, 0, 3.125}}};
    folded.triangles = {{2, 0, 1}, {1, 0, 2}};
    all.push_back({"a triangle folded back", folded, 1, {}, 0});
    // Flat enough that the planes over an edge meet far beyond the band, at the end of a node.
    TriangleMesh spike;
    spike.vertices = {{{6.6875, 7.125, 7.125}},
                      {{7.125, 7.125, 11.3125}},
                      {{0, 4.875, 9.625}},
                      {{15.9375, 13.75, 12.6875}}};
    spike.triangles = {{2, 0, 1}, {2, 3, 0}, {0, 3, 1}, {1, 3, 2}};
    all.push_back({"a spike near the end of a node", spike, 1, {}, 0});
    return all;
}

std::vector<Case> cases() {
    std::vector<Case> all = degenerateCases();
    all.push_back({"crumpled", crumpled(3, 1), 0.4});
    all.push_back({"crumpled, facing unknown", crumpled(2, 2), 0.5, {}, 0});
    all.push_back({"faces on lattice planes", fineBox({{-4, -4, -4}}, {{4, 4, 4}}, 2), 0.5});
    all.push_back({"coplanar faces between lattice planes",
                   fineBox({{-3.3, -2.9, -4.1}}, {{3.7, 4.2, 3.9}}, 2), 0.5});
    all.push_back({"large triangles", boxMesh({{-30.3, -10.2, -8.1}}, {{30.1, 9.7, 8.4}}), 0.5});
    const TriangleMesh cavity = merged(fineBox({{-6, -6, -6}}, {{6, 6, 6}}, 1),
                                       fineBox({{-3.1, -3.2, -3.3}}, {{3.4, 3.5, 3.6}}, 1));
    all.push_back({"a cavity whose shell faces outward", cavity, 0.5, {}, 0});
    const TriangleMesh needle = merged(boxMesh({{-0.02, -0.03, -9.7}}, {{0.025, 0.02, 9.9}}),
                                       fineBox({{3, 3, -9}}, {{3.3, 3.2, 9}}, 2));
    all.push_back({"needles", needle, 0.5});
    all.push_back({"a fan of many long triangles", doubleConeMesh(6, 5, 60), 0.7});
    const Vec<3> away{{1e6, -1e6, 1e6}};
    const TriangleMesh far = translated(crumpled(2, 4), away);
    all.push_back({"far from zero", far, 0.5, away + Vec<3>{{0.1, 0.2, 0.3}}});
    all.push_back({"crumpled, triangles smaller than a voxel", crumpled(4, 5), 1.1});
    all.push_back(
        {"triangles far smaller than a voxel, facing unknown", crumpled(5, 6), 2.7, {}, 0});
    all.push_back({"small faces on lattice planes", fineBox({{-4, -4, -4}}, {{4, 4, 4}}, 4), 0.5});
    all.push_back({"small coplanar faces between lattice planes",
                   fineBox({{-3.3, -2.9, -4.1}}, {{3.7, 4.2, 3.9}}, 5), 0.7});
    // Lattice points lie over the edges and vertices of nearly flat faces.
    for (const int times : {2, 4})
        for (const double tilt : {2e-5, 1e-4}) {
            const TriangleMesh flat = fineBox({{-4, -4, -4}}, {{4, 4, 4}}, times);
            all.push_back({"nearly flat faces, " + std::to_string(times) + ", tilted by " +
                               std::to_string(tilt),
                           shaken(flat, tilt * 4 / (1 << times), 8), 0.5});
        }
    all.push_back({"small triangles far from zero", translated(crumpled(4, 7), away), 1.2,
                   away + Vec<3>{{0.1, 0.2, 0.3}}});
    return all;
}

/// @param tell  whether the band knows which way the triangles face.
openvdb::FloatGrid::Ptr bandOf(const Case& c, float inside, float outside, bool tell = true) {
    const Facing outward(c.mesh.triangles.size(), 1);
    NarrowBandOptions options;
    options.origin = c.origin;
    if (tell && c.facing != 0) options.facing = &outward;
    return narrowBand(c.mesh, c.voxelSize, inside, outside, options);
}

}  // namespace

TEST_CASE("narrow bands are exact") {
    constexpr float kInside = 5, kOutside = 3;
    for (const Case& c : cases()) {
        INFO(c.name);
        const LatticeMesh lattice{c.mesh, c.origin, c.voxelSize};
        const auto grid = bandOf(c, kInside, kOutside);
        // Every voxel around the mesh: those in the band active and exact, all others a side.
        Box<3> box;
        for (const auto& v : c.mesh.vertices) box.add((v - c.origin) * (1 / c.voxelSize));
        std::vector<openvdb::Coord> voxels;
        const auto lowest = [&](int i) { return static_cast<int>(std::floor(box.lo[i])) - 5; };
        const auto highest = [&](int i) { return static_cast<int>(std::ceil(box.hi[i])) + 5; };
        for (int x = lowest(0); x <= highest(0); ++x)
            for (int y = lowest(1); y <= highest(1); ++y)
                for (int z = lowest(2); z <= highest(2); ++z) voxels.emplace_back(x, y, z);
        // A part of them, spread without a pattern.
        std::shuffle(voxels.begin(), voxels.end(), std::mt19937(7));
        voxels.resize(std::min(voxels.size(), std::size_t{1000000} / c.mesh.triangles.size()));
        struct Found {
            bool wrongState, wrongSign;
            double error;
        };
        std::vector<Found> found(voxels.size());
        forAll(voxels.size(), [&](std::size_t i) {
            const openvdb::Coord& at = voxels[i];
            const BandOracle truth =
                oracleAt(lattice, {{double(at[0]), double(at[1]), double(at[2])}});
            const bool active = grid->tree().isValueOn(at);
            const double value = grid->tree().getValue(at) / c.voxelSize;
            const double width = truth.inside ? kInside : kOutside;
            found[i].wrongState =
                active != (truth.distance < width) && std::abs(truth.distance - width) > 1e-4;
            found[i].wrongSign = (value < 0) != truth.inside && truth.distance > 1e-5;
            found[i].error = active ? std::abs(std::abs(value) - truth.distance)
                                    : std::abs(std::abs(value) - width);
        });
        std::size_t states = 0, signs = 0;
        double worst = 0;
        for (const Found& f : found) {
            states += f.wrongState;
            signs += f.wrongSign;
            if (!f.wrongState) worst = std::max(worst, f.error);
        }
        CHECK(states == 0);
        CHECK(signs == 0);
        CHECK(worst < 1e-5);
    }
}

TEST_CASE("a narrow band does not depend on threads, on known facings, or on useless depth") {
    const Case c = cases().front();
    const auto requireSame = [&](const auto& one, const auto& other, double tolerance) {
        REQUIRE(one->activeVoxelCount() == other->activeVoxelCount());
        for (auto value = one->cbeginValueOn(); value; ++value)
            REQUIRE(std::abs(other->tree().getValue(value.getCoord()) - *value) <= tolerance);
    };
    const auto with = [&](int threads) {
        return withThreads(threads, [&] { return bandOf(c, 5, 3); });
    };
    requireSame(with(1), with(3), 0);
    requireSame(bandOf(c, 5, 3), bandOf(c, 5, 3, false), 1e-5 * c.voxelSize);
    // Deeper than the mesh: all of its inside.
    requireSame(bandOf(c, 20, 3), bandOf(c, 1e5f, 3), 0);
}
