// Private to domain: volumes and centroids of domains by integration.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/domain/convex_shape.h"

#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace vdbpack {

/// Integrals over a part of a domain.
template <int Dim>
struct VolumeIntegrals {
    double volume = 0;  ///< 2D: area
    Vec<Dim> moment;    ///< of the position, mm^(Dim+1)

    std::optional<Vec<Dim>> centroid() const {
        return volume != 0 ? std::make_optional(moment * (1 / volume)) : std::nullopt;
    }
    /// Adds a small part about `x`.
    void add(double amount, const Vec<Dim>& x) {
        volume += amount;
        moment += x * amount;
    }
};

/// Over the part of a shape deeper than `depth` that lies inside half-spaces:
/// exact chords along the last axis, midpoint rule across. A clipped ball comes out within 1e-5.
/// @param planes  unit normals, already moved inward by `depth`.
/// @param box     around the result.
template <int Dim>
VolumeIntegrals<Dim> integralsByChords(const ConvexShape<Dim>& shape,
                                       const std::vector<HalfSpace<Dim>>& planes, double depth,
                                       const Box<Dim>& box);

/// Over the part of a domain deeper than `depth`: the sum over cells of the share
/// that lies inside, by the signed distance at the cell's center. Right on average for flat walls,
/// of second order in the cell for curved ones.
/// @param box        around the domain.
/// @param voxelSize  of the field (3D), below half of which there is nothing to resolve, mm; or 0.
/// @param sampler    makes a sampler of the domain; called from many threads.
///
/// Cost: up to 1.2e7 signed distances.
template <int Dim>
VolumeIntegrals<Dim> integralsBySamples(
    const Box<Dim>& box, double voxelSize, double depth,
    const std::function<std::unique_ptr<DomainSampler<Dim>>()>& sampler);

/// Area of the wall (2D: its length): the rate at which the volume falls with depth, by a one-sided
/// difference of second order.
/// @param step  mm.
template <int Dim>
double wallAreaByVolumes(const Domain<Dim>& domain, double step);

}  // namespace vdbpack
