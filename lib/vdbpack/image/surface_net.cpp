#include "vdbpack/image/surface_net.h"

#include "vdbpack/core/error.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint16_t kBeyond = LabelVoxels::kBeyond;
/// Slices of cells that one task works on.
constexpr std::size_t kSlices = 8;

/// The labels of an image with a layer of `kBeyond` around it, row by row.
class PaddedRows {
public:
    explicit PaddedRows(const LabelVoxels& voxels)
        : voxels_(voxels), beyond_(voxels.size[0], kBeyond) {}
    /// Row of voxels; y and z count from 1, 0 and size + 1 are beyond.
    const std::uint16_t* row(std::size_t y, std::size_t z) const {
        const auto& size = voxels_.size;
        if (y == 0 || y > size[1] || z == 0 || z > size[2]) return beyond_.data();
        return voxels_.labels.data() + ((z - 1) * size[1] + y - 1) * size[0];
    }

private:
    const LabelVoxels& voxels_;
    std::vector<std::uint16_t> beyond_;
};

/// The eight labels around a cell: bits 0, 1 and 2 of an index are set for the upper x, y and z.
using Corners = std::array<std::uint16_t, 8>;

/// Calls `work(x, y, corners)` for each cell of a slice that a surface crosses, by rising y, x.
template <class Work>
void forEachCell(const LabelVoxels& voxels, const PaddedRows& rows, std::size_t z,
                 const Work& work) {
    const std::size_t width = voxels.size[0], height = voxels.size[1];
    for (std::size_t y = 0; y <= height; ++y) {
        const std::uint16_t* const near[4] = {rows.row(y, z), rows.row(y + 1, z),
                                              rows.row(y, z + 1), rows.row(y + 1, z + 1)};
        Corners c;
        c.fill(kBeyond);
        bool uniform = true;  // the four labels at the lower x
        for (std::size_t x = 0; x <= width; ++x) {
            std::array<std::uint16_t, 4> next;
            next.fill(kBeyond);
            if (x < width)
                for (std::size_t r = 0; r < 4; ++r) next[r] = near[r][x];
            const bool nextUniform = next[0] == next[1] && next[0] == next[2] && next[0] == next[3];
            for (std::size_t r = 0; r < 4; ++r) c[2 * r + 1] = next[r];
            if (!(uniform && nextUniform && next[0] == c[0]) &&
                std::any_of(c.begin(), c.end(),
                            [](std::uint16_t l) { return l != 0 && l != kBeyond; }))
                work(x, y, c);
            for (std::size_t r = 0; r < 4; ++r) c[2 * r] = next[r];
            uniform = nextUniform;
        }
    }
}

/// Corners of a cell's six sides: -x, +x, -y, +y, -z, +z.
constexpr std::size_t kSides[6][4] = {{0, 2, 4, 6}, {1, 3, 5, 7}, {0, 1, 4, 5},
                                      {2, 3, 6, 7}, {0, 1, 2, 3}, {4, 5, 6, 7}};

std::uint8_t junctionsOf(const Corners& c) {
    unsigned bits = 0;
    for (unsigned side = 0; side < 6; ++side) {
        std::array<std::uint16_t, 4> labels;
        for (std::size_t k = 0; k < 4; ++k) labels[k] = c[kSides[side][k]];
        std::sort(labels.begin(), labels.end());
        if (std::unique(labels.begin(), labels.end()) - labels.begin() >= 3) bits |= 1u << side;
    }
    return static_cast<std::uint8_t>(bits);
}

/// Whether a face is between two voxels: nothing is between the background and what lies beyond.
bool isFace(std::uint16_t a, std::uint16_t b) {
    return a != b && !((a == 0 || a == kBeyond) && (b == 0 || b == kBeyond));
}

/// The faces of a slice of cells whose vertices lie in it and in the one below: those between
/// voxels of the slice below it, and those across z to the slice above.
class SliceMaps {
public:
    SliceMaps(std::size_t width, std::size_t cells) : width_(width), here_(cells), below_(cells) {}
    void next() { here_.swap(below_); }
    void set(std::size_t x, std::size_t y, std::uint32_t vertex) { here_[y * width_ + x] = vertex; }
    std::uint32_t here(std::size_t x, std::size_t y) const { return here_[y * width_ + x]; }
    std::uint32_t below(std::size_t x, std::size_t y) const { return below_[y * width_ + x]; }

private:
    std::size_t width_;
    std::vector<std::uint32_t> here_, below_;
};

}  // namespace

