// Stamps many ellipsoids into one narrow-band level set.
#pragma once

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace vdbpack {

template <int Dim>
class KnownCore;
template <int Dim>
class LinearSampler;
class VdbGrid;

/// How far apart voids still blend, in lengths of the blend.
inline constexpr double kBlendReach = 4;

struct VoidJoin {
    /// Voids whose surfaces come nearer than four times this run into one another, mm; 0: they do
    /// not. It rounds the edges between them, and opens walls that are thinner.
    double blend = 0;
    /// Radius of the struts that remain along the lines where three voids (2D: two) are nearest and
    /// equally near, however far these overlap, mm; 0: there are none.
    double strut = 0;
    double strutShare =
        1;  ///< of those lines that have a strut, chosen at random by the voids' ids

    bool isNone() const { return !(blend > 0 || strut > 0); }
    /// How far a void may lie from a point and still change the level set there, mm.
    double reach(double voxelSize) const {
        const double ofStruts = strut > 0 ? blend + 3 * voxelSize + strutReach(voxelSize) : 0;
        return std::max(kBlendReach * blend, ofStruts);
    }
    /// Where struts meet the solid, they are rounded over this length, mm.
    double rounding() const { return 2 * blend; }
    /// The most by which the distances to the voids of a strut differ, up to three voxels beyond
    /// its surface, mm.
    double strutReach(double voxelSize) const {
        return 1.75 * (strut + rounding() + 3 * voxelSize);
    }
};

template <int Dim>
struct StampOptions {
    double voxelSize = 0;  ///< mm
    Vec<Dim> origin;       ///< center of a voxel, mm; positions the lattice
    /// Distances outside of voids are computed up to this, mm; at least three voxels.
    double reach = 0;
    VoidJoin join;
    /// Layer below the wall of the envelope that is kept free of voids; 0: voids may cut the wall.
    /// Where its thickness varies, the level set crosses zero where the shell ends; next to it the
    /// distances are off by the slope of the thickness.
    ShellThickness shell{};
    /// Where the shell ends, kept for further stampings of the same domain, shell and lattice;
    /// null: it is not.
    std::shared_ptr<KnownCore<Dim>> core{};
};

/// Nothing is known yet.
template <int Dim>
std::shared_ptr<KnownCore<Dim>> unknownCore();

/// The distance to joined voids at a point, negative inside, mm.
///
/// Blended, it is c (1 - (sum of max(0, 1 - d / c)^4)^(1/4)), where d are the distances to each
/// void and c is four times the blend; for one void alone it is the distance to that void. A strut
/// takes away all that is nearer to its line than its radius.
///
/// Source of the blend: the union by p-norms of Ricci (1973), "A constructive geometry for computer
/// graphics", The Computer Journal 16 (2), 157-160, doi:10.1093/comjnl/16.2.157, of a function that
/// vanishes at c. The lines of the struts are the edges of the Apollonius diagram of the voids
/// (Okabe, Boots, Sugihara, Chiu (2000), Spatial Tessellations, 3.2), as the struts of an open-cell
/// foam are.
/// @param voids  all within `how.reach` of the point; the others need not be there.
template <int Dim>
double joinedDistance(const std::vector<const Ellipsoid<Dim>*>& voids, const Vec<Dim>& x,
                      const VoidJoin& how);

/// Voids as signed distances, negative inside: the union of ellipsoids (2D: ellipses), joined
/// as the options say, with a shell limited to the part of the domain below it. Immutable.
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
    /// Whether a point lies in the voids, by the ellipsoids themselves and how they join. Those
    /// near it are listed by tile: this costs about as much as a lookup.
    /// @param voids  the ellipsoids that were stamped.
    bool isIn(const std::vector<Ellipsoid<Dim>>& voids, const Vec<Dim>& x) const;
    /// 3D: the level set `voids` with a band of three voxels on both sides.
    std::shared_ptr<const VdbGrid> grid() const;

    /// Looks up distances; one per thread.
    class Sampler {
    public:
        explicit Sampler(const StampedVoids& voids);
        ~Sampler();
        /// The trilinearly (2D: bilinearly) interpolated distance, mm; clamped to the band.
        double operator()(const Vec<Dim>& x);

    private:
        std::unique_ptr<LinearSampler<Dim>> sample_;
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
///                the wall is searched. In a periodic cell the voids repeat: what leaves it through
///                a face comes in through the opposite one; the volume is that in the box of the
///                cell, whose faces end no void.
/// @throws ParameterError for a voxel size, shell or half-axis that is not positive and finite
/// (the shell may be 0); ResourceError for voxels that are too small for the domain.
/// The same for any number of threads.
template <int Dim>
std::shared_ptr<const StampedVoids<Dim>> stampVoids(const std::vector<Ellipsoid<Dim>>& voids,
                                                    const Domain<Dim>& domain,
                                                    const StampOptions<Dim>& options,
                                                    const Callbacks& callbacks = {});

}  // namespace vdbpack
