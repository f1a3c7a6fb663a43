// A pack, or solids, as a part of a page that a browser turns, zooms and cuts.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/preview/preview.h"

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// Nothing is copied: all members must outlive the call.
template <int Dim>
struct ViewScene {
    const Pack<Dim>* pack = nullptr;     ///< null: the solids inside the wall are shown
    const TriangleMesh* wall = nullptr;  ///< in space: around the spheres; null: none
    /// Without a pack: name and number of triangles of each solid, in the order of the wall.
    std::vector<std::pair<std::string, std::size_t>> solids{};
    double wallVoxel = 0;               ///< mm, of a wall that is a coarse contour; 0: it is none
    const PlaneField* field = nullptr;  ///< in the plane: distances to the wall; null: none
    Box<Dim> bounds;                    ///< shown in addition to the spheres, mm; may be empty
};

/// With the colors and the cut of a picture at first.
struct ViewOptions : PreviewOptions {
    std::size_t mostSpheres = 1'000'000;  ///< of a larger pack, a random subset is shown
    std::size_t mostBytes = 14'400'000;   ///< of the spheres' numbers in the page
    std::size_t mostTriangles = 150'000;  ///< a wall with more is left out
    bool large = false;                   ///< fills the window
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
/// Coordinates, radii and columns of numbers that are not whole are rounded to 1/65534 of their
/// range. The view states the rounding, the share of spheres that a subset has, and what it leaves
/// out: columns beyond `mostBytes`, a wall beyond `mostTriangles`.
///
/// Cost: about a second of processor time for a million spheres.
/// Solids are opaque, and filled where they are cut; several have a color each.
/// @throws ParameterError for an empty pack, centers and radii that are not finite, or a cut that
/// misses the scene.
template <int Dim>
ViewMarkup viewOf(const ViewScene<Dim>& scene, const ViewOptions& options = {});

}  // namespace vdbpack
