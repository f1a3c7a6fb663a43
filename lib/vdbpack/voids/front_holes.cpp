// Voids that the front packs among the spheres.
#include "vdbpack/core/error.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/voids/cull.h"
#include "vdbpack/voids/solve_target.h"
#include "vdbpack/voids/stamped_solid.h"
#include "vdbpack/voids/void_families.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// How near to a target BV/TV voids are made that are packed.
constexpr double kPackedTolerance = 0.002;
/// Holes with less beside them would be no pack.
constexpr double kMostProbability = 0.9;

/// Takes the holes out of a pack, and sets their share in the report.
/// @return the holes
template <int Dim>
std::vector<Sphere<Dim>> takeHoles(const VoidSetting<Dim>& s, PackResult<Dim>& result,
                                   VoidReport& report) {
    std::vector<Sphere<Dim>> places;
    std::vector<std::uint8_t> keep(result.pack.spheres.size(), 1);
    for (std::size_t i = 0; i < keep.size(); ++i)
        if (result.species[i] != 0) {
            keep[i] = 0;
            places.push_back(result.pack.spheres[i]);
        }
    const auto deep = deeperThan(result.pack.spheres, s.domain, s.recipe.shell);
    const auto core = std::max<std::ptrdiff_t>(1, std::count(deep.begin(), deep.end(), 1));
    report.reachedShare = static_cast<double>(places.size()) / static_cast<double>(core);
    keepOnly(result.pack, keep);
    // Placed in this order, without gaps.
    for (std::size_t i = 0; i < result.pack.order.size(); ++i)
        result.pack.order[i] = static_cast<std::int64_t>(i);
    return places;
}

/// Warns of holes that found no room.
/// @param found  their number.
void warnOfFew(const Callbacks& callbacks, const VoidReport& report, std::size_t found) {
    const auto holes = static_cast<double>(found);
    const double wanted = holes > 0 ? *report.amount * holes / *report.reachedShare : 0;
    if (found == 0)
        callbacks.warn(
            "no hole found room: give smaller ones, a larger `voids.probability` or a "
            "thinner shell");
    else if (holes < 0.8 * wanted && holes < wanted - 3 * std::sqrt(wanted))  // no chance
        callbacks.warn(
            fmt::format("{:.3g} of the spheres were to be holes, {:.3g} are: no more found room",
                        *report.amount, *report.reachedShare));
}

}  // namespace

template <int Dim>
PackResult<Dim> packWithHoles(const VoidSetting<Dim>& s, const PackOptions& options,
                              const std::vector<Sphere<Dim>>& existing, MadeVoids<Dim>& made) {
    const FrontHoles& recipe = *std::get_if<FrontHoles>(&s.recipe.method);
    made.report.method = nameOf(s.recipe);
    made.report.shell = s.recipe.shell;
    const VoidShape<Dim> shape = voidShapeOf(s, &made.report.chosen);
    const double voxel =
        voidVoxelFor(s.recipe, shape.radius.min() * std::min(1.0, shape.aspect.min()));
    PackResult<Dim> result;
    const auto bvtvAt = [&](double probability) {
        PackOptions mixed = options;
        mixed.species.push_back({shape.radius, probability, s.recipe.shell});
        result = packSpheres(s.domain, mixed, s.callbacks, existing);
        made.report.amount = probability;
        made.list = voidsAtSpheres(takeHoles(s, result, made.report), false, shape, s.seed);
        if (!result.interrupted) {
            try {
                return bvtvOf(s, voxel, made);
            } catch (const Interrupted&) {
                result.interrupted = true;
            }
        }
        // An interrupted pack is kept unchanged, without voids and further trials.
        made.stamped.reset();
        made.solid = {};
        made.report.bvtv.reset();
        return recipe.targetBvtv.value_or(0);
    };
    if (const auto target = recipe.targetBvtv) {
        // As if holes took their share of what is filled.
        const double left = -std::log(*target) * options.sizes.meanBall(Dim);
        const double guess = std::clamp(left / (left + shape.meanMeasure()), 1e-4, 0.3);
        solveForBvtv(s.recipe, 0, guess, kMostProbability, kPackedTolerance,
                     "; give larger or longer voids, or set `voids` boolean, whose voids overlap",
                     bvtvAt);
        if (!result.interrupted) warnIfOff(s, made.report);
    } else {
        if (!recipe.probability)
            made.report.chosen.push_back(
                fmt::format("a hole with probability {}", kDefaultProbability));
        bvtvAt(recipe.probability.value_or(kDefaultProbability));
    }
    warnOfFew(s.callbacks, made.report, made.list.size());
    return result;
}

template PackResult<2> packWithHoles(const VoidSetting<2>&, const PackOptions&,
                                     const std::vector<Sphere<2>>&, MadeVoids<2>&);
template PackResult<3> packWithHoles(const VoidSetting<3>&, const PackOptions&,
                                     const std::vector<Sphere<3>>&, MadeVoids<3>&);

}  // namespace vdbpack
