#include "vdbpack/run/pack_stage.h"

#include "vdbpack/core/ball_share.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/pack/front_fraction.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/voids/cull.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

using SourcePtr = std::shared_ptr<const DomainSource>;
template <int Dim>
using RunPtr = std::unique_ptr<Run<Dim>>;

/// Cuts the voids of a run into a trial pack for its target count, and counts what remains.
/// @param existing  spheres that always remain, and do not count.
/// @param largest   radius of the spheres of the trial, mm.
/// @param voids     of all trials, and then of the run, where one list serves all; else none.
/// @throws as makeVoids
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

/// About what densifying adds to the solid fraction of a front at most.
template <int Dim>
constexpr double kMostGain = Dim == 3 ? 0.045 : 0.02;

/// About the solid fraction of walls a few spheres thick.
constexpr double kThinWalls = 0.45;

/// Packs so many spheres that about `target` remain, counting those that densifying will add and
/// without those that voids will remove.
template <int Dim>
PackResult<Dim> packTarget(Run<Dim>& run, const PackRecipe& recipe, double target,
                           const Prepared<Dim>& prepared, PackOptions& options) {
    const Domain<Dim>& domain = run.filled();
    const std::vector<Sphere<Dim>>& existing = prepared.existing.spheres;
    std::optional<MadeVoids<Dim>> voids;
    CountedSpheres<Dim> counted;
    counted.warns = false;  // the run judges what it writes (`warnOfCount`)
    if (recipe.voids.as<FrontHoles>())
        target /= prepared.radii.share;  // about; `packToKeep` comes nearer
    else
        counted.count = [&](const std::vector<Sphere<Dim>>& trial, double largest) {
            return keptCount(run, existing, trial, largest, voids);
        };
    if (run.solid)  // spheres of smaller packs would not fit into its walls
        counted.fraction = kThinWalls;
    else if (counted.count)
        counted.share = prepared.radii.share;
    auto result = packToCount(domain, options, target, run.callbacks, existing, counted);
    if (recipe.densify.fraction > 0 && !result.interrupted) {
        double front = ballShare(result.pack.spheres, domain.volume(), run.ranks());
        front += ballShare(existing, domain.volume());
        const double after = std::isfinite(recipe.densify.fraction) ? recipe.densify.fraction
                                                                    : front + kMostGain<Dim>;
        if (after > front)  // fewer, larger spheres
            result = packToCount(domain, options, target * front / after, run.callbacks, existing,
                                 counted);
    }
    if (voids) run.voids.made = std::move(*voids);
    return result;
}

/// The solid fraction that a front of scaled sizes would have.
template <int Dim>
double frontOf(const Domain<Dim>& domain, const SizeDistribution& sizes, double scale, double gap) {
    return frontFraction<Dim>(scale * sizes.mean(), std::pow(scale, Dim) * sizes.meanBall(Dim),
                              domain.wallArea() / domain.volume(), gap);
}

/// Warns of a solid fraction that packs of these sizes do not have.
/// @param front  the front's, or what it would be.
template <int Dim>
void warnOfFraction(const Run<Dim>& run, const PackRecipe& recipe, double front) {
    constexpr double kMost = Dim == 3 ? 1.12 : 1.15;  // times the front's; of equal spheres 1.07
    const double asked = recipe.densify.fraction;
    if (!std::isfinite(asked) || run.report.interrupted) return;
    if (asked > kMost * front)
        run.callbacks.warn(fmt::format(
            "`densify` {:g}: {} of these sizes hardly fill more than {:.2f} here; the densest pack "
            "is sought, which takes as long as `densify` max",
            asked, Measure<Dim>::kSpheres, kMost * front));
    else if (asked < front && !recipe.randomStart)
        run.callbacks.warn(fmt::format(
            "`densify` {:g}: the front has {:.4g} already, and nothing is removed; `start` random "
            "and `gap` give looser packs",
            asked, front));
}

/// Warns of settings of a front where there is none.
void warnOfNoFront(const PackOptions& options, const Callbacks& callbacks) {
    const PackOptions usual(options.sizes);
    const std::pair<const char*, bool> settings[] = {{"order", options.order != usual.order},
                                                     {"effort", options.effort != usual.effort},
                                                     {"blockSide", options.blockSide > 0}};
    for (const auto& [name, isSet] : settings)
        if (isSet)
            callbacks.warn(
                fmt::format("`{}` has no effect with `start` random, which has no front", name));
}

/// Scales sizes such that about `target` spheres at random points make the solid fraction asked
/// for.
template <int Dim>
void scaleForRandom(const Run<Dim>& run, const PackRecipe& recipe, double target,
                    PackOptions& options) {
    const Domain<Dim>& domain = run.filled();
    const PackOptions asked = options;
    const double ball = asked.sizes.meanBall(Dim);
    double scale = 1;
    for (int round = 0; round < 3; ++round) {  // what can be reached depends on the sizes
        const double front = frontOf(domain, asked.sizes, scale, recipe.packing.gap);
        const double after = std::isfinite(recipe.densify.fraction) ? recipe.densify.fraction
                                                                    : front + kMostGain<Dim>;
        scale = std::pow(after * domain.volume() / (target * ball), 1.0 / Dim);
    }
    scaleSizes(options, asked, scale);
}

