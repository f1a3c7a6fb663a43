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
#include <array>
#include <cmath>
#include <cstdint>
#include <new>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// Side of a tile, and the width of the border whose samples smooth its light, pixels.
constexpr int kTile = 80, kApron = 2;
/// Samples of a pixel with an edge, and where they lie: a rotated grid, no two in a row or column.
constexpr int kSamples = 4;
constexpr std::array<std::array<double, 2>, kSamples> kInPixel{
    {{0.125, 0.625}, {0.375, 0.125}, {0.625, 0.875}, {0.875, 0.375}}};
/// Order in which the pixels of a square of 4 x 4 use the sequence: neighbors far apart in it.
constexpr std::array<std::uint32_t, 16> kSquare{0, 8,  2, 10, 12, 4, 14, 6,
                                                3, 11, 1, 9,  15, 7, 13, 5};
/// Least cosine of normals, and most change of the light of the wall, without an edge between.
constexpr float kSmooth = 0.9f, kSameVeil = 0.1f;

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

/// The samples of a tile and its border: one in the middle of each pixel, and `kSamples` instead in
/// those with an edge.
class TileSamples {
public:
    TileSamples(const SpaceTracer& tracer, int left, int top, int columns, int rows)
        : tracer_(tracer),
          columns_(columns),
          rows_(rows),
          middles_(count(columns, rows)),
          edge_(middles_.size(), kNone) {
        Batch seen(tracer, true), lights(tracer, false);
        for (int j = 0; j < rows; ++j)
            for (int i = 0; i < columns; ++i)
                seen.add({left + i + 0.5, top + j + 0.5, 0, &middles_[at(i, j)]});
        seen.flush();
        const auto rays = static_cast<std::uint32_t>(tracer.lightRays());
        for (int j = 0; j < rows; ++j)
            for (int i = 0; i < columns; ++i)
                for (std::uint32_t n = 0; n < rays; ++n)
                    lights.add({0, 0, rays * pointOf(left + i, top + j) + n, &middles_[at(i, j)],
                                nullptr, 1 / static_cast<float>(rays)});
        lights.flush();
        refine(left, top);
    }

    /// How many there are of a pixel, and the first of them.
    int countAt(int i, int j) const { return edge_[at(i, j)] == kNone ? 1 : kSamples; }
    const Sample* of(int i, int j) const {
        const std::int32_t e = edge_[at(i, j)];
        return e == kNone ? &middles_[at(i, j)] : edges_[static_cast<std::size_t>(e)].data();
    }

private:
    using Spot = SpaceTracer::Spot;
    static constexpr std::int32_t kNone = -1;

    /// Spots whose rays are cast once there are enough of them.
    class Batch {
    public:
        Batch(const SpaceTracer& tracer, bool sees) : tracer_(tracer), sees_(sees) {}
        void add(const Spot& spot) {
            spots_[static_cast<std::size_t>(count_++)] = spot;
            if (count_ == kTogether) flush();
        }
        void flush() {
            if (sees_)
                tracer_.see(spots_.data(), count_);
            else
                tracer_.light(spots_.data(), count_);
            count_ = 0;
        }

    private:
        const SpaceTracer& tracer_;
        bool sees_;  // or lights
        std::array<Spot, kTogether> spots_;
        int count_ = 0;
    };

    static std::size_t count(int columns, int rows) {
        return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    }
    std::size_t at(int i, int j) const {
        return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
               static_cast<std::size_t>(i);
    }
    static std::uint32_t pointOf(int x, int y) {
        return kSquare[static_cast<std::size_t>((y & 3) * 4 + (x & 3))];
    }

    /// What lies between two pixels: nothing, an edge of what is seen, or one of the wall before
    /// it.
    std::uint8_t between(const Sample& a, const Sample& b) const {
        if (std::fabs(a.through - b.through) > kSameVeil) return 2;
        if (a.body != b.body || a.albedo.r != b.albedo.r) return 1;
        return a.takesLight() &&
               (dot(a.normal, b.normal) < kSmooth ||
                std::fabs(dot(b.at - a.at, a.normal)) > tracer_.planeTolerance(a.at));
    }

