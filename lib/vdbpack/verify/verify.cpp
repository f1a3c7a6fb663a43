#include "vdbpack/verify/verify.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/verify/wall_tree.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <tuple>

namespace vdbpack {

namespace {

using Blocks = tbb::blocked_range<std::size_t>;

bool worse(const OverlapPair& a, const OverlapPair& b) {
    return std::make_tuple(-a.overlap, a.i, a.j) < std::make_tuple(-b.overlap, b.i, b.j);
}
bool worse(const ProtrudingSphere& a, const ProtrudingSphere& b) {
    return std::make_tuple(-a.protrusion, a.i) < std::make_tuple(-b.protrusion, b.i);
}

/// Keeps the worst few, in an order that does not depend on that of arrival.
template <typename T>
void keepWorst(std::vector<T>& worst, const T& found) {
    if (worst.size() == kWorstNamed && !worse(found, worst.back())) return;
    const auto at = std::upper_bound(worst.begin(), worst.end(), found,
                                     [](const T& a, const T& b) { return worse(a, b); });
    worst.insert(at, found);
    if (worst.size() > kWorstNamed) worst.pop_back();
}

void note(ProtrusionCheck& check, std::size_t i, double protrusion) {
    if (!(protrusion > 0)) return;
    check.max = std::max(check.max, protrusion);
    if (!(protrusion > kVerifyTolerance)) return;
    ++check.spheres;
    if (protrusion > 1) ++check.centersOutside;
    keepWorst(check.worst, {i, protrusion});
}

ProtrusionCheck joined(ProtrusionCheck a, const ProtrusionCheck& b) {
    a.max = std::max(a.max, b.max);
    a.spheres += b.spheres;
    a.centersOutside += b.centersOutside;
    for (const auto& w : b.worst) keepWorst(a.worst, w);
    return a;
}

template <int Dim>
void requireUsable(const std::vector<HalfSpace<Dim>>& clips) {
    for (const auto& c : clips)
        if (!isFinite(c.normal) || !std::isfinite(c.offset) || !(length(c.normal) > 0))
            throw ParameterError("clip: the normal of a plane must be finite and not zero");
}

template <int Dim>
double innerDistance(const std::vector<HalfSpace<Dim>>& clips, const Vec<Dim>& x) {
    double d = std::numeric_limits<double>::infinity();
    for (const auto& c : clips) d = std::min(d, (c.offset - dot(c.normal, x)) / length(c.normal));
    return d;
}

/// Places along a curve that fills space (Morton order), so that spheres asked about one after the
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
    tbb::parallel_for(Blocks(0, spheres.size(), 4096), [&](const Blocks& block) {
        for (std::size_t k = block.begin(); k < block.end(); ++k) {
            std::uint64_t key = 0;
            for (int i = 0; i < Dim; ++i) {
                const double size = bounds.hi[i] - bounds.lo[i];
                const double t = size > 0 ? (spheres[k].center[i] - bounds.lo[i]) / size : 0;
                const auto c = static_cast<std::uint64_t>(t * ((1 << kBits) - 1));
                for (int b = 0; b < kBits; ++b) key |= (c >> b & 1) << (Dim * b + i);
            }
            items[k] = {key, static_cast<std::uint32_t>(k)};
        }
    });
    tbb::parallel_sort(items.begin(), items.end(), [](const Item& a, const Item& b) {
        return std::make_pair(a.key, a.i) < std::make_pair(b.key, b.i);
    });
    std::vector<std::uint32_t> order(items.size());
    for (std::size_t k = 0; k < items.size(); ++k) order[k] = items[k].i;
    return order;
}

template <int Dim>
ProtrusionCheck checkPieces(const std::vector<Sphere<Dim>>& spheres,
                            std::vector<WallPiece<Dim>> pieces,
                            const std::vector<HalfSpace<Dim>>& clips) {
    requireUsable(spheres);
    requireUsable(clips);
    constexpr std::size_t kMostPieces = 150'000'000;  // bins count their entries in 32 bits
    if (pieces.size() > kMostPieces)
        throw ResourceError(
            fmt::format("wall: {} pieces are more than can be checked at once "
                        "({}); simplify the mesh",
                        pieces.size(), kMostPieces));
    const WallTree<Dim> tree(std::move(pieces));
    const WallSides<Dim> sides(tree.pieces());
    const auto order = coherentOrder(spheres);
    auto result = tbb::parallel_reduce(
        Blocks(0, spheres.size(), 512), ProtrusionCheck{},
        [&](const Blocks& block, ProtrusionCheck check) {
            // From the last center outside, with its distance: bounds the next one's.
            Vec<Dim> last;
            double lastDistance = -1;
            for (std::size_t k = block.begin(); k < block.end(); ++k) {
                const Sphere<Dim>& s = spheres[order[k]];
                const double r = s.radius;
                double inner = 0;
                if (sides.inside(s.center)) {
                    inner = std::sqrt(tree.squaredDistance(s.center, r * r));
                } else {
                    double bound = std::numeric_limits<double>::infinity();
                    if (lastDistance >= 0) {
                        const double reach = (lastDistance + length(s.center - last)) * (1 + 1e-9);
                        bound = reach * reach;
                    }
                    inner = -std::sqrt(tree.squaredDistance(s.center, bound));
                    last = s.center;
                    lastDistance = -inner;
                }
                inner = std::min(inner, innerDistance(clips, s.center));
                note(check, order[k], (r - inner) / r);
            }
            return check;
        },
        joined);
    result.closed = sides.closed();
    return result;
}

void requireIndices(const TriangleMesh& mesh) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const auto v : mesh.triangles[t])
            if (v >= mesh.vertices.size())
                throw InputError(
                    fmt::format("mesh: triangle {} names vertex {} of {}; the mesh is "
                                "damaged, export it again",
                                t, v, mesh.vertices.size()));
}

