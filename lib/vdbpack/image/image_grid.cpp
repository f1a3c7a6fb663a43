#include "vdbpack/image/image_grid.h"

#include <cmath>

namespace vdbpack {

Vec<3> ImageGrid::indexOf(const Vec<3>& point) const {
    return ImageIndexer(*this).indexOf(point);
}

ImageIndexer::ImageIndexer(const ImageGrid& grid)
    : origin_(grid.origin),
      across_{cross(grid.step[1], grid.step[2]), cross(grid.step[2], grid.step[0]),
              cross(grid.step[0], grid.step[1])},
      volume_(grid.signedVoxelVolume()) {}

Vec<3> ImageGrid::reach() const {
    // Lengths of the dual steps.
    const double volume = std::fabs(signedVoxelVolume());
    return {{length(cross(step[1], step[2])) / volume, length(cross(step[2], step[0])) / volume,
             length(cross(step[0], step[1])) / volume}};
}

Box<3> ImageGrid::bounds() const {
    Box<3> box;
    for (int corner = 0; corner < 8; ++corner) {
        Vec<3> index;
        for (int d = 0; d < 3; ++d)
            index[d] =
                (corner >> d & 1 ? static_cast<double>(size[static_cast<std::size_t>(d)]) : 0) -
                0.5;
        box.add(at(index));
    }
    return box;
}

std::string ImageGrid::orientation() const {
    // The assignment of axes to directions with the largest sum of cosines.
    constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                   {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    const auto along = [&](int axis, int direction) {
        const Vec<3>& s = step[static_cast<std::size_t>(axis)];
        return s[direction] / length(s);
    };
    const int(*best)[3] = &kOrders[0];
    double most = -1;
    for (const auto& order : kOrders) {
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis) sum += std::fabs(along(axis, order[axis]));
        if (sum > most + 1e-9) {
            most = sum;
            best = &order;
        }
    }
    std::string code;
    for (int axis = 0; axis < 3; ++axis) {
        const int direction = (*best)[axis];
        code += along(axis, direction) > 0 ? "LPS"[direction] : "RAI"[direction];
    }
    return code;
}

ImageGrid alongAxes(ImageGrid grid) {
    for (std::size_t d = 0; d < 3; ++d) {
        const double step = length(grid.step[d]);
        const auto axis = static_cast<int>(d);
        if (std::fabs(std::fabs(grid.step[d][axis]) - step) > 1e-6 * step) {
            for (std::size_t e = 0; e < 3; ++e) {
                Vec<3> along;
                along[static_cast<int>(e)] = length(grid.step[e]);
                grid.step[e] = along;
            }
            return grid;
        }
    }
    return grid;
}

}  // namespace vdbpack
