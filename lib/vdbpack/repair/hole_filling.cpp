#include "vdbpack/repair/hole_filling.h"

#include "vdbpack/core/sphere.h"
#include "vdbpack/mesh/edge_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::size_t kLongestRim = 1000;
constexpr auto kNoStep = static_cast<std::uint32_t>(-1);

/// One step along a rim, against the side of the triangle there.
struct Step {
    std::uint32_t from = 0, to = 0;
    std::uint32_t next = kNoStep;
    bool walked = false;
};

/// The steps around all holes: where forward and backward sides of an edge do not cancel.
std::vector<Step> stepsOf(const TriangleMesh& mesh) {
    std::vector<Step> steps;
    const EdgeTable edges(mesh);
    edges.forEach([&](std::uint32_t lower, std::uint32_t upper, const EdgeTable::Use* first,
                      const EdgeTable::Use* last) {
        int forward = edges.surplus(first, last);
        for (; forward > 0; --forward) steps.push_back({upper, lower});
        for (; forward < 0; ++forward) steps.push_back({lower, upper});
    });
    return steps;
}

std::vector<Vec<3>> normalsAt(const TriangleMesh& mesh, const std::vector<Step>& steps) {
    std::vector<Vec<3>> normals(mesh.vertices.size());
    std::vector<char> wanted(mesh.vertices.size(), 0);
    for (const Step& s : steps) wanted[s.to] = 1;
    for (const auto& t : mesh.triangles) {
        if (wanted[t[0]] == 0 && wanted[t[1]] == 0 && wanted[t[2]] == 0) continue;
        const Vec<3>& a = mesh.vertices[t[0]];
        const Vec<3> n = cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a);
        for (const std::uint32_t v : t) normals[v] += n;
    }
    return normals;
}

/// Sets `next` of every step: at a vertex where several holes meet, the first way out clockwise
/// from the way in, seen from outside, where the surface is missing.
void link(const TriangleMesh& mesh, std::vector<Step>& steps) {
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> out, in;
    for (std::uint32_t i = 0; i < steps.size(); ++i) {
        out[steps[i].from].push_back(i);
        in[steps[i].to].push_back(i);
    }
    const auto normals = normalsAt(mesh, steps);
    for (auto& [v, ways] : out) {
        auto& arriving = in[v];
        if (ways.size() == 1 && arriving.size() == 1) {
            steps[arriving.front()].next = ways.front();
            continue;
        }
        const Vec<3>& at = mesh.vertices[v];
        const Vec<3> n = squaredLength(normals[v]) > 0 ? normalized(normals[v]) : Vec<3>{{0, 0, 1}};
        const Vec<3> aside = std::fabs(n[0]) < 0.6 ? Vec<3>{{1, 0, 0}} : Vec<3>{{0, 1, 0}};
        const Vec<3> u = normalized(cross(n, aside));
        const Vec<3> w = cross(n, u);
        const auto angle = [&](std::uint32_t to) {
            const Vec<3> d = mesh.vertices[to] - at;
            return std::atan2(dot(d, w), dot(d, u));
        };
        // Pairs by rising turn: the narrowest gaps first.
        struct Pair {
            double turn;
            std::uint32_t arriving, leaving;
        };
        std::vector<Pair> pairs;
        for (const std::uint32_t a : arriving)
            for (const std::uint32_t b : ways) {
                double turn = angle(steps[a].from) - angle(steps[b].to);
                while (turn <= 0) turn += 2 * kPi;
                pairs.push_back({turn, a, b});
            }
        std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
            if (a.turn != b.turn) return a.turn < b.turn;
            return a.arriving != b.arriving ? a.arriving < b.arriving : a.leaving < b.leaving;
        });
        std::vector<std::uint32_t> taken;
        for (const Pair& p : pairs) {
            if (steps[p.arriving].next != kNoStep ||
                std::find(taken.begin(), taken.end(), p.leaving) != taken.end())
                continue;
            steps[p.arriving].next = p.leaving;
            taken.push_back(p.leaving);
        }
    }
}

/// Closed rims, parted wherever they come back to a vertex.
std::vector<std::vector<std::uint32_t>> rimsOf(std::vector<Step>& steps) {
    std::vector<std::vector<std::uint32_t>> rims;
    for (std::uint32_t i = 0; i < steps.size(); ++i) {
        if (steps[i].walked) continue;
        std::vector<std::uint32_t> path;
        std::unordered_map<std::uint32_t, std::size_t> placeOf;
        for (std::uint32_t k = i; k != kNoStep && !steps[k].walked; k = steps[k].next) {
            steps[k].walked = true;
            const std::uint32_t v = steps[k].from;
            const auto seen = placeOf.find(v);
            if (seen != placeOf.end()) {
                const auto first = path.begin() + static_cast<std::ptrdiff_t>(seen->second);
                rims.emplace_back(first, path.end());
                for (auto p = first; p != path.end(); ++p) placeOf.erase(*p);
                path.erase(first, path.end());
            }
            placeOf[v] = path.size();
            path.push_back(v);
        }
        if (!path.empty()) rims.push_back(std::move(path));
    }
    return rims;
}

using Triangle = std::array<std::uint32_t, 3>;

/// Triangles of least area on a closed polygon.
std::vector<Triangle> leastArea(const std::vector<Vec<3>>& vertices,
                                const std::vector<std::uint32_t>& rim) {
    const std::size_t n = rim.size();
    const auto at = [&](std::size_t i) -> const Vec<3>& { return vertices[rim[i]]; };
    std::vector<double> least(n * n, 0);
    std::vector<std::uint32_t> split(n * n, 0);
    for (std::size_t span = 2; span < n; ++span)
        for (std::size_t i = 0; i + span < n; ++i) {
            const std::size_t k = i + span;
            double best = std::numeric_limits<double>::infinity();
            const Vec<3> side = at(k) - at(i);
            for (std::size_t m = i + 1; m < k; ++m) {
                const double before = least[i * n + m] + least[m * n + k];
                if (before >= best) continue;
                const double area = before + 0.5 * length(cross(side, at(m) - at(i)));
                if (area >= best) continue;
                best = area;
                split[i * n + k] = static_cast<std::uint32_t>(m);
            }
            least[i * n + k] = best;
        }
    std::vector<Triangle> triangles;
    std::vector<std::pair<std::size_t, std::size_t>> spans{{0, n - 1}};
    while (!spans.empty()) {
        const auto [i, k] = spans.back();
        spans.pop_back();
        if (k < i + 2) continue;
        const std::size_t m = split[i * n + k];
        triangles.push_back({rim[i], rim[m], rim[k]});
        spans.emplace_back(i, m);
        spans.emplace_back(m, k);
    }
    return triangles;
}

}  // namespace

HoleFilling fillHoles(TriangleMesh& mesh) {
    HoleFilling result;
    std::vector<Step> steps = stepsOf(mesh);
    if (steps.empty()) return result;
    link(mesh, steps);
    for (const auto& rim : rimsOf(steps)) {
        if (rim.size() < 3 || rim.size() > kLongestRim) {
            // Two steps there and back cancel: nothing is open.
            if (rim.size() != 2) ++result.left;
            continue;
        }
        for (const Triangle& t : leastArea(mesh.vertices, rim)) {
            mesh.triangles.push_back(t);
            const Vec<3>& a = mesh.vertices[t[0]];
            result.area += 0.5 * length(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
        }
        ++result.filled;
    }
    return result;
}

}  // namespace vdbpack
