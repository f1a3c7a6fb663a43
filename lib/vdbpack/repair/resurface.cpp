#include "vdbpack/repair/resurface.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/field/winding_lattice.h"
#include "vdbpack/repair/lattice_crossings.h"
#include "vdbpack/repair/marching_cubes.h"
#include "vdbpack/repair/winding_number.h"

#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <vector>

namespace vdbpack {

namespace {

/// Vertices keep this share of an edge away from its ends, so that no triangle is without area.
constexpr double kMargin = 0.01;

/// The place of a vertex between the ends of an edge.
struct Vertex {
    EdgeKey edge;
    VoxelIndex lower;
    int axis;
    float at;
    bool bridge;
};

class Surfacer {
public:
    Surfacer(const TriangleMesh& mesh, const WindingNumber& winding, double voxelSize,
             const Callbacks& callbacks)
        : winding_(winding), voxelSize_(voxelSize), callbacks_(callbacks) {
        // Off the round numbers that planes of a mesh like to lie at.
        const Vec<3> center = mesh.bounds().center();
        for (int d = 0; d < 3; ++d)
            origin_[d] =
                center[d] + voxelSize * std::array<double, 3>{0.4142, 0.2361,
                                                              0.3166}[static_cast<std::size_t>(d)];
        double furthest = 0;
        const Box<3> box = mesh.bounds();
        for (int d = 0; d < 3; ++d)
            furthest = std::max({furthest, std::fabs(box.lo[d]), std::fabs(box.hi[d])});
        roundable_ = furthest * 0x1p-23 < 0.2 * kMargin * voxelSize;
        local_ = mesh;
        for (auto& v : local_.vertices) v = (v - origin_) * (1 / voxelSize);
    }

    Resurfaced run() {
        crossings_ = latticeCrossings(local_);
        report(0.4, 0);
        std::vector<EdgeKey> crossed;
        for (const Crossing& crossing : crossings_)
            if (crossed.empty() || crossed.back() != crossing.edge)
                crossed.push_back(crossing.edge);
        WindingLattice lattice(
            local_, crossed, [&](const Vec<3>& p) { return winding_(world(p)); }, callbacks_);
        report(0.6, 0);
        lattice.followSurface();
        report(0.8, 0);
        placeVertices(lattice);
        measureThin(lattice);
        report(0.9, static_cast<double>(vertices_.size()));
        return makeMesh(lattice);
    }

private:
    void report(double fraction, double count) const {
        callbacks_.stopIfCancelled();
        callbacks_.report("repair", fraction, count);
    }
    Vec<3> world(const Vec<3>& p) const { return origin_ + p * voxelSize_; }

    /// Whether the point on an edge at the share `at` from its lower end lies inside.
    bool isInsideOn(const VoxelIndex& lower, int axis, double at) const {
        Vec<3> p = pointOf(lower);
        p[axis] += at;
        return WindingLattice::isInside(winding_(world(p)));
    }

    /// The vertex on an edge whose ends lie on different sides.
    Vertex vertexOn(const WindingLattice::Change& change) const {
        const auto [lower, axis] = edgeOf(change.edge);
        const bool lowerInside = change.lowerInside;
        Vertex vertex{change.edge, lower, axis, 0.5f, false};
        const auto [first, last] =
            std::equal_range(crossings_.begin(), crossings_.end(), Crossing{vertex.edge, 0, 0},
                             [](const Crossing& a, const Crossing& b) { return a.edge < b.edge; });
        double at = 0.5;
        if (last - first == 1) {
            at = first->at;
        } else if (last != first) {
            // The first after which the other side is reached.
            const auto* crossing = &*first;
            for (; crossing + 1 != &*first + (last - first); ++crossing) {
                const double middle = 0.5 * (crossing[0].at + crossing[1].at);
                if (isInsideOn(lower, axis, middle) != lowerInside) break;
            }
            at = crossing->at;
        } else {
            vertex.bridge = true;
            double low = 0, high = 1;
            for (int i = 0; i < 8; ++i) {
                at = 0.5 * (low + high);
                (isInsideOn(lower, axis, at) == lowerInside ? low : high) = at;
            }
        }
        vertex.at = static_cast<float>(std::clamp(at, kMargin, 1 - kMargin));
        return vertex;
    }

