#include "vdbpack/core/error.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/report/study_table.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/stages.h"

#include <cmath>
#include <functional>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

using Each = std::function<bool(RunResult&&)>;

void requireSeedInNames(const RunSettings& settings) {
    const auto shared = [](const std::string& name) {
        return !name.empty() && withSeed(name, 1) == name;
    };
    for (const OutputTarget& output : settings.outputs)
        if (shared(output.text))
            throw ParameterError(output.text + ": each seed would replace it; name it with {seed}");
    if (shared(settings.reportFile))
        throw ParameterError("`reportFile` " + settings.reportFile +
                             ": each seed would replace it; name it with {seed}, or set "
                             "`table` FILE.csv");
    if (shared(settings.preview.file))
        throw ParameterError("`preview.file` " + settings.preview.file +
                             ": each seed would replace it; name it with {seed}");
}

void checkTable(const std::string& table) {
    if (extensionOf(table) != ".csv")
        throw ParameterError("`table` " + table + ": tables are CSV; name it .csv");
    if (withSeed(table, 1) != table)
        throw ParameterError("`table` " + table + ": one table holds all seeds; leave {seed}");
}

/// What a run leaves of its domain deeper than the shell, measured for a table; nothing if no level
/// set has it, or a target has measured it.
template <class Recipe>
std::optional<SolidMeasures> measuredSolid(const Recipe& recipe, const RunResult& run,
                                           const Callbacks& callbacks) {
    constexpr double kMostVoxels = 8e6;
    const Report& report = run.report;
    if (report.interrupted || report.dim != 3 || !report.voids || !report.voids->targets.empty() ||
        !recipe.voids.shellField.empty())
        return std::nullopt;
    MeasureRecipe measure;
    for (const auto& set : run.levelSets)
        if (set && levelSetName(*set) == kSolid) measure.solid = set;
    if (!measure.solid) return std::nullopt;
    measure.pack = recipe.domain.source;
    measure.domain = recipe.domain;
    measure.shell = report.voids->shell;
    measure.memoryLimit = recipe.memoryLimit;
    measure.threads = recipe.threads;
    // Solids of more voxels are measured in coarser ones.
    const double least = std::cbrt(bandBounds(*measure.solid).volume() / kMostVoxels);
    measure.domain.voxelSize = least > voxelSizeOf(*measure.solid) ? least : 0;
    Callbacks quiet;
    quiet.cancelled = callbacks.cancelled;
    const auto found = runMeasure(measure, quiet).morphometry;
    if (!found) return std::nullopt;
    if (!found->regions.empty()) return found->regions.back();
    return *found;
}

/// @param inputs  that neither the outputs nor the table may replace.
/// @param runEach  makes the runs of all recipes.
template <class Recipe, class RunEach>
StudyResult runsOf(const Recipe& recipe, const std::vector<std::uint64_t>& seeds,
                   const std::string& table, const std::vector<std::string>& inputs,
                   const Callbacks& callbacks, const RunEach& runEach) {
    if (seeds.empty()) throw ParameterError("there are no seeds; give at least one");
    std::vector<Recipe> recipes;
    for (const std::uint64_t seed : seeds) recipes.push_back(recipeForSeed(recipe, seed));
    if (seeds.size() > 1) requireSeedInNames(recipe);
    std::optional<OutputFile> file;
    if (!table.empty()) {
        checkTable(table);
        for (const auto& r : recipes)
            checkFiles(r.outputs, r.reportFile, inputs, {r.preview.file, table});
        file.emplace(table);
    }
    StudyResult study;
    std::vector<std::optional<SolidMeasures>> solids;
    const auto writeTable = [&] {
        if (!file || study.reports.empty()) return;
        // The table of a former study that is complete stays.
        if (study.interrupted) file.emplace(interruptedName(table));
        file->write(studyTable(study.reports, solids));
        file->commit();
    };
    try {
        runEach(recipes, [&](RunResult&& run) {
            study.passed = study.passed && run.passed;
            study.interrupted = run.report.interrupted;
            if (file && !study.interrupted) solids.push_back(measuredSolid(recipe, run, callbacks));
            // Of an interrupted run no figure would compare with the others.
            if (!study.interrupted) study.reports.push_back(std::move(run.report));
            if (!run.passed) study.failures += failures(run);
            return !study.interrupted;
        });
    } catch (...) {
        writeTable();  // the rows that are complete
        throw;
    }
    writeTable();
    return study;
}

}  // namespace

StudyResult runStudy(const PackRecipe& recipe, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks) {
    return runsOf(
        recipe, seeds, table, {recipe.domain.source, recipe.existing}, callbacks,
        [&](const auto& recipes, const Each& done) { packEach(recipes, callbacks, done); });
}

StudyResult runStudy(const VoidsRecipe& recipe, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks) {
    return runsOf(
        recipe, seeds, table, {recipe.domain.source}, callbacks,
        [&](const auto& recipes, const Each& done) { voidsEach(recipes, callbacks, done); });
}

std::string summary(const StudyResult& study) {
    return studySummary(study.reports, study.interrupted);
}

}  // namespace vdbpack
