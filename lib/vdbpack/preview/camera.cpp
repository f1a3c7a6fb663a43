#include "vdbpack/core/error.h"
#include "vdbpack/preview/scene.h"
#include "vdbpack/preview/section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

/// Angle of view along the longer side of the picture, and the margin around the scene.
constexpr double kWidth = 30 * kPi / 180, kMargin = 1.06;
/// The default view: turned from -y towards +x, and raised.
constexpr double kTurn = 35 * kPi / 180, kRise = 22 * kPi / 180;
/// The view of a cut face: off its normal.
constexpr double kCutTurn = 28 * kPi / 180, kCutRise = 20 * kPi / 180;
/// Cosines: of the angle to a cut's normal above which the cut is seen edge-on (84 degrees), and of
/// the rise above which z points at the viewer.
constexpr double kEdgeOn = 0.1, kVertical = 1e-6;

/// x and y change their signs from LPS to RAS.
Vec<3> inSpace(const Vec<3>& x, ImageSpace space) {
    return space == ImageSpace::lps ? x : Vec<3>{{-x[0], -x[1], x[2]}};
}

Vec<3> viewDirection(const PreviewOptions& options) {
    const auto from = [](double azimuth, double rise) {
        return Vec<3>{{std::cos(rise) * std::cos(azimuth), std::cos(rise) * std::sin(azimuth),
                       std::sin(rise)}};
    };
    if (const auto& view = options.view)
        return normalized(view->ofPatient ? inSpace(view->from, options.space) : view->from);
    const auto& cut = options.cut;
    if (!cut) return inSpace(from(-kPi / 2 + kTurn, kRise), options.space);
    if (cut->axis == 0) return from(-kCutTurn, kCutRise);
    if (cut->axis == 1) return from(-kPi / 2 + kCutTurn, kCutRise);
    return from(-kPi / 2 + kCutTurn, kPi / 2 - kCutTurn);
}

/// The extent of the scene along one axis of the picture: a camera at (shift, distance) sees all
/// of it.
class Extent {
public:
    explicit Extent(double tangent) : tan_(tangent), slant_(std::sqrt(1 + tangent * tangent)) {}
    void add(double x, double toward, double radius) {
        const double deep = toward * tan_ + radius * slant_;
        high_ = std::max(high_, x + deep);
        low_ = std::max(low_, -x + deep);
    }
    double distance() const { return (high_ + low_) / (2 * tan_); }
    double shift() const { return (high_ - low_) / 2; }

private:
    double tan_, slant_;
    double high_ = -std::numeric_limits<double>::infinity(), low_ = high_;
};

/// Calls `add(point, radius)` for all that the cut keeps.
template <class Add>
void forEachKept(const SpacePreview& scene, const std::optional<PreviewCut>& cut, const Add& add) {
    if (scene.pack)
        for (const auto& s : scene.pack->spheres)
            if (!cut || keptDepth(*cut, s.center) > -s.radius) add(s.center, s.radius);
    for (const TriangleMesh* mesh : {scene.wall, scene.solid}) {
        if (!mesh) continue;
        for (const auto& v : mesh->vertices)
            if (!cut || keptDepth(*cut, v) >= 0) add(v, 0);
        if (!cut) continue;
        // The remaining part of a large triangle ends at the cut.
        for (const auto& t : mesh->triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec<3>&a = mesh->vertices[t[k]], &b = mesh->vertices[t[(k + 1) % 3]];
                const double da = keptDepth(*cut, a), db = keptDepth(*cut, b);
                if ((da >= 0) != (db >= 0)) add(a + (b - a) * (da / (da - db)), 0);
            }
    }
}

/// Places the camera so that it sees all of the scene in its picture.
/// @param middle  of the scene. @return by what its picture's shape differs from the scene's: the
/// distance that the width requires divided by the distance that the height requires.
double place(const SpacePreview& scene, const PreviewOptions& options, const Vec<3>& middle,
             PreviewCamera& camera) {
    const double longer = std::max(camera.width, camera.height);
    camera.tanX = std::tan(kWidth / 2) * camera.width / longer;
    camera.tanY = std::tan(kWidth / 2) * camera.height / longer;
    Extent across(camera.tanX / kMargin), along(camera.tanY / kMargin);
    double nearest = -std::numeric_limits<double>::infinity(), farthest = -nearest;
    forEachKept(scene, options.cut, [&](Vec<3> center, double radius) {
        center -= middle;
        const double z = dot(center, camera.toward);
        across.add(dot(center, camera.right), z, radius);
        along.add(dot(center, camera.up), z, radius);
        nearest = std::max(nearest, z + radius);
        farthest = std::min(farthest, z - radius);
    });
    // In front of the scene, however small it is.
    const double distance =
        std::max({across.distance(), along.distance(), nearest + 1e-3 * (nearest - farthest)});
    camera.position = middle + camera.toward * distance + camera.right * across.shift() +
                      camera.up * along.shift();
    camera.target = distance - (nearest + farthest) / 2;
    if (options.cut) {
        // The camera looks at the cut face.
        const Vec<3> ray = -camera.toward;
        const double t = -keptDepth(*options.cut, camera.position) /
                         (keptSide(*options.cut) * ray[options.cut->axis]);
        if (t > distance - nearest && t < distance - farthest) camera.target = t;
    }
    return across.distance() / along.distance();
}

}  // namespace

PreviewOptions facingCut(PreviewOptions options) {
    if (!options.cut || !options.view) return options;
    const int axis = options.cut->axis;
    const double faces = viewDirection(options)[axis];
    if (!(std::fabs(faces) > kEdgeOn))
        throw ParameterError(fmt::format(
            "`preview.view`: sees the cut {}={:g} edge-on; look from {}, or leave one of them out",
            "xyz"[axis], options.cut->at,
            std::array{"left or right", "front or back", "top or bottom"}.at(
                static_cast<std::size_t>(axis))));
    options.cut->keeps = faces > 0 ? -1 : 1;
    return options;
}

SpaceFrame frameOf(const SpacePreview& scene, const PreviewOptions& options, const Legend& legend) {
    const Vec<3> middle = checkScene(scene, options).center();
    PreviewCamera camera;
    camera.toward = viewDirection(options);
    const bool vertical = std::hypot(camera.toward[0], camera.toward[1]) < kVertical;
    const Vec<3> up = vertical ? inSpace({{0, -1, 0}}, options.space) : Vec<3>{{0, 0, 1}};
    camera.right = normalized(cross(up, camera.toward));
    camera.up = cross(camera.toward, camera.right);
    const std::vector<Side> sides = seenSides(camera, 3, options);
    // The shape of a square picture's scene; in perspective it depends a little on the picture's.
    camera.width = camera.height = 1;
    double aspect = place(scene, options, middle, camera);
    for (int step = 0;; ++step) {
        Caption caption = captionFor(legend, sides, options, aspect);
        camera.width = caption.width();
        camera.height = caption.sceneHeight();
        aspect *= place(scene, options, middle, camera);
        if (step == 1 || options.height > 0) return {camera, std::move(caption)};
    }
}

PreviewCamera previewCamera(const SpacePreview& scene, const PreviewOptions& asked) {
    const PreviewOptions options = facingCut(asked);
    checkScene(scene, options);
    return frameOf(scene, options,
                   scene.pack ? sphereColors(*scene.pack, options).legend : Legend{})
        .camera;
}

}  // namespace vdbpack
