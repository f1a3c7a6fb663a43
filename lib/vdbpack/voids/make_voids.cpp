#include "vdbpack/voids/make_voids.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/ranks.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/voids/shell_field.h"
#include "vdbpack/voids/solve_target.h"
#include "vdbpack/voids/stamped_solid.h"
#include "vdbpack/voids/structure_fit.h"
#include "vdbpack/voids/void_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

constexpr double kThicknessTolerance = 0.01, kThicknessWarning = 0.02;
constexpr int kThicknessRounds = 6;  // the last repeats the nearest of the others

/// Replaces the targets of a structure by the parameters of a foam that has it.
void fitTo(const VoidSetting<3>& s, FoamPacks<3>& packs, VoidRecipe& recipe, VoidReport& report) {
    const StructureFit fit = fitStructure(withRecipe(s, recipe), packs);
    recipe = fit.recipe;
    report.targets = fit.targets;
    report.specimen = fit.specimen;
    report.thicknessDistance = fit.thicknessDistance;
    report.separationDistance = fit.separationDistance;
    const FoamVoids& foam = *recipe.as<FoamVoids>();
    const VoidShapeRecipe& shape = foam.shape;
    report.radius = shape.radius.in(3).scaled(shape.radiusFactor).spec();
    report.parameters = fmt::format(
        "`voids` foam `targetBvtv` {:.4g} {}`voids.radius` {} `voids.aspect` {} `voids.jitter` "
        "{:.4g} `voids.blend` {:.4g} `voids.strut` {:.4g} `voids.strutShare` {:.4g} "
        "`voids.voxelSize` {:.4g}",
        *foam.targetBvtv,
        shape.orientation.axis ? "`orientation.axis` " + shape.orientation.axis->text + " " : "",
        report.radius, shape.aspect.spec(), *foam.jitter, *recipe.blend, *recipe.strut,
        *recipe.strutShare, recipe.voxelSize);
}
void fitTo(const VoidSetting<2>&, FoamPacks<2>&, VoidRecipe& recipe, VoidReport&) {
    const FoamTargets& t = recipe.as<FoamVoids>()->targets;
    for (const auto& [name, target] : {std::pair{"targetTbsp", t.tbsp}, std::pair{"targetDa", t.da},
                                       std::pair{"targetConnd", t.connd}})
        if (target)
            throw ParameterError(fmt::format(
                "`{}` {:g}: is measured in space; leave it out in a plane", name, *target));
}

/// Makes the voids of a method whose amount can be varied.
template <int Dim>
class Maker {
public:
    Maker(const VoidSetting<Dim>& setting, MadeVoids<Dim>& made)
        : s_(setting), made_(made), recipe_(setting.recipe), packs_(s_.packs ? *s_.packs : own_) {}

    void run() {
        decide();
        if (hasStructureTargets(s_.recipe)) {
            const bool open = !targetBvtvOf(recipe_);
            fitTo(s_, packs_, recipe_, made_.report);
            if (open)
                chosen_.push_back(
                    fmt::format("BV/TV {:.4g}, as bone of that thickness and spacing has",
                                *targetBvtvOf(recipe_)));
        }
        if (const auto thickness = targetTbthOf(recipe_))
            solveThickness(*thickness);
        else
            solve();
        made_.report.chosen = chosen_;
        warnIfOff(s_, made_.report);
        if (const auto* overlay = std::get_if<OverlayVoids>(&s_.recipe.method))
            if (overlay->count.value_or(0) > static_cast<double>(made_.list.size()) + 0.5)
                s_.callbacks.warn(fmt::format("`voids.count` {:.0f}: only {} fit into the domain",
                                              *overlay->count, made_.list.size()));
    }

private:
    VoidSetting<Dim> setting() const {
        VoidSetting<Dim> setting = withRecipe(s_, recipe_);
        setting.packs = &packs_;
        return setting;
    }

