// The run that packs: `vdb_pack pack`.
#include "vdbpack/core/ball_share.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/pack/pack_to_count.h"
#include "vdbpack/preview/result_picture.h"
#include "vdbpack/report/measured_pack.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/kept_count.h"
#include "vdbpack/run/pack_warnings.h"
#include "vdbpack/run/rank_stages.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/run_each.h"
#include "vdbpack/run/run_parts.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/run/structure_sample.h"
#include "vdbpack/voids/bvtv_field.h"
#include "vdbpack/voids/cull.h"
#include "vdbpack/voids/shell_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

using SourcePtr = std::shared_ptr<const DomainSource>;

/// The part that the packs of all seeds of a recipe share.
template <int Dim>
struct Prepared {
    RequestedSizes requested;
    FieldRadii radii;
    DomainSource::Built built{};
    Pack<Dim> existing{};
    std::uint64_t inputOverlaps = 0, inputProtrusions = 0;
    RunVoids<Dim> voids{};
    LocalSizes local{};  ///< what differs by place in the sizes
};

/// Reads the spheres to pack around, and counts what is wrong with them already.
template <int Dim>
void prepareExisting(const PackRecipe& recipe, const DomainSource& source, Prepared<Dim>& prepared,
                     const Callbacks& callbacks) {
    if (recipe.existing.empty()) return;
    prepared.existing = readExisting<Dim>(recipe, prepared.built.sliceHeight);
    const auto& spheres = prepared.existing.spheres;
    const OverlapCheck among = checkOverlap(spheres, ofDim<Dim>(prepared.built)->cell());
    if (!among.complete)
        throw InputError(fmt::format(
            "{}: more than {} pairs of its {} {} overlap one another. Remove the spheres that lie "
            "in others",
            recipe.existing, among.pairs, spheres.size(), Measure<Dim>::kSpheres));
    prepared.inputOverlaps = among.pairs;
    prepared.inputProtrusions = source.protrusion(spheres).spheres;
    if (prepared.inputOverlaps > 0)
        callbacks.warn(
            fmt::format("{}: {} pairs of its {} overlap one another; they are kept as "
                        "they are",
                        recipe.existing, prepared.inputOverlaps, Measure<Dim>::kSpheres));
    if (prepared.inputProtrusions > 0)
        callbacks.warn(
            fmt::format("{}: {} of its {} protrude from the domain; they are kept as "
                        "they are",
                        recipe.existing, prepared.inputProtrusions, Measure<Dim>::kSpheres));
}

/// Warns of sizes for a shell that no sphere of them lies in.
template <int Dim>
void warnOfEmptyShell(const LocalSizes& local, const Callbacks& callbacks) {
    const auto& own = local.shellSizes;
    if (!own || local.shell.most() > own->min()) return;
    callbacks.warn(fmt::format(
        "no {} of `shellRadius` lies in the shell: its thickness is at most {:.4g} mm, the "
        "radii are at least {:.4g} mm, and centers are at least a radius below the wall; give "
        "smaller radii, or a thicker shell",
        Measure<Dim>::kSphere, local.shell.most(), own->min()));
}

template <int Dim>
Prepared<Dim> prepare(const PackRecipe& recipe, const DomainSource& source,
                      const Callbacks& callbacks) {
    PackPlan plan = planPack(recipe, source);
    requireResources(plan.extent, recipe);
    if (Dim == 2 && recipe.voids.fill == Fill::solid)
        throw ParameterError(recipe.domain.source +
                             ": `fill` solid needs a domain of space; leave it out");
    const FieldRadii& radii = plan.radii;
    Prepared<Dim> prepared{std::move(plan.requested), radii};
    prepared.built =
        source.build(radii.detail, radii.reach, callbacks, plannedVoxel(recipe.voids, Dim));
    const Domain<Dim>& domain = *ofDim<Dim>(prepared.built);
    const double height = prepared.built.sliceHeight;
    RunVoids<Dim>& voids = prepared.voids;
    voids.recipe = recipe.voids;
    voids.largestRadius = prepared.requested.largest() * radii.scale;
    voids.shell = shellOver(recipe.voids, domain.bounds(), height);
    if (voids.areCut())
        checkRoom(VoidSetting<Dim>{recipe.voids,
                                   domain,
                                   height,
                                   recipe.seed,
                                   voids.largestRadius,
                                   callbacks,
                                   nullptr,
                                   {},
                                   voids.shell},
                  true);
    prepared.local = localSizes(recipe, prepared.requested, domain, height, voids.shell);
    warnOfEmptyShell<Dim>(prepared.local, callbacks);
    voids.bvtv = bvtvField<Dim>(recipe.voids, source.recipe(), domain.bounds(), height, callbacks);
    checkPreview<Dim>(recipe.preview, domain, nullptr);
    prepareExisting(recipe, source, prepared, callbacks);
    return prepared;
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
    if (target > 0 && !scaled)
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
            "radii {} mm{}, so that about {:.0f} {} {}", options.sizes.spec(),
            options.local.shellSizes ? ", in the shell " + options.local.shellSizes->spec() + " mm"
                                     : std::string(),
            target, Measure<Dim>::kSpheres,
            recipe.voids.empty() ? "fill the domain" : "remain beside the voids"));
    result.pack.sliceHeight = run.built.sliceHeight;
    run.report.interrupted = result.interrupted;
    run.facts.positionStep = result.quantum;
    run.share.pieces = std::move(result.pieces);
    run.pack = std::move(result.pack);
    if (!recipe.existing.empty()) joinExisting(run, recipe, prepared);
    run.report.seconds.pack += run.clock.lap();
    return holes || run.solid || run.voids.made.stamped;
}

