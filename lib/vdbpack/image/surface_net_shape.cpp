// Where the vertices of a surface net lie.
#include "vdbpack/image/surface_net.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint16_t kBeyond = LabelVoxels::kBeyond;

/// Of a side of a cell and the cell beyond it: bit 0 of a side is set for the upper one.
using Neighbors = std::array<std::uint32_t, 6>;

/// The vertices that each one shares a side of its cell with, where a surface crosses it.
std::vector<Neighbors> neighborsOf(const SurfaceNet& net) {
    Neighbors none;
    none.fill(kNone);
    std::vector<Neighbors> all(net.vertices.size(), none);
    for (const SurfaceNet::Face& face : net.faces)
        for (std::size_t k = 0; k < 4; ++k) {
            const std::uint32_t a = face.vertices[k], b = face.vertices[(k + 1) % 4];
            for (std::size_t d = 0; d < 3; ++d) {
                if (net.cells[a][d] == net.cells[b][d]) continue;
                const bool up = net.cells[a][d] < net.cells[b][d];
                all[a][2 * d + (up ? 1 : 0)] = b;
                all[b][2 * d + (up ? 0 : 1)] = a;
            }
        }
    return all;
}

/// How far a vertex may move from the middle of its cell along an axis: not to its sides, so that
/// no voxel vanishes; not at all across the border of the image.
double reachOf(const SurfaceNet& net, const std::array<std::size_t, 3>& size, std::size_t v,
               std::size_t axis) {
    const std::uint16_t cell = net.cells[v][axis];
    return cell == 0 || cell == size[axis] ? 0 : 0.45;
}

/// The nearest point that a vertex may have.
Vec<3> inCell(const SurfaceNet& net, const std::array<std::size_t, 3>& size, std::size_t v,
              Vec<3> x) {
    for (std::size_t d = 0; d < 3; ++d) {
        const double middle = static_cast<double>(net.cells[v][d]) - 0.5;
        const double reach = reachOf(net, size, v, d);
        x.c[d] = std::clamp(x.c[d], middle - reach, middle + reach);
    }
    return x;
}

template <class Work>
void forEachVertex(const SurfaceNet& net, const Work& work) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, net.vertices.size(), 4096),
                      [&](const tbb::blocked_range<std::size_t>& block) {
                          for (std::size_t v = block.begin(); v < block.end(); ++v) work(v);
                      });
}

/// Makes the surfaces less bent: a descent of the squared distances of vertices to the means of
/// their neighbors, by the accelerated steps of Beck and Teboulle (2009), "A fast iterative
/// shrinkage-thresholding algorithm", doi:10.1137/080716542.
void straighten(SurfaceNet& net, const std::array<std::size_t, 3>& size) {
    /// Flattens steps that lie up to some ten voxels apart; more rounds make the flat sides of
    /// boxes bulge.
    constexpr int kRounds = 30;
    /// Below the square of the largest eigenvalue, 2, of what `offMean` computes.
    constexpr double kStep = 0.25;
    const std::vector<Neighbors> neighbors = neighborsOf(net);
    std::vector<Vec<3>> ahead = net.vertices, apart(net.vertices.size());
    const auto offMean = [&](const std::vector<Vec<3>>& x, std::size_t v) {
        const unsigned junctions = net.junctions[v];
        Vec<3> sum;
        int others = 0;
        for (unsigned side = 0; side < 6; ++side) {
            const std::uint32_t to = neighbors[v][side];
            if (to == kNone || (junctions && !(junctions >> side & 1))) continue;
            sum += x[to];
            ++others;
        }
        // A line of three labels may end, or be that of a single voxel.
        return others >= 2 ? x[v] - sum * (1.0 / others) : Vec<3>{};
    };
    double t = 1;
    for (int round = 0; round < kRounds; ++round) {
        forEachVertex(net, [&](std::size_t v) { apart[v] = offMean(ahead, v); });
        const double next = (1 + std::sqrt(1 + 4 * t * t)) / 2, beyond = (t - 1) / next;
        t = next;
        forEachVertex(net, [&](std::size_t v) {
            const Vec<3> x = inCell(net, size, v, ahead[v] - kStep * offMean(apart, v));
            ahead[v] = x + beyond * (x - net.vertices[v]);
            net.vertices[v] = x;
        });
    }
}

/// The area of a face as a vector from the voxel below to that above.
Vec<3> areaOf(const SurfaceNet& net, const SurfaceNet::Face& face) {
    const auto at = [&](std::size_t k) { return net.vertices[face.vertices[k]]; };
    return 0.5 * cross(at(2) - at(0), at(3) - at(1));
}

