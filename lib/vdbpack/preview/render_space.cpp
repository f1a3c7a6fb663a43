// Draws scenes in space, tile by tile.
#include "vdbpack/core/error.h"
#include "vdbpack/core/lanes.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/preview/scene.h"
#include "vdbpack/preview/space_tracer.h"
#include "vdbpack/preview/sphere_colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>

namespace vdbpack {

namespace {

/// Side of a tile, and the width of the border whose samples smooth its light, pixels.
constexpr int kTile = 80, kApron = 2;

/// The light of the samples of a tile, which is noisy with so few rays, and its average over the
/// 4 x 4 pixels around a sample (border pixels have half weight), which together contain all points
/// of the sequence. Only samples of about the same plane and normal are used.
class TileLight {
public:
    TileLight(int columns, int rows)
        : stride_(padded(kSamples * static_cast<std::size_t>(columns + 2 * kApron) + kSamples)),
          values_(kParts * stride_ * static_cast<std::size_t>(rows + 2 * kApron)) {}

    /// Sample `k` of pixel (i, j) of the tile.
    void set(int i, int j, int k, const Sample& s) {
        if (!s.hit) return;
        const float parts[kParts] = {s.at.x,     s.at.y,     s.at.z, s.normal.x,
                                     s.normal.y, s.normal.z, s.open, s.lit};
        float* to = rowAt(j + kApron) + static_cast<std::size_t>(kSamples * (i + kApron) + k);
        for (const float part : parts) {
            *to = part;
            to += stride_;
        }
    }

    void smooth(int i, int j, float tolerance, Sample& s) const {
        static_assert(kSamples == 4 && kApron == 2, "the weights of a row are those of 5 x 4");
        constexpr Float8 kShare[] = {{0.5f, 0.5f, 0.5f, 0.5f, 1, 1, 1, 1},
                                     {1, 1, 1, 1, 1, 1, 1, 1},
                                     {0.5f, 0.5f, 0.5f, 0.5f, 0, 0, 0, 0}};
        Float8 open{}, lit{}, all{};
        for (int row = 0; row <= 2 * kApron; ++row) {
            const float ofRow = row == 0 || row == 2 * kApron ? 0.5f : 1.0f;
            const float* from = rowAt(j + row) + static_cast<std::size_t>(kSamples * i);
            for (const Float8& ofPixel : kShare) {
                const auto part = [&](std::size_t p) { return load(from + p * stride_); };
                // Without a hit the normal is zero.
                const Float8 cosine =
                    part(3) * s.normal.x + part(4) * s.normal.y + part(5) * s.normal.z;
                const Float8 off = (part(0) - s.at.x) * s.normal.x +
                                   (part(1) - s.at.y) * s.normal.y +
                                   (part(2) - s.at.z) * s.normal.z;
                const Float8 weight = where8((cosine >= 0.7f) & (absolute(off) <= tolerance),
                                             (cosine - 0.65f) * ofPixel * ofRow);
                open += weight * part(6);
                lit += weight * part(7);
                all += weight;
                from += kLanes;
            }
        }
        s.open = sum(open) / sum(all);
        s.lit = sum(lit) / sum(all);
    }

private:
    static constexpr std::size_t kParts = 8;
    float* rowAt(int j) { return values_.data() + kParts * stride_ * static_cast<std::size_t>(j); }
    const float* rowAt(int j) const {
        return values_.data() + kParts * stride_ * static_cast<std::size_t>(j);
    }

    std::size_t stride_;         ///< from one part of a row to the next
    std::vector<float> values_;  ///< row by row: all x, all y, ...; a border of kApron pixels
};

void drawTile(const SpaceTracer& tracer, int x0, int y0, Picture& image) {
    const int width = tracer.camera().width, height = tracer.camera().height;
    const int x1 = std::min(x0 + kTile, width), y1 = std::min(y0 + kTile, height);
    const int left = std::max(0, x0 - kApron), top = std::max(0, y0 - kApron);
    const int columns = std::min(width, x1 + kApron) - left;
    const int rows = std::min(height, y1 + kApron) - top;
    std::vector<Sample> samples(static_cast<std::size_t>(columns * rows) * kSamples);
    TileLight light(columns, rows);
    std::size_t next = 0;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i, next += kSamples) {
            tracer.trace(left + i, top + j, &samples[next]);
            for (int k = 0; k < kSamples; ++k)
                light.set(i, j, k, samples[next + static_cast<std::size_t>(k)]);
        }
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
            Color sum;
            for (int k = 0; k < kSamples; ++k) {
                const int i = x - left, j = y - top;
                Sample s = samples[static_cast<std::size_t>(j * columns + i) * kSamples +
                                   static_cast<std::size_t>(k)];
                Color behind{1, 1, 1};
                if (s.hit) {
                    if (!s.flat) light.smooth(i, j, tracer.planeTolerance(s.at), s);
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

std::vector<std::int32_t> visibleSpheres(const SpacePreview& scene, const PreviewOptions& asked) {
    const PreviewOptions options = facingCut(asked);
    const PreviewCamera camera = previewCamera(scene, options);
    SpacePreview spheres = scene;
    spheres.wall = spheres.solid = nullptr;
    StopRequest request(options.cancelled);
    const SpaceTracer tracer(spheres, options, camera, request);
    std::vector<std::int32_t> seen(static_cast<std::size_t>(camera.width) *
                                   static_cast<std::size_t>(camera.height));
    parallelFor(0, camera.height, [&](int y) {
        for (int x = 0; x < camera.width; ++x)
            seen[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
                 static_cast<std::size_t>(x)] = tracer.sphereAt(x + 0.5, y + 0.5);
    });
    return seen;
}

Picture renderPreview(const SpacePreview& scene, const PreviewOptions& asked) {
    try {
        const PreviewOptions options = facingCut(asked);
        checkScene(scene, options);
        SphereColors colors;
        if (scene.pack) colors = sphereColors(*scene.pack, options);
        const auto [camera, caption] = frameOf(scene, options, colors.legend);
        StopRequest request(options.cancelled);
        SpaceTracer tracer(scene, options, camera, request);
        tracer.colorBy(std::move(colors.color));
        Picture image = caption.drawn(tracer.mmPerPixel());
        const int columns = (camera.width + kTile - 1) / kTile;
        const int rows = (camera.height + kTile - 1) / kTile;
        parallelFor(0, columns * rows, [&](int tile) {
            request.stop();
            drawTile(tracer, tile % columns * kTile, tile / columns * kTile, image);
        });
        std::vector<std::string> words;
        if (options.cut)
            words.push_back(fmt::format("cut at {0} = {1:g} mm, {2} {0} stays",
                                        "xyz"[options.cut->axis], options.cut->at,
                                        keptSide(*options.cut) > 0 ? "higher" : "lower"));
        const Float3 from = single(camera.toward);
        words.push_back(fmt::format("seen from ({:.2f}, {:.2f}, {:.2f})", from.x, from.y, from.z));
        describe(titleOf(scene), caption.words(tracer.mmPerPixel(), words), image);
        return image;
    } catch (const std::bad_alloc&) {
        throw ResourceError(
            "preview: not enough memory to draw the scene; leave `preview.file` out");
    }
}

}  // namespace vdbpack
