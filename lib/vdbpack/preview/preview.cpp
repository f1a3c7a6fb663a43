#include "vdbpack/preview/preview.h"

#include "vdbpack/core/error.h"
#include "vdbpack/preview/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace vdbpack {

namespace {

constexpr int kSmallest = 16, kLargest = 16384;

[[noreturn]] void malformed(const std::string& option, const std::string& text, const char* form) {
    throw ParameterError(fmt::format("{} '{}' is malformed; write {}", option, text, form));
}

}  // namespace

PreviewCut parsePreviewCut(const std::string& text) {
    const char* form = "x=V, y=V or z=V, in mm";
    PreviewCut cut;
    if (text.size() < 3 || text[0] < 'x' || text[0] > 'z' || text[1] != '=')
        malformed("--preview-cut", text, form);
    cut.axis = text[0] - 'x';
    const char* const end = text.data() + text.size();
    const auto [next, failed] = std::from_chars(text.data() + 2, end, cut.at);
    if (failed != std::errc() || next != end || !std::isfinite(cut.at))
        malformed("--preview-cut", text, form);
    return cut;
}

PreviewColor parsePreviewColor(const std::string& text) {
    if (text == "radius") return PreviewColor::radius;
    if (text == "region") return PreviewColor::region;
    if (text == "depth") return PreviewColor::depth;
    if (text == "order") return PreviewColor::order;
    throw ParameterError("--preview-color '" + text +
                         "' is none of radius, region, depth and order");
}

std::array<int, 2> parsePreviewSize(const std::string& text) {
    const char* form = "WxH in pixels, like 1600x1200";
    std::array<int, 2> size{};
    const char* const end = text.data() + text.size();
    const auto [cross, noWidth] = std::from_chars(text.data(), end, size[0]);
    if (noWidth != std::errc() || cross == end || *cross != 'x')
        malformed("--preview-size", text, form);
    const auto [next, noHeight] = std::from_chars(cross + 1, end, size[1]);
    if (noHeight != std::errc() || next != end) malformed("--preview-size", text, form);
    checkPreviewSize(size[0], size[1]);
    return size;
}

void checkPreviewSize(int width, int height) {
    if (std::min(width, height) < kSmallest || std::max(width, height) > kLargest)
        throw ParameterError(
            fmt::format("--preview-size {}x{}: pictures have {} to {} pixels a side; take less or "
                        "more",
                        width, height, kSmallest, kLargest));
}

void checkPreviewCut(const PreviewCut& cut, const Box<3>& bounds) {
    if (cut.axis < 0 || cut.axis > 2 || !std::isfinite(cut.at))
        throw ParameterError(
            fmt::format("preview: a cut across axis {} at {} mm is no plane; axes are 0, 1 and 2",
                        cut.axis, cut.at));
    if (!(cut.at > bounds.lo[cut.axis] && cut.at < bounds.hi[cut.axis]))
        throw ParameterError(fmt::format(
            "--preview-cut {0}={1:g}: misses what there is to see, which lies between {0} = "
            "{2:.6g} and {3:.6g} mm; cut between them",
            "xyz"[cut.axis], cut.at, bounds.lo[cut.axis], bounds.hi[cut.axis]));
}

Box<3> boundsOf(const SpacePreview& scene) {
    Box<3> box;
    if (scene.pack) checkSpheres(*scene.pack);
    if (scene.pack)
        for (const auto& s : scene.pack->spheres) {
            const auto ball = Box<3>{s.center, s.center}.grown(s.radius);
            box.add(ball.lo);
            box.add(ball.hi);
        }
    for (const TriangleMesh* mesh : {scene.wall, scene.solid})
        if (mesh)
            for (const auto& v : mesh->vertices) box.add(v);
    if (box.empty())
        throw ParameterError("preview: there is nothing to see; give spheres or a surface");
    return box;
}

Box<3> checkScene(const SpacePreview& scene, const PreviewOptions& options) {
    checkPreviewSize(options.width, options.height);
    const Box<3> bounds = boundsOf(scene);
    if (options.cut) checkPreviewCut(*options.cut, bounds);
    return bounds;
}

std::string groupedCount(std::size_t n) {
    std::string text = std::to_string(n);
    for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, ",");
    return text;
}

template <int Dim>
void checkSpheres(const Pack<Dim>& pack) {
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const Sphere<Dim>& s = pack.spheres[i];
        if (!isFinite(s.center) || !(s.radius > 0) || !std::isfinite(s.radius))
            throw ParameterError(
                fmt::format("preview: {} {} has radius {} or a center that is not finite; leave "
                            "it out",
                            Measure<Dim>::kSphere, i, s.radius));
    }
}

