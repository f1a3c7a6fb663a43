// Recipes of runs for tests, with voids as options request them.
#pragma once

#include "vdbpack/options/jobs.h"
#include "vdbpack/run/recipe.h"
#include "vdbpack/run/run.h"

#include <string>

namespace vdbpack::test {

/// @param output  a file to write; empty: none.
inline PackJob recipeFor(const std::string& domain, const std::string& radius,
                         const std::string& output = {}) {
    PackJob recipe;
    recipe.domain.source = domain;
    recipe.radius = SizeRequest::parse(radius);
    if (!output.empty()) recipe.outputs = {output};
    return recipe;
}

/// The job once its words are parsed.
template <class Job>
Job settled(Job job) {
    job.voids = voidsOf(job.request);
    return job;
}
inline RunResult runPack(const PackJob& job, const Callbacks& callbacks = {}) {
    return vdbpack::runPack(settled(job), callbacks);
}
inline RunResult runVoids(const VoidsJob& job, const Callbacks& callbacks = {}) {
    return vdbpack::runVoids(settled(job), callbacks);
}
inline RunResult runCarve(const CarveJob& job, const Callbacks& callbacks = {}) {
    return vdbpack::runCarve(settled(job), callbacks);
}

}  // namespace vdbpack::test
