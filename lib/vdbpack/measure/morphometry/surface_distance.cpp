#include "vdbpack/measure/morphometry/surface_distance.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/measure/morphometry/labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace vdbpack {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr float kFar = std::numeric_limits<float>::infinity();

struct Lattice {
    explicit Lattice(const VoxelImage& image)
        : size{static_cast<std::size_t>(image.size[0]), static_cast<std::size_t>(image.size[1]),
               static_cast<std::size_t>(image.size[2])},
          stride{1, size[0], size[0] * size[1]} {}
    std::array<std::size_t, 3> size, stride;
};

/// Finds the points and their properties, slice by slice.
class Crossings {
public:
    explicit Crossings(const VoxelImage& image) : image_(image), lattice_(image) {}

    /// Calls `visit(voxel, x, y, z)` for each edge from a voxel of slice `z` along `axis` at which
    /// the solid begins or ends.
    template <class Visit>
    void forEachInSlice(std::size_t axis, std::size_t z, const Visit& visit) const {
        const auto& n = lattice_.size;
        if (axis == 2 && z + 1 >= n[2]) return;
        const std::size_t nx = n[0] - (axis == 0 ? 1 : 0);
        const std::size_t ny = n[1] - (axis == 1 ? 1 : 0);
        const float* d = image_.distance.data();
        const std::size_t step = lattice_.stride[axis];
        for (std::size_t y = 0; y < ny; ++y) {
            const std::size_t row = z * lattice_.stride[2] + y * lattice_.stride[1];
            for (std::size_t x = 0; x < nx; ++x)
                if ((d[row + x] < 0) != (d[row + x + step] < 0)) visit(row + x, x, y, z);
        }
    }

    SurfacePoint point(std::size_t axis, std::size_t voxel, std::size_t x, std::size_t y,
                       std::size_t z) const {
        const float* d = image_.distance.data();
        const std::size_t other = voxel + lattice_.stride[axis];
        const float a = d[voxel], b = d[other];
        const std::array<std::size_t, 3> at{x, y, z};
        const float t = root(voxel, at[axis], axis);
        SurfacePoint p;
        p.axis = static_cast<std::uint8_t>(axis);
        p.at = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
        double square = 0;
        std::array<double, 3> g{};
        for (std::size_t j = 0; j < 3; ++j) {
            g[j] = j == axis ? double{b} - double{a}
                             : (1 - double{t}) * slope(voxel, at[j], j) +
                                   double{t} * slope(other, at[j], j);
            square += g[j] * g[j];
        }
        p.at[axis] += t;
        const double inverse = 1 / std::sqrt(square);  // g[axis] is never 0
        double sum = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            p.normal[j] = static_cast<float>(g[j] * inverse);
            sum += std::abs(double{p.normal[j]});
        }
        p.label = static_cast<std::uint8_t>(labelOf(image_, a < 0 ? voxel : other));
        if (p.label != 0) p.area = static_cast<float>(1 / sum);
        return p;
    }

    /// By label, twice the number of edges along each axis in a slice, where each voxel counts half
    /// of an edge.
    std::vector<std::array<std::size_t, 3>> extents(std::size_t z, std::size_t labels) const {
        const auto& n = lattice_.size;
        std::vector<std::array<std::size_t, 3>> count(labels);
        for (std::size_t y = 0; y < n[1]; ++y)
            for (std::size_t x = 0; x < n[0]; ++x) {
                const std::size_t voxel = z * lattice_.stride[2] + y * lattice_.stride[1] + x;
                auto& own = count[static_cast<std::size_t>(labelOf(image_, voxel))];
                const std::array<std::size_t, 3> at{x, y, z};
                for (std::size_t j = 0; j < 3; ++j)
                    own[j] += std::size_t{at[j] > 0} + std::size_t{at[j] + 1 < n[j]};
            }
        return count;
    }

private:
    /// Position between a voxel (0) and the next one along an axis (1) where the distance vanishes.
    /// Curvature is corrected for: linear interpolation alone is wrong by up to an eighth of it.
    float root(std::size_t voxel, std::size_t at, std::size_t axis) const {
        const float* d = image_.distance.data() + voxel;
        const std::size_t step = lattice_.stride[axis];
        const float a = d[0], b = d[step];
        const float t = a / (a - b);
        if (at == 0 || at + 2 >= lattice_.size[axis]) return t;
        const float bend =
            boundedBend(*(d - step), a, b, d[2 * step], static_cast<float>(image_.voxelSize));
        const float shift = 0.5f * t * (1 - t) * bend / (b - a);
        return std::clamp(t + std::clamp(shift, -0.25f, 0.25f), 0.0f, 1.0f);
    }

    /// Central difference of the distances at a voxel along one axis; one-sided at the border.
    double slope(std::size_t voxel, std::size_t at, std::size_t axis) const {
        const float* d = image_.distance.data();
        const std::size_t step = lattice_.stride[axis];
        const bool low = at > 0, high = at + 1 < lattice_.size[axis];
        const double difference =
            double{d[high ? voxel + step : voxel]} - double{d[low ? voxel - step : voxel]};
        return low && high ? difference * 0.5 : difference;
    }

    const VoxelImage& image_;
    Lattice lattice_;
};

