#include "vdbpack/preview/scene.h"
#include "vdbpack/preview/section.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

/// Angle of view along the longer side of the picture, and the margin around the scene.
constexpr double kWidth = 30 * kPi / 180, kMargin = 1.06;
/// The default view: turned from -y towards +x, and raised.
constexpr double kTurn = 35 * kPi / 180, kRise = 22 * kPi / 180;
/// The view of a cut face: off its normal.
constexpr double kCutTurn = 28 * kPi / 180, kCutRise = 20 * kPi / 180;

Vec<3> viewDirection(const std::optional<PreviewCut>& cut) {
    const auto from = [](double azimuth, double rise) {
        return Vec<3>{{std::cos(rise) * std::cos(azimuth), std::cos(rise) * std::sin(azimuth),
                       std::sin(rise)}};
    };
    if (!cut) return from(-kPi / 2 + kTurn, kRise);
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

}  // namespace

PreviewCamera previewCamera(const SpacePreview& scene, const PreviewOptions& options) {
    const Box<3> bounds = checkScene(scene, options);
    const Vec<3> middle = bounds.center();
    PreviewCamera camera;
    camera.toward = viewDirection(options.cut);
    camera.right = normalized(cross({{0, 0, 1}}, camera.toward));
    camera.up = cross(camera.toward, camera.right);
    const double longer = std::max(options.width, options.height);
    camera.tanX = std::tan(kWidth / 2) * options.width / longer;
    camera.tanY = std::tan(kWidth / 2) * options.height / longer;

    Extent across(camera.tanX / kMargin), along(camera.tanY / kMargin);
    double nearest = -std::numeric_limits<double>::infinity(), farthest = -nearest;
    const auto add = [&](Vec<3> center, double radius) {
        center -= middle;
        const double z = dot(center, camera.toward);
        across.add(dot(center, camera.right), z, radius);
        along.add(dot(center, camera.up), z, radius);
        nearest = std::max(nearest, z + radius);
        farthest = std::min(farthest, z - radius);
    };
    if (scene.pack)
        for (const auto& s : scene.pack->spheres)
            if (!options.cut || keptDepth(*options.cut, s.center) > -s.radius)
                add(s.center, s.radius);
    for (const TriangleMesh* mesh : {scene.wall, scene.solid}) {
        if (!mesh) continue;
        for (const auto& v : mesh->vertices)
            if (!options.cut || keptDepth(*options.cut, v) >= 0) add(v, 0);
        if (!options.cut) continue;
        // The remaining part of a large triangle ends at the cut.
        for (const auto& t : mesh->triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec<3>&a = mesh->vertices[t[k]], &b = mesh->vertices[t[(k + 1) % 3]];
                const double da = keptDepth(*options.cut, a), db = keptDepth(*options.cut, b);
                if ((da >= 0) != (db >= 0)) add(a + (b - a) * (da / (da - db)), 0);
            }
    }
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
    return camera;
}

}  // namespace vdbpack
