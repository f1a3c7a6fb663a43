#include "vdbpack/measure/pair_correlation.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

constexpr std::size_t kFewestReferences = 100;
constexpr std::size_t kMostReferences = 100'000;

}  // namespace

template <int Dim>
std::optional<PairCorrelation> pairCorrelation(const std::vector<Sphere<Dim>>& spheres,
                                               const std::vector<float>& depth, double reach,
                                               double volume, int bins) {
    if (!(reach > 0 && std::isfinite(reach)) || bins < 1 || bins > 1'000'000)
        throw ParameterError(
            fmt::format("pair correlation: {} bins up to {} mm; give a positive number of each, "
                        "at most 1,000,000 bins",
                        bins, reach));
    if (depth.size() != spheres.size())
        throw ParameterError(fmt::format("pair correlation: {} depths for {} {}; give one each",
                                         depth.size(), spheres.size(), Measure<Dim>::kSpheres));
    requireUsable(spheres);
    std::vector<std::uint32_t> deep;
    for (std::size_t i = 0; i < spheres.size(); ++i)
        if (static_cast<double>(depth[i]) >= reach) deep.push_back(static_cast<std::uint32_t>(i));
    if (deep.size() < kFewestReferences || !(volume > 0)) return std::nullopt;
    PairCorrelation result;
    result.width = reach / bins;
    result.density = static_cast<double>(deep.size()) / volume;
    // Evenly along the pack's order, which is not spatial alone.
    const std::size_t stride = (deep.size() + kMostReferences - 1) / kMostReferences;
    result.references = (deep.size() + stride - 1) / stride;

    const CellLevels<Dim> cells(spheres);
    using Counts = std::vector<std::uint64_t>;
    tbb::enumerable_thread_specific<Counts> counts(Counts(static_cast<std::size_t>(bins)));
    const double perBin = 1 / result.width;
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, result.references, 64), [&](const auto& block) {
            Counts& mine = counts.local();
            for (std::size_t k = block.begin(); k < block.end(); ++k) {
                const std::uint32_t i = deep[k * stride];
                const Vec<Dim>& x = spheres[i].center;
                cells.forEachNear(x, reach, [&](std::uint32_t j, const Sphere<Dim>& s) {
                    const double square = squaredLength(s.center - x);
                    if (j != i && square < reach * reach)
                        ++mine[std::min(mine.size() - 1,
                                        static_cast<std::size_t>(std::sqrt(square) * perBin))];
                    return true;
                });
            }
        });
    for (std::size_t b = 0; b < static_cast<std::size_t>(bins); ++b) {
        double pairs = 0;
        for (const Counts& c : counts) pairs += static_cast<double>(c[b]);
        const double shell = Measure<Dim>::ball(static_cast<double>(b + 1) * result.width) -
                             Measure<Dim>::ball(static_cast<double>(b) * result.width);
        const double expected = static_cast<double>(result.references) * result.density * shell;
        result.g.push_back(pairs / expected);
        result.error.push_back(std::sqrt(pairs) / expected);
    }
    return result;
}

template std::optional<PairCorrelation> pairCorrelation<2>(const std::vector<Sphere<2>>&,
                                                           const std::vector<float>&, double,
                                                           double, int);
template std::optional<PairCorrelation> pairCorrelation<3>(const std::vector<Sphere<3>>&,
                                                           const std::vector<float>&, double,
                                                           double, int);

}  // namespace vdbpack