    void placeVertices(const WindingLattice& lattice) {
        const std::vector<WindingLattice::Change> changes = lattice.changes();
        vertices_.resize(changes.size());
        parallelFor(IndexRange(0, changes.size(), 512), [&](const IndexRange& range) {
            for (std::size_t i = range.begin(); i != range.end(); ++i)
                vertices_[i] = vertexOn(changes[i]);
        });
        if (vertices_.size() >= static_cast<std::size_t>(1) << 31)
            throw ResourceError(fmt::format(
                "the repaired surface would take {} vertices; give a larger `repairVoxel`",
                vertices_.size()));
    }

    /// Walls that an edge passes through with both ends on one side.
    void measureThin(const WindingLattice& lattice) {
        // In parts of fixed size, so that the sum is the same for any number of threads.
        constexpr std::size_t kPart = 4096;
        std::vector<double> sums(crossings_.size() / kPart + 1, 0);
        parallelFor(std::size_t{0}, sums.size(), [&](std::size_t part) {
            WindingLattice::Reader reader(lattice);
            const std::size_t end = std::min(crossings_.size(), (part + 1) * kPart);
            for (std::size_t i = part * kPart; i < end; ++i) {
                if (i + 1 >= crossings_.size() || crossings_[i].edge != crossings_[i + 1].edge ||
                    crossings_[i + 1].at - crossings_[i].at < 1e-4f)
                    continue;
                const auto [lower, axis] = edgeOf(crossings_[i].edge);
                const bool low = reader.isInside(lower);
                const bool high = reader.isInside(offsetAlong(lower, axis, 1));
                const double middle = 0.5 * (crossings_[i].at + crossings_[i + 1].at);
                // An edge stands for a square of the plane across it; over the three axes the
                // squares of the cosines add up to one.
                if (low == high && isInsideOn(lower, axis, middle) != low)
                    sums[part] += static_cast<double>(crossings_[i].facing);
            }
        });
        for (const double sum : sums) thinArea_ += sum * voxelSize_ * voxelSize_;
    }

    Resurfaced makeMesh(const WindingLattice& lattice) {
        // Cells that have a vertex on one of their edges, by their lowest corners.
        std::vector<EdgeKey> cells;
        cells.reserve(vertices_.size() * 4);
        for (const Vertex& v : vertices_) {
            const int a = (v.axis + 1) % 3, b = (v.axis + 2) % 3;
            for (int k = 0; k < 4; ++k) {
                const VoxelIndex c = offsetAlong(offsetAlong(v.lower, a, -(k & 1)), b, -(k >> 1));
                cells.push_back(edgeKey(c, 0));
            }
        }
        tbb::parallel_sort(cells.begin(), cells.end());
        cells.erase(std::unique(cells.begin(), cells.end()), cells.end());

        static const auto kLoops = makeCubeLoops();
        struct Piece {
            std::vector<std::array<std::uint32_t, 3>> triangles;  // centers: kCenter + number
            std::vector<Vec<3>> centers;                          // in voxels
        };
        constexpr std::uint32_t kCenter = 1u << 31;
        constexpr std::size_t kChunk = 4096;
        std::vector<Piece> parts((cells.size() + kChunk - 1) / kChunk);
        parallelFor(std::size_t{0}, parts.size(), [&](std::size_t chunk) {
            WindingLattice::Reader reader(lattice);
            Piece& part = parts[chunk];
            const std::size_t end = std::min(cells.size(), (chunk + 1) * kChunk);
            for (std::size_t i = chunk * kChunk; i < end; ++i) {
                const VoxelIndex cell = edgeOf(cells[i]).first;
                std::size_t inside = 0;
                for (int c = 0; c < 8; ++c)
                    if (reader.isInside(offsetBy(cell, c & 1, c >> 1 & 1, c >> 2)))
                        inside |= std::size_t{1} << c;
                for (const auto& loop : kLoops[inside]) addLoop(cell, loop, part, kCenter);
            }
        });

        Resurfaced result;
        TriangleMesh& mesh = result.mesh;
        std::size_t bridges = 0;
        for (const Vertex& v : vertices_) {
            mesh.vertices.push_back(rounded(world(placeOf(v))));
            bridges += v.bridge;
        }
        for (const Piece& part : parts) {
            const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
            for (const Vec<3>& center : part.centers)
                mesh.vertices.push_back(rounded(world(center)));
            for (auto t : part.triangles) {
                for (auto& v : t)
                    if (v >= kCenter) v = first + (v - kCenter);
                mesh.triangles.push_back(t);
            }
        }
        result.thinArea = thinArea_;
        result.bridgedShare = vertices_.empty() ? 0
                                                : static_cast<double>(bridges) /
                                                      static_cast<double>(vertices_.size());
        return result;
    }

