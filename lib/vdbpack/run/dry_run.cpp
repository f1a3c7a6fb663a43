#include "vdbpack/run/dry_run.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/pack/pack_to_count.h"
#include "vdbpack/run/clock.h"
#include "vdbpack/run/measure_stage.h"
#include "vdbpack/run/pack_stage.h"
#include "vdbpack/run/stages.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Spheres of the larger trial at most, and its share of the pack at least where that is less.
constexpr double kTrialCount = 100000;
constexpr double kTrialShare = 0.08;
/// The smaller trial has as many times fewer.
constexpr double kTrialRatio = 4;
/// A pack of no more spheres is its own trial.
constexpr double kSmallCount = 20000;
constexpr double kSmallBesides = 400000;
/// Share of a full run's packing time that --target-count adds with its own trials.
constexpr double kTargetTrials = 0.25;

/// A pack is densified on trial with no more spheres.
constexpr double kDensifyCount = 20000;

/// What one trial gave.
template <int Dim>
struct Trial {
    double scale = 1;                ///< of the radii, against the pack to come
    double count = 0, fraction = 0;  ///< of what is placed
    double existing = 0, existingFraction = 0;
    double voxels = 0, voxelSize = 0;
    double volume = 0, area = 0;               ///< of the domain, mm^dim
    double domain = 0, pack = 0, measure = 0;  ///< seconds
    /// What was packed: existing spheres first.
    std::shared_ptr<const Domain<Dim>> filled;
    std::vector<Sphere<Dim>> spheres;
};

/// The line through two points, at `x`; through the second alone where they are too close.
double line(double x1, double y1, double x2, double y2, double x) {
    if (std::fabs(x2 - x1) < 1e-9 * (std::fabs(x1) + std::fabs(x2))) return y2;
    return y2 + (y2 - y1) / (x2 - x1) * (x - x2);
}

template <int Dim>
Trial<Dim> tryOut(const PackRecipe& recipe, const DomainSource& source,
                  const SizeDistribution& sizes, double scale, const Callbacks& callbacks) {
    Callbacks quiet;
    quiet.cancelled = callbacks.cancelled;
    Trial<Dim> trial;
    trial.scale = scale;
    Clock clock;
    PackOptions options = packOptions(recipe, sizes.scaled(scale));
    options.gap *= scale;
    options.maxCount = 0;
    const auto built = source.build(fieldDetail(options.sizes.min(), options.sizes.mean()),
                                    options.sizes.max() * 1.05 + options.gap, quiet);
    const auto& domain = ofDim<Dim>(built);
    trial.domain = clock.lap();
    const DomainFacts facts = domain->facts();
    trial.voxels = static_cast<double>(facts.activeVoxels);
    trial.voxelSize = facts.voxelSize;
    trial.volume = domain->volume();
    trial.area = domain->wallArea();
    const Pack<Dim> existing = readExisting<Dim>(recipe, built.sliceHeight);
    clock.lap();
    auto result = packSpheres(*domain, options, quiet, existing.spheres);
    if (result.interrupted) throw Interrupted();
    trial.pack = clock.lap();
    trial.count = static_cast<double>(result.pack.spheres.size());
    for (const auto& s : result.pack.spheres) trial.fraction += Measure<Dim>::ball(s.radius);
    trial.fraction /= domain->volume();
    trial.existing = static_cast<double>(existing.spheres.size());
    const auto sampler = domain->sampler();
    for (const auto& s : existing.spheres)
        if (sampler->contains(s.center))
            trial.existingFraction += Measure<Dim>::ball(s.radius) / domain->volume();
    clock.lap();
    Report report;
    measurePack(result.pack, &source, domain.get(), &options.sizes, recipe.contactTolerance,
                report);
    trial.measure = clock.lap();
    trial.filled = domain;
    trial.spheres = existing.spheres;
    trial.spheres.insert(trial.spheres.end(), result.pack.spheres.begin(),
                         result.pack.spheres.end());
    return trial;
}

/// The scale at which `sizes` give `count` spheres around existing ones or with a gap.
template <int Dim>
double scaleBesides(const PackRecipe& recipe, const DomainSource& source,
                    const SizeDistribution& sizes, double count, const Callbacks& callbacks) {
    Callbacks quiet;
    quiet.cancelled = callbacks.cancelled;
    PackOptions options = packOptions(recipe, sizes);
    options.maxCount = 0;
    const auto built =
        source.build(fieldDetail(sizes.min(), sizes.mean()), sizes.max() * 3 + recipe.gap, quiet);
    const Pack<Dim> existing = readExisting<Dim>(recipe, built.sliceHeight);
    const auto& domain = *ofDim<Dim>(built);
    if (count > kSmallBesides)
        return scaleForCount(domain, options, count, quiet, existing.spheres);
    packToCount(domain, options, count, quiet, existing.spheres);
    return options.sizes.mean() / sizes.mean();
}

