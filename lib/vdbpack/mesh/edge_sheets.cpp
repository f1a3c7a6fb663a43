#include "vdbpack/mesh/edge_sheets.h"

#include "vdbpack/core/sphere.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbpack {

namespace {

/// Angle between triangles below which they coincide, radians.
constexpr double kSameAngle = 1e-9;

/// A triangle at an edge, by its angle around it.
struct Sheet {
    double angle;
    bool forward;
    const EdgeTable::Use* use;
};

/// The triangles at an edge by increasing angle. Of those that coincide, a forward one, behind
/// which the inside ends, comes first where solids are apart, and last where walls cancel.
std::vector<Sheet> sortAround(const TriangleMesh& mesh, const EdgeTable& edges, std::uint32_t lower,
                              std::uint32_t upper, const EdgeTable::Use* first,
                              const EdgeTable::Use* last, CommonWalls walls) {
    const Vec<3>& from = mesh.vertices[lower];
    const Vec<3> along = normalized(mesh.vertices[upper] - from);
    const Vec<3> aside = std::fabs(along[0]) < 0.6 ? Vec<3>{{1, 0, 0}} : Vec<3>{{0, 1, 0}};
    const Vec<3> u = normalized(cross(along, aside));
    const Vec<3> v = cross(along, u);
    const bool forwardFirst = walls == CommonWalls::apart;
    std::vector<Sheet> sheets;
    for (const auto* use = first; use != last; ++use) {
        const auto& t = mesh.triangles[use->triangle()];
        const Vec<3> d = mesh.vertices[t[(use->side + 2) % 3]] - from;
        const bool forward = edges.isForward(*use);
        double angle = std::atan2(dot(d, v), dot(d, u));
        if (angle < kSameAngle - kPi) angle += 2 * kPi;
        sheets.push_back({angle - (forward == forwardFirst ? kSameAngle : 0), forward, use});
    }
    std::sort(sheets.begin(), sheets.end(), [](const Sheet& a, const Sheet& b) {
        return a.angle != b.angle ? a.angle < b.angle : a.use->side < b.use->side;
    });
    return sheets;
}

}  // namespace

std::vector<SheetPair> pairSheets(const TriangleMesh& mesh, const EdgeTable& edges,
                                  std::uint32_t lower, std::uint32_t upper,
                                  const EdgeTable::Use* first, const EdgeTable::Use* last,
                                  CommonWalls walls) {
    const std::vector<Sheet> sheets = sortAround(mesh, edges, lower, upper, first, last, walls);
    // The normal of a forward triangle points to larger angles: with increasing angle the inside
    // begins at a backward triangle and ends at a forward one.
    std::vector<SheetPair> pairs;
    std::vector<std::size_t> open;
    const std::size_t n = sheets.size();
    std::vector<char> done(n, 0);
    for (std::size_t round = 0; round < 2 * n; ++round) {
        const std::size_t i = round % n;
        if (done[i] != 0) continue;
        if (!sheets[i].forward) {
            if (std::find(open.begin(), open.end(), i) == open.end()) open.push_back(i);
        } else if (!open.empty()) {
            const Sheet& begin = sheets[open.back()];
            const bool isWall = walls == CommonWalls::cancel &&
                                std::fabs(sheets[i].angle - begin.angle) < 2 * kSameAngle;
            pairs.push_back({*begin.use, *sheets[i].use, isWall});
            done[open.back()] = done[i] = 1;
            open.pop_back();
        }
    }
    return pairs;
}

}  // namespace vdbpack
