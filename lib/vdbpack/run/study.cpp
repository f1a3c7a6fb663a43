#include "vdbpack/core/error.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/report/study_table.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/stages.h"

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

/// @param inputs  that neither the outputs nor the table may replace.
/// @param runEach  makes the runs of all recipes.
template <class Recipe, class RunEach>
StudyResult runsOf(const Recipe& recipe, const std::vector<std::uint64_t>& seeds,
                   const std::string& table, const std::vector<std::string>& inputs,
                   const RunEach& runEach) {
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
    const auto writeTable = [&] {
        if (!file || study.reports.empty()) return;
        // The table of a former study that is complete stays.
        if (study.interrupted) file.emplace(interruptedName(table));
        file->write(studyTable(study.reports));
        file->commit();
    };
    try {
        runEach(recipes, [&](RunResult&& run) {
            study.passed = study.passed && run.passed;
            study.interrupted = run.report.interrupted;
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
        recipe, seeds, table, {recipe.domain.source, recipe.existing},
        [&](const auto& recipes, const Each& done) { packEach(recipes, callbacks, done); });
}

StudyResult runStudy(const VoidsRecipe& recipe, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks) {
    return runsOf(
        recipe, seeds, table, {recipe.domain.source},
        [&](const auto& recipes, const Each& done) { voidsEach(recipes, callbacks, done); });
}

std::string summary(const StudyResult& study) {
    return studySummary(study.reports, study.interrupted);
}

}  // namespace vdbpack
