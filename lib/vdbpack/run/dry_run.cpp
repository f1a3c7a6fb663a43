#include "vdbpack/core/clock.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/run/structure_sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

DryRun dryRunPack(const PackRecipe& asked, const Callbacks& callbacks) {
    PackRecipe recipe = asked;
    checkRecipe(recipe);
    if (!recipe.parts.empty())
        throw ParameterError(
            "a dry run predicts one part; leave out `partsFile`, and name the domain of one");
    return withThreads(recipe.threads, [&] {
        recipe.voids = withSample(recipe.voids, recipe.domain, callbacks);
        Clock clock;
        const DomainSource source(recipe.domain, callbacks);
        const double mesh = clock.lap();
        // A run that memory does not allow is not estimated more closely.
        PackPlan plan = planPack(recipe, source);
        if (estimate(plan.extent, recipe).memory() <= memoryLimit(recipe.memoryLimit))
            plan = planPack(recipe, source, true);
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
        for (double* stage : {&s.domain, &s.pack, &s.settle, &s.densify, &s.voids, &s.measure})
            s.total += * stage *= slower;
        return run;
    });
}

}  // namespace vdbpack