template void checkSpheres<2>(const Pack<2>&);
template void checkSpheres<3>(const Pack<3>&);

template <int Dim>
SphereColors sphereColors(const Pack<Dim>& pack, PreviewColor by) {
    const std::size_t n = pack.spheres.size();
    const auto require = [&](std::size_t have, const char* name) {
        if (have != n)
            throw ParameterError(
                fmt::format("--preview-color {}: {} of {} {} have it; color by radius", name, have,
                            n, Measure<Dim>::kSpheres));
    };
    SphereColors colors;
    colors.color.resize(n);
    if (by == PreviewColor::region) {
        // As in files: without regions all is cortical.
        if (!pack.region.empty()) require(pack.region.size(), "region");
        const Color cortical = fromSrgb(0x4a78a8), trabecular = fromSrgb(0xf0d9a0);
        for (std::size_t i = 0; i < n; ++i)
            colors.color[i] = pack.region.empty() || pack.region[i] == 0 ? cortical : trabecular;
        colors.words = "colored by region, cortical blue, trabecular sand";
        return colors;
    }
    const char* name = by == PreviewColor::radius  ? "radius"
                       : by == PreviewColor::depth ? "depth"
                                                   : "order";
    if (by == PreviewColor::depth) require(pack.depth.size(), name);
    if (by == PreviewColor::order) require(pack.order.size(), name);
    const auto value = [&](std::size_t i) {
        return by == PreviewColor::radius  ? pack.spheres[i].radius
               : by == PreviewColor::depth ? static_cast<double>(pack.depth[i])
                                           : static_cast<double>(pack.order[i]);
    };
    double lo = n > 0 ? value(0) : 0, hi = lo;
    for (std::size_t i = 1; i < n; ++i) {
        lo = std::min(lo, value(i));
        hi = std::max(hi, value(i));
    }
    // One value, up to rounding: the middle of the ramp.
    const bool one = !(hi - lo > 1e-9 * std::fabs(hi));
    for (std::size_t i = 0; i < n; ++i)
        colors.color[i] = rampColor(one ? 0.5 : (value(i) - lo) / (hi - lo));
    const char* unit = by == PreviewColor::order ? "" : " mm";
    colors.words = one ? fmt::format("colored by {}, {:.4g}{}", name, lo, unit)
                       : fmt::format("colored by {}, {:.4g} to {:.4g}{} from dark to light", name,
                                     lo, hi, unit);
    return colors;
}

template SphereColors sphereColors<2>(const Pack<2>&, PreviewColor);
template SphereColors sphereColors<3>(const Pack<3>&, PreviewColor);

Color boneColor() {
    static const Color color = fromSrgb(0xece2cf);
    return color;
}

Color boneCutColor() {
    static const Color color = fromSrgb(0xd3a078);
    return color;
}

Color inkColor() {
    static const Color color = fromSrgb(0x2b3440);
    return color;
}

ScaleBar scaleBarFor(double mmPerPixel, int width) {
    const double most = 0.25 * width * mmPerPixel;
    if (!(most > 0) || !std::isfinite(most)) return {};
    const double ten = std::pow(10, std::floor(std::log10(most)));
    if (most >= 5 * ten) return {5 * ten, 5};
    if (most >= 2 * ten) return {2 * ten, 4};
    return {ten, 10};
}

void drawScaleBar(const ScaleBar& bar, double mmPerPixel, Image& image) {
    if (!(bar.length > 0)) return;
    const double pixels = bar.length / mmPerPixel;
    const int thick = std::max(2, image.height / 150), margin = std::max(3, image.height / 40);
    const int y1 = image.height - margin, y0 = y1 - thick;
    std::uint8_t ink[3];
    toSrgb(inkColor(), ink);
    const auto paint = [&](int x, int y, float share, bool dark) {
        if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
        for (int c = 0; c < 3; ++c) {
            std::uint8_t& to = image.pixel(x, y)[c];
            const float color = dark ? ink[c] : 255;
            to = static_cast<std::uint8_t>(to + share * (color - to) + 0.5f);
        }
    };
    for (int x = margin; x < margin + pixels + 1; ++x) {
        // Ends lie between pixels; the parts take turns in dark and white, framed.
        const double left = x - margin, inside = std::clamp(pixels - left, 0.0, 1.0);
        const auto part = static_cast<int>((left + 0.5) / pixels * bar.parts);
        const bool end = x == margin || left + 1 >= pixels;
        for (int y = y0; y < y1; ++y)
            paint(x, y, static_cast<float>(inside), end || y == y0 || y + 1 == y1 || part % 2 == 0);
    }
}

void describe(const std::string& title, const std::string& description, Image& image) {
    image.texts = {{"Title", title}, {"Description", description}};
}

}  // namespace vdbpack