template <int Dim>
using RunPtr = std::unique_ptr<Run<Dim>>;

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
        densifyStage(*run, std::move(densify));
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
    const bool foreseen = !recipe.voids.as<FrontHoles>() &&
                          !(recipe.densify.fraction > 0 && recipe.voids.keepConnected);
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

/// A pack, cut and measured.
template <int Dim>
RunPtr<Dim> packMeasured(const PackRecipe& recipe, const SourcePtr& source,
                         const Prepared<Dim>& prepared, const Report& begun, const Clock& clock,
                         const Callbacks& callbacks) {
    PackOptions options = packOptions(recipe, prepared.requested.sizes);
    options.local = prepared.local;
    RunPtr<Dim> run = packToKeep(recipe, source, prepared, begun, clock, callbacks, options);
    measureStage(*run);
    if (recipe.packing.maxCount == 0) {
        warnOfCount(*run, prepared.requested.targetCount);
        warnOfFewSpheres(*run, options.local.largest(options.sizes));
    }
    return run;
}

/// All stages after those that the seeds share.
template <int Dim>
RunResult packPrepared(const PackRecipe& recipe, const SourcePtr& source,
                       const Prepared<Dim>& prepared, const Report& begun, const Clock& clock,
                       const Callbacks& callbacks) {
    const RunPtr<Dim> packed = packMeasured(recipe, source, prepared, begun, clock, callbacks);
    Run<Dim>& run = *packed;
    PageDetails details;
    if (isPage(recipe.reportFile))
        run.unlessInterrupted([&] {
            Callbacks own = callbacks;
            if (run.ranks()) own.cancelled = nullptr;
            details = pageDetails(run.pack, run.facts.fixed, run.filledSource(),
                                  run.solid ? run.source.get() : nullptr, run.filled(),
                                  run.sizes->all, run.report, own, rowsOf(run));
        });
    RunResult result = finishStage(run);
    if (run.isFirst()) writeReport(result, details, recipe);
    return result;
}

template <int Dim>
void packAll(const std::vector<PackRecipe>& recipes, const SourcePtr& source, const Report& begun,
             Clock clock, const Callbacks& callbacks,
             const std::function<bool(RunResult&&)>& done) {
    Report first = begun;
    clock.lap();
    const Prepared<Dim> prepared =
        prepare<Dim>(recipes.front(), *source, keepingWarnings(callbacks, first.warnings));
    first.seconds.domain = clock.lap();
    for (const PackRecipe& recipe : recipes) {
        if (!done(packPrepared(recipe, source, prepared, first, clock, callbacks))) return;
        // Seconds spent once are reported once.
        first.seconds = {};
        clock = Clock();
    }
}

}  // namespace

std::unique_ptr<Run<3>> packPart(const PackRecipe& recipe, const SourcePtr& source,
                                 const Report& begun, Clock clock, const Callbacks& callbacks) {
    Report first = begun;
    const auto prepared = prepare<3>(recipe, *source, keepingWarnings(callbacks, first.warnings));
    first.seconds.domain = clock.lap();
    auto run = packMeasured<3>(recipe, source, prepared, first, clock, callbacks);
    run->voids.bvtv = {};  // it holds an image
    return run;
}

void packEach(const std::vector<PackRecipe>& asked, const Callbacks& caller,
              const std::function<bool(RunResult&&)>& done) {
    std::vector<PackRecipe> recipes = asked;
    const PackRecipe& recipe = recipes.front();
    const Callbacks callbacks = withinMemory(caller, recipe.memoryLimit);
    for (const auto& r : recipes) checkRecipe(r);
    if (recipe.ranks) checkRanks(recipe);
    Clock clock;
    Report report = begunReport(recipe, "pack", recipe.domain.source);
    const auto work = [&] {
        const Callbacks heard = keepingWarnings(callbacks, report.warnings);
        const VoidRecipe sampled = withSample(recipe.voids, heard);
        for (PackRecipe& r : recipes) {
            r.voids = sampled;
            for (PackRecipe& part : r.parts) part.voids = withSample(part.voids, heard);
        }
        if (Parts parts = partsOf(recipe, heard); !parts.empty()) {
            report.seconds.mesh = clock.lap();
            if (recipes.size() > 1)
                throw ParameterError("several parts are packed with one `seed`");
            done(packParts(recipe, std::move(parts), report, clock, callbacks));
            return;
        }
        const auto source = std::make_shared<const DomainSource>(recipe.domain, heard);
        report.seconds.mesh = clock.lap();
        if (recipe.ranks) checkRanksIn(*source, recipe);
        beginOn({source.get()}, recipe, recipe.voids, report, heard);
        warnOfUnused(recipe.domain, *source, heard);
        checkOutputKinds(recipe.outputs, RunKind::pack, recipe.voids, source->dim());
        if (source->dim() == 3)
            packAll<3>(recipes, source, report, clock, callbacks, done);
        else
            packAll<2>(recipes, source, report, clock, callbacks, done);
    };
    try {
        // One thread more speaks with the other ranks.
        withThreads(recipe.threads, work, recipe.ranks ? 1 : 0);
    } catch (const Interrupted&) {
        if (recipe.ranks) throw;  // the others may have come farther
        RunResult none;
        none.report = report;
        none.report.interrupted = true;
        none.passed = true;
        done(std::move(none));
    }
}

RunResult runPack(const PackRecipe& recipe, const Callbacks& callbacks) {
    RunResult result;
    packEach({recipe}, callbacks, [&result](RunResult&& run) {
        result = std::move(run);
        return true;
    });
    return result;
}

}  // namespace vdbpack
