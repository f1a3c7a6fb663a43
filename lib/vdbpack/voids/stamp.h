// Stamps many ellipsoids into one narrow-band level set.
#pragma once

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/field/linear_sampler.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace vdbpack {

class VdbGrid;

template <int Dim>
struct StampOptions {
    double voxelSize = 0;  ///< mm
    Vec<Dim> origin;       ///< center of a voxel, mm; positions the lattice
    /// Distances outside of voids are computed up to this, mm; at least three voxels.
    double reach = 0;
    /// Thickness of the layer below the wall of the envelope that is kept free of voids, mm; 0:
    /// voids may cut the wall.
    double shell = 0;
};

/// Voids as signed distances, negative inside: the union of ellipsoids (2D: ellipses), with a shell
/// limited to the part of the domain below it. Immutable.
template <int Dim>
class StampedVoids {
public:
    StampedVoids();
    ~StampedVoids();
    StampedVoids(const StampedVoids&) = delete;
    StampedVoids& operator=(const StampedVoids&) = delete;

    double voxelSize() const;
    /// Volume (2D: area) of the voids inside the domain and deeper than the shell, mm^Dim, counted
    /// by voxel centers: fractions of voxels would underestimate thin walls.
    double volume() const;
    /// The number of voxels in the band.
    std::uint64_t activeVoxels() const;
    /// Whether a point lies in one of the ellipsoids, by their inequality. The ellipsoids near it
    /// are listed by tile: this costs about as much as a lookup.
    /// @param voids  the ellipsoids that were stamped.
    bool isIn(const std::vector<Ellipsoid<Dim>>& voids, const Vec<Dim>& x) const;
    /// 3D: the level set `voids` with a band of three voxels on both sides.
    std::shared_ptr<const VdbGrid> grid() const;

    /// Looks up distances; one per thread.
    class Sampler {
    public:
        explicit Sampler(const StampedVoids& voids);
        /// The trilinearly (2D: bilinearly) interpolated distance, mm; clamped to the band.
        double operator()(const Vec<Dim>& x) { return sample_(x); }

    private:
        LinearSampler<Dim> sample_;
    };

    struct Impl;

private:
    template <int D>
    friend std::shared_ptr<const StampedVoids<D>> stampVoids(const std::vector<Ellipsoid<D>>&,
                                                             const Domain<D>&,
                                                             const StampOptions<D>&,
                                                             const Callbacks&);
    std::unique_ptr<Impl> impl_;
};

/// Stamps all ellipsoids at once, tile by tile in parallel: each voxel takes the minimum of the
/// distances to the ellipsoids that reach it, as successive unions would give.
///
/// Outside of all voids the error of the distances is below 4e-4 of the shorter half-axis up to
/// ratios of 10; inside overlapping voids they are the distances to the farther surface. With a
/// shell, the exact distance to the wall decides which voxels lie deeper. They may reach into
/// cavities that the shell does not line (`Domain::envelope`).
///
/// @param domain  the domain that voids are cut into; tiles beyond it are skipped. Faster if its
///                field is deeper than the shell plus ten voxels: below the field the distance to
///                the wall is searched.
/// @throws ParameterError for a voxel size, shell or half-axis that is not positive and finite
/// (the shell may be 0); ResourceError for voxels that are too small for the domain.
/// The same for any number of threads.
template <int Dim>
std::shared_ptr<const StampedVoids<Dim>> stampVoids(const std::vector<Ellipsoid<Dim>>& voids,
                                                    const Domain<Dim>& domain,
                                                    const StampOptions<Dim>& options,
                                                    const Callbacks& callbacks = {});

}  // namespace vdbpack
