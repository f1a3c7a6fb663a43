// Where the vertices of a surface net lie.
#include "vdbpack/core/parallel.h"
#include "vdbpack/image/surface_net.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace vdbpack {

namespace {

/// Across the sides of a cell to -x, +x, -y, +y, -z, +z.
using Neighbors = std::array<std::uint32_t, 6>;
/// Such as the way from the middle of a cell to its vertex, along the axes; then the fourth number
/// is 0.
using Float4 [[gnu::vector_size(16)]] = float;

/// Which vertices bend a surface together.
struct Links {
    std::vector<Neighbors> to;        ///< the vertex itself where there is none
    std::vector<std::uint8_t> sides;  ///< bits 0 to 5 are set where there is one
};

/// Those that share a side of their cells where a surface crosses it; along a line of three labels,
/// those of the line.
Links linksOf(const SurfaceNet& net) {
    Links links;
    links.to.resize(net.vertices.size());
    links.sides.resize(net.vertices.size());
    for (std::size_t v = 0; v < links.to.size(); ++v)
        links.to[v].fill(static_cast<std::uint32_t>(v));
    const auto link = [&](std::uint32_t from, std::uint32_t to, std::size_t side) {
        if (net.junctions[from] && !(net.junctions[from] >> side & 1)) return;
        links.to[from][side] = to;
        links.sides[from] = static_cast<std::uint8_t>(links.sides[from] | 1u << side);
    };
    for (const SurfaceNet::Face& face : net.faces)
        for (std::size_t k = 0; k < 4; ++k) {
            const std::uint32_t a = face.vertices[k], b = face.vertices[(k + 1) % 4];
            for (std::size_t d = 0; d < 3; ++d) {
                if (net.cells[a][d] == net.cells[b][d]) continue;
                const bool up = net.cells[a][d] < net.cells[b][d];
                link(a, b, 2 * d + (up ? 1 : 0));
                link(b, a, 2 * d + (up ? 0 : 1));
            }
        }
    return links;
}

/// How far a vertex may move from the middle of its cell: not to its sides, so that no voxel
/// vanishes.
constexpr float kReach = 0.48f;

/// The same along an axis: not at all across the border of the image.
float reachOf(const SurfaceNet& net, const std::array<std::size_t, 3>& size, std::size_t v,
              std::size_t axis) {
    const std::uint16_t cell = net.cells[v][axis];
    return cell == 0 || cell == size[axis] ? 0 : kReach;
}

/// The nearest point that a vertex may have.
Vec<3> inCell(const SurfaceNet& net, const std::array<std::size_t, 3>& size, std::size_t v,
              Vec<3> x) {
    for (std::size_t d = 0; d < 3; ++d) {
        const double middle = static_cast<double>(net.cells[v][d]) - 0.5;
        const double reach = static_cast<double>(reachOf(net, size, v, d));
        x.c[d] = std::clamp(x.c[d], middle - reach, middle + reach);
    }
    return x;
}

template <class Work>
void forEachVertex(const SurfaceNet& net, const Work& work) {
    parallelFor(IndexRange(0, net.vertices.size(), 4096), [&](const IndexRange& block) {
        for (std::size_t v = block.begin(); v < block.end(); ++v) work(v);
    });
}

/// Computes how far vertices lie from the means of those that they are linked to.
class OffMean {
public:
    explicit OffMean(const Links& links) : links_(links) {
        for (unsigned sides = 0; sides < rules_.size(); ++sides) {
            Rule& rule = rules_[sides];
            int count = 0;
            for (unsigned side = 0; side < 6; ++side) {
                if (!(sides >> side & 1)) continue;
                rule.toCells[side / 2] += side % 2 ? 1.0f : -1.0f;
                ++count;
            }
            // A line of three labels may end, or be that of a single voxel.
            rule.share = count >= 2 ? 1 / static_cast<float>(count) : 0;
        }
    }

    /// @param offsets  of vertices from the middles of their cells.
    Float4 ofOffsets(const std::vector<Float4>& offsets, std::size_t v) const {
        const Rule& rule = rules_[links_.sides[v]];
        return rule.share * (sixfold(offsets, v) - rule.toCells);
    }

    /// @param values  any numbers.
    Float4 ofValues(const std::vector<Float4>& values, std::size_t v) const {
        return rules_[links_.sides[v]].share * sixfold(values, v);
    }

private:
    struct Rule {
        float share = 0;   // of each neighbor
        Float4 toCells{};  // sum of the ways to the cells of the neighbors
    };

