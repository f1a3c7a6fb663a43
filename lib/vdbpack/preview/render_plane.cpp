// Draws circles at true scale.
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/preview/scene.h"
#include "vdbpack/preview/section.h"
#include "vdbpack/preview/sphere_colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace vdbpack {

namespace {

constexpr int kSide = 4;  // samples along a side of a pixel
constexpr double kPlaneMargin = 0.02;
constexpr double kOutline = 1.2;            // half width, pixels
constexpr double kCircleRim = 0.9;          // width of a circle's rim, pixels
constexpr double kLargestCircleRim = 0.12;  // the same at most, share of the radius
constexpr float kCircleShade = 0.42f;

/// Bilinear interpolation; far outside beyond the lattice.
double distanceAt(const PlaneField& field, const Vec<2>& x) {
    const double i = (x[0] - field.origin[0]) / field.step,
                 j = (x[1] - field.origin[1]) / field.step;
    if (!(i >= 0 && j >= 0 && i < static_cast<double>(field.columns - 1) &&
          j < static_cast<double>(field.rows - 1)))
        return 1e300;
    const auto i0 = static_cast<std::int64_t>(i), j0 = static_cast<std::int64_t>(j);
    const double u = i - static_cast<double>(i0), v = j - static_cast<double>(j0);
    const float* at = &field.distance[static_cast<std::size_t>(j0 * field.columns + i0)];
    const double low = at[0] + u * (at[1] - at[0]);
    const double high = at[field.columns] + u * (at[field.columns + 1] - at[field.columns]);
    return low + v * (high - low);
}

void checkField(const PlaneField& field) {
    if (field.columns < 2 || field.rows < 2 || !(field.step > 0) ||
        field.distance.size() != static_cast<std::size_t>(field.columns * field.rows))
        throw ParameterError(fmt::format(
            "preview: a field of {} x {} distances, {} mm apart, has {} values; give one "
            "per lattice point",
            field.columns, field.rows, field.step, field.distance.size()));
}

Box<2> boundsOf(const PlanePreview& scene) {
    Box<2> bounds = scene.bounds;
    if (scene.pack && !scene.pack->spheres.empty()) {
        const Box<2> circles = boundsOf(*scene.pack);
        bounds.add(circles.lo);
        bounds.add(circles.hi);
    }
    if (bounds.empty()) throw ParameterError("preview: the scene is empty; give circles or bounds");
    return bounds;
}

PlaneDiscs discsOf(const Pack<2>* pack) {
    if (!pack) return {{}, {}};
    std::vector<std::int32_t> indices(pack->spheres.size());
    std::iota(indices.begin(), indices.end(), 0);
    return {pack->spheres, std::move(indices)};
}

}  // namespace

Picture renderPreview(const PlanePreview& scene, const PreviewOptions& options) {
    checkPreviewSize(options.width, options.height);
    refuseInPlane(options);
    const Box<2> bounds = boundsOf(scene);
    if (scene.field) checkField(*scene.field);
    SphereColors colors;
    if (scene.pack) colors = sphereColors(*scene.pack, options);

    const Vec<2> size = bounds.size();
    PreviewCamera above;
    above.right[0] = above.up[1] = above.toward[2] = 1;
    const Caption caption = captionFor(colors.legend, seenSides(above, 2, options), options,
                                       size[0] / std::max(size[1], 1e-300));
    const int width = caption.width(), height = caption.sceneHeight();
    const double pixel = std::max({size[0] / (width * (1 - 2 * kPlaneMargin)),
                                   size[1] / (height * (1 - 2 * kPlaneMargin)), 1e-300});
    const Vec<2> middle = bounds.center();
    const auto pointAt = [&](double x, double y) {
        return Vec<2>{
            {middle[0] + (x - 0.5 * width) * pixel, middle[1] - (y - 0.5 * height) * pixel}};
    };

    const PlaneDiscs discs = discsOf(scene.pack);
    const Color white{1, 1, 1}, inside = scene.pack ? fromSrgb(0xf3efe7) : boneCutColor();
    const auto colorAt = [&](const Vec<2>& x) {
        Color color = white;
        if (scene.field) {
            const double d = distanceAt(*scene.field, x);
            if (std::fabs(d) < kOutline * pixel) return inkColor();
            if (d < 0) color = inside;
        }
        const auto found = discs.at(x);
        if (found.index < 0) return color;
        const auto i = static_cast<std::size_t>(found.index);
        const double rim =
            std::min(kCircleRim * pixel, kLargestCircleRim * scene.pack->spheres[i].radius);
        return colors.color[i] * (found.rim < rim ? kCircleShade : 1);
    };
    StopRequest request(options.cancelled);
    Picture image = caption.drawn(pixel);
    parallelFor(0, height, [&](int y) {
        request.stop();
        for (int x = 0; x < width; ++x) {
            Color sum;
            for (int j = 0; j < kSide; ++j)
                for (int i = 0; i < kSide; ++i)
                    sum += colorAt(pointAt(x + (i + 0.5) / kSide, y + (j + 0.5) / kSide));
            toSrgb(sum * (1.0f / (kSide * kSide)), image.pixel(x, y));
        }
    });
    describe(scene.pack ? groupedCount(scene.pack->spheres.size()) + " circles" : "a solid",
             caption.words(pixel, {}), image);
    return image;
}

}  // namespace vdbpack