SurfaceNet surfaceNet(const LabelVoxels& voxels) {
    const auto& size = voxels.size;
    const PaddedRows rows(voxels);
    const std::size_t slices = size[2] + 1;
    // Vertices are numbered slice by slice.
    std::vector<std::size_t> first(slices + 1);
    tbb::parallel_for(std::size_t{0}, slices, [&](std::size_t z) {
        std::size_t count = 0;
        forEachCell(voxels, rows, z, [&](std::size_t, std::size_t, const Corners&) { ++count; });
        first[z + 1] = count;
    });
    std::partial_sum(first.begin(), first.end(), first.begin());
    if (first.back() >= kNone)
        throw ResourceError(
            "surfaces of labels: more than 4,000,000,000 vertices; give fewer "
            "labels or a coarser image");
    SurfaceNet net;
    net.vertices.resize(first.back());
    net.cells.resize(first.back());
    net.junctions.resize(first.back());
    const std::size_t tasks = (slices + kSlices - 1) / kSlices;
    std::vector<std::vector<SurfaceNet::Face>> faces(tasks);
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
        SliceMaps maps(size[0] + 1, (size[0] + 1) * (size[1] + 1));
        const std::size_t begin = task * kSlices, end = std::min(slices, begin + kSlices);
        auto& own = faces[task];
        for (std::size_t z = begin > 0 ? begin - 1 : 0; z < end; ++z) {
            maps.next();
            auto vertex = static_cast<std::uint32_t>(first[z]);
            forEachCell(voxels, rows, z, [&](std::size_t x, std::size_t y, const Corners& c) {
                maps.set(x, y, vertex);
                if (z >= begin) {
                    net.cells[vertex] = {static_cast<std::uint16_t>(x),
                                         static_cast<std::uint16_t>(y),
                                         static_cast<std::uint16_t>(z)};
                    net.vertices[vertex] = {{static_cast<double>(x) - 0.5,
                                             static_cast<double>(y) - 0.5,
                                             static_cast<double>(z) - 0.5}};
                    net.junctions[vertex] = junctionsOf(c);
                    // The faces whose four cells are this one and those before it.
                    const auto add = [&](std::size_t low, std::size_t high, std::uint8_t axis,
                                         std::array<std::uint32_t, 4> around) {
                        if (isFace(c[low], c[high])) own.push_back({around, c[low], c[high], axis});
                    };
                    if (y > 0 && z > 0)
                        add(0, 1, 0,
                            {maps.below(x, y - 1), maps.below(x, y), maps.here(x, y),
                             maps.here(x, y - 1)});
                    if (x > 0 && z > 0)
                        add(0, 2, 1,
                            {maps.below(x - 1, y), maps.here(x - 1, y), maps.here(x, y),
                             maps.below(x, y)});
                    if (x > 0 && y > 0)
                        add(0, 4, 2,
                            {maps.here(x - 1, y - 1), maps.here(x, y - 1), maps.here(x, y),
                             maps.here(x - 1, y)});
                }
                ++vertex;
            });
        }
    });
    std::size_t count = 0;
    for (const auto& own : faces) count += own.size();
    net.faces.reserve(count);
    for (auto& own : faces) {
        net.faces.insert(net.faces.end(), own.begin(), own.end());
        own = {};
    }
    return net;
}

