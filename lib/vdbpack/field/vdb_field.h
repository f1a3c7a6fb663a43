// Private: a mesh as a narrow band of signed distances, without OpenVDB's headers.
#pragma once

#include "vdbpack/core/depth_range.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/core/vec.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace vdbpack {

class VdbGrid;

/// How the triangles of a mesh bound its inside.
struct MeshNesting {
    /// Every edge joins two triangles, so that parity tells inside from outside.
    bool watertight = false;
    /// Of each triangle: 1 if its normal points out of the solid, -1 if into it; empty: unknown.
    std::vector<std::int8_t> facing;
    /// Of each triangle: closed shells around its shell (mesh_shells.h); shells at odd depth bound
    /// cavities. Empty: all are at depth 0.
    std::vector<std::uint8_t> depthOfTriangle;
};

/// Signed distances to a mesh near its wall: at least `depth` inside, three voxels outside.
///
/// Exact for a watertight mesh (`narrowBand`); else with errors of up to a voxel, and holes smaller
/// than a voxel closed (`sealedBand`). The lattice lies about a local origin, so that a bone far
/// from zero loses no digits. Immutable.
class VdbField {
public:
    /// @throws ResourceError if memory does not suffice; Interrupted as soon as the callbacks say
    ///         so.
    VdbField(const TriangleMesh& mesh, const MeshNesting& nesting, double voxelSize, double depth,
             const Callbacks& callbacks = {});
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
    /// Volume inside: sum of the shares of voxels.
    double volume() const;
    /// Volume of the part that is `depth` mm deep, as `Sampler` sees it: two parts of a bone closer
    /// than a voxel, or an interior thinner than that, are seen alike by both.
    double volumeDeeperThan(double depth) const { return volumesDeeperThan({depth})[0]; }
    /// The same of several depths, which ascend, in one pass.
    std::vector<double> volumesDeeperThan(const std::vector<double>& depths) const;
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
        /// Bounds of the depth that the exact distances of the eight voxels around `x` give, mm;
        /// infinite where the field is not exact.
        DepthRange depthRange(const Vec<3>& x);
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
