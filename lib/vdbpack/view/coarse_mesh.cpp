#include "vdbpack/view/coarse_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace vdbpack {

namespace {

double areaOf(const TriangleMesh& mesh) {
    double area = 0;
    for (const auto& t : mesh.triangles)
        area += 0.5 * length(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]],
                                   mesh.vertices[t[2]] - mesh.vertices[t[0]]));
    return area;
}

TriangleMesh clustered(const TriangleMesh& mesh, double side) {
    const Vec<3> lo = mesh.bounds().lo;
    std::unordered_map<std::uint64_t, std::uint32_t> clusters;
    std::vector<std::uint32_t> clusterOf;
    std::vector<double> members;
    TriangleMesh coarse;
    clusterOf.reserve(mesh.vertices.size());
    for (const Vec<3>& v : mesh.vertices) {
        std::uint64_t cell = 0;
        for (int d = 0; d < 3; ++d)
            cell = cell << 21 | static_cast<std::uint64_t>((v[d] - lo[d]) / side);
        const auto next = static_cast<std::uint32_t>(coarse.vertices.size());
        const auto [at, added] = clusters.emplace(cell, next);
        if (added) {
            coarse.vertices.push_back({});
            members.push_back(0);
        }
        coarse.vertices[at->second] += v;
        members[at->second] += 1;
        clusterOf.push_back(at->second);
    }
    for (std::size_t i = 0; i < members.size(); ++i) coarse.vertices[i] *= 1 / members[i];
    for (const auto& t : mesh.triangles) {
        const std::array<std::uint32_t, 3> c{clusterOf[t[0]], clusterOf[t[1]], clusterOf[t[2]]};
        if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0]) coarse.triangles.push_back(c);
    }
    return coarse;
}

}  // namespace

TriangleMesh coarsened(const TriangleMesh& mesh, std::size_t mostTriangles) {
    if (mesh.triangles.size() <= mostTriangles) return mesh;
    // A flat part leaves about two triangles a cell.
    double side = std::sqrt(2 * areaOf(mesh) / static_cast<double>(mostTriangles));
    const Vec<3> size = mesh.bounds().size();
    side = std::max(side, *std::max_element(size.c.begin(), size.c.end()) * 0x1p-20);
    for (;; side *= 1.15) {
        TriangleMesh coarse = clustered(mesh, side);
        if (coarse.triangles.size() <= mostTriangles) return coarse;
    }
}

}  // namespace vdbpack
