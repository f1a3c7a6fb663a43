#include "vdbpack/report/study_table.h"

#include "vdbpack/verify/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <type_traits>

namespace vdbpack {

namespace {

/// A figure of the runs.
struct Figure {
    const char* name;
    std::function<std::optional<double>(const Report&)> of;
    const char* form = "{:.10g}";
};

std::function<std::optional<double>(const Report&)> ofContacts(double ContactNetwork::*value) {
    return [value](const Report& r) {
        return r.contacts ? std::make_optional((*r.contacts).*value) : std::nullopt;
    };
}

template <class Value>
std::function<std::optional<double>(const Report&)> ofVoids(Value VoidReport::*value) {
    return [value](const Report& r) -> std::optional<double> {
        if (!r.voids) return std::nullopt;
        if constexpr (std::is_same_v<Value, std::uint64_t>)
            return static_cast<double>((*r.voids).*value);
        else
            return (*r.voids).*value;
    };
}

/// A number of a structure: measured in all of it, else as a specimen had it that met a target.
std::function<std::optional<double>(const Report&)> ofStructure(
    const std::string& target,
    std::function<std::optional<double>(const SolidMeasures&)> measured) {
    return [target, measured](const Report& r) -> std::optional<double> {
        if (!r.voids) return std::nullopt;
        if (r.voids->solid) return measured(*r.voids->solid);
        for (const TargetReport& t : r.voids->targets)
            if (t.name == target) return t.reached;
        return target == "targetTbth" ? r.voids->thickness : std::nullopt;
    };
}

std::optional<double> meanOf(const std::optional<LengthStatistics>& length) {
    return length ? std::make_optional(length->mean) : std::nullopt;
}

/// Spheres in the shell, or deeper.
std::function<std::optional<double>(const Report&)> ofRegion(bool inShell) {
    return [inShell](const Report& r) -> std::optional<double> {
        if (!r.voids || !(r.voids->shell > 0) || r.task == "voids") return std::nullopt;
        const std::uint64_t cortical = r.voids->cortical;
        return static_cast<double>(inShell ? cortical : r.count - cortical);
    };
}

const std::vector<Figure>& figures() {
    using R = const Report&;
    using M = const SolidMeasures&;
    using Value = std::optional<double>;
    const auto ofSpheres = [](const std::function<double(R)>& value) {
        return [value](R r) { return r.task == "voids" ? Value() : Value(value(r)); };
    };
    static const std::vector<Figure> all{
        {"count", ofSpheres([](R r) { return static_cast<double>(r.count); })},
        {"radius_mean", ofSpheres([](R r) { return r.radius.mean; })},
        {"ks", [](R r) { return r.ks; }},
        {"ks_volume", [](R r) { return r.ksByVolume; }},
        {"solid_total", [](R r) { return r.solidFractionTotal; }},
        {"solid_interior", [](R r) { return r.solidFractionInterior; }},
        {"contacts_mean", ofContacts(&ContactNetwork::mean)},
        {"few_contacts_share", ofContacts(&ContactNetwork::fewShare)},
        {"largest_component", ofContacts(&ContactNetwork::largestComponent)},
        {"overlap_max", [](R r) { return r.overlap ? Value(r.overlap->max) : Value(); }},
        {"overlap_pairs",
         [](R r) { return r.overlap ? Value(static_cast<double>(r.overlap->pairs)) : Value(); }},
        {"gap_min", [](R r) { return r.smallestGap; }},
        {"protrusion_max", [](R r) { return r.protrusion ? Value(r.protrusion->max) : Value(); }},
        {"protrusion_spheres",
         [](R r) {
             return r.protrusion ? Value(static_cast<double>(r.protrusion->spheres)) : Value();
         }},
        {"voids", ofVoids(&VoidReport::count)},
        {"bvtv", ofVoids(&VoidReport::bvtv)},
        {"tbth", ofStructure("targetTbth", [](M m) { return meanOf(m.thickness); })},
        {"tbsp", ofStructure("targetTbsp", [](M m) { return meanOf(m.separation); })},
        {"da",
         ofStructure("targetDa",
                     [](M m) { return m.anisotropy ? Value(m.anisotropy->degree) : Value(); })},
        {"connd", ofStructure("targetConnd", [](M m) { return Value(m.connectivityDensity); })},
        {"culled", ofVoids(&VoidReport::culled)},
        {"cortical", ofRegion(true)},
        {"trabecular", ofRegion(false)},
        {"solid_attached", ofVoids(&VoidReport::solidAttached)},
        {"spheres_attached", ofVoids(&VoidReport::spheresAttached)},
        {"seconds_pack", ofSpheres([](R r) { return r.seconds.pack; }), "{:.4f}"},
        {"seconds_total", [](R r) { return r.seconds.total; }, "{:.4f}"}};
    return all;
}

std::optional<double> figureOf(const std::string& name, const Report& report) {
    for (const Figure& figure : figures())
        if (name == figure.name) return figure.of(report);
    return std::nullopt;
}

/// A column of the summary.
struct SummaryColumn {
    const char* title;
    const char* figure;  ///< its name
    const char* form;
    int width;
};

std::vector<SummaryColumn> summaryColumns(const std::vector<Report>& reports) {
    const auto any = [&](const char* figure) {
        return std::any_of(reports.begin(), reports.end(),
                           [&](const Report& r) { return figureOf(figure, r).has_value(); });
    };
    const bool spheres = reports.empty() || any("count"), voids = any("bvtv");
    if (!spheres)
        return {{"voids", "voids", "{:.0f}", 9},
                {"BV/TV", "bvtv", "{:.4f}", 8},
                {"Tb.Th", "tbth", "{:.4g}", 7},
                {"attached", "solid_attached", "{:.4f}", 9},
                {"total, s", "seconds_total", "{:.2f}", 9}};
    std::vector<SummaryColumn> columns{{"spheres", "count", "{:.0f}", 9},
                                       {"solid", "solid_total", "{:.4f}", 7}};
    if (voids)
        columns.push_back({"BV/TV", "bvtv", "{:.4f}", 8});
    else
        columns.push_back({"interior", "solid_interior", "{:.4f}", 8});
    if (any("cortical"))
        columns.push_back({"cortical", "cortical", "{:.0f}", 8});
    else
        columns.push_back({"ks", "ks", "{:.5f}", 8});
    if (voids)
        columns.push_back({"connected", "largest_component", "{:.4f}", 9});
    else
        columns.push_back({"contacts", "contacts_mean", "{:.3f}", 8});
    if (any("tbth")) columns.push_back({"Tb.Th", "tbth", "{:.4g}", 7});
    columns.push_back({"pack, s", "seconds_pack", "{:.2f}", 7});
    return columns;
}

/// Mean and standard deviation, where there is any value.
std::array<std::optional<double>, 2> spreadOf(const char* figure,
                                              const std::vector<Report>& reports, std::size_t from,
                                              std::size_t to) {
    double n = 0, sum = 0, squares = 0;
    for (std::size_t run = from; run < to; ++run)
        if (const auto value = figureOf(figure, reports[run])) {
            n += 1;
            sum += *value;
            squares += *value * *value;
        }
    std::array<std::optional<double>, 2> spread;
    if (n > 0) spread[0] = sum / n;
    if (n > 1) spread[1] = std::sqrt(std::max(0.0, (squares - sum * sum / n) / (n - 1)));
    return spread;
}

/// Where the runs of the case end that begins with run `from`.
std::size_t endOfCase(const std::vector<Report>& reports, std::size_t from) {
    std::size_t to = from + 1;
    while (to < reports.size() && reports[to].varied == reports[from].varied) ++to;
    return to;
}

/// Which options the runs differ in.
const std::vector<std::pair<std::string, std::string>>& variedIn(
    const std::vector<Report>& reports) {
    static const std::vector<std::pair<std::string, std::string>> none;
    return reports.empty() ? none : reports.front().varied;
}

}  // namespace

std::string studyTable(const std::vector<Report>& reports) {
    std::string text;
    for (const auto& [option, value] : variedIn(reports)) text += option + ',';
    text += "seed,hash";
    for (const Figure& figure : figures()) text += std::string(",") + figure.name;
    text += '\n';
    for (const Report& r : reports) {
        for (const auto& [option, value] : r.varied) text += value + ',';
        text += fmt::format("{},{}", r.seed, r.task == "voids" ? "" : hashText(r.hash));
        for (const Figure& figure : figures()) {
            const auto value = figure.of(r);
            text += ',' + (value ? fmt::format(fmt::runtime(figure.form), *value) : "");
        }
        text += '\n';
    }
    return text;
}

std::string studySummary(const std::vector<Report>& reports, bool interrupted) {
    const auto columns = summaryColumns(reports);
    const auto cell = [](const SummaryColumn& c, const std::optional<double>& value) {
        return fmt::format(" {:>{}}", value ? fmt::format(fmt::runtime(c.form), *value) : "-",
                           c.width);
    };
    std::string text;
    const auto& options = variedIn(reports);
    const auto wide = [](const std::string& name) { return std::max<std::size_t>(8, name.size()); };
    for (const auto& [option, value] : options)
        text += fmt::format("{:>{}} ", option, wide(option));
    text += fmt::format("{:>8}", "seed");
    const bool spheres = columns.front().figure == std::string("count");
    for (const auto& c : columns) text += fmt::format(" {:>{}}", c.title, c.width);
    text += spheres ? fmt::format(" {:>17}\n", "hash") : "\n";
    const auto row = [&](std::size_t run, const std::string& name, const auto& valueOf) {
        for (const auto& [option, value] : reports[run].varied)
            text += fmt::format("{:>{}} ", value, wide(option));
        text += fmt::format("{:>8}", name);
        for (const auto& c : columns) text += cell(c, valueOf(c));
    };
    for (std::size_t from = 0, to; from < reports.size(); from = to) {
        to = endOfCase(reports, from);
        for (std::size_t run = from; run < to; ++run) {
            const Report& r = reports[run];
            row(run, std::to_string(r.seed), [&](const auto& c) { return figureOf(c.figure, r); });
            text += spheres ? fmt::format(" {:>17}\n", hashText(r.hash)) : "\n";
        }
        if (to - from < 2) continue;
        for (const std::size_t k : {0, 1}) {
            row(from, k == 0 ? "mean" : "sd",
                [&](const auto& c) { return spreadOf(c.figure, reports, from, to)[k]; });
            text += '\n';
        }
    }
    if (interrupted) text += fmt::format("interrupted after {} runs\n", reports.size());
    return text;
}

}  // namespace vdbpack
