// Private to previews: what drawings of the plane and of space share.
#pragma once

#include "vdbpack/preview/color.h"
#include "vdbpack/preview/plane_bins.h"
#include "vdbpack/preview/preview.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// Refuses spheres that lie nowhere or have no radius. @throws ParameterError
template <int Dim>
void checkSpheres(const Pack<Dim>& pack);
extern template void checkSpheres<2>(const Pack<2>&);
extern template void checkSpheres<3>(const Pack<3>&);

/// What each sphere of a pack looks like.
struct SphereColors {
    std::vector<Color> color;  ///< one a sphere
    std::string words;         ///< "colored by radius, 1 to 2 mm from dark to light"
};
/// @throws ParameterError if the pack lacks the attribute.
template <int Dim>
SphereColors sphereColors(const Pack<Dim>& pack, PreviewColor by);

extern template SphereColors sphereColors<2>(const Pack<2>&, PreviewColor);
extern template SphereColors sphereColors<3>(const Pack<3>&, PreviewColor);

/// A bone's color, and the same where it is cut.
Color boneColor();
Color boneCutColor();
/// Of outlines.
Color inkColor();

/// Discs of a plane, to find the one that covers a point.
class PlaneDiscs {
public:
    /// @param discs  with their indices in the pack.
    PlaneDiscs(std::vector<Sphere<2>> discs, std::vector<std::int32_t> indices);

    struct Found {
        std::int32_t index = -1;  ///< in the pack; -1: no disc
        double rim = 0;           ///< distance to the disc's edge, mm
    };
    /// The disc that covers `x`: where several do, the one that reaches farthest up as a sphere.
    Found at(const Vec<2>& x) const;
    bool empty() const { return discs_.empty(); }

private:
    std::vector<Sphere<2>> discs_;
    std::vector<std::int32_t> indices_;
    PlaneBins bins_;
};

/// Straight lines of a plane, to tell whether one is near.
class PlaneLines {
public:
    struct Line {
        Vec<2> a, b;
    };
    /// @param reach  the largest distance that will be asked for, mm.
    PlaneLines(std::vector<Line> lines, double reach);
    /// Distance to the nearest line if less than `reach`; else infinity.
    double distance(const Vec<2>& x) const;

private:
    std::vector<Line> lines_;
    double reach_ = 0;
    PlaneBins bins_;
};

/// The axes that span the plane across `axis`.
struct CutAxes {
    int u, v;
    explicit CutAxes(int axis) : u((axis + 1) % 3), v((axis + 2) % 3) {}
    Vec<2> flat(const Vec<3>& x) const { return {{x[u], x[v]}}; }
};

/// Discs in which a cut meets spheres.
PlaneDiscs sectionOf(const Pack<3>& pack, const PreviewCut& cut);
/// Lines in which a cut meets a mesh.
PlaneLines sectionOf(const TriangleMesh& mesh, const PreviewCut& cut, double reach);

/// 1 where what stays of a cut lies at higher coordinates, else -1.
inline double keptSide(const PreviewCut& cut) {
    return cut.axis == 1 ? 1.0 : -1.0;
}
/// How deep a point lies in what stays, mm; negative in what is taken away.
inline double keptDepth(const PreviewCut& cut, const Vec<3>& x) {
    return keptSide(cut) * (x[cut.axis] - cut.at);
}

/// Length of a scale bar and its parts.
struct ScaleBar {
    double length = 0;  ///< mm; 0: none
    int parts = 0;
};
/// The bar that takes a tenth to a quarter of a picture's width.
/// @param mmPerPixel  where the bar is true.
ScaleBar scaleBarFor(double mmPerPixel, int width);
/// Draws it in the lower left.
void drawScaleBar(const ScaleBar& bar, double mmPerPixel, Image& image);

/// Bounds of all there is, mm. @throws ParameterError if there is nothing.
Box<3> boundsOf(const SpacePreview& scene);

/// What `renderPreview` refuses: size, emptiness, cut. @return the bounds of the scene.
Box<3> checkScene(const SpacePreview& scene, const PreviewOptions& options);

/// Title and description.
void describe(const std::string& title, const std::string& description, Image& image);

/// 12,345
std::string groupedCount(std::size_t n);

}  // namespace vdbpack
