#include "vdbpack/report/densified_pack.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/clock.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/formats/joined_packs.h"
#include "vdbpack/measure/bond_order.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/space_shares.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

/// Share of the spheres in crystalline order from which a pack is no longer called random.
constexpr double kCrystal = 0.07;

constexpr auto& kTolerances = Report::Densified::kContactTolerances;

/// The coordination numbers without walls; over ranks: of the spheres of all.
/// @param labels  over ranks: a number of each sphere.
template <int Dim>
std::array<double, 3> contactsOf(const std::vector<Sphere<Dim>>& spheres, Ranks* ranks,
                                 const std::vector<std::int64_t>& labels,
                                 const PeriodicCell<Dim>& cell) {
    std::vector<std::uint64_t> partners(kTolerances.size() + 1);
    partners.back() = spheres.size();
    const auto add = [&](const std::vector<Sphere<Dim>>& all, std::size_t own) {
        const auto found = partnersOfPart(all, own, kTolerances);
        for (std::size_t k = 0; k < found.size(); ++k) partners[k] += found[k];
    };
    if (ranks) {
        SpaceShares<Dim> shares(*ranks, spheres, labels, {kTolerances.back(), 0, cell});
        for (std::size_t round = 0; round < shares.rounds(); ++round) {
            const auto part = shares.part(round);
            add(part.spheres, part.own);
        }
        ranks->sum(partners);
    } else {
        add(withPartners(spheres, kTolerances.back(), cell).spheres, spheres.size());
    }
    std::array<double, 3> means{};
    for (std::size_t k = 0; k < means.size(); ++k)
        means[k] = static_cast<double>(partners[k]) /
                   static_cast<double>(std::max<std::uint64_t>(partners.back(), 1));
    return means;
}

/// The share in crystalline order, as `contactsOf`.
template <int Dim>
double solidLikeOf(const std::vector<Sphere<Dim>>& spheres, Ranks* ranks,
                   const std::vector<std::int64_t>& labels, const PeriodicCell<Dim>& cell) {
    if (!ranks) return solidLikeShare(spheres, cell);
    double largest = 0;
    for (const Sphere<Dim>& s : spheres) largest = std::max(largest, s.radius);
    largest = maxOver(ranks, largest);
    SpaceShares<Dim> shares(*ranks, spheres, labels, {0, 2 * bondReach(largest), cell});
    std::uint64_t count = 0;
    for (std::size_t round = 0; round < shares.rounds(); ++round) {
        const auto part = shares.part(round);
        count += solidLikeOfPart(part.spheres, part.own);
    }
    count = sumOver(ranks, count);
    const std::uint64_t all = sumOver(ranks, std::uint64_t{spheres.size()});
    return all > 0 ? static_cast<double>(count) / static_cast<double>(all) : 0;
}

/// Gives the spheres from `before` on what the nearest sphere before them has in columns.
template <int Dim>
void takeColumns(std::vector<Column> columns, std::size_t before, Pack<Dim>& pack) {
    const std::size_t all = pack.spheres.size();
    const auto sought = static_cast<std::ptrdiff_t>(before < all ? before : 0);
    const CellLevels<Dim> present({pack.spheres.begin(), pack.spheres.begin() + sought});
    for (Column& column : columns) {
        if (!column.numbers.empty()) column.numbers.resize(all);
        if (!column.texts.empty()) column.texts.resize(all);
    }
    parallelFor(before, all, [&](std::size_t i) {
        const Sphere<Dim>& own = pack.spheres[i];
        std::size_t nearest = before;
        for (double reach = own.radius; nearest == before; reach *= 2) {
            double least = reach;
            present.forEachNear(own.center, reach, [&](std::uint32_t k, const Sphere<Dim>& s) {
                const double away = length(s.center - own.center) - s.radius;
                if (away < least || (away == least && k < nearest)) least = away, nearest = k;
                return true;
            });
        }
        for (Column& column : columns) {
            if (!column.numbers.empty()) column.numbers[i] = column.numbers[nearest];
            if (!column.texts.empty()) column.texts[i] = column.texts[nearest];
        }
    });
    pack.columns = std::move(columns);
}