/// Leaves the existing spheres, the first `given`, to the first of several ranks.
template <int Dim>
void shareExisting(Run<Dim>& run, std::size_t given, Pack<Dim>& pack) {
    // Those that were added are numbered on.
    std::int64_t last = given > 0 ? std::numeric_limits<std::int64_t>::min() : -1;
    for (std::size_t i = 0; i < given; ++i) last = std::max(last, pack.order[i]);
    for (std::int64_t& piece : run.share.pieces) piece += last + 1;
    if (run.isFirst()) return;
    std::vector<std::uint8_t> keep(pack.spheres.size(), 1);
    std::fill_n(keep.begin(), given, 0);
    keepOnly(pack, keep);
    run.facts.fixed = run.facts.labelled = 0;
}

/// Puts the existing spheres before those of the front, and notes them.
template <int Dim>
void joinExisting(Run<Dim>& run, const PackRecipe& recipe, const Prepared<Dim>& prepared) {
    const Pack<Dim>& existing = prepared.existing;
    const std::size_t given = existing.spheres.size();
    const std::uint64_t added = sumOver(run.ranks(), std::uint64_t{run.pack.spheres.size()});
    if (added == 0 && !run.report.interrupted)
        run.callbacks.warn(recipe.existing + ": leaves no room for spheres of these radii");
    run.facts.fixed = given;
    if (!existing.region.empty()) run.facts.labelled = given;
    run.report.existing = given;
    run.report.inputOverlaps = prepared.inputOverlaps;
    // Into voids as well, where what they leave is filled.
    run.report.inputProtrusions = run.solid
                                      ? run.filledSource().protrusion(existing.spheres).spheres
                                      : prepared.inputProtrusions;
    run.pack = joined(existing, run.pack);
    if (run.ranks()) shareExisting(run, given, run.pack);
}

/// The front, with the existing spheres before those that it places.
/// @param scaled   whether to pack the sizes of `options` as they are; else they are left as the
///                 target count needs them.
/// @return whether the voids were made with it or before.
template <int Dim>
bool packStage(Run<Dim>& run, const PackRecipe& recipe, const Prepared<Dim>& prepared, bool scaled,
               PackOptions& options) {
    const std::vector<Sphere<Dim>>& existing = prepared.existing.spheres;
    const double target = prepared.requested.targetCount;
    const auto* const holes = recipe.voids.as<FrontHoles>();
    PackResult<Dim> result;
    if (recipe.randomStart) {  // `densify` places them
        if (target > 0 && !scaled)
            scaleForRandom(run, recipe, target / (run.solid ? 1 : prepared.radii.share), options);
        result.quantum = std::exp2(std::floor(std::log2(options.sizes.mean()))) * 0x1p-22;
    } else if (target > 0 && !scaled)
        result = packTarget(run, recipe, target, prepared, options);
    else if (!holes)
        result = packSpheres(run.filled(), options, run.callbacks, existing);
    run.sizes = PackSizes{options.sizes, options.local};
    run.voids.largestRadius = options.local.largest(options.sizes);
    if (holes && !result.interrupted) {
        const Callbacks own = run.own();
        result = packWithHoles(voidSetting(run, own), options, existing, run.voids.made);
    }
    if (target > 0)
        run.report.chosen.push_back(fmt::format(
            "radii {} mm{}, for about {:.0f} {} {}", options.sizes.spec(),
            options.local.shellSizes ? ", in the shell " + options.local.shellSizes->spec() + " mm"
                                     : std::string(),
            target, Measure<Dim>::kSpheres,
            recipe.voids.empty() ? "in the domain" : "beside the voids"));
    result.pack.sliceHeight = run.built.sliceHeight;
    run.report.interrupted = result.interrupted;
    run.facts.positionStep = result.quantum;
    run.share.pieces = std::move(result.pieces);
    run.pack = std::move(result.pack);
    if (!recipe.existing.empty()) joinExisting(run, recipe, prepared);
    run.report.seconds.pack += run.clock.lap();
    return holes || run.solid || run.voids.made.stamped;
}

/// The stages from the packing to the cutting of voids.
/// @param scaled, options  as those of packStage.
template <int Dim>
RunPtr<Dim> packAndCut(const PackRecipe& recipe, const SourcePtr& source,
                       const Prepared<Dim>& prepared, const Report& begun, bool scaled,
                       const Clock& clock, const Callbacks& callbacks, PackOptions& options) {
    auto run = std::make_unique<Run<Dim>>(recipe, source, begun, clock, callbacks);
    run->keepsPack = true;
    run->built = prepared.built;
    run->voids = prepared.voids;
    run->report.seed = recipe.seed;
    run->report.chosen = prepared.requested.chosen;
    for (const FoundValue& found : prepared.voids.found) run->report.found.push_back(found);
    run->report.requestedGap = recipe.packing.gap;
    run->clock.lap();
    if constexpr (Dim == 3)
        if (recipe.voids.fill == Fill::solid)
            solidStage(*run, prepared.radii.detail, prepared.radii.reach);
    const bool voidsMade = packStage(*run, recipe, prepared, scaled, options);
    if (recipe.densify.fraction > 0) {
        DensifyOptions densify = recipe.densify;
        densify.gap = recipe.packing.gap;
        densify.mixSizes = true;
        densify.random = recipe.randomStart;
        if (recipe.randomStart) warnOfNoFront(options, run->callbacks);
        if (!run->ranks() && recipe.existing.empty())
            warnOfFraction(*run, recipe,
                           recipe.randomStart
                               ? frontOf(run->filled(), options.sizes, 1, recipe.packing.gap)
                               : solidFraction(run->pack.spheres, run->filled()));
        densifyStage(*run, std::move(densify));
    } else if (recipe.settle) {
        settleStage(*run, recipe.packing.gap, recipe.densify.device);
    }
    cutStage(*run, voidsMade);
    return run;
}

