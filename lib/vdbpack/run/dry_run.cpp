#include "vdbpack/run/dry_run.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/pack/pack_to_count.h"
#include "vdbpack/run/clock.h"
#include "vdbpack/run/pack_plan.h"
#include "vdbpack/run/run_each.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/run/structure_sample.h"
#include "vdbpack/voids/structure_fit.h"
#include "vdbpack/voids/trabecular_presets.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <variant>

namespace vdbpack {

namespace {

/// Spheres of a pack that is its own trial, and of the larger trial of others; beside existing
/// spheres, whose radii do not scale with the others. The smaller trial has kRatio times fewer.
constexpr double kTrial = 40000, kTrialBesides = 400000, kRatio = 4;
/// Of a trial whose spheres do not fit.
constexpr double kSmallerScale = 1.5;
/// Voxels of the voids of a trial, at most, in those of the run.
constexpr double kCoarserVoxels = 2;

/// The run of a recipe with larger radii.
struct Trial {
    double scale = 1;    ///< of the radii, against the pack to come
    double count = 0;    ///< spheres placed
    double solid = 0;    ///< their share of the domain
    double voxels = 0;   ///< of the field
    double stamped = 0;  ///< memory of the voids, which their time is in proportion to
    Report report;
};

template <int Dim>
double ballsFrom(const Pack<Dim>& pack, std::size_t first) {
    double sum = 0;
    for (std::size_t i = first; i < pack.spheres.size(); ++i)
        sum += Measure<Dim>::ball(pack.spheres[i].radius);
    return sum;
}

/// Fixes the sizes of voids, and enlarges their voxels with the spheres, as far as the voids
/// permit.
void coarsenVoids(VoidRecipe& voids, double scale, const VoidExtent& planned) {
    if (!(scale > 1) || !(planned.voxelSize > 0)) return;
    voids.voxelSize = std::min(scale, kCoarserVoxels) * planned.voxelSize;
}

Trial tryOut(PackRecipe recipe, const DomainSource& source, double scale, const VoidExtent& voids,
             const Callbacks& callbacks) {
    if (scale > 1) recipe.maxCount = 0;
    recipe.targetCount =
        requestedSizes(recipe, source.dim()).targetCount / std::pow(scale, source.dim());
    recipe.radiusFactor = scale;
    recipe.gap *= scale;
    coarsenVoids(recipe.voids, scale, voids);
    recipe.outputs.clear();
    recipe.reportFile.clear();
    recipe.preview = {};
    recipe.memoryLimit = 0;
    Callbacks quiet;
    quiet.cancelled = callbacks.cancelled;
    RunResult run = packIn(source, recipe, quiet);
    if (run.report.interrupted) throw Interrupted();
    Trial trial;
    trial.scale = scale;
    trial.count = static_cast<double>(run.report.count - run.report.existing);
    trial.solid =
        std::visit([&](const auto& p) { return ballsFrom(p, run.report.existing); }, run.pack) /
        run.report.volume;
    const Extent extent = planPack(recipe, source).extent;
    trial.voxels = extent.field.voxels();
    trial.stamped = stampBytes(extent);
    trial.report = std::move(run.report);
    return trial;
}

/// A trial of at most that scale; of a smaller one where such large spheres do not fit into thin
/// parts.
Trial tryLarge(const PackRecipe& recipe, const DomainSource& source, double scale,
               const VoidExtent& voids, const Callbacks& callbacks) {
    for (;;) {
        try {
            return tryOut(recipe, source, scale, voids, callbacks);
        } catch (const InputError&) {
            if (!(scale > 1)) throw;
        }
        scale = std::max(1.0, scale / kSmallerScale);
    }
}

/// The same of `kRatio` times fewer spheres than a trial; that trial itself if they do not fit.
Trial trySmall(const PackRecipe& recipe, const DomainSource& source, const Trial& large,
               const VoidExtent& voids, const Callbacks& callbacks) {
    if (!(large.scale > 1)) return large;
    try {
        return tryOut(recipe, source, large.scale * std::pow(kRatio, 1.0 / source.dim()), voids,
                      callbacks);
    } catch (const InputError&) {
        return large;
    }
}

/// The line through two points, at `x`; through the second alone where they are too close.
double line(double x1, double y1, double x2, double y2, double x) {
    if (std::fabs(x2 - x1) < 1e-9 * (std::fabs(x1) + std::fabs(x2))) return y2;
    return y2 + (y2 - y1) / (x2 - x1) * (x - x2);
}

DryRun predict(const PackRecipe& recipe, const DomainSource& source, const Callbacks& callbacks) {
    const int dim = source.dim();
    auto [requested, radii, extent] = planPack(recipe, source);
    const double most = recipe.existing.empty() ? kTrial : kTrialBesides;
    const double scale = std::max(1.0, std::pow(extent.count / most, 1.0 / dim));
    // Voids keep the sizes that follow from the radii of the pack to come.
    PackRecipe sized = recipe;
    if (VoidShapeRecipe* shape = shapeOf(sized.voids); shape && shape->radius.empty())
        shape->radius = defaultVoidRadius(requested.largest() * radii.scale);
    const Trial large = tryLarge(sized, source, scale, extent.voids, callbacks);
    const Trial small = trySmall(sized, source, large, extent.voids, callbacks);
    DryRun run;
    run.trial = large.report;
    run.voxelSize = extent.field.voxelSize;

    const double existing = large.report.solidFractionTotal.value_or(0) - large.solid;
    double solid =
        std::clamp(line(small.scale, small.solid, large.scale, large.solid, 1), 0.0, 0.95);
    if (recipe.densify > 0 && std::isfinite(recipe.densify)) {
        solid = std::min(solid, std::max(recipe.densify - existing, large.solid));
        run.densified = solid + existing > recipe.densify - 1e-4;
    }
    // Radii are scaled to a target count; else the count follows from them.
    const double filled = solid * run.trial.volume;
    // Sizes by place: as in the trial.
    const double each =
        requested.differByPlace() && large.count > 0
            ? large.solid * run.trial.volume / large.count / std::pow(large.scale, dim)
            : requested.sizes.meanBall(dim);
    run.count = large.scale > 1 ? filled / each : large.count;
    run.sizes = requested.sizes.spec();
    if (requested.targetCount > 0) {
        if (large.scale > 1) run.count = requested.targetCount;
        run.sizes =
            scaledSizes(requested.sizes, std::pow(filled / (run.count * each), 1.0 / dim), dim)
                .spec();
    }
    if (recipe.maxCount > 0 && run.count > static_cast<double>(recipe.maxCount)) {
        solid *= static_cast<double>(recipe.maxCount) / run.count;
        run.count = static_cast<double>(recipe.maxCount);
    }
    run.solidFraction = solid + existing;

    const auto secondsAt = [&](double Report::Seconds::*stage, double Trial::*amount, double x) {
        const double larger = large.report.seconds.*stage;
        return std::max(larger,
                        line(small.*amount, small.report.seconds.*stage, large.*amount, larger, x));
    };
    run.seconds.domain = secondsAt(&Report::Seconds::domain, &Trial::voxels, extent.field.voxels());
    for (const auto stage :
         {&Report::Seconds::pack, &Report::Seconds::densify, &Report::Seconds::measure})
        run.seconds.*stage = secondsAt(stage, &Trial::count, run.count);
    // Voids, and the contour of a solid that is filled, cost time for the voxels of their walls.
    const double finer = large.stamped > 0 ? std::max(1.0, stampBytes(extent) / large.stamped) : 1;
    run.seconds.voids = finer * large.report.seconds.voids;
    if (recipe.voids.fill == Fill::solid) {
        run.seconds.domain = std::max(run.seconds.domain, finer * large.report.seconds.domain);
        run.seconds.measure = std::max(run.seconds.measure, finer * large.report.seconds.measure);
    }
    run.count += static_cast<double>(run.trial.existing);
    extent.count = run.count;
    run.estimate = estimate(extent, recipe);
    return run;
}

}  // namespace

DryRun dryRunPack(const PackRecipe& asked, const Callbacks& callbacks) {
    PackRecipe recipe = asked;
    checkRecipe(recipe);
    if (!recipe.parts.empty())
        throw ParameterError(
            "a dry run predicts one part; leave out `partsFile`, and name the domain of one");
    return withThreads(recipe.threads, [&] {
        Clock clock;
        // A foam of usual bone costs about as much as the one that will be found.
        recipe.voids = usualFoam(withSample(recipe.voids, callbacks));
        const DomainSource source(recipe.domain, callbacks);
        const double mesh = clock.lap();
        DryRun run = predict(recipe, source, callbacks);
        Report::Seconds& s = run.seconds;
        s.mesh = mesh;
        s.total = mesh + s.domain + s.pack + s.densify + s.voids + s.measure;
        run.trialSeconds = clock.total();
        return run;
    });
}

nlohmann::ordered_json toJson(const DryRun& f) {
    using Json = nlohmann::ordered_json;
    Json json;
    json["dryRun"] = true;
    json["threads"] = f.trial.threads;
    json["domain"] = {{"volume", f.trial.volume},
                      {"voxelSize", f.voxelSize > 0 ? Json(f.voxelSize) : Json()}};
    json["spheres"] = {
        {"count", std::llround(f.count)}, {"existing", f.trial.existing}, {"requested", f.sizes}};
    json["solidFraction"] = {{"total", f.solidFraction}};
    json["seconds"] = {{"mesh", f.seconds.mesh},   {"domain", f.seconds.domain},
                       {"pack", f.seconds.pack},   {"densify", f.seconds.densify},
                       {"voids", f.seconds.voids}, {"measure", f.seconds.measure},
                       {"total", f.seconds.total}};
    const auto whole = [](double bytes) { return std::llround(std::min(bytes, 9e18)); };
    json["peakMemoryBytes"] = whole(f.estimate.memory());
    for (const auto& part : f.estimate.parts) json["memory"][part.name] = whole(part.bytes);
    json["files"] = Json::array();
    for (const auto& file : f.estimate.files)
        json["files"].push_back({{"name", file.name}, {"bytes", whole(file.bytes)}});
    json["trial"] = {{"count", f.trial.count - f.trial.existing}, {"seconds", f.trialSeconds}};
    return json;
}

std::string summary(const DryRun& f) {
    const char* spheres = f.trial.dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres;
    std::string text = fmt::format("dry run    nothing is written; expect about\n");
    text += fmt::format("{:<11}{:.0f}, radii {} mm{}\n", spheres, f.count, f.sizes,
                        f.trial.existing > 0
                            ? fmt::format("; {} of them exist already", f.trial.existing)
                            : std::string());
    text += fmt::format("{:<11}{:.3f} of the domain{}\n", "solid", f.solidFraction,
                        f.densified ? "" : "; denser packs are not reached");
    if (f.voxelSize > 0) text += fmt::format("{:<11}voxels of {:.4g} mm\n", "field", f.voxelSize);
    text += fmt::format(
        "{:<11}mesh {:.2f}, domain {:.2f}, pack {:.2f}, {}{}measure {:.2f}, total {:.2f} on {} "
        "thread{}\n",
        "seconds", f.seconds.mesh, f.seconds.domain, f.seconds.pack,
        f.seconds.densify > 0 ? fmt::format("densify {:.2f}, ", f.seconds.densify) : std::string(),
        f.seconds.voids > 0 ? fmt::format("voids {:.2f}, ", f.seconds.voids) : std::string(),
        f.seconds.measure, f.seconds.total, f.trial.threads, f.trial.threads == 1 ? "" : "s");
    text += fmt::format("{:<11}about {} at most: {}\n", "memory", bytesText(f.estimate.memory()),
                        f.estimate.memoryText());
    for (const auto& file : f.estimate.files)
        text += fmt::format("{:<11}{} about {}\n", "file", file.name, bytesText(file.bytes));
    text += fmt::format("{:<11}trials of up to {} {}, {:.2f} s\n", "from",
                        f.trial.count - f.trial.existing, spheres, f.trialSeconds);
    return text;
}

}  // namespace vdbpack
