#include "vdbpack/run/report_file.h"

#include "vdbpack/domain/intersection_domain.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/report/report_page.h"
#include "vdbpack/run/measure_stage.h"
#include "vdbpack/run/outputs.h"

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

/// The rows of a table; settings that were not requested have none.
class Settings {
public:
    void add(const std::string& name, const std::string& value) {
        if (!value.empty()) rows_.emplace_back(name, value);
    }
    void add(const std::string& name, double value, const char* unit = "") {
        if (value > 0) add(name, fmt::format("{:.10g}{}", value, unit));
    }
    void add(const std::string& name, const std::vector<std::string>& values) {
        for (const auto& value : values) add(name, value);
    }
    void add(const char* name, const DomainRecipe& domain, const Report& report) {
        add(name, domain.source);
        if (domain.unit != Unit::millimeter) add("--unit", unitName(domain.unit));
        if (domain.scale != 1) add("--scale", domain.scale);
        add("--grid", domain.gridName);
        add("--label", domain.label);
        if (domain.threshold) add("--threshold", fmt::format("{:g}", *domain.threshold));
        add("--slice", domain.slice);
        add("--clip", domain.clips);
        add("--periodic", domain.periodic);
        add("--voxel", domain.voxelSize, " mm");
        if (!(domain.voxelSize > 0)) add("voxels chosen", report.domain.voxelSize, " mm");
        if (domain.repair) add("--repair", "yes");
        add("--repair-voxel", domain.repairVoxel, " mm");
        if (domain.repairComponents == RepairComponents::separate)
            add("--repair-components", "separate");
        add("--cavities", domain.cavities);
        if (domain.shellFrom == ShellFrom::outer) add("--shell-from", "outer");
    }
    void add(const char* name, const InputPack& input, const Report& report) {
        add(name, input.pack);
        if (input.packUnit != Unit::millimeter) add("--pack-unit", unitName(input.packUnit));
        add("--domain", input.domain, report);
        add("--radius", input.radius);
        if (input.weightBy == WeightBy::volume) add("--weight-by", "volume");
    }
    void add(const RunSettings& settings, const Report& report, bool random = true) {
        if (random) add("--seed", std::to_string(settings.seed));
        add("--threads", std::to_string(report.threads));
        add("--contact-tol", settings.contactTolerance);
        add("--density", settings.density);
        for (const std::string& sample : settings.grey.samples) add("--sample", sample);
        add("--calibrate", settings.grey.calibration);
        add("--modulus", settings.grey.modulus);
        if (!settings.grey.calibration.empty())
            add("--density-classes", std::to_string(settings.grey.classes));
    }
    void add(const VoidRecipe& voids) {
        add("--voids", voids.method);
        add("--shell", voids.shell, " mm");
        add("--shell-field", voids.shellField);
        if (voids.cull == Cull::touch) add("--cull", "touch");
        if (voids.keepConnected) add("--keep-connected", "yes");
        add("--target-bvtv", voids.targetBvtv.value_or(0));
        add("--bvtv-field", voids.bvtvField);
        add("--bvtv-range", voids.bvtvRange);
        add("--trabecular", voids.trabecular);
        add("--like", voids.like);
        add("--target-tbth", voids.targetTbth.value_or(0), " mm");
        add("--target-tbsp", voids.targetTbsp.value_or(0), " mm");
        add("--target-da", voids.targetDa.value_or(0));
        add("--target-connd", voids.targetConnd.value_or(0), " /mm³");
        add("--void-voxel", voids.voxelSize, " mm");
        add("--void-radius", voids.radius);
        add("--void-aspect", voids.aspect);
        if (voids.blend) add("--void-blend", fmt::format("{} mm", *voids.blend));
        if (voids.strut) add("--void-strut", fmt::format("{} mm", *voids.strut));
        if (voids.strutShare) add("--void-strut-share", *voids.strutShare);
        if (voids.jitter) add("--void-jitter", *voids.jitter);
        add("--void-count", voids.count.value_or(0));
        if (voids.probability) add("--void-probability", fmt::format("{}", *voids.probability));
        add("--delete-fraction", voids.deleteFraction.value_or(0));
        add("--void-matrix", voids.matrix);
        add("--void-cell", voids.cell);
        add("--void-angles", voids.orientation.angles);
        add("--void-axis", voids.orientation.axis);
        add("--void-field", voids.orientation.field);
    }
    std::vector<std::pair<std::string, std::string>> take() { return std::move(rows_); }

private:
    std::vector<std::pair<std::string, std::string>> rows_;
};

