#include "vdbpack/run/report_file.h"

#include "vdbpack/formats/outputs.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/options/jobs.h"
#include "vdbpack/report/report_page.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <utility>
#include <variant>
#include <vector>

namespace vdbpack {

namespace {

using Json = nlohmann::ordered_json;

void write(const std::string& path, const std::string& text) {
    OutputFile file(path);
    file.write(text);
    file.commit();
}

/// Names of files are any bytes; JSON is UTF-8.
std::string jsonText(const Json& json) {
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// The options that were given, and what the run made of them.
std::vector<std::pair<std::string, std::string>> settingsOf(const RunSettings& recipe,
                                                            const Report& report) {
    auto settings = recipe.givenOptions;
    const auto add = [&](const char* name, const std::string& value) {
        if (!value.empty()) settings.emplace_back(name, value);
    };
    for (const FoundValue& found : report.found)
        add((found.option + " found").c_str(), found.value);
    add("radii used", report.requested);
    if (report.domain.voxelSize > 0)
        add("voxels used", fmt::format("{:.10g} mm", report.domain.voxelSize));
    add("seed", std::to_string(recipe.seed));
    add("threads", std::to_string(report.threads));
    return settings;
}

/// The page of a run on `subject`, with what all commands have in common.
ReportPage pageOf(const RunResult& run, const std::string& subject, const RunSettings& recipe) {
    ReportPage page;
    page.subject = subject;
    page.report = run.report;
    for (auto* texts : {&page.report.warnings, &page.report.chosen})
        for (std::string& text : *texts) text = withOptionNames(text);
    page.picture = run.picture;
    page.settings = settingsOf(recipe, run.report);
    return page;
}

}  // namespace

std::string reportFileOf(const RunSettings& settings, const Report& report) {
    const std::string& file = settings.reportFile;
    return report.interrupted && !file.empty() ? interruptedName(file) : file;
}

void writeReport(const RunResult& run, const std::string& subject, const RunSettings& settings,
                 const PageDetails& details) {
    const std::string file = reportFileOf(settings, run.report);
    if (file.empty()) return;
    Json figures = toJson(run);
    for (Json& text : figures["warnings"]) text = withOptionNames(text.get<std::string>());
    if (!isPage(file)) return write(file, jsonText(figures));
    ReportPage page = pageOf(run, subject, settings);
    if (details.structure) {
        addTo(figures, *details.structure);
        page.structure = *details.structure;
    }
    page.radii = details.radii;
    write(file, reportPage(page, figures));
}

RunResult reported(RunResult run, const InputPack& recipe) {
    PageDetails details;
    std::visit([&](const auto& pack) { details.radii = radiiOf(pack, 0, nullptr); }, run.pack);
    writeReport(run, recipe.pack, recipe, details);
    return run;
}

void writeReport(const MeasureResult& result, const MeasureRecipe& recipe) {
    if (recipe.reportFile.empty()) return;
    const Json figures = toJson(result);
    if (!isPage(recipe.reportFile)) return write(recipe.reportFile, jsonText(figures));
    ReportPage page = pageOf(result.run, recipe.pack, recipe);
    page.structure = result.structure;
    page.morphometry = result.morphometry;
    if (!result.morphometry)
        std::visit(
            [&](const auto& pack) {
                const auto sizes = recipe.sizes(page.report.dim);
                page.radii = radiiOf(pack, 0, sizes ? &*sizes : nullptr);
            },
            result.run.pack);
    write(recipe.reportFile, reportPage(page, figures));
}

}  // namespace vdbpack