    /// Sets the target BV/TV where the recipe leaves the amount of voids open.
    void decide() {
        const auto* boolean = recipe_.as<BooleanVoids>();
        const auto* foam = recipe_.as<FoamVoids>();
        const bool open =
            (boolean && !boolean->count && !boolean->targetBvtv) ||
            (foam && !foam->targetBvtv && !(Dim == 3 && foam->targets.any() && !s_.bvtv));
        if (!open) return;
        const char* const how = foam ? "voids dilated to" : "as many voids as make";
        if (!s_.bvtv) {
            setTargetBvtv(recipe_, kDefaultBvtv);
            chosen_.push_back(fmt::format("{} BV/TV {}", how, kDefaultBvtv));
            return;
        }
        const BvtvField& field = *bvtvFieldOf(recipe_);
        const double mean = meanBvtv(s_);
        if (!(mean > 0 && mean < 1))
            throw InputError(fmt::format(
                "`bvtvField` {}: BV/TV is {:g} in all of the domain; check `bvtvRange`{}",
                field.file, mean,
                field.range ? fmt::format(" {},{}", field.range->first, field.range->second) : ""));
        chosen_.push_back(fmt::format("{} BV/TV {:.4f}, the mean of {}", how, mean, field.file));
        setTargetBvtv(recipe_, mean);
    }

    /// The amount of a recipe without a target.
    double amountOf(const VoidFamily<Dim>& family) const {
        if (const auto* boolean = recipe_.as<BooleanVoids>())
            return *boolean->count / regionOf(s_).volume();
        if (const auto* overlay = recipe_.as<OverlayVoids>())
            return overlay->count.value_or(family.most);
        return recipe_.as<GridVoids>()->probability.value_or(1);
    }

    /// As many voids, or as large ones, as the recipe asks for.
    void solve() {
        const VoidSetting<Dim> s = setting();
        const auto target = targetBvtvOf(recipe_);
        const auto family =
            voidFamily(s, target.value_or(kDefaultBvtv), named_ ? nullptr : &chosen_);
        named_ = true;
        const double voxel = voxelFor(s, family.leastHalfAxis);
        if (family.follow) family.follow(stampOptions(s, voxel));
        const auto bvtvAt = [&](double amount) {
            made_.list = family.list(amount);
            return bvtvOf(s, voxel, made_);
        };
        if (target)
            made_.report.amount =
                solveForBvtv(recipe_, 0, family.guess, family.most, bvtvTolerance(recipe_),
                             family.remedy, bvtvAt, family.steepness);
        else
            bvtvAt(amountOf(family));
    }

    /// Scales the voids until the walls between them have the wanted thickness at the wanted BV/TV.
    void solveThickness(double target) {
        const Vec<Dim> size = s_.domain.bounds().size();
        const double side = *std::min_element(size.c.begin(), size.c.end());
        if (!(target < 0.25 * side))
            throw ParameterError(
                fmt::format("`targetTbth` {}: not reachable, trabeculae in a domain of {:.4g} mm "
                            "are thinner than a quarter of it; give a smaller one",
                            target, side));
        VoidShapeRecipe& shape = *shapeOf(recipe_);
        const bool open = shape.radius.empty();
        const SizeDistribution radii =
            open && !(s_.largestRadius > 0) ? defaultVoidRadius(1) : voidRadii(s_);
        shape.radius = radii;
        // Walls are about as thick as b times -1/ln(BV/TV), to begin with: then by what was
        // measured.
        if (open) shape.radiusFactor = kRadiusPerThickness * target / radii.mean();
        // In a cell that repeats along all axes no point is deeper than others.
        const Vec<Dim> deepest =
            s_.domain.cell().all() ? s_.domain.bounds().center() : largestBall(s_.domain).center;
        double least = std::numeric_limits<double>::infinity();  // miss of the nearest round
        double nearest = shape.radiusFactor, miss = least;
        for (int round = 0;; ++round) {
            const double thickness = thicknessNow(deepest, target);
            made_.report.radius = radii.scaled(shape.radiusFactor).spec();
            miss = std::fabs(thickness - target);
            if (miss <= kThicknessTolerance * target || round == kThicknessRounds) break;
            if (miss < least) {
                least = miss;
                nearest = shape.radiusFactor;
            }
            shape.radiusFactor =
                round == kThicknessRounds - 1 ? nearest : shape.radiusFactor * target / thickness;
        }
        if (miss > kThicknessWarning * target)
            s_.callbacks.warn(
                fmt::format("`targetTbth` {}: the nearest value found is {:.4g} mm; "
                            "give a larger domain or a smaller `voids.voxelSize`",
                            target, *made_.report.thickness));
    }

