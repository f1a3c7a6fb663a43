// Private: a mesh as a narrow band of signed distances, without OpenVDB's headers.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace vdbpack {

class VdbGrid;

/// Signed distances to a mesh near its wall: at least `depth` inside, three voxels outside.
///
/// Distances are to the nearest triangle, without OpenVDB's smoothing of values (which makes them
/// too deep by more than 0.01 voxel in ten times as many voxels). The lattice lies about a local
/// origin, so that a bone far from zero loses no digits. Immutable.
class VdbField {
public:
    /// @param depthOfTriangle  one a triangle: closed shells around its shell (mesh_shells.h);
    ///        shells at odd depth bound cavities. Empty: all are at depth 0.
    /// @throws ResourceError if memory does not suffice; Interrupted as soon as the callbacks say
    ///         so.
    VdbField(const TriangleMesh& mesh, const std::vector<std::uint8_t>& depthOfTriangle,
             double voxelSize, double depth, const Callbacks& callbacks = {});
    /// A level set as it is, in its own voxels, which lie along x, y, z; where its band is not deep
    /// enough it is widened by the fast sweeping method (Zhao 2004,
    /// doi:10.1090/S0025-5718-04-01678-3).
    VdbField(const VdbGrid& levelSet, double depth);
    ~VdbField();
    VdbField(const VdbField&) = delete;
    VdbField& operator=(const VdbField&) = delete;

    double voxelSize() const;
    /// Distances are clamped at this depth inside, mm.
    double depth() const;
    std::uint64_t activeVoxels() const;
    /// Volume of the part deeper than `depth` mm: sum of the shares of voxels that lie inside.
    double volumeDeeperThan(double depth) const;
    /// The band cut to three voxels on both sides, in mm of the mesh, class level set, named
    /// `surface`. Made on the first call.
    std::shared_ptr<const VdbGrid> surface() const;

    /// Looks distances up; one per thread.
    class Sampler {
    public:
        explicit Sampler(const VdbField& field);
        ~Sampler();
        /// Trilinear in the signed distances of the lattice, mm.
        double operator()(const Vec<3>& x);
        /// -1 or 1 where all eight voxels around `x` lie inside or outside, else 0.
        int sideAround(const Vec<3>& x);

    private:
        struct Impl;
        std::unique_ptr<Impl> impl_;
    };

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace vdbpack
