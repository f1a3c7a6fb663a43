#include "vdbpack/view/shown_spheres.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/preview/section.h"
#include "vdbpack/report/report.h"
#include "vdbpack/view/exposure.h"
#include "vdbpack/view/packed_arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

constexpr double kSteps = 65535;

/// Rows by the class of their spheres, then along the curve.
void arrange(const std::vector<std::uint8_t>& classOf, std::vector<std::uint64_t> codes,
             std::vector<std::uint32_t> rows, ShownSpheres& shown) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
    keys.reserve(rows.size());
    constexpr int kCodeBits = 48;
    for (const std::uint32_t row : rows)
        keys.emplace_back(std::uint64_t{classOf[row]} << kCodeBits | codes[row], row);
    std::sort(keys.begin(), keys.end());
    shown.rows.reserve(keys.size());
    shown.codes.reserve(keys.size());
    for (const auto& [key, row] : keys) {
        shown.rows.push_back(row);
        shown.codes.push_back(codes[row]);
        if (classOf[row] == static_cast<std::uint8_t>(Exposure::outer)) ++shown.outer;
        if (classOf[row] == static_cast<std::uint8_t>(Exposure::inner)) ++shown.inner;
    }
}

/// The `most` rows of the lowest rank; of equal ranks a random selection, the same each time.
std::vector<std::uint32_t> selected(const std::vector<std::uint8_t>& rankOf, std::size_t most) {
    std::vector<std::uint32_t> rows(rankOf.size());
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<std::uint32_t>(i);
    if (rows.size() <= most) return rows;
    const auto key = [&](std::uint32_t row) {
        return std::uint64_t{rankOf[row]} << 56 | mix64(row + 0x9e3779b97f4a7c15ull) >> 8;
    };
    std::nth_element(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(most), rows.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    rows.resize(most);
    return rows;
}

template <int Dim>
std::vector<std::uint64_t> codesOf(const std::vector<Sphere<Dim>>& spheres,
                                   const Lattice& lattice) {
    std::vector<std::uint64_t> codes;
    codes.reserve(spheres.size());
    for (const auto& s : spheres) {
        const auto at = lattice.at(inSpace(s.center));
        codes.push_back(mortonCode(at[0], at[1], at[2]));
    }
    return codes;
}

/// The planes where a selection is complete: that of the cut, or the three through the middle.
std::vector<PreviewCut> favoredPlanes(const std::vector<Sphere<3>>& spheres,
                                      const ViewOptions& options) {
    if (options.cut) return {*options.cut};
    Box<3> bounds;
    for (const auto& s : spheres) bounds.add(s.center);
    const Vec<3> size = bounds.size(), center = bounds.center();
    // A round number, for the page says which.
    const double longest = std::max(*std::max_element(size.c.begin(), size.c.end()), 1e-300);
    const double unit = std::pow(10, std::floor(std::log10(longest)) - 3);
    std::vector<PreviewCut> planes;
    for (int axis = 0; axis < 3; ++axis)
        planes.push_back({axis, std::round(center[axis] / unit) * unit + 0.0});
    return planes;
}

/// "1,000,000 of 5,000,000 spheres are shown: ...".
std::string wordsOfSelection(const std::vector<std::uint8_t>& rankOf,
                             const std::vector<std::uint32_t>& rows,
                             const std::vector<PreviewCut>& planes) {
    std::array<std::size_t, 3> all{}, kept{};
    for (const std::uint8_t rank : rankOf) ++all[rank];
    for (const std::uint32_t row : rows) ++kept[rankOf[row]];
    const auto share = [&](std::size_t rank) {
        if (kept[rank] == all[rank]) return std::string("all");
        return fmt::format("{:.2g} %",
                           100 * static_cast<double>(kept[rank]) / static_cast<double>(all[rank]));
    };
    std::string near;
    for (const PreviewCut& plane : planes)
        near += fmt::format("{}{} = {:.4g}", near.empty() ? "" : ", ", "xyz"[plane.axis], plane.at);
    return fmt::format(
        "{} of {} spheres are shown: {} of those near the surface, {} of those near {} mm, {} of "
        "the others",
        grouped(rows.size()), grouped(rankOf.size()), share(0), share(1), near, share(2));
}

}  // namespace

Lattice::Lattice(const Box<3>& bounds) : lo(bounds.lo) {
    const Vec<3> size = bounds.size();
    step = std::max(*std::max_element(size.c.begin(), size.c.end()) / kSteps, 1e-300);
}

std::array<std::uint32_t, 3> Lattice::at(const Vec<3>& x) const {
    std::array<std::uint32_t, 3> place{};
    for (int d = 0; d < 3; ++d)
        place[static_cast<std::size_t>(d)] =
            static_cast<std::uint32_t>(std::clamp(std::round((x[d] - lo[d]) / step), 0.0, kSteps));
    return place;
}

Vec<3> inSpace(const Vec<3>& x) {
    return x;
}

Vec<3> inSpace(const Vec<2>& x) {
    return {{x[0], x[1], 0}};
}

ShownSpheres shownSpheres(const std::vector<Sphere<3>>& spheres, const Lattice& lattice,
                          const ViewOptions& options) {
    ShownSpheres shown;
    shown.depth = kOpticalDepth * opticalRadius(spheres);
    const std::vector<Exposure> exposure = exposureOf(spheres);
    std::vector<std::uint8_t> classOf(spheres.size());
    for (std::size_t i = 0; i < spheres.size(); ++i)
        classOf[i] = static_cast<std::uint8_t>(exposure[i]);
    std::vector<std::uint8_t> rankOf(spheres.size());
    std::vector<PreviewCut> planes;
    if (spheres.size() > options.mostSpheres) {
        planes = favoredPlanes(spheres, options);
        for (std::size_t i = 0; i < spheres.size(); ++i) {
            const auto& s = spheres[i];
            const bool isNear = std::any_of(planes.begin(), planes.end(), [&](const auto& plane) {
                const double below = keptDepth(plane, s.center);
                return below > -s.radius && below < shown.depth;
            });
            rankOf[i] = exposure[i] == Exposure::outer ? 0 : isNear ? 1 : 2;
        }
    }
    auto rows = selected(rankOf, options.mostSpheres);
    if (rows.size() < spheres.size()) shown.words = wordsOfSelection(rankOf, rows, planes);
    arrange(classOf, codesOf(spheres, lattice), std::move(rows), shown);
    return shown;
}

ShownSpheres shownSpheres(const std::vector<Sphere<2>>& circles, const Lattice& lattice,
                          const ViewOptions& options) {
    ShownSpheres shown;
    const std::vector<std::uint8_t> same(circles.size());
    auto rows = selected(same, options.mostSpheres);
    if (rows.size() < circles.size())
        shown.words = fmt::format("{} of {} circles are shown, at random", grouped(rows.size()),
                                  grouped(circles.size()));
    arrange(same, codesOf(circles, lattice), std::move(rows), shown);
    return shown;
}

}  // namespace vdbpack