/// What densifying adds, from a trial that gains as much over its own front.
template <int Dim>
void predictDensify(const PackRecipe& recipe, const Trial<Dim>& trial,
                    const SizeDistribution& sizes, DryRun& f, const Callbacks& callbacks) {
    const double existing = trial.existingFraction, before = trial.fraction + existing;
    DensifyOptions options;
    options.sizes = sizes.scaled(trial.scale);
    options.gap = recipe.gap * trial.scale;
    options.seed = recipe.seed;
    options.fixed = static_cast<std::size_t>(trial.existing);
    options.fraction =
        std::isfinite(recipe.densify) ? before + recipe.densify - f.solidFraction : recipe.densify;
    if (!(options.fraction > before)) return;
    Callbacks quiet;
    quiet.cancelled = callbacks.cancelled;
    Clock clock;
    const auto result = densify(*trial.filled, trial.spheres, options, quiet);
    if (result.interrupted) throw Interrupted();
    const double gain = result.after - result.before;
    const double more = (f.solidFraction + gain) / f.solidFraction;
    f.seconds.densify = clock.lap() * f.count / static_cast<double>(trial.spheres.size());
    f.solidFraction += gain;
    f.densified = result.reached || !std::isfinite(recipe.densify);
    if (recipe.targetCount > 0 || recipe.radius.empty())  // the radii follow the count
        f.sizes = scaledSizes(SizeDistribution::parse(f.sizes, Dim, recipe.weightBy),
                              std::pow(more, 1.0 / Dim), Dim)
                      .spec();
    else
        f.count *= more;
}

template <int Dim>
DryRun predict(const PackRecipe& recipe, const DomainSource& source, const Callbacks& callbacks) {
    RequestedSizes requested = requestedSizes(recipe, Dim);
    DryRun f;
    f.dim = Dim;
    f.volume = source.volume();
    // Radii times `unit` fill the domain with about `expected` spheres.
    const double guess = Dim == 3 ? 0.6 : 0.82;
    double expected = guess * f.volume / requested.sizes.meanBall(Dim), unit = 1;
    if (requested.targetCount > 0) {
        unit = std::pow(expected / requested.targetCount, 1.0 / Dim);
        expected = requested.targetCount;
    }
    if (requested.targetCount > 0 && (recipe.gap > 0 || !recipe.existing.empty())) {
        // Neither the gap nor the existing spheres are scaled with the radii.
        unit *= scaleBesides<Dim>(recipe, source, scaledSizes(requested.sizes, unit, Dim),
                                  requested.targetCount, callbacks);
        requested.targetCount = 0;
        expected = guess * f.volume / (requested.sizes.meanBall(Dim) * std::pow(unit, Dim));
    }
    // Existing spheres do not scale with the radii: larger packs are their own trial then.
    const double smallCount = recipe.existing.empty() ? kSmallCount : kSmallBesides;
    SizeDistribution sizes = scaledSizes(requested.sizes, unit, Dim);
    Trial<Dim> small, large;
    if (expected <= smallCount) {
        small = large = tryOut<Dim>(recipe, source, sizes, 1, callbacks);
    } else {
        const double most = std::min(kTrialCount, std::max(kSmallCount, kTrialShare * expected));
        const double scale = std::pow(expected / most, 1.0 / Dim);
        small =
            tryOut<Dim>(recipe, source, sizes, scale * std::pow(kTrialRatio, 1.0 / Dim), callbacks);
        large = tryOut<Dim>(recipe, source, sizes, scale, callbacks);
    }
    const auto fractionAt = [&](double scale) {
        return std::clamp(line(small.scale, small.fraction, large.scale, large.fraction, scale),
                          0.0, 0.95);
    };
    double scale = 1;
    if (requested.targetCount > 0) {
        // Where the fraction that the walls leave gives the count asked for.
        for (int i = 0; i < 30; ++i)
            scale = std::pow(
                fractionAt(scale) * f.volume / (sizes.meanBall(Dim) * requested.targetCount),
                1.0 / Dim);
        if (large.scale == 1) {  // the pack itself was the trial
            scale = std::pow(large.count / requested.targetCount, 1.0 / Dim);
        }
        f.count = requested.targetCount;
    } else {
        f.count = large.scale == 1 ? large.count : fractionAt(1) * f.volume / sizes.meanBall(Dim);
    }
    f.solidFraction = fractionAt(scale);
    f.sizes = scaledSizes(sizes, scale, Dim).spec();
    // Stopped early: as much of the pack and of its time.
    const double share =
        recipe.maxCount > 0 ? std::min(1.0, static_cast<double>(recipe.maxCount) / f.count) : 1.0;
    f.count *= share;
    f.solidFraction = f.solidFraction * share + large.existingFraction;
    if (recipe.densify > 0) {
        // Fewer spheres suffice, and moving them takes long.
        const bool few = static_cast<double>(large.spheres.size()) <= kDensifyCount;
        predictDensify(recipe, few ? large : small, sizes, f, callbacks);
    }

    // The field: voxels by a power of the scale, the second where the band is thin against the
    // bone; seconds by the voxels.
    double voxels = large.voxels;
    f.seconds.domain = large.domain;
    if (!(recipe.domain.voxelSize > 0) && small.voxels > 0 && small.scale > large.scale) {
        const double power =
            std::log(large.voxels / small.voxels) / std::log(small.scale / large.scale);
        voxels *= std::pow(large.scale / scale, std::clamp(power, 1.0, 3.0));
        f.seconds.domain = std::max(
            large.domain, line(small.voxels, small.domain, large.voxels, large.domain, voxels));
    }
    f.voxelSize = recipe.domain.voxelSize > 0 ? recipe.domain.voxelSize
                                              : large.voxelSize * scale / large.scale;
    const auto atCount = [&](double smaller, double larger) {
        return std::max(larger, line(small.count, smaller, large.count, larger, f.count));
    };
    f.seconds.pack = large.scale == 1 ? large.pack * share : atCount(small.pack, large.pack);
    if (requested.targetCount > 0) f.seconds.pack *= 1 + kTargetTrials;
    f.seconds.measure = atCount(small.measure, large.measure);
    f.trialCount = static_cast<std::uint64_t>(large.count);
    f.existing = static_cast<std::uint64_t>(large.existing);
    f.count += large.existing;
    // Figures of the trials replace the guesses.
    Extent extent = extentOf(recipe, source);
    const double guessed = extent.domainVolume;
    extent.domainVolume = large.volume;
    extent.domainArea = large.area;
    extent.count = f.count;
    if (guessed > 0) extent.voids.count *= large.volume / guessed;
    if (extent.field.triangles > 0) extent.field.voxelSize = f.voxelSize;
    f.estimate = estimate(extent);
    return f;
}

}  // namespace

