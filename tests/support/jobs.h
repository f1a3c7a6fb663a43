// Jobs of runs for tests, with voids as options request them.
#pragma once

#include "vdbpack/options/jobs.h"
#include "vdbpack/run/recipe.h"
#include "vdbpack/run/run.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

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

/// The recipe of a command on the pack in a file. @param domain, output  empty: none.
template <class Recipe>
Recipe onPack(const std::string& pack, const std::string& domain = {},
              const std::string& output = {}) {
    Recipe recipe;
    recipe.pack = pack;
    recipe.domain.source = domain;
    if (!output.empty()) recipe.outputs = {output};
    return recipe;
}

/// Requests voids by this method. @param radius  of their shorter half-axes.
inline void setVoids(VoidRequest& request, const std::string& method,
                     const std::string& radius = {}, std::optional<double> targetBvtv = {}) {
    request.method = method;
    if (!radius.empty()) request.radius = radius;
    if (targetBvtv) request.targetBvtv = targetBvtv;
}

/// Voids of a domain without spheres. @param output  a file to write; empty: none.
inline VoidsJob voidsIn(const std::string& domain, const std::string& output = {}) {
    VoidsJob job;
    job.domain.source = domain;
    if (!output.empty()) job.outputs = {output};
    return job;
}

/// Whether a warning has this part.
inline bool mentions(const std::vector<std::string>& warnings, const std::string& part) {
    return std::any_of(warnings.begin(), warnings.end(),
                       [&](const auto& w) { return w.find(part) != std::string::npos; });
}

/// Callbacks that keep the warnings of runs.
struct Listener {
    std::vector<std::string> warnings;
    Callbacks callbacks;
    Listener() {
        callbacks.warning = [this](const std::string& text) { warnings.push_back(text); };
    }
    bool heard(const std::string& part) const { return mentions(warnings, part); }
};

/// The job once its words are parsed.
template <class Job>
Job settled(Job job) {
    job.voids = voidsOf(job.request);
    return job;
}
inline RunResult runPack(const PackJob& job, const Callbacks& callbacks = {}) {
    return vdbpack::runPack(settled(job), callbacks);
}
inline std::vector<std::string> warningsOf(const PackJob& recipe) {
    return runPack(recipe).report.warnings;
}
inline RunResult runVoids(const VoidsJob& job, const Callbacks& callbacks = {}) {
    return vdbpack::runVoids(settled(job), callbacks);
}
inline RunResult runCarve(const CarveJob& job, const Callbacks& callbacks = {}) {
    return vdbpack::runCarve(settled(job), callbacks);
}

}  // namespace vdbpack::test