template <int Dim>
std::int64_t nameOf(const Pack<Dim>& pack, std::size_t i) {
    return i < pack.id.size() ? pack.id[i] : static_cast<std::int64_t>(i);
}

template <int Dim>
std::string placeOf(const Pack<Dim>& pack, std::size_t i) {
    const Sphere<Dim>& s = pack.spheres[i];
    std::string text = fmt::format("{} at (", nameOf(pack, i));
    for (int k = 0; k < Dim; ++k) text += fmt::format("{}{:.6g}", k ? ", " : "", s.center[k]);
    return text + fmt::format("), radius {:.6g}", s.radius);
}

template <int Dim>
nlohmann::ordered_json sphereJson(const Pack<Dim>& pack, std::size_t i) {
    const Sphere<Dim>& s = pack.spheres[i];
    nlohmann::ordered_json json;
    json["id"] = nameOf(pack, i);
    json["position"] = s.center.c;
    json["radius"] = s.radius;
    return json;
}

}  // namespace

template <int Dim>
OverlapCheck checkOverlap(const std::vector<Sphere<Dim>>& spheres) {
    requireUsable(spheres);
    struct Found {
        OverlapCheck check;
        std::uint64_t sinceShared = 0;
    };
    const std::uint64_t limit = 200 * static_cast<std::uint64_t>(spheres.size()) + 1000000;
    std::atomic<std::uint64_t> shared{0};
    tbb::enumerable_thread_specific<Found> found;
    const CellLevels<Dim> cells(spheres);
    cells.forEachPair(
        [&](std::uint32_t i, const Sphere<Dim>& a, std::uint32_t j, const Sphere<Dim>& b,
            double d2) {
            const double overlap =
                (a.radius + b.radius - std::sqrt(d2)) / std::min(a.radius, b.radius);
            Found& mine = found.local();
            mine.check.max = std::max(mine.check.max, overlap);
            if (!(overlap > kVerifyTolerance)) return;
            ++mine.check.pairs;
            if (++mine.sinceShared == 4096) {
                shared += mine.sinceShared;
                mine.sinceShared = 0;
            }
            keepWorst(mine.check.worst, {std::min(i, j), std::max(i, j), overlap});
        },
        [&] { return shared.load(std::memory_order_relaxed) > limit; });
    OverlapCheck result;
    for (const Found& f : found) {
        result.max = std::max(result.max, f.check.max);
        result.pairs += f.check.pairs;
        for (const auto& w : f.check.worst) keepWorst(result.worst, w);
    }
    result.complete = shared <= limit;
    return result;
}

