// Private to previews: discs and lines in a plane, and cuts through spheres and meshes.
#pragma once

#include "vdbpack/preview/plane_bins.h"
#include "vdbpack/preview/preview.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// Discs in a plane, to find the disc that covers a point.
class PlaneDiscs {
public:
    /// @param indices  of the discs in the pack.
    PlaneDiscs(std::vector<Sphere<2>> discs, std::vector<std::int32_t> indices);

    struct Found {
        std::int32_t index = -1;  ///< in the pack; -1: no disc
        double rim = 0;           ///< distance to the disc's edge, mm
    };
    /// The disc that covers `x`; of several, the one whose sphere is highest above `x`.
    Found at(const Vec<2>& x) const;
    bool empty() const { return discs_.empty(); }

private:
    std::vector<Sphere<2>> discs_;
    std::vector<std::int32_t> indices_;
    PlaneBins bins_;
};

/// Line segments in a plane, to find the distance to the nearest.
class PlaneLines {
public:
    struct Line {
        Vec<2> a, b;
    };
    /// @param reach  distances are computed up to this, mm.
    PlaneLines(std::vector<Line> lines, double reach);
    /// Distance to the nearest line if less than `reach`, otherwise infinity.
    double distance(const Vec<2>& x) const;

private:
    std::vector<Line> lines_;
    double reach_ = 0;
    PlaneBins bins_;
};

/// The axes of the plane normal to `axis`.
struct CutAxes {
    int u, v;
    explicit CutAxes(int axis) : u((axis + 1) % 3), v((axis + 2) % 3) {}
    Vec<2> flat(const Vec<3>& x) const { return {{x[u], x[v]}}; }
};

/// The discs in which a cut intersects spheres.
PlaneDiscs sectionOf(const Pack<3>& pack, const PreviewCut& cut);
/// The lines in which a cut intersects a mesh.
PlaneLines sectionOf(const TriangleMesh& mesh, const PreviewCut& cut, double reach);

/// 1 if a cut keeps the side of higher coordinates, otherwise -1.
inline double keptSide(const PreviewCut& cut) {
    return cut.keeps != 0 ? cut.keeps : cut.axis == 1 ? 1 : -1;
}
/// Depth of a point below the cut face, mm; negative on the side that is removed.
inline double keptDepth(const PreviewCut& cut, const Vec<3>& x) {
    return keptSide(cut) * (x[cut.axis] - cut.at);
}

}  // namespace vdbpack
