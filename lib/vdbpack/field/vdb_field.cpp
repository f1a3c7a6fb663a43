#include "vdbpack/field/vdb_field.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/band_width.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/level_volume.h"
#include "vdbpack/field/narrow_band.h"
#include "vdbpack/field/sealed_band.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/field/vdb_init.h"

#include <fmt/format.h>
#include <openvdb/tools/Composite.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <new>
#include <numeric>

namespace vdbpack {

namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using Leaf = FloatGrid::TreeType::LeafNodeType;

constexpr float kOutsideVoxels = 3;
/// Error of distances of an exact band, voxels.
constexpr double kDepthRounding = 1e-5;

/// The band of a mesh that is not watertight: each level of shells takes off what the next one
/// encloses, from the inside out.
FloatGrid::Ptr sealedBands(const LatticeMesh& lattice,
                           const std::vector<std::uint8_t>& depthOfTriangle, float inside,
                           const Callbacks& callbacks) {
    const int deepest = depthOfTriangle.empty()
                            ? 0
                            : *std::max_element(depthOfTriangle.begin(), depthOfTriangle.end());
    FloatGrid::Ptr grid;
    for (int level = deepest; level >= 0; --level) {
        std::vector<std::uint32_t> chosen;
        if (deepest > 0)
            for (std::size_t i = 0; i < depthOfTriangle.size(); ++i)
                if (depthOfTriangle[i] == level) chosen.push_back(static_cast<std::uint32_t>(i));
        // What lies outside of a cavity's shell is inside of the bone.
        const bool cavity = level % 2 == 1;
        const auto outer = sealedBand(lattice, chosen, cavity ? kOutsideVoxels : inside,
                                      cavity ? inside : kOutsideVoxels, callbacks);
        if (grid) openvdb::tools::csgDifference(*outer, *grid);
        grid = outer;
    }
    return grid;
}

}  // namespace

struct VdbField::Impl {
    FloatGrid::Ptr grid;  // mm about `origin`
    Vec<3> origin;
    double voxelSize = 0;
    double depth = 0;
    double deepest = 0;  // at which distances are clamped, less a little, mm; 0: they are not exact
    mutable std::once_flag surfaceOnce;
    mutable std::shared_ptr<const VdbGrid> surface;
};

VdbField::VdbField(const TriangleMesh& mesh, const MeshNesting& nesting, double voxelSize,
                   double depth, const Callbacks& callbacks)
    : impl_(std::make_unique<Impl>()) {
    initializeOpenVdb();
    const double insideVoxels =
        std::max(static_cast<double>(kOutsideVoxels), std::ceil(depth / voxelSize) + 1);
    impl_->voxelSize = voxelSize;
    impl_->depth = (insideVoxels - 1) * voxelSize;
    impl_->origin = fieldOrigin(mesh.bounds(), voxelSize);
    const auto inside = static_cast<float>(insideVoxels);
    try {
        if (nesting.watertight) {
            NarrowBandOptions options;
            options.origin = impl_->origin;
            options.facing = nesting.facing.empty() ? nullptr : &nesting.facing;
            impl_->grid = narrowBand(mesh, voxelSize, inside, kOutsideVoxels, options, callbacks);
            impl_->deepest = (insideVoxels - kDepthRounding) * voxelSize;
        } else {
            impl_->grid = sealedBands({mesh, impl_->origin, voxelSize}, nesting.depthOfTriangle,
                                      inside, callbacks);
        }
    } catch (const std::bad_alloc&) {
        throw ResourceError(fmt::format(
            "not enough memory for a field of voxels of {:.4g} mm; give a larger `voxelSize`",
            voxelSize));
    }
}

VdbField::VdbField(const VdbGrid& levelSet, double depth) : impl_(std::make_unique<Impl>()) {
    initializeOpenVdb();
    const auto& transform = levelSet.grid->transform();
    const double h = transform.voxelSize()[0];
    const auto origin = transform.indexToWorld(openvdb::Vec3d(0, 0, 0));
    impl_->voxelSize = h;
    impl_->origin = {{origin[0], origin[1], origin[2]}};
    const double insideVoxels =
        std::max(static_cast<double>(kOutsideVoxels), std::ceil(depth / h) + 1);
    const double band = static_cast<double>(levelSet.grid->background()) / h;
    try {
        // Without the translation, which would cost digits far from zero.
        const FloatGrid::Ptr grid = levelSet.grid->copy();
        grid->setTransform(openvdb::math::Transform::createLinearTransform(h));
        impl_->grid = band >= insideVoxels
                          ? grid
                          : widened(*grid, static_cast<int>(std::ceil(insideVoxels - band)));
    } catch (const std::bad_alloc&) {
        throw ResourceError(fmt::format(
            "not enough memory for a level set of voxels of {:.4g} mm; give a larger `voxelSize`",
            h));
    }
    impl_->depth = (std::max(band, insideVoxels) - 1) * h;
}

VdbField::~VdbField() = default;

double VdbField::voxelSize() const {
    return impl_->voxelSize;
}

double VdbField::depth() const {
    return impl_->depth;
}

std::uint64_t VdbField::activeVoxels() const {
    return impl_->grid->activeVoxelCount();
}

double VdbField::volume() const {
    const double h = impl_->voxelSize;
    return h * h * h * volumeByVoxels(*impl_->grid, static_cast<float>(h));
}

std::vector<double> VdbField::volumesDeeperThan(const std::vector<double>& depths) const {
    const double h = impl_->voxelSize;
    std::vector<float> levels;
    for (const double depth : depths) levels.push_back(static_cast<float>(-depth));
    std::vector<double> volumes = volumesByCells(*impl_->grid, levels);
    for (double& volume : volumes) volume *= h * h * h;
    return volumes;
}

