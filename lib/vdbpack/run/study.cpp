#include "vdbpack/run/study.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/run/outputs.h"
#include "vdbpack/run/pack_each.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace vdbpack {

StudyResult runStudy(const PackRecipe& recipe, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks) {
    if (seeds.empty()) throw ParameterError("there are no seeds; give at least one");
    std::vector<PackRecipe> recipes;
    for (const std::uint64_t seed : seeds) {
        recipes.push_back(recipeForSeed(recipe, seed));
    }
    if (seeds.size() > 1)
        for (const std::string& name : recipe.outputs)
            if (withSeed(name, 1) == name)
                throw ParameterError(name + ": each seed would replace it; name it with {seed}");
    if (seeds.size() > 1 && !recipe.reportFile.empty() &&
        withSeed(recipe.reportFile, 1) == recipe.reportFile)
        throw ParameterError("`reportFile` " + recipe.reportFile +
                             ": each seed would replace it; name it with {seed}, or set "
                             "`table` FILE.csv");
    if (seeds.size() > 1 && !recipe.preview.file.empty() &&
        withSeed(recipe.preview.file, 1) == recipe.preview.file)
        throw ParameterError("`preview.file` " + recipe.preview.file +
                             ": each seed would replace it; name it with {seed}");
    std::optional<OutputFile> file;
    if (!table.empty()) {
        if (extensionOf(table) != ".csv")
            throw ParameterError("`table` " + table + ": tables are CSV; name it .csv");
        if (withSeed(table, 1) != table)
            throw ParameterError("`table` " + table + ": one table holds all seeds; leave {seed}");
        for (const auto& r : recipes)
            checkFiles(r.outputs, r.reportFile, {r.domain.source, r.existing},
                       {r.preview.file, table});
        file.emplace(table);
    }
    StudyResult study;
    const auto writeTable = [&] {
        if (!file || study.reports.empty()) return;
        file->write(studyTable(study.reports));
        file->commit();
    };
    try {
        packEach(recipes, callbacks, [&](RunResult&& run) {
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

std::string studyTable(const std::vector<Report>& reports) {
    std::string text =
        "seed,hash,count,radius_mean,ks,ks_volume,solid_total,solid_interior,contacts_mean,"
        "few_contacts_share,largest_component,overlap_max,overlap_pairs,gap_min,protrusion_max,"
        "protrusion_spheres,seconds_pack,seconds_total\n";
    const auto number = [](const std::optional<double>& v) {
        return v ? fmt::format("{:.10g}", *v) : std::string();
    };
    for (const Report& r : reports) {
        const auto contacts = [&](double ContactNetwork::*value) {
            return r.contacts ? std::make_optional((*r.contacts).*value) : std::nullopt;
        };
        text += fmt::format(
            "{},{},{},{:.10g},{},{},{},{},{},{},{},{},{},{},{},{},{:.4f},{:.4f}\n", r.seed,
            hashText(r.hash), r.count, r.radius.mean, number(r.ks), number(r.ksByVolume),
            number(r.solidFractionTotal), number(r.solidFractionInterior),
            number(contacts(&ContactNetwork::mean)), number(contacts(&ContactNetwork::fewShare)),
            number(contacts(&ContactNetwork::largestComponent)),
            number(r.overlap ? std::make_optional(r.overlap->max) : std::nullopt),
            r.overlap ? std::to_string(r.overlap->pairs) : "", number(r.smallestGap),
            number(r.protrusion ? std::make_optional(r.protrusion->max) : std::nullopt),
            r.protrusion ? std::to_string(r.protrusion->spheres) : "", r.seconds.pack,
            r.seconds.total);
    }
    return text;
}

std::string summary(const StudyResult& study) {
    const char* form = "{:>8} {:>9} {:>7} {:>8} {:>8} {:>8} {:>7} {:>17}\n";
    std::string text = fmt::format(fmt::runtime(form), "seed", "spheres", "solid", "interior", "ks",
                                   "contacts", "pack, s", "hash");
    struct Sum {
        double n = 0, sum = 0, squares = 0;
        void add(double v) { n += 1, sum += v, squares += v * v; }
        std::string mean(const char* number) const {
            return n > 0 ? fmt::format(fmt::runtime(number), sum / n) : "-";
        }
        std::string sd(const char* number) const {
            if (n < 2) return "-";
            const double variance = std::max(0.0, (squares - sum * sum / n) / (n - 1));
            return fmt::format(fmt::runtime(number), std::sqrt(variance));
        }
    } count, total, interior, ks, contacts;
    for (const Report& r : study.reports) {
        const auto cell = [](const std::optional<double>& v, Sum& sum, const char* number) {
            if (v) sum.add(*v);
            return v ? fmt::format(fmt::runtime(number), *v) : std::string("-");
        };
        count.add(static_cast<double>(r.count));
        const auto mean = r.contacts ? std::make_optional(r.contacts->mean) : std::nullopt;
        text += fmt::format(fmt::runtime(form), r.seed, r.count,
                            cell(r.solidFractionTotal, total, "{:.4f}"),
                            cell(r.solidFractionInterior, interior, "{:.4f}"),
                            cell(r.ks, ks, "{:.5f}"), cell(mean, contacts, "{:.3f}"),
                            fmt::format("{:.2f}", r.seconds.pack), hashText(r.hash));
    }
    const auto row = [&](const char* name, std::string (Sum::*value)(const char*) const) {
        text += fmt::format(fmt::runtime(form), name, (count.*value)("{:.1f}"),
                            (total.*value)("{:.4f}"), (interior.*value)("{:.4f}"),
                            (ks.*value)("{:.5f}"), (contacts.*value)("{:.3f}"), "", "");
    };
    row("mean", &Sum::mean);
    row("sd", &Sum::sd);
    if (study.interrupted) text += fmt::format("interrupted after {} runs\n", study.reports.size());
    return text;
}

}  // namespace vdbpack
