// The run that makes any pack denser: `vdb_pack densify`.
#include "vdbpack/measure/density.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/report_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace vdbpack {

namespace {

/// Below this solid fraction, packs have voids.
template <int Dim>
constexpr double kOfVoids = Dim == 3 ? 0.45 : 0.65;

/// Refuses a pack most of which lies outside of the domain, such as one in another unit: to push
/// its spheres together across the wall takes long, and is in vain.
template <int Dim>
void requireInside(const Pack<Dim>& pack, const Domain<Dim>& domain, const std::string& file) {
    const std::vector<double> distances = domain.signedDistances(centersOf(pack));
    const auto outside =
        std::count_if(distances.begin(), distances.end(), [](double d) { return d > 0; });
    if (2 * static_cast<std::size_t>(outside) > distances.size())
        throw InputError(fmt::format(
            "{}: {} of {} centers lie outside of the domain; check that the pack belongs to it, "
            "and `unit` and `packUnit`",
            file, outside, distances.size()));
}

template <int Dim>
RunResult densifyInput(Run<Dim>& run, const DensifyRecipe& recipe) {
    requireRoomToNumber(run.pack, recipe.pack);
    run.report.requestedGap = recipe.densify.gap;
    const std::optional<SizeDistribution> sizes = recipe.sizes(Dim);
    if (sizes) run.sizes = PackSizes{*sizes};
    RadiusStatistics radius = radiusStatistics(run.pack.spheres);
    // Coordinates are written as finely as the radii of the input pack deserve.
    run.facts.positionStep = std::exp2(std::floor(std::log2(radius.mean))) * 0x1p-22;
    if (sizes) {
        radius.min = std::min(radius.min, sizes->min());
        radius.max = std::max(radius.max, sizes->max());
    }
    const double detail = fieldDetail(radius.min, radius.mean),
                 reach = radius.max + recipe.densify.gap;
    Extent extent = extentOf(*run.source, detail, reach);
    extent.count = static_cast<double>(run.pack.spheres.size());
    extent.densifying = true;
    const PeriodicCell<Dim> stated = run.pack.cell;
    domainStage(run, extent, detail, reach);
    warnOfOtherCell(recipe.pack, stated, recipe.domain, run.domain(), run.callbacks);
    requireInside(run.pack, run.domain(), recipe.pack);
    requireOneBody(run.pack, run.domain(), recipe.pack, "densify");
    const double fraction = solidFraction(run.pack.spheres, run.domain());
    if (fraction < kOfVoids<Dim> && recipe.densify.fraction > fraction)
        run.callbacks.warn(fmt::format(
            "densify: the {} fill {:.2g} of the domain. Spheres are added in its voids as well; to "
            "keep voids, densify first and cut them with carve",
            Measure<Dim>::kSpheres, fraction));
    if (recipe.densify.fraction > 0 && recipe.densify.fraction < fraction)
        run.callbacks.warn(fmt::format(
            "`densify` {:g}: the {} fill {:.4g} of the domain already; overlaps alone are removed",
            recipe.densify.fraction, Measure<Dim>::kSpheres, fraction));
    run.pack.sliceHeight = run.built.sliceHeight;
    run.keepsPack = true;
    densifyStage(run, recipe.densify);
    measureStage(run);
    return reported(finishStage(run), recipe);
}

}  // namespace

RunResult runDensify(const DensifyRecipe& recipe, const Callbacks& callbacks) {
    refuseInterfaces(recipe);
    checkSettings(recipe, RunKind::pack, {}, inputFiles(recipe));
    return runOnInputPack(recipe, "densify", {}, callbacks,
                          [&](auto& run) { return densifyInput(run, recipe); });
}

}  // namespace vdbpack