ProtrusionCheck checkProtrusion(const std::vector<Sphere<3>>& spheres, const TriangleMesh& mesh,
                                const std::vector<HalfSpace<3>>& clips) {
    if (mesh.triangles.empty())
        throw InputError("mesh: there are no triangles to check against; give a closed surface");
    requireIndices(mesh);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        for (const double c : mesh.vertices[i].c)
            if (!(std::abs(c) <= kLargestLength))
                throw InputError(
                    fmt::format("mesh: vertex {} has the coordinate {}; the mesh is "
                                "damaged, export it again",
                                i, c));
    std::vector<WallPiece<3>> pieces(mesh.triangles.size());
    for (std::size_t t = 0; t < pieces.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) pieces[t][k] = mesh.vertices[mesh.triangles[t][k]];
    return checkPieces<3>(spheres, std::move(pieces), clips);
}

ProtrusionCheck checkProtrusion(const std::vector<Sphere<2>>& circles,
                                const std::vector<WallSegment>& wall,
                                const std::vector<HalfSpace<2>>& clips) {
    if (wall.empty())
        throw InputError("wall: there are no segments to check against; give a closed curve");
    std::vector<WallPiece<2>> pieces(wall.size());
    for (std::size_t t = 0; t < wall.size(); ++t) {
        pieces[t] = {wall[t].a, wall[t].b};
        for (const auto& p : pieces[t])
            for (const double c : p.c)
                if (!(std::abs(c) <= kLargestLength))
                    throw InputError(
                        fmt::format("wall: segment {} has the coordinate {}; the wall "
                                    "is damaged, make it again",
                                    t, c));
    }
    return checkPieces<2>(circles, std::move(pieces), clips);
}

std::vector<WallSegment> sliceSegments(const TriangleMesh& mesh, double height) {
    requireIndices(mesh);
    std::vector<WallSegment> segments;
    for (const auto& t : mesh.triangles) {
        std::array<Vec<2>, 3> ends;
        std::size_t n = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            Vec<3> a = mesh.vertices[t[k]], b = mesh.vertices[t[(k + 1) % 3]];
            if ((a[2] > height) == (b[2] > height)) continue;
            // From the lower to the upper end: the same point in both triangles of the edge.
            if (a[2] > b[2]) std::swap(a, b);
            const double s = (height - a[2]) / (b[2] - a[2]);
            ends[n++] = {{a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])}};
        }
        if (n == 2) segments.push_back({ends[0], ends[1]});
    }
    return segments;
}

template <int Dim>
Shape<Dim> Shape<Dim>::ofBox(const Box<Dim>& box) {
    Shape shape;
    shape.kind = Kind::box;
    shape.box = box;
    return shape;
}

template <int Dim>
Shape<Dim> Shape<Dim>::ofBall(double radius, const Vec<Dim>& center) {
    Shape shape;
    shape.kind = Kind::ball;
    shape.radius = radius;
    shape.center = center;
    return shape;
}

template <int Dim>
Shape<Dim> Shape<Dim>::ofCylinder(double radius, double height, const Vec<Dim>& center) {
    static_assert(Dim == 2 || Dim == 3);
    Shape shape;
    shape.kind = Dim == 3 ? Kind::cylinder : Kind::ball;
    shape.radius = radius;
    shape.height = height;
    shape.center = center;
    return shape;
}