std::string densifyText(double fraction) {
    return std::isfinite(fraction) ? fmt::format("{}", fraction) : "max";
}

std::vector<std::pair<std::string, std::string>> settingsOf(const PackRecipe& recipe,
                                                            const Report& report) {
    Settings s;
    s.add("DOMAIN", recipe.domain, report);
    s.add("--radius", recipe.radius.empty() ? "by default" : recipe.radius);
    if (recipe.weightBy == WeightBy::volume) s.add("--weight-by", "volume");
    s.add("--size-field", recipe.sizeField);
    s.add("--shell-radius", recipe.shellRadius);
    if (recipe.voids.fill == Fill::solid) s.add("--fill", "solid");
    s.add("--target-count", recipe.targetCount);
    s.add("radii used", report.requested);
    s.add("--max-count", static_cast<double>(recipe.maxCount));
    s.add("--effort", nameOf(recipe.effort));
    s.add("--order", nameOf(recipe.order));
    s.add("--block-side", recipe.blockSide, " mm");
    s.add("--gap", recipe.gap, " mm");
    if (recipe.densify > 0) s.add("--densify", densifyText(recipe.densify));
    s.add(recipe.voids);
    s.add("--existing", recipe.existing);
    if (!recipe.existing.empty()) s.add("--pack-unit", unitName(recipe.packUnit));
    s.add(recipe, report);
    if (recipe.outUnit != Unit::millimeter) s.add("--out-unit", unitName(recipe.outUnit));
    return s.take();
}

std::vector<std::pair<std::string, std::string>> settingsOf(const MeasureRecipe& recipe,
                                                            const Report& report) {
    Settings s;
    s.add("FILE", recipe, report);
    s.add("--shell", recipe.shell, " mm");
    if (recipe.sphereMorphometry) s.add("--morphometry", "yes");
    s.add("--dilation", recipe.dilation.value_or(0), " mm");
    s.add(recipe, report, false);
    return s.take();
}

std::vector<std::pair<std::string, std::string>> settingsOf(const CarveRecipe& recipe,
                                                            const Report& report) {
    Settings s;
    s.add("PACK", recipe, report);
    s.add(recipe.voids);
    s.add(recipe, report);
    return s.take();
}

std::vector<std::pair<std::string, std::string>> settingsOf(const DensifyRecipe& recipe,
                                                            const Report& report) {
    Settings s;
    s.add("PACK", recipe, report);
    s.add("--gap", recipe.gap, " mm");
    s.add("--densify", recipe.fraction > 0 ? densifyText(recipe.fraction) : "overlaps alone");
    s.add(recipe, report);
    return s.take();
}

std::vector<std::pair<std::string, std::string>> settingsOf(const VoidsRecipe& recipe,
                                                            const Report& report) {
    Settings s;
    s.add("DOMAIN", recipe.domain, report);
    s.add(recipe.voids);
    s.add("--seed", std::to_string(recipe.seed));
    s.add("--threads", std::to_string(report.threads));
    return s.take();
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

bool isPage(const std::string& reportFile) {
    return extensionOf(reportFile) == ".html";
}

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
                std::optional<SizeDistribution> sizes;
                if (!recipe.radius.empty())
                    sizes =
                        SizeDistribution::parse(recipe.radius, page.report.dim, recipe.weightBy);
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
