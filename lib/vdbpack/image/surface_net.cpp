#include "vdbpack/image/surface_net.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"

#include <algorithm>
#include <limits>
#include <numeric>

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

void addVertex(SurfaceNet& net, std::uint32_t vertex, const std::array<std::size_t, 3>& cell,
               const Corners& c) {
    for (std::size_t d = 0; d < 3; ++d) {
        net.cells[vertex][d] = static_cast<std::uint16_t>(cell[d]);
        net.vertices[vertex].c[d] = static_cast<double>(cell[d]) - 0.5;
    }
    net.junctions[vertex] = junctionsOf(c);
}

/// Adds the faces whose four cells are this one and those before it.
void addFaces(const SliceMaps& maps, const std::array<std::size_t, 3>& cell, const Corners& c,
              std::vector<SurfaceNet::Face>& faces) {
    const auto [x, y, z] = cell;
    const auto add = [&](std::size_t high, std::uint8_t axis, std::array<std::uint32_t, 4> around) {
        if (SurfaceNet::isFace(c[0], c[high])) faces.push_back({around, c[0], c[high], axis});
    };
    if (y > 0 && z > 0)
        add(1, 0, {maps.below(x, y - 1), maps.below(x, y), maps.here(x, y), maps.here(x, y - 1)});
    if (x > 0 && z > 0)
        add(2, 1, {maps.below(x - 1, y), maps.here(x - 1, y), maps.here(x, y), maps.below(x, y)});
    if (x > 0 && y > 0)
        add(4, 2,
            {maps.here(x - 1, y - 1), maps.here(x, y - 1), maps.here(x, y), maps.here(x - 1, y)});
}

}  // namespace

SurfaceNet surfaceNet(const LabelVoxels& voxels) {
    const auto& size = voxels.size;
    const PaddedRows rows(voxels);
    const std::size_t slices = size[2] + 1;
    // Vertices are numbered slice by slice.
    std::vector<std::size_t> first(slices + 1);
    parallelFor(std::size_t{0}, slices, [&](std::size_t z) {
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
    parallelFor(std::size_t{0}, tasks, [&](std::size_t task) {
        SliceMaps maps(size[0] + 1, (size[0] + 1) * (size[1] + 1));
        const std::size_t begin = task * kSlices, end = std::min(slices, begin + kSlices);
        auto& own = faces[task];
        for (std::size_t z = begin > 0 ? begin - 1 : 0; z < end; ++z) {
            maps.next();
            auto vertex = static_cast<std::uint32_t>(first[z]);
            forEachCell(voxels, rows, z, [&](std::size_t x, std::size_t y, const Corners& c) {
                maps.set(x, y, vertex);
                if (z >= begin) {
                    addVertex(net, vertex, {x, y, z}, c);
                    addFaces(maps, {x, y, z}, c, own);
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

void interpolate(SurfaceNet& net, const LabelVoxels& voxels,
                 const std::function<double(std::size_t, std::size_t)>& shareOf) {
    const auto& size = voxels.size;
    const std::size_t stride[3] = {1, size[0], size[0] * size[1]};
    parallelFor(IndexRange(0, net.vertices.size(), 1024), [&](const auto& block) {
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