    /// To the nearest numbers that a binary .stl holds, so that the surface can be read back as it
    /// is; not far from zero, where they lie too far apart for the lattice.
    Vec<3> rounded(const Vec<3>& p) const {
        if (!roundable_) return p;
        Vec<3> q;
        for (int d = 0; d < 3; ++d) q[d] = static_cast<double>(static_cast<float>(p[d]));
        return q;
    }

    static Vec<3> placeOf(const Vertex& v) {
        Vec<3> p = pointOf(v.lower);
        p[v.axis] += v.at;
        return p;
    }

    /// Triangles of one loop in a cell: a fan from a vertex whose diagonals run through the cell,
    /// as one in a face could be an edge of the next cell too; else about the middle.
    template <class Part>
    void addLoop(const VoxelIndex& cell, const std::vector<std::uint8_t>& loop, Part& part,
                 std::uint32_t centerMark) const {
        std::array<std::uint32_t, 12> ids{};
        const std::size_t n = loop.size();
        for (std::size_t k = 0; k < n; ++k) {
            const CubeEdge edge = cubeEdge(loop[k]);
            const VoxelIndex lower =
                offsetBy(cell, edge.corner & 1, edge.corner >> 1 & 1, edge.corner >> 2);
            const EdgeKey key = edgeKey(lower, edge.axis);
            const auto at =
                std::lower_bound(vertices_.begin(), vertices_.end(), key,
                                 [](const Vertex& v, EdgeKey wanted) { return v.edge < wanted; });
            ids[k] = static_cast<std::uint32_t>(at - vertices_.begin());
        }
        for (std::size_t apex = 0; apex < n; ++apex) {
            bool free = true;
            for (std::size_t k = 2; k + 1 < n && free; ++k)
                free = !shareFace(loop[apex], loop[(apex + k) % n]);
            if (!free) continue;
            for (std::size_t k = 1; k + 1 < n; ++k)
                part.triangles.push_back({ids[apex], ids[(apex + k) % n], ids[(apex + k + 1) % n]});
            return;
        }
        Vec<3> middle;
        for (std::size_t k = 0; k < n; ++k) middle += placeOf(vertices_[ids[k]]);
        const auto center = static_cast<std::uint32_t>(centerMark + part.centers.size());
        part.centers.push_back(middle * (1.0 / static_cast<double>(n)));
        for (std::size_t k = 0; k < n; ++k)
            part.triangles.push_back({ids[k], ids[(k + 1) % n], center});
    }

    const WindingNumber& winding_;
    double voxelSize_;
    const Callbacks& callbacks_;
    Vec<3> origin_;
    TriangleMesh local_;  // in voxels about origin_
    std::vector<Crossing> crossings_;
    std::vector<Vertex> vertices_;
    double thinArea_ = 0;
    bool roundable_ = false;
};

}  // namespace

Resurfaced resurface(const TriangleMesh& mesh, const WindingNumber& winding, double voxelSize,
                     const Callbacks& callbacks) {
    const Vec<3> size = mesh.bounds().size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    if (!(longest / voxelSize < kFarthestIndex - 16))
        throw ResourceError(fmt::format(
            "voxels of {:.4g} mm are too many along {:.4g} mm; give a larger `repairVoxel`",
            voxelSize, longest));
    try {
        return Surfacer(mesh, winding, voxelSize, callbacks).run();
    } catch (const std::bad_alloc&) {
        throw ResourceError(fmt::format(
            "not enough memory to repair a surface in voxels of {:.4g} mm; give a larger "
            "`repairVoxel`",
            voxelSize));
    }
}

}  // namespace vdbpack