std::shared_ptr<const VdbGrid> VdbField::surface() const {
    std::call_once(impl_->surfaceOnce, [&] {
        const double h = impl_->voxelSize;
        const auto background = static_cast<float>(kOutsideVoxels * h);
        const FloatGrid::Ptr grid = narrowed(*impl_->grid, background);
        const auto transform = openvdb::math::Transform::createLinearTransform(h);
        const Vec<3>& o = impl_->origin;
        transform->postTranslate(openvdb::Vec3d(o[0], o[1], o[2]));
        grid->setTransform(transform);
        grid->setName("surface");
        grid->setGridClass(openvdb::GRID_LEVEL_SET);
        impl_->surface = std::make_shared<VdbGrid>(grid);
    });
    return impl_->surface;
}

struct VdbField::Sampler::Impl {
    explicit Impl(const VdbField::Impl& field)
        : accessor(field.grid->getConstAccessor()),
          origin(field.origin),
          voxelSize(field.voxelSize),
          inverse(1 / field.voxelSize),
          outside(field.grid->background()),
          deepest(field.deepest) {}

    /// Sets the values of the voxels around `x`, numbered by x + 2 y + 4 z, and where `x` is
    /// between the first and the last. @return whether they are several; else values[0] holds for
    /// all.
    bool around(const Vec<3>& x, double (&values)[8], double (&between)[3]) {
        int at[3];
        for (int i = 0; i < 3; ++i) {
            const double place = (x[i] - origin[i]) * inverse;
            const double floor = std::floor(place);
            // Far from all voxels, where an index would overflow, all is outside.
            if (!(std::abs(floor) < 1e9)) {
                values[0] = outside;
                return false;
            }
            between[i] = place - floor;
            at[i] = static_cast<int>(floor);
        }
        constexpr int kMask = static_cast<int>(Leaf::DIM) - 1;
        const Coord corner(at[0], at[1], at[2]);
        const bool oneLeaf =
            (at[0] & kMask) != kMask && (at[1] & kMask) != kMask && (at[2] & kMask) != kMask;
        if (!oneLeaf) {
            for (int i = 0; i < 8; ++i)
                values[i] = accessor.getValue(corner.offsetBy(i & 1, i >> 1 & 1, i >> 2));
            return true;
        }
        const Leaf* leaf = accessor.probeConstLeaf(corner);
        if (!leaf) {
            values[0] = accessor.getValue(corner);
            return false;
        }
        const openvdb::Index first = Leaf::coordToOffset(corner);
        for (openvdb::Index i = 0; i < 8; ++i)
            values[i] = leaf->getValue(first + (i & 1) * Leaf::DIM * Leaf::DIM +
                                       (i >> 1 & 1) * Leaf::DIM + (i >> 2));
        return true;
    }

    FloatGrid::ConstAccessor accessor;
    Vec<3> origin;
    double voxelSize, inverse;
    double outside;
    double deepest;
};

VdbField::Sampler::Sampler(const VdbField& field) : impl_(std::make_unique<Impl>(*field.impl_)) {}

VdbField::Sampler::~Sampler() = default;

int VdbField::Sampler::sideAround(const Vec<3>& x) {
    Coord corner;
    for (int i = 0; i < 3; ++i) {
        const double floor = std::floor((x[i] - impl_->origin[i]) * impl_->inverse);
        if (!(std::abs(floor) < 1e9)) return 1;
        corner[i] = static_cast<int>(floor);
    }
    int inside = 0;
    for (int i = 0; i < 8; ++i)
        inside += impl_->accessor.getValue(corner.offsetBy(i & 1, i >> 1 & 1, i >> 2)) < 0;
    return inside == 8 ? -1 : inside == 0 ? 1 : 0;
}

double VdbField::Sampler::operator()(const Vec<3>& x) {
    double v[8], w[3];
    if (!impl_->around(x, v, w)) return v[0];
    const double x00 = v[0] + w[0] * (v[1] - v[0]);
    const double x10 = v[2] + w[0] * (v[3] - v[2]);
    const double x01 = v[4] + w[0] * (v[5] - v[4]);
    const double x11 = v[6] + w[0] * (v[7] - v[6]);
    const double y0 = x00 + w[1] * (x10 - x00);
    const double y1 = x01 + w[1] * (x11 - x01);
    return y0 + w[2] * (y1 - y0);
}

DepthRange VdbField::Sampler::depthRange(const Vec<3>& x) {
    DepthRange range;
    double values[8], between[3];
    if (!(impl_->deepest > 0)) return range;
    const bool several = impl_->around(x, values, between);
    const double h = impl_->voxelSize;
    if (!several) {
        // Voxels in front of or behind the band, all around `x`.
        if (values[0] > 0)
            range.most = h - values[0];
        else
            range.least = -values[0] - h;
        return range;
    }
    // The distance changes by no more than the way.
    const double slack = kDepthRounding * h;
    for (int i = 0; i < 8; ++i) {
        double square = 0;
        for (int d = 0; d < 3; ++d) {
            const double way = (i >> d & 1) - between[d];
            square += way * way;
        }
        const double way = std::sqrt(square) * h + slack;
        // Values at the ends of the band are clamped: they bound the distance on one side.
        if (values[i] < impl_->outside) range.least = std::max(range.least, -values[i] - way);
        if (-values[i] < impl_->deepest) range.most = std::min(range.most, way - values[i]);
    }
    return range;
}

}  // namespace vdbpack