    /// Tb.Th of the recipe as it is, mm.
    double thicknessNow(const Vec<Dim>& deepest, double target) {
        made_.surface.reset();
        made_.report.totalVolume = 0;
        solve();
        s_.callbacks.stopIfCancelled();
        const VoidSetting<Dim> s = setting();
        made_.report.thickness = thicknessOf(s, made_, deepest);
        if (!made_.report.thickness)
            throw InputError(fmt::format(
                "`targetTbth` {}: no solid is left to measure; give a higher `targetBvtv`",
                target));
        return *made_.report.thickness;
    }

    const VoidSetting<Dim>& s_;
    MadeVoids<Dim>& made_;
    VoidRecipe recipe_;  ///< with what was decided and found
    FoamPacks<Dim> own_;
    FoamPacks<Dim>& packs_;
    std::vector<std::string> chosen_;
    bool named_ = false;  ///< whether `chosen_` has the defaults of the family
};

template <int Dim>
void readListed(const VoidSetting<Dim>& s, const std::string& file, MadeVoids<Dim>& made) {
    made.list = readVoidList<Dim>(file);
    if (made.list.empty())
        throw InputError(file + ": holds no voids; give a list with at least one row");
    requireFitting(s, longestHalfAxis(made.list));
    bvtvOf(s, voxelFor(s, leastHalfAxis(made.list)), made);
}

}  // namespace

template <int Dim>
std::vector<std::shared_ptr<const VdbGrid>> MadeVoids<Dim>::levelSets() const {
    if (!solid.grid) return {};
    return {surface, voids, solid.grid};
}

template <int Dim>
void noteShell(const VoidSetting<Dim>& setting, VoidReport& report) {
    const ShellThickness shell = shellOf(setting);
    report.shell = shell.most();
    if (!shell.isUniform()) report.leastShell = shell.least();
}

template <int Dim>
MadeVoids<Dim> makeVoids(const VoidSetting<Dim>& s) {
    MadeVoids<Dim> made;
    made.report.method = nameOf(s.recipe);
    noteShell(s, made.report);
    if (!s.recipe.makesVoids()) return made;
    if (const auto* listed = std::get_if<ListedVoids>(&s.recipe.method))
        readListed(s, listed->file, made);
    else
        Maker<Dim>(s, made).run();
    made.core.reset();
    if (made.list.empty())
        s.callbacks.warn("no void lies in the part of the domain that may have them");
    return made;
}

template <int Dim>
MadeVoids<Dim> makeVoids(const Domain<Dim>& domain, const VoidRecipe& recipe, std::uint64_t seed,
                         const Callbacks& callbacks) {
    checkVoids(recipe, false, false);
    VoidSetting<Dim> setting{recipe, domain, 0, seed, 0, callbacks};
    setting.localShell = shellOver(recipe, domain.bounds(), 0);
    checkRoom(setting, false);
    MadeVoids<Dim> made = makeVoids(setting);
    measureVoids(setting, 0, static_cast<const Pack<Dim>*>(nullptr), made);
    return made;
}

template <int Dim>
void measureVoids(const VoidSetting<Dim>& s, double contactTolerance, const Pack<Dim>* pack,
                  MadeVoids<Dim>& made) {
    if (made.stamped && !made.solid.grid) cut(s, made);
    if (pack && !s.recipe.keepConnected && (!s.recipe.empty() || s.recipe.hasShell()))
        attachedToShell(s, contactTolerance, *pack, made.report);
    if (!pack || !made.report.bvtv || !(made.report.totalVolume > 0)) return;
    double filled = 0;
    for (std::size_t i = 0; i < pack->spheres.size(); ++i)
        if (pack->region.empty() || pack->region[i] != 0)
            filled += Measure<Dim>::ball(pack->spheres[i].radius);
    made.report.filled = sumOver(s.ranks, filled) / made.report.totalVolume;
}

#define VDBPACK_INSTANTIATE(Dim)                                                            \
    template struct MadeVoids<Dim>;                                                         \
    template void noteShell(const VoidSetting<Dim>&, VoidReport&);                          \
    template MadeVoids<Dim> makeVoids(const VoidSetting<Dim>&);                             \
    template MadeVoids<Dim> makeVoids(const Domain<Dim>&, const VoidRecipe&, std::uint64_t, \
                                      const Callbacks&);                                    \
    template void measureVoids(const VoidSetting<Dim>&, double, const Pack<Dim>*, MadeVoids<Dim>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