    void findEdges() {
        kind_.resize(middles_.size());
        const auto mark = [&](std::size_t p, std::size_t q) {
            const std::uint8_t kind = between(middles_[p], middles_[q]);
            kind_[p] = std::max(kind_[p], kind), kind_[q] = std::max(kind_[q], kind);
        };
        for (int j = 0; j < rows_; ++j)
            for (int i = 0; i < columns_; ++i) {
                if (i + 1 < columns_) mark(at(i, j), at(i + 1, j));
                if (j + 1 < rows_) mark(at(i, j), at(i, j + 1));
            }
        std::int32_t found = 0;
        for (std::size_t p = 0; p < edge_.size(); ++p)
            if (kind_[p] > 0) edge_[p] = found++;
        edges_.resize(static_cast<std::size_t>(found));
    }

    /// Of the samples of a pixel, each body's first has light of its own, and others share it.
    void refine(int left, int top) {
        findEdges();
        Batch seen(tracer_, true);
        const auto forEach = [&](const auto& visit) {
            for (int j = 0; j < rows_; ++j)
                for (int i = 0; i < columns_; ++i)
                    if (const std::int32_t e = edge_[at(i, j)]; e != kNone)
                        visit(left + i, top + j, middles_[at(i, j)],
                              edges_[static_cast<std::size_t>(e)]);
        };
        forEach([&](int x, int y, const Sample& middle, auto& samples) {
            const bool same = kind_[static_cast<std::size_t>(&middle - middles_.data())] == 1;
            for (std::size_t k = 0; k < kSamples; ++k)
                seen.add({x + kInPixel[k][0], y + kInPixel[k][1], 0, &samples[k],
                          same ? &middle : nullptr});
        });
        seen.flush();
        Batch lights(tracer_, false);
        std::vector<std::pair<Sample*, const Sample*>> shared;
        forEach([&](int x, int y, const Sample& middle, auto& samples) {
            for (std::size_t k = 0; k < kSamples; ++k) {
                Sample& s = samples[k];
                if (!s.takesLight()) continue;
                const Sample* like = middle.body == s.body ? &middle : nullptr;
                for (std::size_t l = 0; l < k && !like; ++l)
                    if (samples[l].body == s.body) like = &samples[l];
                if (like)
                    shared.emplace_back(&s, like);
                else
                    lights.add(
                        {0, 0, kSamples * pointOf(x, y) + static_cast<std::uint32_t>(k), &s});
            }
        });
        lights.flush();
        for (const auto& [s, like] : shared) s->open = like->open, s->lit = like->lit;
    }

    const SpaceTracer& tracer_;
    int columns_, rows_;
    std::vector<Sample> middles_;
    std::vector<std::uint8_t> kind_;  ///< of each pixel, the most that `between` found beside it
    std::vector<std::int32_t> edge_;  ///< of each pixel, its place in `edges_`, or kNone
    std::vector<std::array<Sample, kSamples>> edges_;
};

void drawTile(const SpaceTracer& tracer, int x0, int y0, Picture& image) {
    const int width = tracer.camera().width, height = tracer.camera().height;
    const int x1 = std::min(x0 + kTile, width), y1 = std::min(y0 + kTile, height);
    const int left = std::max(0, x0 - kApron), top = std::max(0, y0 - kApron);
    const int columns = std::min(width, x1 + kApron) - left;
    const int rows = std::min(height, y1 + kApron) - top;
    const TileSamples samples(tracer, left, top, columns, rows);
    TileLight light(columns, rows);
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
            for (int k = 0; k < kSamples; ++k)  // one sample counts as often as several
                light.set(i, j, k, samples.of(i, j)[samples.countAt(i, j) > 1 ? k : 0]);
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
            const int i = x - left, j = y - top, count = samples.countAt(i, j);
            Color sum;
            for (int k = 0; k < count; ++k) {
                Sample s = samples.of(i, j)[k];
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
            toSrgb(sum * (1.0f / static_cast<float>(count)), image.pixel(x, y));
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
