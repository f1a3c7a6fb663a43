// Pictures of packs and solids, drawn on the processor.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/preview/picture.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// The attribute that colors spheres.
enum class PreviewColor { radius, region, depth, order, column };

/// A plane that cuts the scene open, seen from the side that is removed. The side of lower x,
/// higher y or lower z is kept, which the default view shows best.
struct PreviewCut {
    int axis = 0;   ///< 0, 1, 2: x, y, z
    double at = 0;  ///< mm
};

struct PreviewOptions {
    int width = 1600, height = 1200;  ///< pixels, 16 to 16384 each
    PreviewColor color = PreviewColor::radius;
    std::string column;  ///< of numbers, for PreviewColor::column
    std::optional<PreviewCut> cut;
    std::string file;  ///< .png that a run writes; empty: none
    /// Called often, by one thread at a time; once it returns true, drawing throws Interrupted.
    std::function<bool()> cancelled;
};

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

    /// Direction, not of unit length, through a point of the picture: -1 to 1 from left to right,
    /// and from the top down.
    Vec<3> direction(double x, double y) const {
        return right * (x * tanX) - up * (y * tanY) - toward;
    }
};

/// A camera that shows all that the cut keeps: 30 degrees wide along the longer side, z up, in a
/// three-quarter view; with a cut, about 30 degrees off the normal of the cut face.
/// @throws as `renderPreview`
PreviewCamera previewCamera(const SpacePreview& scene, const PreviewOptions& options);

/// The index of the sphere visible in the middle of each pixel, row by row from the top; -1: none.
/// Walls and solids are ignored; a cut face of a sphere counts as that sphere.
/// @throws as `renderPreview`
std::vector<std::int32_t> visibleSpheres(const SpacePreview& scene, const PreviewOptions& options);

/// Whether this build can draw scenes in space, which needs Embree 3.
bool canDrawSpace();

/// Draws a scene: key light with soft shadows, ambient occlusion, four samples per pixel, and in
/// the lower left a scale bar of 1, 2 or 5 times a power of ten mm, with 10, 4 or 5 parts and its
/// length beside it. Its
/// scale is that of the middle of the scene, or of the cut face at which the camera looks.
///
/// Cut spheres and solids have flat faces, cut walls are lines. `texts` of the image describe it:
/// "Title", and "Description" with colors, cut and scale. The same for any number of threads. Cost:
/// a million spheres at 1600 x 1200 in some seconds on two threads; 60 bytes per sphere for the
/// hierarchy of boxes.
/// @throws ParameterError for a size out of bounds, an empty scene, an attribute to color by that
/// the pack does not have, a cut that misses the scene, or a build without Embree; ResourceError if
/// memory does not suffice; Interrupted.
Picture renderPreview(const SpacePreview& scene, const PreviewOptions& options);

/// Draws circles at true scale, y up, with the outline of the domain; needs no Embree.
/// @throws as above; ParameterError for a cut.
Picture renderPreview(const PlanePreview& scene, const PreviewOptions& options);

/// "x=12.5" as a cut. @throws ParameterError
PreviewCut parsePreviewCut(const std::string& text);
/// "1600x1200" as width and height. @throws ParameterError, for sizes out of bounds too
std::array<int, 2> parsePreviewSize(const std::string& text);

/// Refuses sizes out of bounds. @throws ParameterError
void checkPreviewSize(int width, int height);
/// Refuses a cut that misses a scene of these bounds. @throws ParameterError
void checkPreviewCut(const PreviewCut& cut, const Box<3>& bounds);

}  // namespace vdbpack
