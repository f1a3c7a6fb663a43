#include "vdbpack/view/contour_lines.h"

#include <array>
#include <cstddef>

namespace vdbpack {

std::vector<Vec<2>> contourLines(const PlaneField& field) {
    std::vector<Vec<2>> ends;
    const auto distance = [&](std::int64_t i, std::int64_t j) {
        return static_cast<double>(field.distance[static_cast<std::size_t>(j * field.columns + i)]);
    };
    for (std::int64_t j = 0; j + 1 < field.rows; ++j)
        for (std::int64_t i = 0; i + 1 < field.columns; ++i) {
            // The corners of a cell in turn around it.
            const std::array<std::array<std::int64_t, 2>, 4> corners{
                {{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
            std::array<Vec<2>, 4> crossings;
            std::size_t n = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                const auto &a = corners[k], &b = corners[(k + 1) % 4];
                const double da = distance(a[0], a[1]), db = distance(b[0], b[1]);
                if ((da < 0) == (db < 0)) continue;
                const double t = da / (da - db);
                const auto along = [&](std::size_t d) {
                    return (static_cast<double>(a[d]) + t * static_cast<double>(b[d] - a[d])) *
                           field.step;
                };
                crossings[n++] = field.origin + Vec<2>{{along(0), along(1)}};
            }
            // Of four crossings, each line joins two that follow one another.
            for (std::size_t k = 0; k + 1 < n; k += 2) {
                ends.push_back(crossings[k]);
                ends.push_back(crossings[k + 1]);
            }
        }
    return ends;
}

}  // namespace vdbpack
