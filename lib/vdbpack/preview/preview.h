// Pictures of packs and solids, drawn on the processor.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/core/units.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/preview/picture.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// The attribute that colors spheres. chosen: their part, of two to eight, else the radius.
enum class PreviewColor { chosen, radius, region, depth, order, column };

/// A plane that cuts the scene open, seen from the side that is removed.
struct PreviewCut {
    int axis = 0;   ///< 0, 1, 2: x, y, z
    double at = 0;  ///< mm
    /// 1: higher coordinates are kept, -1: lower ones; 0: what is farther from the viewer, and
    /// without a view the side of lower x, higher y or lower z.
    int keeps = 0;
};

/// Where the viewer stands.
struct PreviewView {
    Vec<3> from;             ///< direction from the scene to the viewer, of any length
    bool ofPatient = false;  ///< `from` is given in LPS, whatever the axes of the world are
};

struct PreviewOptions {
    /// Pixels, 16 to 16384 each. `height` 0: the picture is fitted to the scene, up to 1 : 3, and
    /// `width` is its longer side.
    int width = 1600, height = 0;
    PreviewColor color = PreviewColor::chosen;
    std::string column;  ///< of numbers, for PreviewColor::column
    std::optional<PreviewCut> cut;
    std::optional<PreviewView> view;     ///< nothing: from the front, left and above; else a cut's
    ImageSpace space = ImageSpace::lps;  ///< axes of the world, which say what front and left are
    bool ofPatient = false;              ///< whether the sides are a patient's: L, R, A, P, S, I
    std::string file;                    ///< .png that a run writes; empty: none
    /// Called often, by one thread at a time; once it returns true, drawing throws Interrupted.
    std::function<bool()> cancelled;
};

/// Names of the higher and the lower end of each axis.
using SideNames = std::array<std::array<const char*, 2>, 3>;
SideNames sideNames(const PreviewOptions& options);

/// A scene in space, in mm. Nothing is copied: all members must outlive the drawing.
struct SpacePreview {
    const Pack<3>* pack = nullptr;       ///< null: no spheres
    const TriangleMesh* wall = nullptr;  ///< around the spheres, drawn translucent; null: none
    /// A closed surface that is drawn as a solid body with cut faces; null: none.
    const TriangleMesh* solid = nullptr;
};

/// Signed distances in the plane, negative inside, on a square lattice.
struct PlaneField {
    std::int64_t columns = 0, rows = 0;
    double step = 0;              ///< between neighbors, mm
    Vec<2> origin;                ///< of distance (0, 0), mm
    std::vector<float> distance;  ///< mm, x fastest; may be clamped a few steps from zero
};

/// A scene in a plane, in mm.
struct PlanePreview {
    const Pack<2>* pack = nullptr;      ///< null: no circles
    const PlaneField* field = nullptr;  ///< of the domain or the solid; null: none
    Box<2> bounds;                      ///< shown in addition to the circles, mm; may be empty
};

/// A pinhole camera that looks along -toward.
struct PreviewCamera {
    Vec<3> position;            ///< mm
    Vec<3> right, up, toward;   ///< unit vectors of the picture; `toward` points out of it
    double tanX = 0, tanY = 0;  ///< half of the picture's width and height, at distance one
    double target =
        0;  ///< distance to the middle of the scene, or to the cut face, along -toward, mm
    /// Pixels of the scene, which is the upper part of the picture; none of the scale bar, the
    /// legend and the letters reaches into it.
    int width = 0, height = 0;

    /// Direction, not of unit length, through a point of the scene's part: -1 to 1 from left to
    /// right, and from the top down.
    Vec<3> direction(double x, double y) const {
        return right * (x * tanX) - up * (y * tanY) - toward;
    }
};

/// A camera that shows all that the cut keeps: 30 degrees wide along the longer side, z up (from
/// above and below, the front). Without a view, a three-quarter view from the front and the left
/// of the patient (-y and +x, with axes RAS +y and -x); with a cut, about 30 degrees off the normal
/// of the cut face.
/// @throws as `renderPreview`
PreviewCamera previewCamera(const SpacePreview& scene, const PreviewOptions& options);

/// The index of the sphere visible in the middle of each pixel of the scene's part of the picture
/// (`PreviewCamera::width` a row), row by row from the top; -1: none. Walls and solids are ignored;
/// a cut face of a sphere counts as that sphere.
/// @throws as `renderPreview`
std::vector<std::int32_t> visibleSpheres(const SpacePreview& scene, const PreviewOptions& options);

/// Whether this build can draw scenes in space, which needs Embree 3.
bool canDrawSpace();

/// Draws a scene: key light with soft shadows, ambient occlusion, four samples per pixel.
///
/// Below the scene stand a scale bar of 1, 2 or 5 times a power of ten mm, with 10, 4 or 5 parts
/// and its length beside it; a color bar with its ends, or the names of the colors; and a cross
/// whose letters name the sides that are seen. The bar's scale is that of the middle of the scene,
/// or of the cut face at which the camera looks. They are left out where they would take more than
/// two fifths of the height.
///
/// Cut spheres and solids have flat faces, cut walls are lines. `texts` of the image describe it:
/// "Title", and "Description" with colors, cut, sides and scale. The same for any number of
/// threads. Cost: a million spheres at 1600 x 1200 in some seconds on two threads; 60 bytes per
/// sphere for the hierarchy of boxes.
/// @throws ParameterError for a size out of bounds, an empty scene, an attribute to color by that
/// the pack does not have, a cut that misses the scene or is seen edge-on, or a build without
/// Embree; ResourceError if memory does not suffice; Interrupted.
Picture renderPreview(const SpacePreview& scene, const PreviewOptions& options);

/// Draws circles at true scale, y up, with the outline of the domain; needs no Embree.
/// @throws as above; ParameterError for a cut or a view.
Picture renderPreview(const PlanePreview& scene, const PreviewOptions& options);

/// "x=12.5" as a cut. @throws ParameterError
PreviewCut parsePreviewCut(const std::string& text);
/// "front", "back", "left", "right", "top", "bottom" or "X,Y,Z". @throws ParameterError
PreviewView parsePreviewView(const std::string& text);
/// "1600x1200" as width and height, "1600" as a width with the height 0. @throws ParameterError,
/// for sizes out of bounds too
std::array<int, 2> parsePreviewSize(const std::string& text);

/// Refuses sizes out of bounds; a height of 0 is allowed. @throws ParameterError
void checkPreviewSize(int width, int height);
/// Refuses a cut that misses a scene of these bounds. @throws ParameterError
void checkPreviewCut(const PreviewCut& cut, const Box<3>& bounds);

}  // namespace vdbpack
