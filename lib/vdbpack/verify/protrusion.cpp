#include "vdbpack/verify/protrusion.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/verify/overlap.h"
#include "vdbpack/verify/usable.h"
#include "vdbpack/verify/wall_sides.h"
#include "vdbpack/verify/wall_tree.h"
#include "vdbpack/verify/worst.h"

#include <fmt/format.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace vdbpack {

namespace {

bool protrudesMore(const ProtrudingSphere& a, const ProtrudingSphere& b) {
    return std::make_tuple(-a.protrusion, a.i) < std::make_tuple(-b.protrusion, b.i);
}

void note(ProtrusionCheck& check, std::size_t i, double protrusion) {
    if (!(protrusion > 0)) return;
    check.max = std::max(check.max, protrusion);
    if (!(protrusion > kVerifyTolerance)) return;
    ++check.spheres;
    if (protrusion > 1) ++check.centersOutside;
    keepWorst(check.worst, ProtrudingSphere{i, protrusion}, protrudesMore);
}

template <int Dim>
void requirePlanes(const std::vector<HalfSpace<Dim>>& clips) {
    for (const auto& c : clips)
        if (!isFinite(c.normal) || !std::isfinite(c.offset) || !(length(c.normal) > 0))
            throw ParameterError("clip: the normal of a plane must be finite and not zero");
}

/// Indices along a curve that fills space (Morton order), so that spheres checked one after the
/// other meet the same part of the wall.
template <int Dim>
std::vector<std::uint32_t> coherentOrder(const std::vector<Sphere<Dim>>& spheres) {
    struct Item {
        std::uint64_t key;
        std::uint32_t i;
    };
    Box<Dim> bounds;
    for (const auto& s : spheres) bounds.add(s.center);
    std::vector<Item> items(spheres.size());
    constexpr int kBits = 16;
    forAll(spheres.size(), [&](std::size_t k) {
        std::uint64_t key = 0;
        for (int i = 0; i < Dim; ++i) {
            const double size = bounds.hi[i] - bounds.lo[i];
            const double t = size > 0 ? (spheres[k].center[i] - bounds.lo[i]) / size : 0;
            const auto c = static_cast<std::uint64_t>(t * ((1 << kBits) - 1));
            for (int b = 0; b < kBits; ++b) key |= (c >> b & 1) << (Dim * b + i);
        }
        items[k] = {key, static_cast<std::uint32_t>(k)};
    });
    tbb::parallel_sort(items.begin(), items.end(), [](const Item& a, const Item& b) {
        return std::make_pair(a.key, a.i) < std::make_pair(b.key, b.i);
    });
    std::vector<std::uint32_t> order(items.size());
    for (std::size_t k = 0; k < items.size(); ++k) order[k] = items[k].i;
    return order;
}

/// Squared distances of centers to the nearest piece, mm².
/// @param bound  of a center: the squared distance from which on the bound itself will do.
template <int Dim, class Bound>
std::vector<double> nearestSquares(const std::vector<Sphere<Dim>>& spheres,
                                   std::vector<WallPiece<Dim>> pieces, const Bound& bound) {
    const WallTree<Dim> tree(std::move(pieces));
    const auto order = coherentOrder(spheres);
    std::vector<double> squares(spheres.size());
    // Of the same spheres for any number of threads, so that distances are the same to the last
    // bit.
    constexpr std::size_t kTogether = WallTree<Dim>::kTogether, kBlock = 64 * kTogether;
    forAll((spheres.size() + kBlock - 1) / kBlock, [&](std::size_t b) {
        auto nearest = WallTree<Dim>::noPieces();
        const std::size_t end = std::min(spheres.size(), (b + 1) * kBlock);
        for (std::size_t k = b * kBlock; k < end; k += kTogether) {
            std::array<std::size_t, kTogether> which;
            typename WallTree<Dim>::Points centers;
            typename WallTree<Dim>::Squares bounds;
            for (std::size_t l = 0; l < kTogether; ++l) {
                which[l] = order[std::min(k + l, end - 1)];
                centers[l] = spheres[which[l]].center;
                bounds[l] = bound(which[l]);
            }
            const auto found = tree.squaredDistances(centers, bounds, nearest);
            for (std::size_t l = 0; l < kTogether; ++l) squares[which[l]] = found[l];
        }
    });
    return squares;
}

/// @param distances  if given, takes the distance of each center to the nearest piece, mm.
template <int Dim>
ProtrusionCheck checkPieces(const std::vector<Sphere<Dim>>& spheres,
                            std::vector<WallPiece<Dim>> pieces,
                            const std::vector<HalfSpace<Dim>>& clips,
                            std::vector<double>* distances) {
    requireVerifiable(spheres);
    requirePlanes(clips);
    constexpr std::size_t kMostPieces = 150'000'000;  // the tree counts them in 32 bits
    if (pieces.size() > kMostPieces)
        throw ResourceError(fmt::format(
            "wall: {} pieces are more than can be checked at once ({}); simplify the mesh",
            pieces.size(), kMostPieces));
    const WallSides<Dim> sides(pieces, spheres);
    const auto squares = nearestSquares<Dim>(spheres, std::move(pieces), [&](std::size_t i) {
        return sides.inside(i) && !distances ? spheres[i].radius * spheres[i].radius
                                             : std::numeric_limits<double>::infinity();
    });
    if (distances) {
        distances->resize(spheres.size());
        forAll(spheres.size(), [&](std::size_t i) { (*distances)[i] = std::sqrt(squares[i]); });
    }
    auto result = tbb::parallel_reduce(
        IndexRange(0, spheres.size(), 4096), ProtrusionCheck{},
        [&](const IndexRange& block, ProtrusionCheck check) {
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                const double distance = std::sqrt(squares[i]), r = spheres[i].radius;
                const double inner = std::min(sides.inside(i) ? distance : -distance,
                                              innerDistance(clips, spheres[i].center));
                note(check, i, (r - inner) / r);
            }
            return check;
        },
        joined);
    result.closed = sides.closed();
    return result;
}

}  // namespace