template <int Dim>
double Shape<Dim>::innerDistance(const Vec<Dim>& x) const {
    // Depth below each wall; outside, the walls passed add up like the legs of a triangle.
    double least = std::numeric_limits<double>::infinity(), outside2 = 0;
    const auto wall = [&](double depth) {
        least = std::min(least, depth);
        if (depth < 0) outside2 += depth * depth;
    };
    switch (kind) {
        case Kind::box:
            for (int i = 0; i < Dim; ++i) wall(std::min(x[i] - box.lo[i], box.hi[i] - x[i]));
            break;
        case Kind::ball:
            wall(radius - length(x - center));
            break;
        case Kind::cylinder:
            wall(radius - std::hypot(x[0] - center[0], x[1] - center[1]));
            wall(height / 2 - std::abs(x[Dim - 1] - center[Dim - 1]));
            break;
    }
    const double own = least < 0 ? -std::sqrt(outside2) : least;
    return std::min(own, vdbpack::innerDistance(clips, x));
}

std::optional<Shape<2>> sliceShape(const Shape<3>& shape, double height) {
    Shape<2> cut;
    const double z = height - shape.center[2];
    switch (shape.kind) {
        case Shape<3>::Kind::box:
            if (!(height > shape.box.lo[2] && height < shape.box.hi[2])) return std::nullopt;
            cut = Shape<2>::ofBox(
                {{{shape.box.lo[0], shape.box.lo[1]}}, {{shape.box.hi[0], shape.box.hi[1]}}});
            break;
        case Shape<3>::Kind::ball:
            if (!(std::abs(z) < shape.radius)) return std::nullopt;
            cut = Shape<2>::ofBall(std::sqrt((shape.radius - z) * (shape.radius + z)),
                                   {{shape.center[0], shape.center[1]}});
            break;
        case Shape<3>::Kind::cylinder:
            if (!(std::abs(z) < shape.height / 2)) return std::nullopt;
            cut = Shape<2>::ofBall(shape.radius, {{shape.center[0], shape.center[1]}});
            break;
    }
    for (const auto& c : shape.clips) {
        const HalfSpace<2> line{{{c.normal[0], c.normal[1]}}, c.offset - c.normal[2] * height};
        if (length(line.normal) > 0)
            cut.clips.push_back(line);
        else if (line.offset < 0)
            return std::nullopt;
    }
    return cut;
}

template <int Dim>
ProtrusionCheck checkProtrusion(const std::vector<Sphere<Dim>>& spheres, const Shape<Dim>& shape) {
    requireUsable(spheres);
    requireUsable(shape.clips);
    return tbb::parallel_reduce(
        Blocks(0, spheres.size(), 4096), ProtrusionCheck{},
        [&](const Blocks& block, ProtrusionCheck check) {
            for (std::size_t i = block.begin(); i < block.end(); ++i)
                note(check, i,
                     (spheres[i].radius - shape.innerDistance(spheres[i].center)) /
                         spheres[i].radius);
            return check;
        },
        joined);
}

template <int Dim>
RadiusStatistics radiusStatistics(const std::vector<Sphere<Dim>>& spheres) {
    RadiusStatistics s;
    if (spheres.empty()) return s;
    const double n = static_cast<double>(spheres.size());
    s.min = s.max = spheres.front().radius;
    double sum = 0;
    for (const auto& sphere : spheres) {
        s.min = std::min(s.min, sphere.radius);
        s.max = std::max(s.max, sphere.radius);
        sum += sphere.radius;
    }
    s.mean = sum / n;
    double squares = 0;
    for (const auto& sphere : spheres) {
        const double d = sphere.radius - s.mean;
        squares += d * d;
    }
    s.sd = std::sqrt(squares / n);
    return s;
}

