#include "vdbpack/run/densify_stage.h"

#include "vdbpack/densify/densify.h"
#include "vdbpack/measure/bond_order.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/run/clock.h"
#include "vdbpack/run/recipe.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

template <int Dim>
std::array<double, 3> contactsOf(const std::vector<Sphere<Dim>>& spheres) {
    std::array<double, 3> means{};
    for (std::size_t k = 0; k < means.size(); ++k)
        means[k] = countContacts(spheres, Report::Densified::kContactTolerances[k]).meanOfSpheres;
    return means;
}

}  // namespace

template <int Dim>
void densifyPack(const Domain<Dim>& domain, const DensifySetting& setting, Pack<Dim>& pack,
                 Report& report, const Callbacks& callbacks) {
    Clock clock;
    Report::Densified told;
    if (std::isfinite(setting.fraction)) told.requested = setting.fraction;
    told.contactsBefore = contactsOf(pack.spheres);
    DensifyOptions options;
    options.fraction = setting.fraction;
    if (setting.sizes) options.sizes = *setting.sizes;
    options.gap = setting.gap;
    options.seed = setting.seed;
    options.fixed = setting.fixed;
    options.regions = pack.region;
    auto result = densify(domain, pack.spheres, options, callbacks);
    const std::size_t before = pack.spheres.size();
    told.before = result.before;
    told.after = result.after;
    told.inserted = result.spheres.size() - before;
    told.steps = result.steps;
    told.stages = result.stages;
    if (!result.interrupted) {
        told.contactsAfter = contactsOf(result.spheres);
        told.solidLike = solidLikeShare(result.spheres);
    }
    Pack<Dim> added;
    added.spheres.assign(result.spheres.begin() + static_cast<std::ptrdiff_t>(before),
                         result.spheres.end());
    result.spheres.resize(before);
    pack.spheres = std::move(result.spheres);
    pack = appended(std::move(pack), added.spheres);
    if (!result.regions.empty()) pack.region = std::move(result.regions);
    if (result.interrupted)
        report.interrupted = true;
    else if (!result.apart)
        callbacks.warn(
            fmt::format("densify: the overlaps of the input {} were not resolved in {} steps; the "
                        "pack is unchanged. There are too many for the domain, or some lie far "
                        "outside it",
                        Measure<Dim>::kSpheres, result.steps));
    else if (!result.reached && std::isfinite(setting.fraction))
        callbacks.warn(
            fmt::format("densify: the solid fraction {} was requested, {:.4f} was reached; "
                        "smaller {} reach more",
                        setting.fraction, result.after, Measure<Dim>::kSpheres));
    told.seconds = clock.lap();
    report.densified = told;
}

template void densifyPack(const Domain<2>&, const DensifySetting&, Pack<2>&, Report&,
                          const Callbacks&);
template void densifyPack(const Domain<3>&, const DensifySetting&, Pack<3>&, Report&,
                          const Callbacks&);

}  // namespace vdbpack
