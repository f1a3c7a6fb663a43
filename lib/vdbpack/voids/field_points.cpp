#include "vdbpack/voids/field_points.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

constexpr double kFarthest = 1e9;  ///< from the origin, mm

std::string describe(const Box<3>& box) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g}) mm", box.lo[0],
                       box.lo[1], box.lo[2], box.hi[0], box.hi[1], box.hi[2]);
}

}  // namespace

PointColumns::PointColumns(const NumberTable& table)
    : columns_{table.require({"x", "points0", "coord1", "coor1"}),
               table.require({"y", "points1", "coord2", "coor2"}),
               table.find({"z", "points2", "coord3", "coor3"})} {}

Vec<3> PointColumns::point(const NumberTable& table, double scale) const {
    Vec<3> x;
    for (std::size_t d = 0; d < 3; ++d)
        x.c[d] = columns_[d] ? table.number(*columns_[d]) * scale : 0;
    for (const double c : x.c)
        if (!(std::fabs(c) <= kFarthest))
            table.failRow("the point lies more than 1e9 mm from the origin; check the unit");
    return x;
}

Box<3> coveredBy(const Box<3>& points, bool planar) {
    const Vec<3> size = points.size();
    const double longest = std::max({size[0], size[1], size[2]});
    Box<3> box = points;
    for (int d = 0; d < 3; ++d) {
        const double margin = std::max(0.1 * size[d], 0.01 * longest);
        box.lo[d] -= margin;
        box.hi[d] += margin;
    }
    if (planar) {
        box.lo[2] = -std::numeric_limits<double>::infinity();
        box.hi[2] = std::numeric_limits<double>::infinity();
    }
    return box;
}

template <int Dim>
void requireCovered(const std::string& field, const Box<3>& covered, const Box<Dim>& bounds,
                    double sliceHeight) {
    Box<3> needed{{{0, 0, sliceHeight}}, {{0, 0, sliceHeight}}};
    for (int d = 0; d < Dim; ++d) {
        needed.lo[d] = bounds.lo[d];
        needed.hi[d] = bounds.hi[d];
    }
    // Both may be computed from the same numbers in different ways.
    const double rounding = 1e-9 * length(needed.size());
    if (covered.grown(rounding).contains(needed.lo) && covered.grown(rounding).contains(needed.hi))
        return;
    throw InputError(fmt::format(
        "{} covers {}, but the domain spans {}; check the unit and the origin of the field, or "
        "extend it over the domain",
        field, describe(covered), describe(needed)));
}

template void requireCovered(const std::string&, const Box<3>&, const Box<2>&, double);
template void requireCovered(const std::string&, const Box<3>&, const Box<3>&, double);

}  // namespace vdbpack
