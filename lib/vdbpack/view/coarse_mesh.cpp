#include "vdbpack/view/coarse_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace vdbpack {

namespace {

/// Vertices up to which clusters are relaxed: about 2 µs each.
constexpr std::size_t kMostRelaxed = 1'000'000;

double areaOf(const TriangleMesh& mesh) {
    double area = 0;
    for (const auto& t : mesh.triangles)
        area += 0.5 * length(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]],
                                   mesh.vertices[t[2]] - mesh.vertices[t[0]]));
    return area;
}

/// Vertices in clusters, one a cell of a grid at first.
class Clusters {
public:
    Clusters(const TriangleMesh& mesh, double side)
        : mesh_(mesh), lo_(mesh.bounds().lo), side_(side) {
        of_.reserve(mesh.vertices.size());
        for (const Vec<3>& v : mesh.vertices) {
            const auto next = static_cast<std::uint32_t>(clusterAt_.size());
            of_.push_back(clusterAt_.emplace(cellOf(v), next).first->second);
        }
        average();
    }

    /// Moves each vertex to the nearest cluster: corners of cells with few vertices would be
    /// slivers and folds of the surface.
    void relax() {
        for (std::size_t i = 0; i < of_.size(); ++i) {
            const Vec<3>& v = mesh_.vertices[i];
            double nearest = squaredLength(v - middles_[of_[i]]);
            for (int n = 0; n < 27; ++n) {
                const Vec<3> beside{{v[0] + (n % 3 - 1) * side_, v[1] + (n / 3 % 3 - 1) * side_,
                                     v[2] + (n / 9 - 1) * side_}};
                const auto at = clusterAt_.find(cellOf(beside));
                if (at == clusterAt_.end()) continue;
                const double square = squaredLength(v - middles_[at->second]);
                if (square < nearest) {
                    nearest = square;
                    of_[i] = at->second;
                }
            }
        }
        average();
    }

    TriangleMesh mesh() const {
        TriangleMesh coarse;
        coarse.vertices = middles_;
        for (const auto& t : mesh_.triangles) {
            const std::array<std::uint32_t, 3> c{of_[t[0]], of_[t[1]], of_[t[2]]};
            if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0]) coarse.triangles.push_back(c);
        }
        return coarse;
    }

private:
    std::uint64_t cellOf(const Vec<3>& v) const {
        std::uint64_t cell = 0;
        for (int d = 0; d < 3; ++d)
            // One cell more on each side, for neighbors.
            cell = cell << 21 | static_cast<std::uint64_t>((v[d] - lo_[d]) / side_ + 1);
        return cell;
    }
    void average() {
        std::vector<double> members(clusterAt_.size(), 0);
        std::vector<Vec<3>> sums(clusterAt_.size());
        for (std::size_t i = 0; i < of_.size(); ++i) {
            sums[of_[i]] += mesh_.vertices[i];
            members[of_[i]] += 1;
        }
        middles_.resize(sums.size());
        for (std::size_t k = 0; k < sums.size(); ++k)
            if (members[k] > 0) middles_[k] = sums[k] * (1 / members[k]);
    }

    const TriangleMesh& mesh_;
    Vec<3> lo_;
    double side_;
    std::unordered_map<std::uint64_t, std::uint32_t> clusterAt_;  ///< by cell
    std::vector<std::uint32_t> of_;                               ///< of each vertex
    std::vector<Vec<3>> middles_;  ///< of each cluster; of one that lost its vertices, the last
};

}  // namespace

TriangleMesh coarsened(const TriangleMesh& mesh, std::size_t mostTriangles) {
    if (mesh.triangles.size() <= mostTriangles) return mesh;
    // A flat part leaves about two triangles a cell.
    double side = std::sqrt(2 * areaOf(mesh) / static_cast<double>(mostTriangles));
    const Vec<3> size = mesh.bounds().size();
    side = std::max(side, *std::max_element(size.c.begin(), size.c.end()) * 0x1p-20);
    for (;; side *= 1.15) {
        Clusters clusters(mesh, side);
        TriangleMesh coarse = clusters.mesh();
        if (coarse.triangles.size() > mostTriangles) continue;
        if (mesh.vertices.size() > kMostRelaxed) return coarse;
        clusters.relax();
        TriangleMesh relaxed = clusters.mesh();
        return relaxed.triangles.size() <= mostTriangles ? relaxed : coarse;
    }
}

}  // namespace vdbpack
