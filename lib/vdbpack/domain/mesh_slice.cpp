#include "vdbpack/domain/mesh_slice.h"

#include "vdbpack/core/cell_share.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/facet_bins.h"
#include "vdbpack/domain/volume_integrals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace vdbpack {

namespace {

constexpr double kMostNodes = 1.6e7;
// Largest relative difference of the areas by outline and by raster of a usable outline.
constexpr double kAreaTolerance = 0.02;

/// Where the triangles cut the plane, the domain to the left of each segment.
///
/// A vertex on the plane counts as above it: the slice is the limit from below, the same for all
/// triangles at the vertex, so that outlines close.
std::vector<Facet<2>> cut(const TriangleMesh& mesh, const std::vector<std::int8_t>& facing,
                          double height) {
    std::vector<Facet<2>> segments;
    const auto crossing = [&](std::uint32_t i, std::uint32_t j) {
        // Both triangles at an edge receive the same point, to the last bit.
        const Vec<3>& a = mesh.vertices[std::min(i, j)];
        const Vec<3>& b = mesh.vertices[std::max(i, j)];
        const double t = (height - a[2]) / (b[2] - a[2]);
        return Vec<2>{{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])}};
    };
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
        const auto& triangle = mesh.triangles[k];
        Facet<2> segment;
        int crossings = 0;
        for (std::size_t e = 0; e < 3; ++e) {
            const std::uint32_t i = triangle[e];
            const std::uint32_t j = triangle[(e + 1) % 3];
            const bool fromAbove = mesh.vertices[i][2] >= height;
            if (fromAbove == (mesh.vertices[j][2] >= height)) continue;
            // Seen from outside, an outward triangle is left upward at the end of its segment.
            segment[fromAbove ? 0 : 1] = crossing(i, j);
            ++crossings;
        }
        if (crossings != 2) continue;
        if (!facing.empty() && facing[k] < 0) std::swap(segment[0], segment[1]);
        segments.push_back(segment);
    }
    return segments;
}

/// Signed distances on a square lattice: magnitude from the segments, sign from the winding number
/// of the outline around a node, or from the 3D field where the outline is not closed.
class SliceDomain : public Domain<2> {
public:
    SliceDomain(const MeshDomain& domain, std::vector<Facet<2>> segments, bool oriented,
                double height, std::shared_ptr<const Domain<2>> envelope)
        : facts_(domain.facts()),
          depth_(domain.fieldDepth()),
          bins_(std::move(segments)),
          envelope_(std::move(envelope)) {
        facts_.kind = "slice";
        bounds_ = bins_.bounds();
        spacing_ = std::max(0.5 * facts_.voxelSize, std::sqrt(bounds_.volume() / kMostNodes));
        outside_ = 3 * facts_.voxelSize;
        const Box<2> around = bounds_.grown(outside_ + spacing_);
        lo_ = around.lo;
        for (int i = 0; i < 2; ++i)
            nodes_[static_cast<std::size_t>(i)] =
                static_cast<int>(std::ceil(around.size()[i] / spacing_)) + 1;
        const auto inside = oriented ? insideByWinding() : insideByField(domain, height);
        fillRaster(inside);

        const Vec<2> center = bounds_.center();
        VolumeIntegrals<2> integrals;
        for (const auto& segment : bins_.facets()) {
            const Vec<2> a = segment[0] - center;
            const Vec<2> b = segment[1] - center;
            integrals.add(0.5 * (a[0] * b[1] - a[1] * b[0]), center + (a + b) * (1.0 / 3));
            length_ += length(b - a);
        }
        area_ = integrals.volume;
        centroid_ = integrals.centroid();
        if (oriented) return;
        const double byRaster = areaDeeperThan(0);
        if (std::abs(area_ - byRaster) <= kAreaTolerance * byRaster) return;
        area_ = byRaster;
        centroid_.reset();
    }

    Box<2> bounds() const override { return bounds_; }
    double volume() const override { return area_; }
    std::optional<Vec<2>> centroid() const override { return centroid_; }
    double wallArea() const override { return length_; }
    double volumeDeeperThan(double depth) const override {
        return depth > 0 ? areaDeeperThan(depth) : area_;
    }
    double fieldDepth() const override { return depth_; }
    std::unique_ptr<DomainSampler<2>> sampler() const override;
    DomainFacts facts() const override { return facts_; }
    const Domain<2>& envelope() const override {
        return envelope_ ? *envelope_ : static_cast<const Domain<2>&>(*this);
    }

    double signedDistance(const Vec<2>& x) const {
        double w[2];
        std::size_t at[2];
        for (int i = 0; i < 2; ++i) {
            const double position = (x[i] - lo_[i]) / spacing_;
            const int last = nodes_[static_cast<std::size_t>(i)] - 2;
            if (!(position >= 0 && position <= last + 1)) return outside_;
            const int cell = std::min(static_cast<int>(position), last);
            w[i] = position - cell;
            at[i] = static_cast<std::size_t>(cell);
        }
        const auto across = static_cast<std::size_t>(nodes_[0]);
        const float* v = raster_.data() + at[1] * across + at[0];
        const double low = v[0] + w[0] * (v[1] - v[0]);
        const double high = v[across] + w[0] * (v[across + 1] - v[across]);
        return low + w[1] * (high - low);
    }

    const FacetBins<2>& bins() const { return bins_; }

private:
    Vec<2> node(std::size_t column, std::size_t row) const {
        return {{lo_[0] + static_cast<double>(column) * spacing_,
                 lo_[1] + static_cast<double>(row) * spacing_}};
    }