/// One line of squared distances and the points they belong to.
class Line {
public:
    explicit Line(std::size_t n)
        : square(n), index(n), vertex_(n), from_(n), out_(n), outIndex_(n) {}

    /// On entry, `index[i]` is the point between positions i and i + 1; on return, the point
    /// nearest to position i.
    void nearestOnLine(const std::vector<SurfacePoint>& points, std::size_t axis) {
        const std::size_t n = index.size();
        std::fill(square.begin(), square.end(), kFar);
        std::uint32_t last = kNone;
        float at = 0;
        for (std::size_t i = 0; i < n; ++i) {
            if (last != kNone) {
                square[i] = (static_cast<float>(i) - at) * (static_cast<float>(i) - at);
                outIndex_[i] = last;
            } else {
                outIndex_[i] = kNone;
            }
            if (index[i] != kNone) {
                last = index[i];
                at = points[last].at[axis];
            }
        }
        last = kNone;
        for (std::size_t i = n; i-- > 0;) {
            if (index[i] != kNone) {
                last = index[i];
                at = points[last].at[axis];
            }
            const float s = (static_cast<float>(i) - at) * (static_cast<float>(i) - at);
            if (last != kNone && s < square[i]) {
                square[i] = s;
                outIndex_[i] = last;
            }
        }
        index.swap(outIndex_);
    }

    /// The lower envelope of the parabolas with vertices at the positions of the line.
    void envelope() {
        const std::size_t n = index.size();
        std::size_t count = 0;
        for (std::size_t q = 0; q < n; ++q) {
            const float height = square[q];
            if (height == kFar) continue;
            float meet = -kFar;
            while (count > 0) {
                const std::size_t v = vertex_[count - 1];
                meet = 0.5f * ((height - square[v]) / static_cast<float>(q - v) +
                               static_cast<float>(q + v));
                if (meet > from_[count - 1]) break;
                --count;
                meet = -kFar;
            }
            vertex_[count] = static_cast<std::uint32_t>(q);
            from_[count] = meet;
            ++count;
        }
        if (count == 0) return;
        std::size_t k = 0;
        for (std::size_t q = 0; q < n; ++q) {
            while (k + 1 < count && from_[k + 1] < static_cast<float>(q)) ++k;
            const std::size_t v = vertex_[k];
            const float away = static_cast<float>(q) - static_cast<float>(v);
            out_[q] = square[v] + away * away;
            outIndex_[q] = index[v];
        }
        square.swap(out_);
        index.swap(outIndex_);
    }

    std::vector<float> square;
    std::vector<std::uint32_t> index;

private:
    std::vector<std::uint32_t> vertex_;
    std::vector<float> from_, out_;
    std::vector<std::uint32_t> outIndex_;
};

/// Runs `work(line)` for all lines along `axis`, between `load` and `store` of its voxels. Sixteen
/// neighboring lines are processed together, since their values share cache lines.
template <class Load, class Work, class Store>
void forEachLine(const Lattice& lattice, std::size_t axis, const Load& load, const Work& work,
                 const Store& store) {
    constexpr std::size_t kTogether = 16;
    const std::size_t across = axis == 2 ? 1 : 2;  // the axis of the outer loop
    const std::size_t inner = axis == 0 ? 1 : 0;   // neighbors in memory, for axes 1 and 2
    const std::size_t n = lattice.size[axis];
    parallelFor(IndexRange(0, lattice.size[across]), [&](const IndexRange& range) {
        std::vector<Line> lines(kTogether, Line(n));
        for (std::size_t s = range.begin(); s != range.end(); ++s)
            for (std::size_t first = 0; first < lattice.size[inner]; first += kTogether) {
                const std::size_t together = std::min(kTogether, lattice.size[inner] - first);
                const std::size_t base = s * lattice.stride[across] + first * lattice.stride[inner];
                for (std::size_t i = 0; i < n; ++i)
                    for (std::size_t k = 0; k < together; ++k)
                        load(lines[k], i,
                             base + k * lattice.stride[inner] + i * lattice.stride[axis]);
                for (std::size_t k = 0; k < together; ++k) work(lines[k]);
                for (std::size_t i = 0; i < n; ++i)
                    for (std::size_t k = 0; k < together; ++k)
                        store(lines[k], i,
                              base + k * lattice.stride[inner] + i * lattice.stride[axis]);
            }
    });
}

