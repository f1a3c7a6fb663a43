// Many ellipsoids as one narrow-band level set.
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
    Vec<Dim> origin;       ///< center of a voxel, mm: fixes the lattice
    /// Distances outside of voids must be known up to this, mm; three voxels at the least.
    double reach = 0;
    /// Voids stay deeper than this below the wall, mm; 0: they may open it.
    double shell = 0;
};

/// Voids as signed distances, negative inside: the union of ellipsoids (2D: ellipses), and with a
/// shell cut back to what lies deeper. Immutable.
template <int Dim>
class StampedVoids {
public:
    StampedVoids();
    ~StampedVoids();
    StampedVoids(const StampedVoids&) = delete;
    StampedVoids& operator=(const StampedVoids&) = delete;

    double voxelSize() const;
    /// Volume (2D: area) of the voids inside the domain and deeper than the shell, mm^Dim: the
    /// voxels whose centers lie there. Shares of voxels would make too little of thin walls.
    double volume() const;
    /// Voxels in the band.
    std::uint64_t activeVoxels() const;
    /// Whether a point lies in one of the ellipsoids, by their own inequality. Those that may hold
    /// it are known by tile: about as cheap as a lookup.
    /// @param voids  as they were stamped.
    bool isIn(const std::vector<Ellipsoid<Dim>>& voids, const Vec<Dim>& x) const;
    /// 3D: the band cut to three voxels on both sides, class level set, named `voids`.
    std::shared_ptr<const VdbGrid> grid() const;

    /// Looks distances up; one per thread.
    class Sampler {
    public:
        explicit Sampler(const StampedVoids& voids);
        /// Linear in each direction between the voxels, mm; clamped to the band.
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

/// Stamps all ellipsoids at once: tile by tile in parallel, each voxel taking the least of the
/// distances to the ellipsoids that reach it, which is what unions one by one would give.
///
/// Outside of all voids the distances are exact to 4e-4 of the shorter half-axis up to ratios of
/// 10; inside overlapping ones they are those to the farther of the surfaces. With a shell the wall
/// itself decides which voxels lie deeper, not the field alone.
///
/// @param domain  what the voids are cut into; tiles beyond it are left out. Fast where its field
///                is as deep as the shell and ten voxels: beyond it the wall itself is asked.
/// @throws ParameterError for a voxel size, shell or half-axis that is not positive and finite
/// (the shell may be 0); ResourceError if the memory it would take is not there.
/// The same for any number of threads.
template <int Dim>
std::shared_ptr<const StampedVoids<Dim>> stampVoids(const std::vector<Ellipsoid<Dim>>& voids,
                                                    const Domain<Dim>& domain,
                                                    const StampOptions<Dim>& options,
                                                    const Callbacks& callbacks = {});

}  // namespace vdbpack
