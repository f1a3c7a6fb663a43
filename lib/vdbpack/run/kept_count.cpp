#include "vdbpack/run/kept_count.h"

#include "vdbpack/core/sphere.h"
#include "vdbpack/voids/shell_field.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

constexpr double kLeastShare = 0.01;
/// A void that removes all spheres that meet it removes those about its wall, too.
constexpr double kTouchShare = 0.8;

/// Whether the voids of one trial serve for the next. Their default sizes follow from the spheres
/// of the first, which hardly differ.
bool serveAll(const VoidRecipe& recipe) {
    return recipe.cull == Cull::center && !recipe.as<Thinning>() && !recipe.as<FrontHoles>();
}

}  // namespace

double keptShare(const VoidRecipe& voids, const Extent& extent) {
    if (voids.empty() || !(extent.volume > 0)) return 1;
    const auto [least, most] = shellRange(voids);
    const double shell =
        std::clamp(0.5 * (least + most) * extent.area / extent.volume, 0.0, 1 - kLeastShare);
    const auto* const thinning = voids.as<Thinning>();
    const double bvtv = targetBvtvOf(voids).value_or(
        thinning && thinning->fraction ? 1 - *thinning->fraction : extent.voids.left);
    const double share = std::max(shell + (1 - shell) * bvtv, kLeastShare);
    const bool touched = voids.fill == Fill::domain && voids.cull == Cull::touch;
    return touched ? kTouchShare * share : share;
}

template <int Dim>
double KeptCount<Dim>::operator()(const std::vector<Sphere<Dim>>& trial, double largest) {
    const auto placed = static_cast<double>(sumOver(run_.ranks(), std::uint64_t{trial.size()}));
    const VoidRecipe& recipe = *run_.voidRecipe;
    // Where the solid is filled, no void removes a sphere.
    if (recipe.empty() || (run_.solid && !recipe.keepConnected)) return placed;
    Callbacks quiet;
    if (!run_.ranks()) quiet.cancelled = run_.callbacks.cancelled;
    // These voids will be those of the run, which makes no others.
    if (!run_.solid && serveAll(recipe)) quiet.warning = run_.callbacks.warning;
    const auto settingWith = [&](const Callbacks& callbacks) {
        return VoidSetting<Dim>{recipe,
                                run_.domain(),
                                run_.built.sliceHeight,
                                run_.settings.seed,
                                largest,
                                callbacks,
                                nullptr,
                                run_.bvtv,
                                run_.shell};
    };
    MadeVoids<Dim> made;
    if (voids_)
        made = std::move(*voids_);
    else if (!run_.solid)
        made = makeVoids(settingWith(quiet));
    Pack<Dim> pack;
    pack.spheres = existing_;
    pack.spheres.insert(pack.spheres.end(), trial.begin(), trial.end());
    const VoidReport report = made.report;
    Callbacks silent;  // the spheres of the run are not these
    silent.cancelled = quiet.cancelled;
    cullPack(settingWith(silent), run_.settings.contactTolerance, existing_.size(), made, pack);
    made.report = report;
    if (!run_.solid && serveAll(recipe)) voids_ = std::move(made);
    return static_cast<double>(
        sumOver(run_.ranks(), std::uint64_t{pack.spheres.size() - existing_.size()}));
}

template class KeptCount<2>;
template class KeptCount<3>;

}  // namespace vdbpack
