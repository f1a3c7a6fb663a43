// Draws scenes in space, tile by tile.
#include "vdbpack/core/error.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/preview/scale_bar.h"
#include "vdbpack/preview/space_tracer.h"
#include "vdbpack/preview/sphere_colors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <new>

namespace vdbpack {

namespace {

/// Side of a tile, and the width of the border whose samples smooth its light, pixels.
constexpr int kTile = 80, kApron = 2;

/// Averages the light of a sample, which is noisy with so few rays, over the 4 x 4 pixels around it
/// (border pixels have half weight), which together contain all points of the sequence. Only
/// samples of about the same plane and normal are used.
void smooth(const SpaceTracer& tracer, const std::vector<Sample>& samples, int columns, int rows,
            int x, int y, Sample& s) {
    const auto at = [&](int i, int j) {
        return (static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) +
                static_cast<std::size_t>(i)) *
               kSamples;
    };
    const float tolerance = 2.5f * static_cast<float>(tracer.footprint()) *
                            std::sqrt(dot(s.at - tracer.eye(), s.at - tracer.eye()));
    float open = 0, lit = 0, sum = 0;
    for (int j = std::max(0, y - kApron); j <= std::min(rows - 1, y + kApron); ++j)
        for (int i = std::max(0, x - kApron); i <= std::min(columns - 1, x + kApron); ++i) {
            const float share = (std::abs(i - x) == kApron ? 0.5f : 1.0f) *
                                (std::abs(j - y) == kApron ? 0.5f : 1.0f);
            const Sample* near = &samples[at(i, j)];
            for (int m = 0; m < kSamples; ++m, ++near) {
                if (!near->hit) continue;
                const float cosine = dot(near->normal, s.normal);
                if (cosine < 0.7f) continue;
                if (std::fabs(dot(near->at - s.at, s.normal)) > tolerance) continue;
                const float weight = share * (cosine - 0.65f);
                open += weight * near->open;
                lit += weight * near->lit;
                sum += weight;
            }
        }
    s.open = open / sum;
    s.lit = lit / sum;
}

void drawTile(const SpaceTracer& tracer, int x0, int y0, Image& image) {
    const int x1 = std::min(x0 + kTile, image.width), y1 = std::min(y0 + kTile, image.height);
    const int left = std::max(0, x0 - kApron), top = std::max(0, y0 - kApron);
    const int columns = std::min(image.width, x1 + kApron) - left;
    const int rows = std::min(image.height, y1 + kApron) - top;
    std::vector<Sample> samples(static_cast<std::size_t>(columns * rows) * kSamples);
    std::size_t next = 0;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
            for (int k = 0; k < kSamples; ++k) tracer.trace(left + i, top + j, k, samples[next++]);
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
            Color sum;
            for (int k = 0; k < kSamples; ++k) {
                const int i = x - left, j = y - top;
                Sample s = samples[static_cast<std::size_t>(j * columns + i) * kSamples +
                                   static_cast<std::size_t>(k)];
                Color behind{1, 1, 1};
                if (s.hit) {
                    if (!s.flat) smooth(tracer, samples, columns, rows, i, j, s);
                    behind = tracer.shade(s);
                }
                // Clamped per sample: a very bright one would make edges ragged.
                Color c = s.veil + behind * s.through;
                c = {std::min(c.r, 1.0f), std::min(c.g, 1.0f), std::min(c.b, 1.0f)};
                sum += c;
            }
            toSrgb(sum * (1.0f / kSamples), image.pixel(x, y));
        }
}

std::string titleOf(const SpacePreview& scene) {
    if (!scene.pack) return "a solid";
    return groupedCount(scene.pack->spheres.size()) + " spheres";
}

}  // namespace

bool canDrawSpace() {
    return true;
}

std::vector<std::int32_t> visibleSpheres(const SpacePreview& scene, const PreviewOptions& options) {
    SpacePreview spheres = scene;
    spheres.wall = spheres.solid = nullptr;
    StopRequest request(options.cancelled);
    const SpaceTracer tracer(spheres, options, request);
    std::vector<std::int32_t> seen(static_cast<std::size_t>(options.width) *
                                   static_cast<std::size_t>(options.height));
    tbb::parallel_for(0, options.height, [&](int y) {
        for (int x = 0; x < options.width; ++x)
            seen[static_cast<std::size_t>(y) * static_cast<std::size_t>(options.width) +
                 static_cast<std::size_t>(x)] = tracer.sphereAt(x + 0.5, y + 0.5);
    });
    return seen;
}

Image renderPreview(const SpacePreview& scene, const PreviewOptions& options) {
    try {
        checkScene(scene, options);
        SphereColors colors;
        if (scene.pack) colors = sphereColors(*scene.pack, options.color);
        StopRequest request(options.cancelled);
        SpaceTracer tracer(scene, options, request);
        tracer.colorBy(std::move(colors.color));
        Image image;
        image.width = options.width;
        image.height = options.height;
        image.pixels.resize(3 * static_cast<std::size_t>(image.width) *
                            static_cast<std::size_t>(image.height));
        const int columns = (image.width + kTile - 1) / kTile;
        const int rows = (image.height + kTile - 1) / kTile;
        tbb::parallel_for(0, columns * rows, [&](int tile) {
            request.stop();
            drawTile(tracer, tile % columns * kTile, tile / columns * kTile, image);
        });
        const ScaleBar bar = scaleBarFor(tracer.mmPerPixel(), image.width);
        drawScaleBar(bar, tracer.mmPerPixel(), image);
        std::string words = colors.words;
        const auto add = [&](const std::string& more) {
            words += (words.empty() ? "" : "; ") + more;
        };
        if (options.cut)
            add(fmt::format("cut at {0} = {1:g} mm, {2} {0} stays", "xyz"[options.cut->axis],
                            options.cut->at, keptSide(*options.cut) > 0 ? "higher" : "lower"));
        const Float3 from = single(tracer.camera().toward);
        add(fmt::format("seen from ({:.2f}, {:.2f}, {:.2f})", from.x, from.y, from.z));
        add(fmt::format("scale bar {:g} mm in {} parts", bar.length, bar.parts));
        describe(titleOf(scene), words, image);
        return image;
    } catch (const std::bad_alloc&) {
        throw ResourceError(
            "preview: not enough memory to draw the scene; leave `preview.file` out");
    }
}

}  // namespace vdbpack
