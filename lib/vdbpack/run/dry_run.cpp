#include "vdbpack/core/clock.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/shared_radii.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/run/structure_sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace vdbpack {

namespace {

/// A run that memory does not allow is not estimated more closely.
PackPlan planWithin(const PackRecipe& recipe, const DomainSource& source,
                    const Callbacks& callbacks) {
    PackPlan plan = planPack(recipe, source);
    if (estimate(plan.extent, recipe).memory() <= memoryLimit(recipe.memoryLimit))
        plan = planPack(recipe, source, true);
    const double target = plan.requested.targetCount;
    if (!(plan.count >= 0.5))
        throw InputError(
            fmt::format("{}: no sphere {} is expected to fit; {}", recipe.domain.source,
                        target > 0 ? fmt::format("of {:.0f}", target) : "of these radii",
                        target > 0 ? "give a larger number, which makes them smaller"
                                   : "choose smaller radii"));
    constexpr double kClear = 1.05;
    if (target > 0 && plan.count - plan.existing > kClear * target)
        callbacks.warn(fmt::format(
            "`targetCount` {:.0f}: about {:.0f} are expected, since none of more than {:.4g} mm "
            "fits into the domain; give another number, or the radii themselves",
            target, plan.count - plan.existing, plan.room));
    return plan;
}

std::string sizesOf(const PackPlan& plan) {
    return plan.requested.sizes.scaled(plan.scale).spec();
}

/// Adds what a part needs to what the others do, with its field and its voids.
void addPart(PackPlan& all, const PackPlan& part) {
    Extent& e = all.extent;
    const Extent& own = part.extent;
    const double spheres = e.kept * e.count + own.kept * own.count;
    all.solidFraction =
        (all.solidFraction * e.volume + part.solidFraction * own.volume) / (e.volume + own.volume);
    all.count += part.count;
    all.densified = all.densified && part.densified;
    e.volume += own.volume;
    e.area += own.area;
    e.count += own.count;
    e.kept = spheres / e.count;
    e.field.triangles += own.field.triangles;
    e.field.area += own.field.area;
    e.field.volume += own.field.volume;
    e.field.depth = std::max(e.field.depth, own.field.depth);
    e.field.voxelSize = std::min(e.field.voxelSize, own.field.voxelSize);
    e.field.watertight = e.field.watertight && own.field.watertight;
    if (e.voids.voxelSize == 0 || own.voids.voxelSize == 0)
        e.voids.voxelSize += own.voids.voxelSize;
    else
        e.voids.voxelSize = std::min(e.voids.voxelSize, own.voids.voxelSize);
    e.voids.count += own.voids.count;
    e.voids.wall += own.voids.wall;
    e.voids.foam = e.voids.foam || own.voids.foam;
    e.labelVoxels = std::max(e.labelVoxels, own.labelVoxels);
    Report::Seconds& s = all.seconds;
    s.domain += part.seconds.domain;
    s.pack += part.seconds.pack;
    s.settle += part.seconds.settle;
    s.densify += part.seconds.densify;
    s.voids += part.seconds.voids;
    s.measure += part.seconds.measure;
}

/// All parts together, and their radii.
PackPlan planParts(const PackRecipe& recipe, Parts& parts, std::string& sizes,
                   const Callbacks& callbacks) {
    if (parts.size() == 1) {
        warnOfUnused(parts[0].recipe.domain, *parts[0].source, callbacks);
        PackPlan one = planWithin(parts[0].recipe, *parts[0].source, callbacks);
        sizes = sizesOf(one);
        return one;
    }
    std::optional<PackPlan> all;
    SharedRadii radii(recipe, parts);
    radii.warnOfUnused(recipe, callbacks);
    for (const std::size_t k : radii.order()) {
        radii.prepare(parts[k].recipe, k);
        const PackPlan one = [&] {
            try {
                return planWithin(parts[k].recipe, *parts[k].source, callbacks);
            } catch (const InputError& error) {
                throw withPart(parts[k], error);
            }
        }();
        radii.take(one.requested.sizes.scaled(one.scale), k);
        if (!all) {
            all = one;
            sizes = sizesOf(one);
        } else {
            addPart(*all, one);
            if (sizes != sizesOf(one)) sizes = "of each part's own, in";
        }
    }
    // Most packs that shall have a number of spheres are made twice.
    if (radii.target() > 0)
        for (double* stage : {&all->seconds.domain, &all->seconds.pack, &all->seconds.settle,
                              &all->seconds.densify, &all->seconds.voids})
            *stage *= 2;
    return *all;
}

}  // namespace

DryRun dryRunPack(const PackRecipe& asked, const Callbacks& callbacks) {
    PackRecipe recipe = asked;
    checkRecipe(recipe);
    return withThreads(recipe.threads, [&] {
        recipe.voids = withSample(recipe.voids, recipe.domain, callbacks);
        for (PackRecipe& part : recipe.parts)
            part.voids = withSample(part.voids, part.domain, callbacks);
        Clock clock;
        partsByCenter(recipe, callbacks);
        Parts parts = partsOf(recipe, callbacks);
        if (parts.empty())
            parts.push_back({recipe, std::make_shared<DomainSource>(recipe.domain, callbacks)});
        const double mesh = clock.lap();
        std::string sizes;
        const PackPlan plan = planParts(recipe, parts, sizes, callbacks);
        const Extent& extent = plan.extent;
        DryRun run{extent.dim,
                   effectiveThreads(recipe.threads),
                   extent.volume,
                   extent.field.voxelSize,
                   plan.count,
                   plan.existing,
                   plan.solidFraction,
                   plan.densified,
                   sizes,
                   plan.seconds,
                   estimate(extent, recipe)};
        // Blocks wait for their neighbors: 4 threads are 3.1, 16 threads 6.4 times as fast as one.
        const double slower = (1 + 0.1 * (run.threads - 1)) / run.threads;
        Report::Seconds& s = run.seconds;
        s.mesh = s.total = mesh;
        for (double* stage : {&s.domain, &s.pack, &s.settle, &s.densify, &s.voids, &s.measure})
            s.total += * stage *= slower;
        return run;
    });
}

}  // namespace vdbpack
