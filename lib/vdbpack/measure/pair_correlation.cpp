#include "vdbpack/measure/pair_correlation.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/measure/space_shares.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

constexpr std::size_t kFewestReferences = 100;
constexpr std::size_t kMostReferences = 100'000;

using Counts = std::vector<std::uint64_t>;

/// Adds the distances below `reach` from the spheres at `references` to all others.
template <int Dim>
void addPairs(const std::vector<Sphere<Dim>>& spheres, const std::vector<std::uint32_t>& references,
              double reach, Counts& pairs) {
    const CellLevels<Dim> cells(spheres);
    PerThread<Counts> counts([&] { return Counts(pairs.size()); });
    const double perBin = static_cast<double>(pairs.size()) / reach;
    parallelFor(IndexRange(0, references.size(), 64), [&](const auto& block) {
        Counts& mine = counts.local();
        for (std::size_t k = block.begin(); k < block.end(); ++k) {
            const std::uint32_t i = references[k];
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
    for (const Counts& mine : counts)
        for (std::size_t b = 0; b < pairs.size(); ++b) pairs[b] += mine[b];
}

template <int Dim>
void checkRequest(const std::vector<Sphere<Dim>>& spheres, std::size_t depths, double reach,
                  int bins, const SphereRows& rows, const PeriodicCell<Dim>& cell) {
    if (!(reach > 0 && std::isfinite(reach)) || bins < 1 || bins > 1'000'000)
        throw ParameterError(
            fmt::format("pair correlation: {} bins up to {} mm; give a positive number of each, "
                        "at most 1,000,000 bins",
                        bins, reach));
    if (depths != spheres.size() && !(depths == 0 && cell.all()))
        throw ParameterError(fmt::format("pair correlation: {} depths for {} {}; give one each",
                                         depths, spheres.size(), Measure<Dim>::kSpheres));
    if (reach > 0.5 * cell.shortest() || (cell.any() && rows.ranks))
        throw ParameterError(
            fmt::format("pair correlation: {} mm in a periodic cell {} mm long; give at most half "
                        "its length, to one process",
                        reach, cell.shortest()));
    requireUsable(spheres);
}

}  // namespace

template <int Dim>
std::optional<PairCorrelation> pairCorrelation(const std::vector<Sphere<Dim>>& spheres,
                                               const std::vector<float>& depth, double reach,
                                               double volume, int bins, const SphereRows& rows,
                                               const PeriodicCell<Dim>& cell) {
    checkRequest(spheres, depth.size(), reach, bins, rows, cell);
    const auto isDeep = [&](std::size_t i) {
        return depth.empty() || static_cast<double>(depth[i]) >= reach;
    };
    std::uint64_t deep = 0;
    for (std::size_t i = 0; i < spheres.size(); ++i) deep += isDeep(i);
    deep = sumOver(rows.ranks, deep);
    if (deep < kFewestReferences || !(volume > 0)) return std::nullopt;
    PairCorrelation result;
    result.width = reach / bins;
    result.density = static_cast<double>(deep) / volume;
    // Evenly along the pack's order, which is not spatial alone.
    const std::uint64_t stride = (deep + kMostReferences - 1) / kMostReferences;
    const auto isReference = [&](std::size_t i) { return isDeep(i) && rows[i] % stride == 0; };

    Counts counts(static_cast<std::size_t>(bins));
    if (!rows.ranks) {
        std::vector<std::uint32_t> references;
        for (std::size_t i = 0; i < spheres.size(); ++i)
            if (isReference(i)) references.push_back(static_cast<std::uint32_t>(i));
        result.references = references.size();
        if (cell.any())
            addPairs(withImages(spheres, cell, reach).spheres, references, reach, counts);
        else
            addPairs(spheres, references, reach, counts);
    } else {
        std::vector<std::int64_t> marks(spheres.size());
        for (std::size_t i = 0; i < spheres.size(); ++i) marks[i] = isReference(i);
        SpaceShares<Dim> shares(*rows.ranks, spheres, marks, {0, reach});
        for (std::size_t round = 0; round < shares.rounds(); ++round) {
            const auto part = shares.part(round);
            std::vector<std::uint32_t> references;
            for (std::size_t i = 0; i < part.own; ++i)
                if (part.rows[i]) references.push_back(static_cast<std::uint32_t>(i));
            result.references += references.size();
            addPairs(part.spheres, references, reach, counts);
        }
        result.references = sumOver(rows.ranks, result.references);
        rows.ranks->sum(counts);
    }
    for (std::size_t b = 0; b < counts.size(); ++b) {
        const auto pairs = static_cast<double>(counts[b]);
        const double shell = Measure<Dim>::ball(static_cast<double>(b + 1) * result.width) -
                             Measure<Dim>::ball(static_cast<double>(b) * result.width);
        const double expected = static_cast<double>(result.references) * result.density * shell;
        result.g.push_back(pairs / expected);
        result.error.push_back(std::sqrt(pairs) / expected);
    }
    return result;
}

#define VDBPACK_INSTANTIATE(Dim)                                                         \
    template std::optional<PairCorrelation> pairCorrelation(                             \
        const std::vector<Sphere<Dim>>&, const std::vector<float>&, double, double, int, \
        const SphereRows&, const PeriodicCell<Dim>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
