#include "vdbpack/run/dry_run.h"

#include "vdbpack/core/clock.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/run/structure_sample.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Usual errors, as measured (assets/guides/reliability.md).
constexpr double kCountError = 0.05, kMemoryError = 0.25, kTimeError = 0.5;

}  // namespace

DryRun dryRunPack(const PackRecipe& asked, const Callbacks& callbacks) {
    PackRecipe recipe = asked;
    checkRecipe(recipe);
    if (!recipe.parts.empty())
        throw ParameterError(
            "a dry run predicts one part; leave out `partsFile`, and name the domain of one");
    return withThreads(recipe.threads, [&] {
        recipe.voids = withSample(recipe.voids, callbacks);
        Clock clock;
        const DomainSource source(recipe.domain, callbacks);
        const double mesh = clock.lap();
        const PackPlan plan = planPack(recipe, source, true);
        if (!(plan.count >= 0.5))
            throw InputError(recipe.domain.source +
                             ": no sphere of these radii is expected to fit; choose smaller radii");
        const Extent& extent = plan.extent;
        DryRun run{extent.dim,
                   effectiveThreads(recipe.threads),
                   extent.volume,
                   extent.field.voxelSize,
                   plan.count,
                   plan.existing,
                   plan.solidFraction,
                   plan.densified,
                   plan.requested.sizes.scaled(plan.scale).spec(),
                   plan.seconds,
                   estimate(extent, recipe)};
        // Blocks wait for their neighbors: 4 threads are 3.1, 16 threads 6.4 times as fast as one.
        const double slower = (1 + 0.1 * (run.threads - 1)) / run.threads;
        Report::Seconds& s = run.seconds;
        s.mesh = s.total = mesh;
        for (double* stage : {&s.domain, &s.pack, &s.densify, &s.voids, &s.measure})
            s.total += * stage *= slower;
        return run;
    });
}

nlohmann::ordered_json toJson(const DryRun& f) {
    using Json = nlohmann::ordered_json;
    const auto whole = [](double amount) { return std::llround(std::min(amount, 9e18)); };
    const Report::Seconds& s = f.seconds;
    Json json;
    json["dryRun"] = true;
    json["threads"] = f.threads;
    json["domain"] = {{"volume", f.volume},
                      {"voxelSize", f.voxelSize > 0 ? Json(f.voxelSize) : Json()}};
    json["spheres"] = {
        {"count", whole(f.count)}, {"existing", whole(f.existing)}, {"requested", f.sizes}};
    json["solidFraction"] = {{"total", f.solidFraction}};
    json["seconds"] = {{"mesh", s.mesh},       {"domain", s.domain}, {"pack", s.pack},
                       {"densify", s.densify}, {"voids", s.voids},   {"measure", s.measure},
                       {"total", s.total}};
    json["peakMemoryBytes"] = whole(f.estimate.memory());
    for (const auto& part : f.estimate.parts) json["memory"][part.name] = whole(part.bytes);
    json["files"] = Json::array();
    for (const auto& file : f.estimate.files)
        json["files"].push_back({{"name", file.name}, {"bytes", whole(file.bytes)}});
    json["errors"] = {{"count", kCountError}, {"memory", kMemoryError}, {"seconds", kTimeError}};
    return json;
}

std::string summary(const DryRun& f) {
    std::string text = "dry run    nothing is packed or written; expect about\n";
    const auto row = [&text](const char* name, const std::string& value) {
        text += fmt::format("{:<11}{}\n", name, value);
    };
    const Report::Seconds& s = f.seconds;
    row(f.dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres,
        fmt::format("{:.0f}, radii {} mm", f.count, f.sizes) +
            (f.existing > 0 ? fmt::format("; {} of them exist already", f.existing) : ""));
    row("solid", fmt::format("{:.3f} of the domain{}", f.solidFraction,
                             f.densified ? "" : "; denser packs are not reached"));
    if (f.voxelSize > 0) row("field", fmt::format("voxels of {:.4g} mm", f.voxelSize));
    row("seconds",
        fmt::format("mesh {:.2f}, domain {:.2f}, pack {:.2f}, densify {:.2f}, voids {:.2f}, "
                    "measure {:.2f}, total {:.2f} on {} thread{}",
                    s.mesh, s.domain, s.pack, s.densify, s.voids, s.measure, s.total, f.threads,
                    f.threads == 1 ? "" : "s"));
    row("memory", fmt::format("about {} at most: {}", bytesText(f.estimate.memory()),
                              f.estimate.memoryText()));
    for (const auto& file : f.estimate.files)
        row("file", fmt::format("{} about {}", file.name, bytesText(file.bytes)));
    row("errors", fmt::format("usually up to {:.0f} % in the count, {:.0f} % in memory, {:.0f} % "
                              "in time",
                              100 * kCountError, 100 * kMemoryError, 100 * kTimeError));
    return text;
}

}  // namespace vdbpack
