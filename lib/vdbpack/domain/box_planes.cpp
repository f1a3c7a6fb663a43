#include "vdbpack/domain/box_planes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vdbpack {

namespace {

/// The point where Dim planes meet, by Cramer's rule; false if they nearly do not.
bool meetingPoint(const std::array<HalfSpace<2>, 2>& p, Vec<2>& x) {
    const double det = p[0].normal[0] * p[1].normal[1] - p[0].normal[1] * p[1].normal[0];
    if (std::abs(det) < 1e-9) return false;
    x[0] = (p[0].offset * p[1].normal[1] - p[0].normal[1] * p[1].offset) / det;
    x[1] = (p[0].normal[0] * p[1].offset - p[0].offset * p[1].normal[0]) / det;
    return true;
}

bool meetingPoint(const std::array<HalfSpace<3>, 3>& p, Vec<3>& x) {
    const Vec<3> c = cross(p[1].normal, p[2].normal);
    const double det = dot(p[0].normal, c);
    if (std::abs(det) < 1e-9) return false;
    x = (c * p[0].offset + cross(p[2].normal, p[0].normal) * p[1].offset +
         cross(p[0].normal, p[1].normal) * p[2].offset) *
        (1 / det);
    return true;
}

}  // namespace

template <int Dim>
std::vector<HalfSpace<Dim>> halfSpacesOf(const Box<Dim>& box) {
    std::vector<HalfSpace<Dim>> planes;
    for (int d = 0; d < Dim; ++d) {
        HalfSpace<Dim> low, high;
        low.normal[d] = -1;
        low.offset = -box.lo[d];
        high.normal[d] = 1;
        high.offset = box.hi[d];
        planes.push_back(low);
        planes.push_back(high);
    }
    return planes;
}

/// Of the corners: points where Dim planes meet and that lie inside all others.
template <int Dim>
Box<Dim> cutBounds(const Box<Dim>& box, std::vector<HalfSpace<Dim>> planes) {
    Box<Dim> bounds;
    if (box.empty()) return bounds;
    for (const HalfSpace<Dim>& side : halfSpacesOf(box)) planes.push_back(side);
    double size = 0;
    for (int i = 0; i < Dim; ++i) size = std::max({size, std::abs(box.lo[i]), std::abs(box.hi[i])});
    const auto addCorner = [&](const std::array<HalfSpace<Dim>, Dim>& meeting) {
        Vec<Dim> x;
        if (!meetingPoint(meeting, x)) return;
        for (const auto& plane : planes)
            if (dot(plane.normal, x) > plane.offset + 1e-9 * size) return;
        bounds.add(x);
    };
    for (std::size_t i = 0; i < planes.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            if constexpr (Dim == 2) {
                addCorner({planes[i], planes[j]});
            } else {
                for (std::size_t k = 0; k < j; ++k) addCorner({planes[i], planes[j], planes[k]});
            }
        }
    return bounds.empty() ? bounds : intersection(bounds, box);
}

template std::vector<HalfSpace<2>> halfSpacesOf(const Box<2>&);
template std::vector<HalfSpace<3>> halfSpacesOf(const Box<3>&);
template Box<2> cutBounds(const Box<2>&, std::vector<HalfSpace<2>>);
template Box<3> cutBounds(const Box<3>&, std::vector<HalfSpace<3>>);

}  // namespace vdbpack
