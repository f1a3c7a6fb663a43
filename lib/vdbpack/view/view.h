// A pack as a part of a page that a browser turns, zooms and cuts.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/preview/preview.h"

#include <cstddef>
#include <optional>
#include <string>

namespace vdbpack {

/// Nothing is copied: all members must outlive the call.
template <int Dim>
struct ViewScene {
    const Pack<Dim>* pack = nullptr;
    const TriangleMesh* wall = nullptr;  ///< in space: around the spheres; null: none
    const PlaneField* field = nullptr;   ///< in the plane: distances to the wall; null: none
    Box<Dim> bounds;                     ///< shown in addition to the spheres, mm; may be empty
};

struct ViewOptions {
    PreviewColor color = PreviewColor::radius;  ///< at first
    std::string column;                         ///< for PreviewColor::column
    std::optional<PreviewCut> cut;              ///< at first
    std::size_t mostSpheres = 1'000'000;        ///< of a larger pack, a selection is shown
    std::size_t mostBytes = 10'800'000;  ///< of compressed numbers; a page has four thirds of it
    std::size_t mostTriangles = 12'000;  ///< of the wall that is shown
    bool large = false;                  ///< fills the window
};

/// Parts of an HTML page, well-formed XML; both empty: no view.
struct ViewMarkup {
    std::string style;  ///< for a <style> of its head
    std::string body;   ///< within a <figure class='picture'> that may have a picture before it
};

/// A view of a pack: spheres drawn by WebGL2, a translucent wall, a movable cut, colors by any
/// column, a table of the sphere that is clicked. Where WebGL2 is missing, the page shows the
/// picture before it. Nothing is fetched; the same for the same input.
///
/// Positions are rounded to 1/65535 of the longest side, radii and columns of numbers that are not
/// whole to 1/65534 of their range. Of a pack of more than `mostSpheres`, those near its surface
/// and near the cut (without one: near the three middle planes) are shown first, and a share of the
/// others; the view says so. Columns beyond `mostBytes`, and texts with more than 255 words, are
/// left out, which it says, too.
///
/// Cost: about a second for a million spheres on two threads.
/// @throws ParameterError for an empty pack, or centers and radii that are not finite.
template <int Dim>
ViewMarkup viewOf(const ViewScene<Dim>& scene, const ViewOptions& options = {});

}  // namespace vdbpack