/// Moves the faces between two labels, all of them as far, so that each label has the volume of its
/// voxels again.
void restoreVolumes(SurfaceNet& net, const std::array<std::size_t, 3>& size) {
    constexpr int kRounds = 3, kSweeps = 200;
    for (int round = 0; round < kRounds; ++round) {
        std::vector<double> missing(std::size_t{kBeyond} + 1);
        std::map<std::pair<std::uint16_t, std::uint16_t>, double> areas;  // of labels that touch
        for (const SurfaceNet::Face& face : net.faces) {
            const Vec<3> area = areaOf(net, face);
            Vec<3> middle;
            for (const std::uint32_t v : face.vertices) middle += 0.25 * net.vertices[v];
            double volume = -dot(middle, area) / 3;
            // The voxels of a label, counted along rows: from face to face.
            if (face.axis == 0) volume += static_cast<double>(net.cells[face.vertices[0]][0]) - 0.5;
            missing[face.below] += volume;
            missing[face.above] -= volume;
            if (face.below == kBeyond || face.above == kBeyond) continue;
            areas[std::minmax(face.below, face.above)] += length(area);
        }
        // The least movement that does so is a potential of the labels; that of the background is
        // 0.
        std::vector<double> potential(missing.size()), flow, weight(missing.size());
        for (const auto& [labels, area] : areas) {
            weight[labels.first] += area;
            weight[labels.second] += area;
        }
        for (int sweep = 0; sweep < kSweeps; ++sweep) {
            flow = missing;
            for (const auto& [labels, area] : areas) {
                flow[labels.first] += area * potential[labels.second];
                flow[labels.second] += area * potential[labels.first];
            }
            for (std::size_t l = 1; l < flow.size(); ++l)
                if (weight[l] > 0) potential[l] = flow[l] / weight[l];
        }
        std::vector<Vec<3>> shift(net.vertices.size());
        std::vector<double> around(net.vertices.size());
        for (const SurfaceNet::Face& face : net.faces) {
            const Vec<3> area = areaOf(net, face);
            const double by = face.below == kBeyond || face.above == kBeyond
                                  ? 0
                                  : potential[face.below] - potential[face.above];
            for (const std::uint32_t v : face.vertices) {
                shift[v] += by * area;
                around[v] += length(area);
            }
        }
        forEachVertex(net, [&](std::size_t v) {
            if (around[v] > 0)
                net.vertices[v] =
                    inCell(net, size, v, net.vertices[v] + shift[v] * (1 / around[v]));
        });
    }
}

}  // namespace

void smooth(SurfaceNet& net, const std::array<std::size_t, 3>& size) {
    straighten(net, size);
    restoreVolumes(net, size);
}

void interpolate(SurfaceNet& net, const LabelVoxels& voxels,
                 const std::function<double(std::size_t, std::size_t)>& shareOf) {
    const auto& size = voxels.size;
    const std::size_t stride[3] = {1, size[0], size[0] * size[1]};
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, net.vertices.size(), 1024), [&](const auto& block) {
            for (std::size_t v = block.begin(); v < block.end(); ++v) {
                const auto& cell = net.cells[v];
                // Whether a corner of the cell is a voxel, and which.
                std::array<std::size_t, 8> at{};
                std::array<bool, 8> within{};
                for (std::size_t k = 0; k < 8; ++k) {
                    within[k] = true;
                    for (std::size_t d = 0; d < 3; ++d) {
                        const std::size_t i = cell[d] + (k >> d & 1);  // from 1
                        within[k] = within[k] && i >= 1 && i <= size[d];
                        at[k] += (i - 1) * stride[d];
                    }
                }
                Vec<3> sum;
                int count = 0;
                for (std::size_t k = 0; k < 8; ++k)
                    for (std::size_t d = 0; d < 3; ++d) {
                        const std::size_t l = k | std::size_t{1} << d;
                        if (l == k || !(within[k] || within[l])) continue;
                        const std::uint16_t a = within[k] ? voxels.labels[at[k]] : kBeyond;
                        const std::uint16_t b = within[l] ? voxels.labels[at[l]] : kBeyond;
                        if (!SurfaceNet::isFace(a, b)) continue;
                        Vec<3> x;
                        for (std::size_t e = 0; e < 3; ++e)
                            x.c[e] = static_cast<double>(k >> e & 1) - 0.5;
                        x.c[d] += within[k] && within[l] ? shareOf(at[k], at[l]) : 0.5;
                        sum += x;
                        ++count;
                    }
                for (int d = 0; d < 3; ++d) {
                    const std::uint16_t i = cell[static_cast<std::size_t>(d)];
                    if (count > 0 && i != 0 && i != size[static_cast<std::size_t>(d)])
                        net.vertices[v][d] += sum[d] / count;
                }
            }
        });
}

}  // namespace vdbpack