double ksDistance(std::vector<double> radii, const std::function<double(double)>& cdf,
                  const std::function<double(double)>& cdfBefore, int weightPower) {
    constexpr double kRounding = 1e-6;
    const auto& before = cdfBefore ? cdfBefore : cdf;
    tbb::parallel_sort(radii.begin(), radii.end());
    const std::size_t n = radii.size();
    // Weight of the radii before each, by number without a table.
    std::vector<double> sums;
    if (weightPower > 0) {
        sums.resize(n + 1);
        for (std::size_t k = 0; k < n; ++k) sums[k + 1] = sums[k] + std::pow(radii[k], weightPower);
    }
    const auto shareBefore = [&](std::size_t k) {
        return sums.empty() ? static_cast<double>(k) / static_cast<double>(n) : sums[k] / sums[n];
    };
    // The share of radii jumps at each radius and is level between: F is above it by the most
    // just before a jump, below it by the most just after one.
    return tbb::parallel_reduce(
        Blocks(0, n, 1024), 0.0,
        [&](const Blocks& block, double largest) {
            for (std::size_t k = block.begin(); k < block.end(); ++k) {
                const double r = radii[k];
                if (k == 0 || radii[k - 1] < r)
                    largest = std::max(largest, before(r * (1 - kRounding)) - shareBefore(k));
                if (k + 1 == n || radii[k + 1] > r)
                    largest = std::max(largest, shareBefore(k + 1) - cdf(r * (1 + kRounding)));
            }
            return largest;
        },
        [](double a, double b) { return std::max(a, b); });
}

template <int Dim>
std::uint64_t packHash(const Pack<Dim>& pack) {
    const auto take = [](std::uint64_t h, double v) {
        v += 0.0;  // -0 becomes 0
        std::uint64_t bits;
        std::memcpy(&bits, &v, sizeof bits);
        return mix64(h ^ bits);
    };
    return tbb::parallel_reduce(
        Blocks(0, pack.spheres.size(), 4096), std::uint64_t{0},
        [&](const Blocks& block, std::uint64_t sum) {
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                const Sphere<Dim>& s = pack.spheres[i];
                std::uint64_t h = 0x9e3779b97f4a7c15ull;
                for (int k = 0; k < Dim; ++k) h = take(h, s.center[k]);
                if (Dim == 2) h = take(h, pack.sliceHeight);
                sum += take(h, s.radius);
            }
            return sum;
        },
        std::plus<>());
}

std::string hashText(std::uint64_t hash) {
    return fmt::format("{:016x}", hash);
}

bool VerifyResult::passed() const {
    return overlap.pairs == 0 && (!protrusion || protrusion->spheres == 0) &&
           (!ks || *ks <= ksLimit);
}

template <int Dim>
VerifyResult verifyPack(const Pack<Dim>& pack) {
    VerifyResult result;
    result.overlap = checkOverlap(pack.spheres);
    result.count = pack.spheres.size();
    result.radius = radiusStatistics(pack.spheres);
    result.hash = packHash(pack);
    return result;
}

