// Where the points of a lattice near a surface lie: inside or outside by winding numbers.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/field/lattice_edge.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <functional>
#include <memory>
#include <vector>

namespace vdbpack {

/// Winding numbers at points of a cubic lattice: around the triangles of a mesh, and wherever the
/// surface between inside (winding number of at least 1/2) and outside leads away from them.
class WindingLattice {
public:
    /// The winding number at a point in voxels; called from many threads.
    using Winding = std::function<double(const Vec<3>&)>;

    static bool isInside(double winding) { return winding >= 0.5; }

    /// @param mesh  in voxels about the origin of the lattice; must outlive this, as `callbacks`.
    /// @param crossed  edges of the lattice that triangles cross.
    /// @throws Interrupted, std::bad_alloc
    WindingLattice(const TriangleMesh& mesh, const std::vector<EdgeKey>& crossed, Winding winding,
                   const Callbacks& callbacks);
    ~WindingLattice();

    /// Adds points until every cell that the surface passes through has eight known corners: along
    /// the surface, and from where a coarse lattice finds it away from all triangles.
    void followSurface();

    /// An edge with ends on different sides.
    struct Change {
        EdgeKey edge;
        bool lowerInside;
    };
    /// All of them, by rising keys.
    std::vector<Change> changes() const;

    /// Looks points up; one per thread. Unknown points have a winding number of a distance: ask for
    /// corners of cells that the surface passes through and for ends of crossed edges.
    class Reader {
    public:
        explicit Reader(const WindingLattice& lattice);
        ~Reader();
        bool isInside(const VoxelIndex& point);

    private:
        struct Impl;
        std::unique_ptr<Impl> impl_;
    };

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace vdbpack