/// Warns if the result differs from the request.
/// @param crystalline  share of spheres in crystalline order, if there are too many.
template <int Dim>
void warnOfResult(const DensifyResult<Dim>& result, double fraction, const PeriodicCell<Dim>& cell,
                  std::optional<double> crystalline, const Callbacks& callbacks) {
    if (!result.interrupted && !result.apart)
        callbacks.warn(
            fmt::format("densify: the overlaps of the input {} were not resolved in {} steps; the "
                        "pack is unchanged. There are too many for the domain, or some lie far "
                        "outside it",
                        Measure<Dim>::kSpheres, result.steps));
    else if (!result.interrupted && !result.reached && std::isfinite(fraction))
        callbacks.warn(fmt::format(
            "densify: the solid fraction {} was requested, {:.4f} was reached{}", fraction,
            result.after,
            cell.all() ? std::string()
                       : fmt::format("; smaller {} reach more", Measure<Dim>::kSpheres)));
    if (crystalline)
        callbacks.warn(fmt::format(
            "densify: {:.0f} % of the spheres are in crystalline order: nearly equal "
            "ones reach {:.4f} in no other way here. Request a lower solid fraction{}",
            100 * *crystalline, result.after,
            std::isfinite(fraction) ? ", or max for the densest pack that is about random"
                                    : " for a pack that is random along its walls, too"));
}

}  // namespace

template <int Dim>
void densifyPack(const Domain<Dim>& domain, DensifyOptions options,
                 std::vector<std::int64_t>& pieces, Pack<Dim>& pack, Report& report,
                 const Callbacks& callbacks) {
    Clock clock;
    Report::Densified told;
    if (std::isfinite(options.fraction)) told.requested = options.fraction;
    Ranks* const ranks = options.ranks;
    told.contactsBefore = contactsOf(pack.spheres, ranks, pack.order, domain.cell());
    if (ranks) {
        options.labels.assign(pack.order.begin(), pack.order.end());
        options.pieces = pieces;
    } else if (!options.local) {
        options.regions = pack.region;
    }
    auto result = densify(domain, pack.spheres, options, callbacks);
    if (options.random && !result.apart && !result.interrupted)
        throw InputError(
            fmt::format("densify: {} at random points were not pushed apart in {} steps; choose "
                        "smaller radii, or a front (`start`)",
                        Measure<Dim>::kSpheres, result.steps));
    const std::size_t before = pack.spheres.size();
    told.random = options.random;
    told.before = result.before;
    told.after = result.after;
    told.inserted = sumOver(ranks, std::uint64_t{result.spheres.size() - before});
    told.steps = result.steps;
    told.stages = result.stages;
    report.device = result.device;
    const std::vector<std::int64_t> labels(result.labels.begin(), result.labels.end());
    if (!result.interrupted) {
        told.contactsAfter = contactsOf(result.spheres, ranks, labels, domain.cell());
        told.solidLike = solidLikeOf(result.spheres, ranks, labels, domain.cell());
    }
    const bool crystallized =
        Dim == 3 && told.solidLike.value_or(0) > kCrystal &&
        solidLikeOf(pack.spheres, ranks, pack.order, domain.cell()) <= kCrystal;
    Pack<Dim> added;
    added.spheres.assign(result.spheres.begin() + static_cast<std::ptrdiff_t>(before),
                         result.spheres.end());
    result.spheres.resize(before);
    pack.spheres = std::move(result.spheres);
    std::vector<Column> columns;
    if (options.fixed == 0) columns.swap(pack.columns);
    pack = appended(std::move(pack), added.spheres);
    if (!columns.empty()) takeColumns(std::move(columns), before, pack);
    if (ranks) {
        pack.order = labels;
        pieces = std::move(result.pieces);
    }
    if (!options.local && !result.regions.empty()) pack.region = std::move(result.regions);
    report.interrupted = report.interrupted || result.interrupted;
    warnOfResult(result, options.fraction, domain.cell(),
                 crystallized ? told.solidLike : std::nullopt, callbacks);
    told.seconds = clock.lap();
    report.densified = told;
}

template void densifyPack(const Domain<2>&, DensifyOptions, std::vector<std::int64_t>&, Pack<2>&,
                          Report&, const Callbacks&);
template void densifyPack(const Domain<3>&, DensifyOptions, std::vector<std::int64_t>&, Pack<3>&,
                          Report&, const Callbacks&);

}  // namespace vdbpack
