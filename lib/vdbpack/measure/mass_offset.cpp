#include "vdbpack/measure/mass_offset.h"

#include "vdbpack/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbpack {

template <int Dim>
std::optional<MassOffset> massOffset(const std::vector<Sphere<Dim>>& spheres,
                                     const Domain<Dim>& domain, Ranks* ranks) {
    const auto centroid = domain.centroid();
    const PeriodicCell<Dim> cell = domain.cell();
    if (!centroid || cell.all()) return std::nullopt;
    const Vec<Dim> size = domain.bounds().size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    // Sums of shares of the domain, then of these times positions from -1 to 1, in whole numbers:
    // they do not depend on the order.
    using Sums = std::vector<std::uint64_t>;
    const double whole = 0x1p58 / domain.volume();
    PerThread<Sums> parts([] { return Sums(Dim + 1); });
    parallelFor(IndexRange(0, spheres.size(), 4096), [&](const IndexRange& block) {
        Sums& part = parts.local();
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            const double mass = whole * Measure<Dim>::ball(spheres[i].radius);
            const Vec<Dim> x = (spheres[i].center - *centroid) * (1 / longest);
            for (int d = 0; d <= Dim; ++d)
                part[static_cast<std::size_t>(d)] +=
                    static_cast<std::uint64_t>(std::llrint(d < Dim ? mass * x[d] : mass));
        }
    });
    Sums sums(Dim + 1);
    for (const Sums& part : parts)
        for (std::size_t d = 0; d <= Dim; ++d) sums[d] += part[d];
    if (ranks) ranks->sum(sums);
    const auto valueOf = [](std::uint64_t sum) {
        return static_cast<double>(static_cast<std::int64_t>(sum));
    };
    if (sums[Dim] == 0) return std::nullopt;
    MassOffset offset;
    for (std::size_t d = 0; d < Dim; ++d) {
        if (cell.isAlong(static_cast<int>(d))) continue;
        offset.axes[d] = longest * valueOf(sums[d]) / valueOf(sums[Dim]);
        offset.length = std::hypot(offset.length, *offset.axes[d]);
    }
    offset.share = offset.length / longest;
    return offset;
}

template std::optional<MassOffset> massOffset(const std::vector<Sphere<2>>&, const Domain<2>&,
                                              Ranks*);
template std::optional<MassOffset> massOffset(const std::vector<Sphere<3>>&, const Domain<3>&,
                                              Ranks*);

}  // namespace vdbpack
