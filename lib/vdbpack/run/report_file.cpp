#include "vdbpack/run/report_file.h"

#include "vdbpack/domain/intersection_domain.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/report/measured_pack.h"
#include "vdbpack/report/report_page.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
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

/// Of the spheres that were added; those that stood are not this run's choice.
template <int Dim>
RadiusHistogram histogramOf(const Pack<Dim>& pack, std::size_t existing,
                            const SizeDistribution* sizes, Ranks* ranks = nullptr) {
    std::vector<double> radii;
    for (std::size_t i = existing; i < pack.spheres.size(); ++i)
        radii.push_back(pack.spheres[i].radius);
    if (!sizes) return radiusHistogram(radii);
    return radiusHistogram(
        radii, [&](double r) { return sizes->cdfBelow(r); }, {sizes->min(), sizes->max()}, 40,
        ranks);
}

/// The options that were given, and what the run made of them.
std::vector<std::pair<std::string, std::string>> settingsOf(const RunSettings& recipe,
                                                            const Report& report) {
    auto settings = recipe.givenOptions;
    const auto add = [&](const char* name, const std::string& value) {
        if (!value.empty()) settings.emplace_back(name, value);
    };
    add("radii used", report.requested);
    if (report.domain.voxelSize > 0)
        add("voxels used", fmt::format("{:.10g} mm", report.domain.voxelSize));
    add("seed", std::to_string(recipe.seed));
    add("threads", std::to_string(report.threads));
    return settings;
}

/// The page of a run on `subject`, with what all commands have in common.
template <class Recipe>
ReportPage pageOf(const RunResult& run, const std::string& subject, const Recipe& recipe) {
    ReportPage page;
    page.subject = subject;
    page.report = run.report;
    page.picture = run.picture;
    page.settings = settingsOf(recipe, run.report);
    return page;
}

}  // namespace

template <int Dim>
PageDetails pageDetails(const Pack<Dim>& pack, std::size_t fixed, const DomainSource& source,
                        const DomainSource* around, const Domain<Dim>& domain,
                        const SizeDistribution& sizes, const Report& report,
                        const Callbacks& callbacks, const SphereRows& rows) {
    PageDetails details;
    // Radii by place have no distribution of their own.
    details.radii =
        histogramOf(pack, fixed, report.localSizes.empty() ? &sizes : nullptr, rows.ranks);
    // Its layers are those of one thickness.
    const double shell = report.voids && !report.voids->leastShell ? report.voids->shell : 0;
    const double depth = structureDepth(report.radius, shell);
    if (report.count == 0 || domain.fieldDepth() >= depth) {
        details.structure = measureStructure(pack, &domain, report, shell, callbacks, rows);
        return details;
    }
    const double detail = fieldDetail(report.radius.min, report.radius.mean);
    auto space = ofDim<Dim>(source.build(detail, depth / 3, callbacks));
    if constexpr (Dim == 3)
        if (around) space = partDomain(space, around->build(detail, depth / 3, callbacks).space);
    details.structure = measureStructure(pack, space.get(), report, shell, callbacks, rows);
    return details;
}

std::string reportFileOf(const RunSettings& settings, const Report& report) {
    const std::string& file = settings.reportFile;
    return report.interrupted && !file.empty() ? interruptedName(file) : file;
}

void writeReport(const RunResult& run, const PageDetails& details, const PackRecipe& recipe) {
    const std::string file = reportFileOf(recipe, run.report);
    if (file.empty()) return;
    Json figures = toJson(run);
    if (!isPage(file)) return write(file, jsonText(figures));
    addTo(figures, details.structure);
    ReportPage page = pageOf(run, recipe.domain.source, recipe);
    page.structure = details.structure;
    page.radii = details.radii;
    write(file, reportPage(page, figures));
}

namespace {

/// The report of a run on a pack that exists.
template <class Recipe>
void writeOfGiven(const RunResult& run, const Recipe& recipe) {
    const std::string file = reportFileOf(recipe, run.report);
    if (file.empty()) return;
    const Json figures = toJson(run);
    if (!isPage(file)) return write(file, jsonText(figures));
    ReportPage page = pageOf(run, recipe.pack, recipe);
    std::visit([&](const auto& pack) { page.radii = histogramOf(pack, 0, nullptr); }, run.pack);
    write(file, reportPage(page, figures));
}

}  // namespace

void writeReport(const RunResult& run, const CarveRecipe& recipe) {
    writeOfGiven(run, recipe);
}

void writeReport(const RunResult& run, const DensifyRecipe& recipe) {
    writeOfGiven(run, recipe);
}

void writeReport(const RunResult& run, const VoidsRecipe& recipe) {
    if (recipe.reportFile.empty()) return;
    const Json figures = toJson(run);
    if (!isPage(recipe.reportFile)) return write(recipe.reportFile, jsonText(figures));
    write(recipe.reportFile, reportPage(pageOf(run, recipe.domain.source, recipe), figures));
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
                page.radii = histogramOf(pack, 0, sizes ? &*sizes : nullptr);
            },
            result.run.pack);
    write(recipe.reportFile, reportPage(page, figures));
}

template PageDetails pageDetails<2>(const Pack<2>&, std::size_t, const DomainSource&,
                                    const DomainSource*, const Domain<2>&, const SizeDistribution&,
                                    const Report&, const Callbacks&, const SphereRows&);
template PageDetails pageDetails<3>(const Pack<3>&, std::size_t, const DomainSource&,
                                    const DomainSource*, const Domain<3>&, const SizeDistribution&,
                                    const Report&, const Callbacks&, const SphereRows&);

}  // namespace vdbpack