ProtrusionCheck joined(ProtrusionCheck a, const ProtrusionCheck& b) {
    a.max = std::max(a.max, b.max);
    a.spheres += b.spheres;
    a.centersOutside += b.centersOutside;
    a.closed = a.closed && b.closed;
    for (const auto& w : b.worst) keepWorst(a.worst, w, protrudesMore);
    return a;
}

ProtrusionCheck checkProtrusion(const std::vector<Sphere<3>>& spheres, const TriangleMesh& mesh,
                                const std::vector<HalfSpace<3>>& clips,
                                std::vector<double>* distances) {
    if (mesh.triangles.empty())
        throw InputError("mesh: there are no triangles to check against; give a closed surface");
    std::vector<WallPiece<3>> pieces = wallPieces(mesh);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        for (const double c : mesh.vertices[i].c)
            if (!(std::abs(c) <= kLargestVerified))
                throw InputError(fmt::format(
                    "mesh: vertex {} has the coordinate {}; the mesh is damaged, export it again",
                    i, c));
    return checkPieces<3>(spheres, std::move(pieces), clips, distances);
}

ProtrusionCheck checkProtrusion(const std::vector<Sphere<2>>& circles,
                                const std::vector<WallPiece<2>>& wall,
                                const std::vector<HalfSpace<2>>& clips,
                                std::vector<double>* distances) {
    if (wall.empty())
        throw InputError("wall: there are no segments to check against; give a closed curve");
    for (std::size_t t = 0; t < wall.size(); ++t)
        for (const auto& p : wall[t])
            for (const double c : p.c)
                if (!(std::abs(c) <= kLargestVerified))
                    throw InputError(
                        fmt::format("wall: segment {} has the coordinate {}; the wall is damaged, "
                                    "build it again",
                                    t, c));
    return checkPieces<2>(circles, wall, clips, distances);
}

template <int Dim>
ProtrusionCheck checkProtrusion(const std::vector<Sphere<Dim>>& spheres,
                                const WallShape<Dim>& wall) {
    requireVerifiable(spheres);
    requirePlanes(wall.clips);
    return tbb::parallel_reduce(
        IndexRange(0, spheres.size(), 4096), ProtrusionCheck{},
        [&](const IndexRange& block, ProtrusionCheck check) {
            for (std::size_t i = block.begin(); i < block.end(); ++i)
                note(check, i,
                     (spheres[i].radius - wall.innerDistance(spheres[i].center)) /
                         spheres[i].radius);
            return check;
        },
        joined);
}

template ProtrusionCheck checkProtrusion<2>(const std::vector<Sphere<2>>&, const WallShape<2>&);
template ProtrusionCheck checkProtrusion<3>(const std::vector<Sphere<3>>&, const WallShape<3>&);

}  // namespace vdbpack
