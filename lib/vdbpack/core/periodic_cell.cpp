#include "vdbpack/core/periodic_cell.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

namespace vdbpack {

template <int Dim>
SpheresWithImages<Dim> withImages(const std::vector<Sphere<Dim>>& spheres,
                                  const PeriodicCell<Dim>& cell, double reach) {
    SpheresWithImages<Dim> result;
    result.own = spheres.size();
    result.spheres = spheres;
    result.source.resize(spheres.size());
    for (std::size_t i = 0; i < result.own; ++i) {
        result.source[i] = static_cast<std::uint32_t>(i);
        result.spheres[i].center = cell.wrapped(spheres[i].center);
        const Sphere<Dim> s = result.spheres[i];
        const Box<Dim> at{s.center, s.center};
        cell.forEachShift(at, cell.box.grown(reach + s.radius), [&](const Vec<Dim>& shift) {
            if (squaredLength(shift) == 0) return;
            result.spheres.push_back({s.center + shift, s.radius});
            result.source.push_back(static_cast<std::uint32_t>(i));
        });
    }
    return result;
}

template <int Dim>
void requireLongCell(const PeriodicCell<Dim>& cell, double largest, double diameters) {
    const double least = diameters * 2 * largest;
    if (cell.shortest() >= least) return;
    int axis = 0;
    for (int d = Dim; d-- > 0;)
        if (cell.isAlong(d) && cell.length(d) <= cell.shortest()) axis = d;
    throw InputError(fmt::format(
        "the periodic cell is {:.6g} mm long along {}, less than {:g} diameters of the largest {}, "
        "{:.6g} mm with any gap. {}",
        cell.shortest(), "xyz"[axis], diameters, Measure<Dim>::kSphere, least,
        diameters < kCellDiameters ? "Check the cell, and the unit of the pack"
                                   : "Give a longer cell or smaller radii"));
}

template SpheresWithImages<2> withImages(const std::vector<Sphere<2>>&, const PeriodicCell<2>&,
                                         double);
template SpheresWithImages<3> withImages(const std::vector<Sphere<3>>&, const PeriodicCell<3>&,
                                         double);
template void requireLongCell(const PeriodicCell<2>&, double, double);
template void requireLongCell(const PeriodicCell<3>&, double, double);

}  // namespace vdbpack