DryRun dryRunPack(const PackRecipe& recipe, const Callbacks& callbacks) {
    checkRecipe(recipe);
    return withThreads(recipe.threads, [&] {
        Clock clock;
        const DomainSource source(recipe.domain, callbacks);
        const double mesh = clock.lap();
        DryRun f = source.dim() == 3 ? predict<3>(recipe, source, callbacks)
                                     : predict<2>(recipe, source, callbacks);
        f.threads = effectiveThreads(recipe.threads);
        f.seconds.mesh = mesh;
        f.seconds.total =
            mesh + f.seconds.domain + f.seconds.pack + f.seconds.densify + f.seconds.measure;
        f.trialSeconds = clock.total();
        return f;
    });
}

nlohmann::ordered_json toJson(const DryRun& f) {
    using Json = nlohmann::ordered_json;
    Json json;
    json["dryRun"] = true;
    json["threads"] = f.threads;
    json["domain"] = {{"volume", f.volume},
                      {"voxelSize", f.voxelSize > 0 ? Json(f.voxelSize) : Json()}};
    json["spheres"] = {
        {"count", std::llround(f.count)}, {"existing", f.existing}, {"requested", f.sizes}};
    json["solidFraction"] = {{"total", f.solidFraction}};
    json["seconds"] = {{"mesh", f.seconds.mesh},       {"domain", f.seconds.domain},
                       {"pack", f.seconds.pack},       {"densify", f.seconds.densify},
                       {"measure", f.seconds.measure}, {"total", f.seconds.total}};
    json["peakMemoryBytes"] = std::llround(std::min(f.estimate.memory(), 9e18));
    json.update(toJson(f.estimate));
    json["trial"] = {{"count", f.trialCount}, {"seconds", f.trialSeconds}};
    return json;
}

std::string summary(const DryRun& f) {
    const char* spheres = f.dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres;
    std::string text = fmt::format("dry run    nothing is written; expect about\n");
    text += fmt::format(
        "{:<11}{:.0f}, radii {} mm{}\n", spheres, f.count, f.sizes,
        f.existing > 0 ? fmt::format("; {} of them exist already", f.existing) : std::string());
    text += fmt::format("{:<11}{:.3f} of the domain{}\n", "solid", f.solidFraction,
                        f.densified ? "" : "; denser packs are not reached");
    if (f.voxelSize > 0) text += fmt::format("{:<11}voxels of {:.4g} mm\n", "field", f.voxelSize);
    text += fmt::format(
        "{:<11}mesh {:.2f}, domain {:.2f}, pack {:.2f}, {}measure {:.2f}, total {:.2f} on {} "
        "thread{}\n",
        "seconds", f.seconds.mesh, f.seconds.domain, f.seconds.pack,
        f.seconds.densify > 0 ? fmt::format("densify {:.2f}, ", f.seconds.densify) : std::string(),
        f.seconds.measure, f.seconds.total, f.threads, f.threads == 1 ? "" : "s");
    text += summary(f.estimate);
    text += fmt::format("{:<11}trials of up to {} {}, {:.2f} s\n", "from", f.trialCount, spheres,
                        f.trialSeconds);
    return text;
}

}  // namespace vdbpack
