#include "vdbpack/core/error.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/report/study_table.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/stages.h"

#include <fmt/format.h>

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

using Each = std::function<bool(RunResult&&)>;

/// Refuses files that a run would write in place of another one's.
template <class Recipe>
void requireOwnNames(const std::vector<std::vector<Recipe>>& cases) {
    std::string marks = cases.front().size() > 1 ? "{seed}" : "";
    for (const auto& [option, value] : cases.front().front().varied)
        marks += (marks.empty() ? "" : " and ") + ('{' + option + '}');
    std::set<std::string> names;
    const auto requireNew = [&](const std::string& what, const std::string& name) {
        if (!name.empty() && !names.insert(name).second)
            throw ParameterError(what + name + ": several runs would write it; name it with " +
                                 marks);
    };
    for (const auto& recipes : cases)
        for (const Recipe& recipe : recipes) {
            for (const OutputTarget& output : recipe.outputs) requireNew("", output.text);
            requireNew("`reportFile` ", recipe.reportFile);
            requireNew("`preview.file` ", recipe.preview.file);
        }
}

void checkTable(const std::string& table) {
    if (extensionOf(table) != ".csv")
        throw ParameterError("`table` " + table + ": tables are CSV; name it .csv");
    if (withSeed(table, 1) != table)
        throw ParameterError("`table` " + table + ": one table holds all seeds; leave {seed}");
}

/// Warns of seeds that change nothing: packs in which nothing is random.
void warnOfSamePacks(const std::vector<Report>& reports, const Callbacks& callbacks) {
    for (std::size_t n = 1; n < reports.size(); ++n) {
        const Report &before = reports[n - 1], &r = reports[n];
        if (r.count == 0 || r.hash != before.hash || r.seed == before.seed) continue;
        callbacks.warn(
            fmt::format("seeds {} and {} give the same pack, since spheres of one size are not "
                        "drawn at random; give a distribution, such as `radius` uniform:0.98,1.02",
                        before.seed, r.seed));
        return;
    }
}

/// @param inputs  that neither the outputs nor the table may replace.
/// @param runEach  makes the runs of all recipes of a case.
template <class Recipe, class RunEach>
StudyResult runsOf(const std::vector<Recipe>& cases, const std::vector<std::uint64_t>& seeds,
                   const std::string& table, const std::vector<std::string>& inputs,
                   const Callbacks& callbacks, const RunEach& runEach) {
    if (seeds.empty()) throw ParameterError("there are no seeds; give at least one");
    std::vector<std::vector<Recipe>> recipes;
    for (const Recipe& one : cases) {
        recipes.emplace_back();
        for (const std::uint64_t seed : seeds) recipes.back().push_back(recipeForSeed(one, seed));
    }
    requireOwnNames(recipes);
    std::optional<OutputFile> file;
    if (!table.empty()) {
        checkTable(table);
        for (const auto& one : recipes)
            for (const auto& r : one)
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
        const auto done = [&](RunResult&& run) {
            study.passed = study.passed && run.passed;
            study.interrupted = run.report.interrupted;
            // Of an interrupted run no figure would compare with the others.
            if (!study.interrupted) study.reports.push_back(std::move(run.report));
            if (!run.passed) study.failures += failures(run);
            return !study.interrupted;
        };
        for (const auto& one : recipes)
            if (!study.interrupted) runEach(one, done);
    } catch (...) {
        writeTable();  // the rows that are complete
        throw;
    }
    writeTable();
    warnOfSamePacks(study.reports, callbacks);
    return study;
}

}  // namespace

StudyResult runStudy(const std::vector<PackRecipe>& cases, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks) {
    return runsOf(
        cases, seeds, table, {cases.front().domain.source, cases.front().existing}, callbacks,
        [&](const auto& recipes, const Each& done) { packEach(recipes, callbacks, done); });
}

StudyResult runStudy(const std::vector<VoidsRecipe>& cases, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks) {
    return runsOf(
        cases, seeds, table, {cases.front().domain.source}, callbacks,
        [&](const auto& recipes, const Each& done) { voidsEach(recipes, callbacks, done); });
}

std::string summary(const StudyResult& study) {
    return studySummary(study.reports, study.interrupted);
}

}  // namespace vdbpack