/// By which factors, as logarithms, radii were scaled and a target was missed.
struct Miss {
    double scale, count;
};

/// Where the line through two misses meets the target, yet not next to either of them.
double between(const Miss& a, const Miss& b) {
    constexpr double kApart = 0.2;
    const double along = a.count / (a.count - b.count);
    return a.scale + std::clamp(along, kApart, 1 - kApart) * (b.scale - a.scale);
}

/// packAndCut, again with scaled radii where too many or too few spheres remain of those that it
/// sought: which of them holes leave, or stay connected once densified, is known only afterwards.
/// Only the last round says its warnings.
template <int Dim>
RunPtr<Dim> packToKeep(const PackRecipe& recipe, const SourcePtr& source,
                       const Prepared<Dim>& prepared, Report begun, const Clock& clock,
                       const Callbacks& callbacks, PackOptions& options) {
    constexpr int kMostRounds = 6;  // the last repeats the nearest of the others
    constexpr double kNear = 0.018;
    const double target = prepared.requested.targetCount;
    const bool foreseen =
        !recipe.voids.as<FrontHoles>() &&
        !(recipe.densify.fraction > 0 && recipe.voids.keepConnected) &&
        !(recipe.randomStart && (!recipe.voids.empty() || std::isinf(recipe.densify.fraction)));
    if (!(target > 0) || foreseen || recipe.packing.maxCount > 0)
        return packAndCut(recipe, source, prepared, begun, false, clock, callbacks, options);
    const auto holds = std::make_shared<bool>(true);
    Callbacks held = callbacks;
    held.warning = [holds, tell = callbacks.warning](const std::string& text) {
        if (tell && !*holds) tell(text);
    };
    PackOptions first = options;  // with the sizes of the first round
    double scale = 1;
    std::optional<Miss> larger, smaller, nearest;  // of the counts above and below the target
    for (int round = 1;; ++round) {
        auto run = packAndCut(recipe, source, prepared, begun, round > 1, clock, held, options);
        if (round == 1) first = options;
        const auto count = static_cast<double>(
            sumOver(run->ranks(), std::uint64_t{run->pack.spheres.size() - run->facts.fixed}));
        const bool near = std::fabs(count - target) <= std::max(kNear * target, 0.5);
        if (near || !(count > 0) || run->report.interrupted || round == kMostRounds) {
            *holds = false;
            const auto& warnings = run->report.warnings;
            for (std::size_t i = begun.warnings.size(); i < warnings.size(); ++i)
                callbacks.warn(warnings[i]);
            return run;
        }
        const Miss miss{std::log(scale), std::log(count / target)};
        (count > target ? larger : smaller) = miss;
        if (!nearest || std::fabs(miss.count) < std::fabs(nearest->count)) nearest = miss;
        scale = round == kMostRounds - 1 ? std::exp(nearest->scale)
                : larger && smaller      ? std::exp(between(*larger, *smaller))
                                         : scale * std::pow(count / target, 1.0 / Dim);
        scaleSizes(options, first, scale);
        begun.seconds = run->report.seconds;
    }
}

}  // namespace

template <int Dim>
RunPtr<Dim> packMeasured(const PackRecipe& recipe, const SourcePtr& source,
                         const Prepared<Dim>& prepared, const Report& begun, const Clock& clock,
                         const Callbacks& callbacks) {
    PackOptions options = packOptions(recipe, prepared.requested.sizes);
    options.local = prepared.local;
    RunPtr<Dim> run = packToKeep(recipe, source, prepared, begun, clock, callbacks, options);
    measureStage(*run);
    if (recipe.packing.maxCount == 0) {
        const Report& report = run->report;
        const double largest = options.local.largest(options.sizes);
        warnOfCount(*run, prepared.requested.targetCount,
                    static_cast<double>(report.count - report.existing), largest);
        warnOfSizes(*run, largest);
    }
    return run;
}

template RunPtr<2> packMeasured(const PackRecipe&, const SourcePtr&, const Prepared<2>&,
                                const Report&, const Clock&, const Callbacks&);
template RunPtr<3> packMeasured(const PackRecipe&, const SourcePtr&, const Prepared<3>&,
                                const Report&, const Clock&, const Callbacks&);

}  // namespace vdbpack