/// Finds the nearest of the points on edges along one axis, and keeps it where it is nearer than
/// those of other axes.
class NearestPoints {
public:
    NearestPoints(const VoxelImage& image, const Lattice& lattice, SurfaceDistance& result)
        : lattice_(lattice),
          result_(result),
          square_(image.voxels()),
          best_(image.voxels(), kFar),
          index_(image.voxels()) {
        result.nearest.assign(image.voxels(), kNone);
    }

    /// @param start  the first point of each slice.
    void addAxis(const Crossings& crossings, std::size_t axis,
                 const std::vector<std::size_t>& start) {
        parallelFor(std::size_t{0}, lattice_.size[2], [&](std::size_t z) {
            std::fill_n(index_.begin() + static_cast<std::ptrdiff_t>(z * lattice_.stride[2]),
                        lattice_.stride[2], kNone);
            std::size_t next = start[z];
            crossings.forEachInSlice(
                axis, z, [&](std::size_t voxel, std::size_t x, std::size_t y, std::size_t zz) {
                    result_.points[next] = crossings.point(axis, voxel, x, y, zz);
                    index_[voxel] = static_cast<std::uint32_t>(next++);
                });
        });
        const auto loadIndex = [&](Line& line, std::size_t i, std::size_t voxel) {
            line.index[i] = index_[voxel];
        };
        const auto load = [&](Line& line, std::size_t i, std::size_t voxel) {
            line.square[i] = square_[voxel];
            line.index[i] = index_[voxel];
        };
        const auto store = [&](const Line& line, std::size_t i, std::size_t voxel) {
            square_[voxel] = line.square[i];
            index_[voxel] = line.index[i];
        };
        const auto keepNearer = [&](const Line& line, std::size_t i, std::size_t voxel) {
            if (line.square[i] < best_[voxel]) {
                best_[voxel] = line.square[i];
                result_.nearest[voxel] = line.index[i];
            }
        };
        forEachLine(
            lattice_, axis, loadIndex,
            [&](Line& line) { line.nearestOnLine(result_.points, axis); }, store);
        const auto envelope = [](Line& line) { line.envelope(); };
        forEachLine(lattice_, axis == 0 ? 1 : 0, load, envelope, store);
        forEachLine(lattice_, axis == 2 ? 1 : 2, load, envelope, keepNearer);
    }

private:
    const Lattice& lattice_;
    SurfaceDistance& result_;
    std::vector<float> square_, best_;
    std::vector<std::uint32_t> index_;
};

}  // namespace

SurfaceDistance surfaceDistance(const VoxelImage& image) {
    const Lattice lattice(image);
    const Crossings crossings(image);
    const std::size_t slices = lattice.size[2];
    SurfaceDistance result;

    // Number of points of each slice, axis by axis, and edges by label.
    const std::size_t labels = labelCount(image);
    std::array<std::vector<std::size_t>, 3> start;
    for (auto& s : start) s.assign(slices + 1, 0);
    std::vector<std::vector<std::array<std::size_t, 3>>> extents(slices);
    parallelFor(std::size_t{0}, slices, [&](std::size_t z) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            std::size_t count = 0;
            crossings.forEachInSlice(
                axis, z, [&](std::size_t, std::size_t, std::size_t, std::size_t) { ++count; });
            start[axis][z + 1] = count;
        }
        extents[z] = crossings.extents(z, labels);
    });
    std::size_t total = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t z = 0; z <= slices; ++z) total = start[axis][z] += total;
    result.edges.resize(labels);
    for (const auto& slice : extents)
        for (std::size_t label = 0; label < labels; ++label)
            for (std::size_t j = 0; j < 3; ++j)
                result.edges[label][j] += 0.5 * static_cast<double>(slice[label][j]);
    if (total == 0) return result;
    if (total >= kNone)
        throw ResourceError(fmt::format(
            "the surface crosses {} edges between voxels, more than 4e9; take larger voxels, or "
            "measure the image in parts",
            total));
    result.points.resize(total);

    NearestPoints nearest(image, lattice, result);
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (start[axis].back() != start[axis].front())
            nearest.addAxis(crossings, axis, start[axis]);
    return result;
}

}  // namespace vdbpack
