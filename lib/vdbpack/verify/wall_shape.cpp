#include "vdbpack/verify/wall_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

template <int Dim>
double innerDistance(const std::vector<HalfSpace<Dim>>& clips, const Vec<Dim>& x) {
    double d = std::numeric_limits<double>::infinity();
    for (const auto& c : clips) d = std::min(d, (c.offset - dot(c.normal, x)) / length(c.normal));
    return d;
}

template <int Dim>
WallShape<Dim> WallShape<Dim>::ofBox(const Box<Dim>& box) {
    WallShape shape;
    shape.kind = Kind::box;
    shape.box = box;
    return shape;
}

template <int Dim>
WallShape<Dim> WallShape<Dim>::ofBall(double radius, const Vec<Dim>& center) {
    WallShape shape;
    shape.kind = Kind::ball;
    shape.radius = radius;
    shape.center = center;
    return shape;
}

template <int Dim>
WallShape<Dim> WallShape<Dim>::ofCylinder(double radius, double height, const Vec<Dim>& center) {
    static_assert(Dim == 2 || Dim == 3);
    WallShape shape;
    shape.kind = Dim == 3 ? Kind::cylinder : Kind::ball;
    shape.radius = radius;
    shape.height = height;
    shape.center = center;
    return shape;
}

template <int Dim>
double WallShape<Dim>::innerDistance(const Vec<Dim>& x) const {
    // Depth below each wall; outside, the walls passed add up like the legs of a triangle.
    double least = std::numeric_limits<double>::infinity(), outside2 = 0;
    const auto wall = [&](double depth) {
        least = std::min(least, depth);
        if (depth < 0) outside2 += depth * depth;
    };
    switch (kind) {
        case Kind::box:
            for (int i = 0; i < Dim; ++i)
                if (!wraps[static_cast<std::size_t>(i)])
                    wall(std::min(x[i] - box.lo[i], box.hi[i] - x[i]));
            break;
        case Kind::ball:
            wall(radius - length(x - center));
            break;
        case Kind::cylinder:
            wall(radius - std::hypot(x[0] - center[0], x[1] - center[1]));
            wall(height / 2 - std::abs(x[Dim - 1] - center[Dim - 1]));
            break;
    }
    const double own = least < 0 ? -std::sqrt(outside2) : least;
    return std::min(own, vdbpack::innerDistance(clips, x));
}

std::optional<WallShape<2>> sliceShape(const WallShape<3>& shape, double height) {
    WallShape<2> cut;
    const double z = height - shape.center[2];
    switch (shape.kind) {
        case WallShape<3>::Kind::box:
            if (!(height > shape.box.lo[2] && height < shape.box.hi[2])) return std::nullopt;
            cut = WallShape<2>::ofBox(
                {{{shape.box.lo[0], shape.box.lo[1]}}, {{shape.box.hi[0], shape.box.hi[1]}}});
            break;
        case WallShape<3>::Kind::ball:
            if (!(std::abs(z) < shape.radius)) return std::nullopt;
            cut = WallShape<2>::ofBall(std::sqrt((shape.radius - z) * (shape.radius + z)),
                                       {{shape.center[0], shape.center[1]}});
            break;
        case WallShape<3>::Kind::cylinder:
            if (!(std::abs(z) < shape.height / 2)) return std::nullopt;
            cut = WallShape<2>::ofBall(shape.radius, {{shape.center[0], shape.center[1]}});
            break;
    }
    for (const auto& c : shape.clips) {
        const HalfSpace<2> line{{{c.normal[0], c.normal[1]}}, c.offset - c.normal[2] * height};
        if (length(line.normal) > 0)
            cut.clips.push_back(line);
        else if (line.offset < 0)
            return std::nullopt;
    }
    return cut;
}

template double innerDistance<2>(const std::vector<HalfSpace<2>>&, const Vec<2>&);
template double innerDistance<3>(const std::vector<HalfSpace<3>>&, const Vec<3>&);
template struct WallShape<2>;
template struct WallShape<3>;

}  // namespace vdbpack