template <int Dim>
nlohmann::ordered_json toJson(const VerifyResult& result, const Pack<Dim>& pack) {
    nlohmann::ordered_json json;
    json["passed"] = result.passed();
    json["hash"] = hashText(result.hash);
    auto& spheres = json["spheres"];
    spheres["count"] = result.count;
    spheres["radius"] = {{"min", result.radius.min},
                         {"mean", result.radius.mean},
                         {"max", result.radius.max},
                         {"sd", result.radius.sd}};
    spheres["ks"] = result.ks ? nlohmann::ordered_json(*result.ks) : nullptr;
    auto& overlap = json["overlap"];
    overlap["max"] = result.overlap.max;
    overlap["pairs"] = result.overlap.pairs;
    overlap["complete"] = result.overlap.complete;
    overlap["worst"] = nlohmann::ordered_json::array();
    for (const auto& w : result.overlap.worst)
        overlap["worst"].push_back(
            {{"overlap", w.overlap}, {"spheres", {sphereJson(pack, w.i), sphereJson(pack, w.j)}}});
    auto& protrusion = json["protrusion"];
    protrusion = {{"max", nullptr}, {"spheres", nullptr}};
    if (result.protrusion) {
        protrusion["max"] = result.protrusion->max;
        protrusion["spheres"] = result.protrusion->spheres;
        protrusion["centersOutside"] = result.protrusion->centersOutside;
        protrusion["closed"] = result.protrusion->closed;
        protrusion["worst"] = nlohmann::ordered_json::array();
        for (const auto& w : result.protrusion->worst) {
            auto sphere = sphereJson(pack, w.i);
            sphere["protrusion"] = w.protrusion;
            protrusion["worst"].push_back(std::move(sphere));
        }
    }
    return json;
}

template <int Dim>
std::string describe(const VerifyResult& result, const Pack<Dim>& pack) {
    const auto verdict = [](bool ok) { return ok ? "ok" : "FAILED"; };
    std::string text = fmt::format("{:<12}{} {}, radius {:.6g} to {:.6g} mm, mean {:.6g}\n", "pack",
                                   result.count, Measure<Dim>::kSpheres, result.radius.min,
                                   result.radius.max, result.radius.mean);
    text +=
        fmt::format("{:<12}{}: {}{} pairs, largest {:.3g} of the smaller radius\n", "overlap",
                    verdict(result.overlap.pairs == 0), result.overlap.complete ? "" : "more than ",
                    result.overlap.pairs, result.overlap.max);
    for (const auto& w : result.overlap.worst)
        text += fmt::format("  {:.3g}: {}\n    and {}\n", w.overlap, placeOf(pack, w.i),
                            placeOf(pack, w.j));
    if (result.protrusion) {
        const auto& p = *result.protrusion;
        text +=
            fmt::format("{:<12}{}: {} {}, largest {:.3g} of the radius, {} with centers outside\n",
                        "protrusion", verdict(p.spheres == 0), p.spheres, Measure<Dim>::kSpheres,
                        p.max, p.centersOutside);
        if (!p.closed) text += "  the wall is not closed: what is inside was put to the vote\n";
        for (const auto& w : p.worst)
            text += fmt::format("  {:.3g}: {}{}\n", w.protrusion, placeOf(pack, w.i),
                                w.protrusion > 1 ? ", center outside" : "");
    } else {
        text += fmt::format("{:<12}not checked: no domain was given\n", "protrusion");
    }
    if (result.ks)
        text += fmt::format("{:<12}{}: Kolmogorov-Smirnov distance {:.4g}\n", "sizes",
                            verdict(*result.ks <= result.ksLimit), *result.ks);
    text += fmt::format("{:<12}{}\n", "hash", hashText(result.hash));
    return text;
}

#define VDBPACK_INSTANTIATE(Dim)                                                        \
    template OverlapCheck checkOverlap<Dim>(const std::vector<Sphere<Dim>>&);           \
    template struct Shape<Dim>;                                                         \
    template ProtrusionCheck checkProtrusion<Dim>(const std::vector<Sphere<Dim>>&,      \
                                                  const Shape<Dim>&);                   \
    template RadiusStatistics radiusStatistics<Dim>(const std::vector<Sphere<Dim>>&);   \
    template std::uint64_t packHash<Dim>(const Pack<Dim>&);                             \
    template VerifyResult verifyPack<Dim>(const Pack<Dim>&);                            \
    template nlohmann::ordered_json toJson<Dim>(const VerifyResult&, const Pack<Dim>&); \
    template std::string describe<Dim>(const VerifyResult&, const Pack<Dim>&);

VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)

}  // namespace vdbpack