    Float4 sixfold(const std::vector<Float4>& x, std::size_t v) const {
        const Neighbors& to = links_.to[v];
        return 6.0f * x[v] - (x[to[0]] + x[to[1]] + x[to[2]] + x[to[3]] + x[to[4]] + x[to[5]]);
    }

    const Links& links_;
    std::array<Rule, 64> rules_;
};

/// What a vertex resists.
struct Stiffness {
    float bend = 1;      ///< how much the square of its distance from its neighbors' mean counts
    float pull = 0;      ///< how much that of its distance from the middle of its cell does
    float step = 0.25f;  ///< of a descent; at most the inverse of the largest eigenvalue there
};

/// Which vertices have moved since `before`, or lie up to two links from those, which change their
/// slopes.
std::vector<std::uint8_t> movingVertices(const SurfaceNet& net, const Links& links,
                                         const std::vector<Float4>& offsets,
                                         const std::vector<Float4>& before) {
    constexpr float kStill = 0.005f;
    std::vector<std::uint8_t> moves(offsets.size()), near;
    forEachVertex(net, [&](std::size_t v) {
        const Float4 by = offsets[v] - before[v];
        moves[v] = by[0] * by[0] + by[1] * by[1] + by[2] * by[2] > kStill * kStill;
    });
    for (int ring = 0; ring < 2; ++ring) {
        near = moves;
        forEachVertex(net, [&](std::size_t v) {
            for (const std::uint32_t to : links.to[v])
                if (moves[to]) near[v] = 1;
        });
        moves.swap(near);
    }
    return moves;
}

/// Minimizes the energy of `stiffness` by the accelerated steps of Beck and Teboulle (2009), "A
/// fast iterative shrinkage-thresholding algorithm", doi:10.1137/080716542, from the middles of the
/// cells. Wide flat parts take the most rounds; what rests is left out of them.
void relax(SurfaceNet& net, const std::array<std::size_t, 3>& size, const Links& links,
           const std::vector<Stiffness>& stiffness, int rounds) {
    constexpr int kRoundsBetweenChecks = 40;
    const OffMean offMean(links);
    const std::size_t count = net.vertices.size();
    std::vector<Float4> offsets(count), ahead(count), apart(count), before(count);
    std::vector<std::uint32_t> moving(count);
    std::iota(moving.begin(), moving.end(), 0u);
    const auto forEachMoving = [&](const auto& work) {
        parallelFor(IndexRange(0, moving.size(), 4096), [&](const IndexRange& block) {
            for (std::size_t i = block.begin(); i < block.end(); ++i) work(moving[i]);
        });
    };
    const auto setApart = [&](std::size_t v) {
        apart[v] = stiffness[v].bend * offMean.ofOffsets(ahead, v);
    };
    double t = 1;
    for (int round = 0; round < rounds && !moving.empty(); ++round) {
        if (round > 0 && round % kRoundsBetweenChecks == 0) {
            const std::vector<std::uint8_t> moves = movingVertices(net, links, offsets, before);
            moving.clear();
            for (std::size_t v = 0; v < count; ++v)
                if (moves[v])
                    moving.push_back(static_cast<std::uint32_t>(v));
                else
                    ahead[v] = offsets[v];
            forEachVertex(net, setApart);
            before = offsets;
        }
        forEachMoving(setApart);
        const double next = (1 + std::sqrt(1 + 4 * t * t)) / 2;
        const auto beyond = static_cast<float>((t - 1) / next);
        t = next;
        forEachMoving([&](std::size_t v) {
            const Stiffness& s = stiffness[v];
            const Float4 slope = offMean.ofValues(apart, v) + s.pull * ahead[v];
            const Float4 reach = {reachOf(net, size, v, 0), reachOf(net, size, v, 1),
                                  reachOf(net, size, v, 2), 0};
            Float4 x = ahead[v] - s.step * slope;
            x = x > reach ? reach : x;
            x = x < -reach ? -reach : x;
            ahead[v] = x + beyond * (x - offsets[v]);
            offsets[v] = x;
        });
    }
    forEachVertex(net, [&](std::size_t v) {
        for (int d = 0; d < 3; ++d)
            net.vertices[v][d] = static_cast<double>(net.cells[v][static_cast<std::size_t>(d)]) -
                                 0.5 + static_cast<double>(offsets[v][d]);
    });
}

/// The area of a face as a vector from the voxel below to that above.
Vec<3> areaOf(const SurfaceNet& net, const SurfaceNet::Face& face) {
    const auto at = [&](std::size_t k) { return net.vertices[face.vertices[k]]; };
    return 0.5 * cross(at(2) - at(0), at(3) - at(1));
}

/// The normals of the vertices, of length 1; their fourth number is 1. On lines of three labels, 0.
std::vector<Float4> normalsOf(const SurfaceNet& net) {
    std::vector<Float4> normals(net.vertices.size());
    for (const SurfaceNet::Face& face : net.faces) {
        const Vec<3> area = (face.below < face.above ? 1.0 : -1.0) * areaOf(net, face);
        const Float4 a = {static_cast<float>(area[0]), static_cast<float>(area[1]),
                          static_cast<float>(area[2]), 0};
        for (const std::uint32_t v : face.vertices) normals[v] += a;
    }
    forEachVertex(net, [&](std::size_t v) {
        Float4& n = normals[v];
        const float size = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        n = net.junctions[v] || size == 0 ? Float4{} : n * (1 / size);
        if (!net.junctions[v]) n[3] = 1;
    });
    return normals;
}

/// Normals become means over some two vertices to each side.
constexpr int kBlurRounds = 8;

/// How much the normals around each vertex differ: 1 less the length of their mean.
std::vector<float> spreadOfNormals(const SurfaceNet& net, const Links& links) {
    std::vector<Float4> normals = normalsOf(net), means(normals.size());
    for (int round = 0; round < kBlurRounds; ++round) {
        forEachVertex(net, [&](std::size_t v) {
            const Neighbors& to = links.to[v];
            means[v] = (1.0f / 6) * (normals[to[0]] + normals[to[1]] + normals[to[2]] +
                                     normals[to[3]] + normals[to[4]] + normals[to[5]]);
        });
        normals.swap(means);
    }
    std::vector<float> spread(normals.size());
    forEachVertex(net, [&](std::size_t v) {
        const Float4 n = normals[v];
        if (n[3] > 0) spread[v] = 1 - std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / n[3];
    });
    return spread;
}

/// What a vertex resists where normals differ that much.
///
/// At sharp edges the bending counts little, as at the creases of Blake and Zisserman (1987),
/// "Visual Reconstruction", MIT Press. Else the edges, rounded within their cells, would tilt the
/// sides, and these would bulge.
///
/// A surface of a larger radius is bent less: the bending flattens curved ones as far as the cells
/// allow, by a force that grows with the cube of the curvature. The pull stops that. It is weak
/// where the curvature is low, so that steps far apart vanish, but not zero: on top of a wide
/// terrace, nothing else holds the surface where the voxels do on average.
Stiffness stiffnessAt(float spread) {
    /// Half of the bending counts there: 0.02 for a radius of ten voxels, 0.2 for a right angle.
    constexpr float kEdge = 0.036f;
    constexpr float kLeastBend = 0.05f, kNoise = 0.005f, kPull = 0.75f, kLeastPull = 8e-5f,
                    kMostPull = 0.02f;
    Stiffness s;
    const float sharp = spread / kEdge;
    s.bend = std::max(kLeastBend, 1 / (1 + sharp * sharp * sharp));
    // A round of blur has a variance of 1/3 along each axis of the surface.
    const float curvature = std::sqrt(std::max(0.0f, spread - kNoise) * (6.0f / kBlurRounds));
    s.pull = s.bend * std::clamp(kPull * curvature * curvature * curvature, kLeastPull, kMostPull);
    return s;
}

std::vector<Stiffness> stiffnessOf(const SurfaceNet& net, const Links& links) {
    // Lines of three labels have corners as well. The pull bends them near those alone, and they
    // bend the surfaces beside them less.
    Stiffness line;
    line.bend = 0.2f;
    line.pull = 0.01f * line.bend;
    const std::vector<float> spread = spreadOfNormals(net, links);
    std::vector<Stiffness> all(spread.size());
    forEachVertex(
        net, [&](std::size_t v) { all[v] = net.junctions[v] ? line : stiffnessAt(spread[v]); });
    // (a + b)^2 <= 2 a^2 + 2 b^2 for a vertex and the mean of its neighbors.
    forEachVertex(net, [&](std::size_t v) {
        float most = all[v].bend;
        for (const std::uint32_t to : links.to[v]) most = std::max(most, all[to].bend);
        all[v].step = 1 / (4 * most + all[v].pull);
    });
    return all;
}

/// Makes the surfaces less bent, but for their edges.
void straighten(SurfaceNet& net, const std::array<std::size_t, 3>& size) {
    /// The first ones show where edges are; the last ones flatten steps that lie up to some thirty
    /// voxels apart.
    constexpr int kFirstRounds = 16, kRounds = 720;
    const Links links = linksOf(net);
    relax(net, size, links, std::vector<Stiffness>(net.vertices.size()), kFirstRounds);
    relax(net, size, links, stiffnessOf(net, links), kRounds);
}

using LabelPair = std::pair<std::uint16_t, std::uint16_t>;

struct Volumes {
    std::vector<double> voxels, missing;  ///< of labels: theirs, and what surfaces lack of them
    std::map<LabelPair, double> areas;    ///< of labels that touch

