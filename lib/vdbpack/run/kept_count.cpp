#include "vdbpack/run/kept_count.h"

#include "vdbpack/core/sphere.h"

namespace vdbpack {

template <int Dim>
double keptCount(const Run<Dim>& run, const std::vector<Sphere<Dim>>& existing,
                 const std::vector<Sphere<Dim>>& trial, double largest,
                 std::optional<MadeVoids<Dim>>& voids) {
    const VoidRecipe& recipe = run.voids.recipe;
    // Where the solid is filled, no void removes a sphere.
    if (recipe.empty() || (run.solid && !recipe.keepConnected))
        return static_cast<double>(sumOver(run.ranks(), std::uint64_t{trial.size()}));
    // Default sizes of voids follow from the spheres of the first trial, which hardly differ.
    const bool serveAll = !run.solid && recipe.cull == Cull::center && !recipe.as<Thinning>() &&
                          !recipe.as<FrontHoles>();
    Callbacks silent;
    if (!run.ranks()) silent.cancelled = run.callbacks.cancelled;
    Callbacks making = silent;
    if (serveAll) making.warning = run.callbacks.warning;
    const auto settingWith = [&](const Callbacks& callbacks) {
        VoidSetting<Dim> setting = voidSetting(run, callbacks);
        setting.largestRadius = largest;
        setting.ranks = nullptr;
        return setting;
    };
    MadeVoids<Dim> made;
    if (voids)
        made = std::move(*voids);
    else if (!run.solid)
        made = makeVoids(settingWith(making));
    Pack<Dim> pack;
    pack.spheres = existing;
    pack.spheres.insert(pack.spheres.end(), trial.begin(), trial.end());
    const VoidReport report = made.report;
    cullPack(settingWith(silent), run.settings.contactTolerance, existing.size(), made, pack);
    made.report = report;
    if (serveAll) voids = std::move(made);
    return static_cast<double>(
        sumOver(run.ranks(), std::uint64_t{pack.spheres.size() - existing.size()}));
}

template double keptCount(const Run<2>&, const std::vector<Sphere<2>>&,
                          const std::vector<Sphere<2>>&, double, std::optional<MadeVoids<2>>&);
template double keptCount(const Run<3>&, const std::vector<Sphere<3>>&,
                          const std::vector<Sphere<3>>&, double, std::optional<MadeVoids<3>>&);

}  // namespace vdbpack
