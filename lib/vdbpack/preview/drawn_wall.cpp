#include "vdbpack/preview/drawn_wall.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/mesh/made_mesh.h"

#include <algorithm>
#include <cstdint>
#include <memory>

namespace vdbpack {

namespace {

/// Distances beyond the bounds of a plane domain.
constexpr int kRimPixels = 4;

}  // namespace

WallMesh::WallMesh(const DomainSource& source, const DomainSource::Built& built,
                   const TriangleMesh* known, std::size_t mostTriangles, double voxels) {
    const bool whole = source.recipe().clips.empty();
    mesh_ = known ? known : whole && built.mesh ? &built.mesh->wall() : nullptr;
    if (mesh_ && mesh_->triangles.size() <= mostTriangles) return;
    const Domain<3>& domain = *built.space;
    const Box<3> bounds = domain.bounds();
    // Of a periodic cell the picture shows its box.
    if (whole && (domain.facts().kind == "box" || domain.cell().any())) {
        made_ = boxMesh(bounds);
    } else {
        voxelSize_ = length(bounds.size()) / voxels;
        made_ = levelSetMesh(*surfaceLevelSet(domain, voxelSize_), source.recipe().source);
    }
    mesh_ = &made_;
}

PlaneField planeField(const Domain<2>& domain, const StampedVoids<2>* voids, int columns) {
    const Box<2> bounds = domain.bounds();
    PlaneField field;
    const Vec<2> size = bounds.size();
    field.step = std::max(size[0], size[1]) / columns;
    const auto count = [&](double side) {
        return static_cast<std::int64_t>(side / field.step) + 2 + 2 * kRimPixels;
    };
    field.columns = count(size[0]);
    field.rows = count(size[1]);
    field.origin = bounds.grown(kRimPixels * field.step).lo;
    field.distance.resize(static_cast<std::size_t>(field.columns * field.rows));
    struct Samplers {
        std::unique_ptr<DomainSampler<2>> domain;
        std::unique_ptr<StampedVoids<2>::Sampler> voids;
    };
    PerThread<Samplers> samplers([&] {
        return Samplers{domain.sampler(),
                        voids ? std::make_unique<StampedVoids<2>::Sampler>(*voids) : nullptr};
    });
    parallelFor(std::int64_t{0}, field.rows, [&](std::int64_t row) {
        Samplers& local = samplers.local();
        for (std::int64_t column = 0; column < field.columns; ++column) {
            const Vec<2> x = field.origin + Vec<2>{{static_cast<double>(column) * field.step,
                                                    static_cast<double>(row) * field.step}};
            double d = local.domain->signedDistance(x);
            if (local.voids) d = std::max(d, -(*local.voids)(x));
            field.distance[static_cast<std::size_t>(row * field.columns + column)] =
                static_cast<float>(d);
        }
    });
    return field;
}

}  // namespace vdbpack