    bool areRight() const {
        bool right = true;
        for (std::size_t l = 1; l < voxels.size(); ++l)
            right = right && std::fabs(missing[l]) <= 0.005 * voxels[l];
        return right;
    }
};

Volumes volumesOf(const SurfaceNet& net) {
    std::size_t labels = 1;
    for (const SurfaceNet::Face& face : net.faces)
        for (const std::uint16_t label : {face.below, face.above})
            if (label != LabelVoxels::kBeyond) labels = std::max(labels, std::size_t{label} + 1);
    Volumes volumes;
    volumes.voxels.resize(labels);
    volumes.missing.resize(labels);
    for (const SurfaceNet::Face& face : net.faces) {
        const Vec<3> area = areaOf(net, face);
        Vec<3> middle;
        for (const std::uint32_t v : face.vertices) middle += 0.25 * net.vertices[v];
        // The voxels of a label, counted along rows: from face to face.
        const double voxels =
            face.axis == 0 ? static_cast<double>(net.cells[face.vertices[0]][0]) - 0.5 : 0;
        double missing = -dot(middle, area) / 3;
        missing += voxels;
        if (face.below != LabelVoxels::kBeyond) {
            volumes.voxels[face.below] += voxels;
            volumes.missing[face.below] += missing;
        }
        if (face.above != LabelVoxels::kBeyond) {
            volumes.voxels[face.above] -= voxels;
            volumes.missing[face.above] -= missing;
        }
        if (face.below == LabelVoxels::kBeyond || face.above == LabelVoxels::kBeyond) continue;
        volumes.areas[std::minmax(face.below, face.above)] += length(area);
    }
    return volumes;
}

/// Moves the faces between two labels, all of them as far, so that each label has the volume of its
/// voxels again. Where parts are as thin as a voxel, that takes more rounds.
void restoreVolumes(SurfaceNet& net, const std::array<std::size_t, 3>& size) {
    constexpr int kRounds = 3, kMostRounds = 30, kSweeps = 200;
    constexpr std::size_t kManyPairs = 50'000;  // of grey values rather than labels
    for (int round = 0; round < kMostRounds; ++round) {
        const Volumes volumes = volumesOf(net);
        const std::vector<std::pair<LabelPair, double>> areas(volumes.areas.begin(),
                                                              volumes.areas.end());
        if (round >= kRounds && (volumes.areRight() || areas.size() > kManyPairs)) break;
        // The least movement that does so is a potential of the labels; that of the background is
        // 0.
        std::vector<double> potential(volumes.missing.size()), flow, weight(potential.size());
        for (const auto& [pair, area] : areas) {
            weight[pair.first] += area;
            weight[pair.second] += area;
        }
        for (int sweep = 0; sweep < kSweeps; ++sweep) {
            flow = volumes.missing;
            for (const auto& [pair, area] : areas) {
                flow[pair.first] += area * potential[pair.second];
                flow[pair.second] += area * potential[pair.first];
            }
            for (std::size_t l = 1; l < flow.size(); ++l)
                if (weight[l] > 0) potential[l] = flow[l] / weight[l];
        }
        std::vector<Vec<3>> shift(net.vertices.size());
        std::vector<double> around(net.vertices.size());
        for (const SurfaceNet::Face& face : net.faces) {
            const Vec<3> area = areaOf(net, face);
            const double by =
                face.below == LabelVoxels::kBeyond || face.above == LabelVoxels::kBeyond
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

}  // namespace vdbpack