namespace {

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

/// Two labels that touch, and what their faces have together.
struct Interface {
    std::uint16_t below, above;
    double area = 0;
    double shift = 0;  // by which its faces are to move, from `below` to `above`
};

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
        std::vector<double> missing(std::size_t{LabelVoxels::kBeyond} + 1);
        std::map<std::pair<std::uint16_t, std::uint16_t>, Interface> interfaces;
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
            const auto [low, high] = std::minmax(face.below, face.above);
            Interface& at = interfaces[{low, high}];
            at.below = low;
            at.above = high;
            at.area += length(area);
        }
        // The least movement that does so is a potential of the labels: that of the background is
        // 0.
        std::vector<double> potential(missing.size()), flow(missing.size()), weight(missing.size());
        for (const auto& [labels, i] : interfaces) {
            weight[i.below] += i.area;
            weight[i.above] += i.area;
        }
        for (int sweep = 0; sweep < kSweeps; ++sweep) {
            flow = missing;
            for (const auto& [labels, i] : interfaces) {
                flow[i.below] += i.area * potential[i.above];
                flow[i.above] += i.area * potential[i.below];
            }
            for (std::size_t l = 1; l < flow.size(); ++l)
                if (weight[l] > 0) potential[l] = flow[l] / weight[l];
        }
        std::vector<Vec<3>> shift(net.vertices.size());
        std::vector<float> areas(net.vertices.size());
        for (const SurfaceNet::Face& face : net.faces) {
            const Vec<3> area = areaOf(net, face);
            const double by = face.below == kBeyond || face.above == kBeyond
                                  ? 0
                                  : potential[face.below] - potential[face.above];
            for (const std::uint32_t v : face.vertices) {
                shift[v] += by * area;
                areas[v] += static_cast<float>(length(area));
            }
        }
        forEachVertex(net, [&](std::size_t v) {
            if (areas[v] > 0)
                net.vertices[v] =
                    inCell(net, size, v,
                           net.vertices[v] + shift[v] * (1.0 / static_cast<double>(areas[v])));
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
                        if (!isFace(a, b)) continue;
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

namespace {

/// One side of a face.
struct Side {
    std::uint64_t edge;                       // its lower vertex and the axis along which it lies
    std::uint64_t insideVoxel, outsideVoxel;  // of the face
    std::uint32_t face;
    std::uint32_t corner;  // where the side begins
};

/// Corners of faces that belong to the same vertex of the result.
class CornerSets {
public:
    explicit CornerSets(std::size_t count) : parent_(count) {
        std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
    }
    std::uint32_t find(std::uint32_t c) {
        while (parent_[c] != c) c = parent_[c] = parent_[parent_[c]];
        return c;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

private:
    std::vector<std::uint32_t> parent_;
};

/// Joins the corners of faces that go on into one another.
///
/// Where two voxels inside meet at an edge alone, four faces do. Those of each voxel inside go on
/// into one another, so that the surfaces of both touch there and do not cross; but if the faces
/// are joined at both ends of the edge by others, those of each voxel outside do.
/// @param sides  of all faces, those of an edge together, sorted by the voxels inside.
CornerSets joinedCorners(const SurfaceNet& net, const std::vector<std::uint32_t>& faces,
                         const std::vector<Side>& sides) {
    const auto vertexAt = [&](const Side& side, std::uint32_t end) {
        return net.faces[faces[side.face]].vertices[(side.corner + end) % 4];
    };
    const auto cornerAt = [&](const Side& side, std::uint32_t vertex) {
        return 4 * side.face + (vertexAt(side, 0) == vertex ? side.corner : (side.corner + 1) % 4);
    };
    const auto endOf = [&](std::size_t s) {
        std::size_t end = s + 1;
        while (end < sides.size() && sides[end].edge == sides[s].edge) ++end;
        return end;
    };
    std::set<std::uint64_t> byOutside;  // edges
    for (;;) {
        CornerSets corners(4 * faces.size());
        const auto join = [&](const Side& a, const Side& b) {
            for (std::uint32_t end = 0; end < 2; ++end) {
                const std::uint32_t vertex = vertexAt(a, end);
                corners.join(cornerAt(a, vertex), cornerAt(b, vertex));
            }
        };
        for (std::size_t s = 0, end = 0; s < sides.size(); s = end) {
            end = endOf(s);
            if (end - s == 4 && byOutside.count(sides[s].edge)) {
                const bool same = sides[s].outsideVoxel == sides[s + 2].outsideVoxel;
                join(sides[s], sides[same ? s + 2 : s + 3]);
                join(sides[s + 1], sides[same ? s + 3 : s + 2]);
            } else {
                for (std::size_t k = s; k + 1 < end; k += 2) join(sides[k], sides[k + 1]);
            }
        }
        const std::size_t before = byOutside.size();
        for (std::size_t s = 0, end = 0; s < sides.size(); s = end) {
            end = endOf(s);
            if (end - s != 4) continue;
            bool joined = true;
            for (std::uint32_t e = 0; e < 2; ++e) {
                const std::uint32_t vertex = vertexAt(sides[s], e);
                joined = joined &&
                         corners.find(cornerAt(sides[s], vertex)) ==
                             corners.find(cornerAt(sides[s + 2], vertex)) &&
                         corners.find(cornerAt(sides[s], vertex)) ==
                             corners.find(cornerAt(sides[s + 3], vertex));
            }
            if (joined) byOutside.insert(sides[s].edge);
        }
        if (byOutside.size() == before) return corners;
    }
}

}  // namespace

TriangleMesh surfaceOf(const SurfaceNet& net, const ImageGrid& grid,
                       const std::function<bool(std::uint16_t)>& inside) {
    std::vector<std::uint32_t> faces;
    for (std::size_t f = 0; f < net.faces.size(); ++f)
        if (inside(net.faces[f].below) != inside(net.faces[f].above))
            faces.push_back(static_cast<std::uint32_t>(f));
    if (faces.size() >= kNone / 4)
        throw ResourceError(
            "the surface of a label has more than 1,000,000,000 faces; give a "
            "coarser image");
    std::vector<Side> sides(4 * faces.size());
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, faces.size(), 4096), [&](const auto& block) {
            for (std::size_t f = block.begin(); f < block.end(); ++f) {
                const SurfaceNet::Face& face = net.faces[faces[f]];
                auto voxel = net.cells[face.vertices[0]];  // counted from 1
                for (std::size_t d = 0; d < 3; ++d)
                    if (d != face.axis) ++voxel[d];
                const auto number = [](const std::array<std::uint16_t, 3>& v) {
                    return static_cast<std::uint64_t>(v[0]) |
                           static_cast<std::uint64_t>(v[1]) << 16 |
                           static_cast<std::uint64_t>(v[2]) << 32;
                };
                std::uint64_t in = number(voxel);
                ++voxel[face.axis];
                std::uint64_t out = number(voxel);
                if (!inside(face.below)) std::swap(in, out);
                for (std::uint32_t k = 0; k < 4; ++k) {
                    const std::uint32_t a = face.vertices[k], b = face.vertices[(k + 1) % 4];
                    std::uint64_t axis = 0;
                    while (net.cells[a][axis] == net.cells[b][axis]) ++axis;
                    // Vertices are numbered by cells in this order.
                    sides[4 * f + k] = {static_cast<std::uint64_t>(std::min(a, b)) * 3 + axis, in,
                                        out, static_cast<std::uint32_t>(f), k};
                }
            }
        });
    tbb::parallel_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::tie(a.edge, a.insideVoxel, a.face) < std::tie(b.edge, b.insideVoxel, b.face);
    });
    CornerSets corners = joinedCorners(net, faces, sides);
    sides = {};
    TriangleMesh mesh;
    std::vector<std::uint32_t> number(4 * faces.size(), kNone);
    mesh.triangles.resize(2 * faces.size());
    const bool mirrored = grid.signedVoxelVolume() < 0;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const SurfaceNet::Face& face = net.faces[faces[f]];
        std::array<std::uint32_t, 4> q;
        for (std::uint32_t k = 0; k < 4; ++k) {
            const std::uint32_t root = corners.find(static_cast<std::uint32_t>(4 * f) + k);
            if (number[root] == kNone) {
                number[root] = static_cast<std::uint32_t>(mesh.vertices.size());
                mesh.vertices.push_back(grid.at(net.vertices[face.vertices[k]]));
            }
            q[k] = number[root];
        }
        // The shorter diagonal, the same for both labels.
        const auto& v = mesh.vertices;
        const bool other = squaredLength(v[q[1]] - v[q[3]]) < squaredLength(v[q[0]] - v[q[2]]);
        std::array<std::array<std::uint32_t, 3>, 2> pair{{{q[0], q[1], q[2]}, {q[0], q[2], q[3]}}};
        if (other) pair = {{{q[0], q[1], q[3]}, {q[1], q[2], q[3]}}};
        for (auto& triangle : pair)
            if (inside(face.below) == mirrored) std::swap(triangle[1], triangle[2]);
        mesh.triangles[2 * f] = pair[0];
        mesh.triangles[2 * f + 1] = pair[1];
    }
    return mesh;
}

}  // namespace vdbpack
