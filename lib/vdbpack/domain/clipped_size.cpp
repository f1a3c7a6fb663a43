// What clips and other parts leave of a file, estimated.
#include "vdbpack/core/weyl.h"
#include "vdbpack/domain/clipped_domain.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/mesh_sides.h"
#include "vdbpack/verify/wall_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

/// Points by which a volume is estimated, to about 1 %.
constexpr std::size_t kVolumePoints = 40000;
/// Thickness of the layer at a cut in which they are counted for its area, as share of the size.
constexpr double kCutLayer = 0.02;

/// How deep a point lies inside the half-spaces, mm.
double depthIn(const std::vector<HalfSpace<3>>& clips, const Vec<3>& x) {
    double least = std::numeric_limits<double>::infinity();
    for (const HalfSpace<3>& h : clips)
        least = std::min(least, (h.offset - dot(h.normal, x)) / length(h.normal));
    return least;
}

/// What half-spaces along the axes, which most are, leave of a box.
Box<3> narrowed(Box<3> box, const std::vector<HalfSpace<3>>& clips) {
    for (const HalfSpace<3>& h : clips)
        for (int d = 0; d < 3; ++d) {
            const double along = h.normal[d];
            if (std::fabs(std::fabs(along) - length(h.normal)) > 1e-12) continue;
            if (along > 0)
                box.hi[d] = std::min(box.hi[d], h.offset / along);
            else
                box.lo[d] = std::max(box.lo[d], h.offset / along);
        }
    return box;
}

double areaIn(const std::vector<HalfSpace<3>>& clips, const TriangleMesh& mesh) {
    double area = 0;
    for (const auto& t : mesh.triangles) {
        const Vec<3>&a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        if (depthIn(clips, (1.0 / 3) * (a + b + c)) >= 0) area += 0.5 * length(cross(b - a, c - a));
    }
    return area;
}

/// The length of the outline of a slice, mm.
double outlineAt(double height, const std::vector<HalfSpace<3>>& clips, const TriangleMesh& mesh) {
    double sum = 0;
    for (const WallPiece<2>& s : sliceSegments(mesh, height)) {
        const Vec<2> middle = 0.5 * (s[0] + s[1]);
        if (depthIn(clips, {{middle[0], middle[1], height}}) >= 0) sum += length(s[1] - s[0]);
    }
    return sum;
}

}  // namespace

DomainSource::Left DomainSource::left(bool byParts) const {
    if (!mesh_) return {volume(), 0};
    const std::size_t others = byParts ? outsides_.size() : 0;
    if (clips_.empty() && others == 0 && !recipe_.slice)
        return {fileVolume(), analysis_->health.area};
    Box<3> box = narrowed(fileBounds_, clips_);
    if (recipe_.slice) box.lo[2] = box.hi[2] = *recipe_.slice;
    if (box.empty()) throw nothingLeft(fileBounds_);
    std::vector<MeshSides> sides;
    const auto add = [&](const DomainSource& source) {
        sides.emplace_back(*source.mesh_, source.analysis_->health.isWatertight());
    };
    add(*this);
    for (std::size_t n = 0; n < others; ++n) add(*outsides_[n]);
    const double layer = kCutLayer * length(box.size());
    double inside = 0, atCut = 0;
    for (std::size_t n = 0; n < kVolumePoints; ++n) {
        const Vec<3> x = weylPoint(n, box);
        const double depth = depthIn(clips_, x);
        if (depth < 0 || !std::all_of(sides.begin(), sides.end(),
                                      [&](const MeshSides& one) { return one.inside(x); }))
            continue;
        ++inside;
        if (depth < layer) ++atCut;
    }
    const Vec<3> size = box.size();
    const double each = size[0] * size[1] * (recipe_.slice ? 1 : size[2]) / kVolumePoints;
    // What no point has found may still be there.
    return {each * std::max(inside, 0.5),
            each * atCut / layer + (recipe_.slice ? outlineAt(*recipe_.slice, clips_, *mesh_)
                                                  : areaIn(clips_, *mesh_))};
}

}  // namespace vdbpack
