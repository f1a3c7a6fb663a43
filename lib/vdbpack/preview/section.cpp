#include "vdbpack/preview/section.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

std::vector<Box<2>> boxesOf(const std::vector<Sphere<2>>& discs) {
    std::vector<Box<2>> boxes;
    boxes.reserve(discs.size());
    for (const auto& d : discs) boxes.push_back(Box<2>{d.center, d.center}.grown(d.radius));
    return boxes;
}

std::vector<Box<2>> boxesOf(const std::vector<PlaneLines::Line>& lines, double reach) {
    std::vector<Box<2>> boxes;
    boxes.reserve(lines.size());
    for (const auto& line : lines) {
        Box<2> box;
        box.add(line.a);
        box.add(line.b);
        boxes.push_back(box.grown(reach));
    }
    return boxes;
}

}  // namespace

PlaneDiscs::PlaneDiscs(std::vector<Sphere<2>> discs, std::vector<std::int32_t> indices)
    : discs_(std::move(discs)), indices_(std::move(indices)), bins_(boxesOf(discs_)) {}

PlaneDiscs::Found PlaneDiscs::at(const Vec<2>& x) const {
    Found found;
    double highest = 0;
    bins_.near(x, [&](std::uint32_t n) {
        const Sphere<2>& disc = discs_[n];
        const double square = squaredLength(x - disc.center);
        const double height = disc.radius * disc.radius - square;
        if (!(height > highest)) return;
        highest = height;
        found.index = indices_[n];
        found.rim = disc.radius - std::sqrt(square);
    });
    return found;
}

PlaneLines::PlaneLines(std::vector<Line> lines, double reach)
    : lines_(std::move(lines)), reach_(reach), bins_(boxesOf(lines_, reach)) {}

double PlaneLines::distance(const Vec<2>& x) const {
    double nearest = reach_ * reach_;
    bins_.near(x, [&](std::uint32_t n) {
        const Line& line = lines_[n];
        const Vec<2> along = line.b - line.a, to = x - line.a;
        const double square = squaredLength(along);
        const double t = square > 0 ? std::clamp(dot(to, along) / square, 0.0, 1.0) : 0.0;
        nearest = std::min(nearest, squaredLength(to - along * t));
    });
    return nearest < reach_ * reach_ ? std::sqrt(nearest) : std::numeric_limits<double>::infinity();
}

PlaneDiscs sectionOf(const Pack<3>& pack, const PreviewCut& cut) {
    const CutAxes axes(cut.axis);
    std::vector<Sphere<2>> discs;
    std::vector<std::int32_t> indices;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const Sphere<3>& s = pack.spheres[i];
        const double d = s.center[cut.axis] - cut.at;
        if (!(std::fabs(d) < s.radius)) continue;
        discs.push_back({axes.flat(s.center), std::sqrt((s.radius - d) * (s.radius + d))});
        indices.push_back(static_cast<std::int32_t>(i));
    }
    return {std::move(discs), std::move(indices)};
}

PlaneLines sectionOf(const TriangleMesh& mesh, const PreviewCut& cut, double reach) {
    const CutAxes axes(cut.axis);
    std::vector<PlaneLines::Line> lines;
    for (const auto& t : mesh.triangles) {
        std::array<Vec<2>, 3> crossings;
        std::size_t n = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec<3>& a = mesh.vertices[t[k]];
            const Vec<3>& b = mesh.vertices[t[(k + 1) % 3]];
            const double da = a[cut.axis] - cut.at, db = b[cut.axis] - cut.at;
            // A vertex in the plane counts as above it, so that no crossing is counted twice.
            if ((da >= 0) == (db >= 0)) continue;
            crossings[n++] = axes.flat(a + (b - a) * (da / (da - db)));
        }
        if (n == 2) lines.push_back({crossings[0], crossings[1]});
    }
    return {std::move(lines), reach};
}

}  // namespace vdbpack