    std::vector<std::uint8_t> insideByField(const MeshDomain& domain, double height) const {
        const auto across = static_cast<std::size_t>(nodes_[0]);
        std::vector<std::uint8_t> inside(across * static_cast<std::size_t>(nodes_[1]));
        parallelFor(IndexRange(0, inside.size(), 4096), [&](const IndexRange& range) {
            const auto field = domain.sampler();
            for (std::size_t i = range.begin(); i != range.end(); ++i) {
                const Vec<2> x = node(i % across, i / across);
                inside[i] = field->signedDistance({{x[0], x[1], height}}) < 0;
            }
        });
        return inside;
    }

    /// Counts the segments left of a node: those that run down enter the domain, those that run
    /// up leave it.
    std::vector<std::uint8_t> insideByWinding() const {
        struct Crossing {
            double x;
            int turn;
        };
        const auto across = static_cast<std::size_t>(nodes_[0]);
        std::vector<std::vector<Crossing>> rows(static_cast<std::size_t>(nodes_[1]));
        for (const auto& segment : bins_.facets()) {
            const bool down = segment[0][1] > segment[1][1];
            const Vec<2>& low = segment[down ? 1 : 0];
            const Vec<2>& high = segment[down ? 0 : 1];
            // Rows with low <= y < high, so that each end belongs to one of two segments.
            auto row = static_cast<std::size_t>(
                std::max(0.0, std::floor((low[1] - lo_[1]) / spacing_) - 1));
            for (; row < rows.size(); ++row) {
                const double y = node(0, row)[1];
                if (y < low[1]) continue;
                if (y >= high[1]) break;
                const double t = (y - low[1]) / (high[1] - low[1]);
                rows[row].push_back({low[0] + t * (high[0] - low[0]), down ? 1 : -1});
            }
        }
        std::vector<std::uint8_t> inside(across * rows.size());
        for (std::size_t row = 0; row < rows.size(); ++row) {
            auto& crossings = rows[row];
            std::sort(crossings.begin(), crossings.end(),
                      [](const Crossing& a, const Crossing& b) { return a.x < b.x; });
            std::size_t next = 0;
            int winding = 0;
            for (std::size_t i = 0; i < across; ++i) {
                for (; next < crossings.size() && crossings[next].x <= node(i, row)[0]; ++next)
                    winding += crossings[next].turn;
                inside[row * across + i] = winding > 0;
            }
        }
        return inside;
    }

    void fillRaster(const std::vector<std::uint8_t>& inside) {
        const auto across = static_cast<std::size_t>(nodes_[0]);
        raster_.resize(inside.size());
        parallelFor(IndexRange(0, inside.size(), 1024), [&](const IndexRange& range) {
            for (std::size_t i = range.begin(); i != range.end(); ++i) {
                const double most = inside[i] ? depth_ : outside_;
                WallPoint<2> wall;
                const double distance =
                    bins_.nearest(node(i % across, i / across), most, wall) ? wall.distance : most;
                raster_[i] = static_cast<float>(inside[i] ? -distance : distance);
            }
        });
    }

    /// Sum over the cells around the nodes of the share that lies deeper.
    double areaDeeperThan(double depth) const {
        std::vector<double> sums(static_cast<std::size_t>(nodes_[1]));
        const auto across = static_cast<std::size_t>(nodes_[0]);
        const auto level = static_cast<float>(-depth);
        for (std::size_t row = 0; row + 1 < sums.size(); ++row)
            for (std::size_t i = 0; i + 1 < across; ++i) {
                const float* const v = raster_.data() + row * across + i;
                sums[row] += shareBelowZero<2>(
                    {v[0] - level, v[1] - level, v[across] - level, v[across + 1] - level});
            }
        return spacing_ * spacing_ * std::accumulate(sums.begin(), sums.end(), 0.0);
    }

    DomainFacts facts_;
    double depth_;
    FacetBins<2> bins_;
    std::shared_ptr<const Domain<2>> envelope_;  // null: the slice itself
    Box<2> bounds_;
    double spacing_ = 0;
    Vec<2> lo_;
    std::array<int, 2> nodes_{};
    double outside_ = 0;
    std::vector<float> raster_;
    double area_ = 0;
    std::optional<Vec<2>> centroid_;
    double length_ = 0;
};

class SliceSampler : public DomainSampler<2> {
public:
    explicit SliceSampler(const SliceDomain& slice) : slice_(slice) {}
    double signedDistance(const Vec<2>& x) override { return slice_.signedDistance(x); }
    bool nearestWall(const Vec<2>& x, double reach, WallPoint<2>& wall) override {
        return slice_.bins().nearest(x, reach, wall);
    }
    void wallsWithin(const Vec<2>& x, double reach, std::vector<WallPoint<2>>& points) override {
        slice_.bins().within(x, reach, points);
    }

private:
    const SliceDomain& slice_;
};

std::unique_ptr<DomainSampler<2>> SliceDomain::sampler() const {
    return std::make_unique<SliceSampler>(*this);
}

}  // namespace

std::shared_ptr<const Domain<2>> meshSlice(std::shared_ptr<const MeshDomain> domain,
                                           const std::vector<std::int8_t>& facing, double height,
                                           std::shared_ptr<const Domain<2>> envelope) {
    std::vector<Facet<2>> segments = cut(domain->wall(), facing, height);
    std::shared_ptr<const SliceDomain> slice;
    if (!segments.empty())
        slice = std::make_shared<SliceDomain>(*domain, std::move(segments), !facing.empty(), height,
                                              std::move(envelope));
    if (!slice || !(slice->volume() > 0)) {
        const Box<3> bounds = domain->bounds();
        throw InputError(
            fmt::format("slice z={}: the plane misses the domain, which spans z = {:.6g} to {:.6g} "
                        "mm; choose a height in between",
                        height, bounds.lo[2], bounds.hi[2]));
    }
    return slice;
}

}  // namespace vdbpack
