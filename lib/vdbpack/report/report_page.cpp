#include "vdbpack/report/report_page.h"

#include "vdbpack/report/markup.h"
#include "vdbpack/report/page_frame.h"
#include "vdbpack/report/report_charts.h"
#include "vdbpack/report/svg_chart.h"
#include "vdbpack/report/words.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace vdbpack {

namespace {

/// A value that is not finite counts as not measured.
void dropNotFinite(Report& r) {
    for (auto* value :
         {&r.solidFractionTotal, &r.solidFractionInterior, &r.ks, &r.ksByVolume, &r.smallestGap})
        if (*value && !std::isfinite(**value)) value->reset();
    if (r.voids && r.voids->bvtv && !std::isfinite(*r.voids->bvtv)) r.voids->bvtv.reset();
}

/// The row of figures at the top.
class Keys {
public:
    void add(const std::string& label, const std::string& value, const std::string& note = "",
             const char* style = "") {
        rows_ +=
            fmt::format("<div><dt>{}</dt><dd class='{}'>{}</dd>{}</div>\n", escaped(label), style,
                        escaped(value), note.empty() ? "" : "<dd>" + escaped(note) + "</dd>");
    }
    std::string html() const { return "<dl class='keys'>\n" + rows_ + "</dl>\n"; }

private:
    std::string rows_;
};

/// A check: nothing found beyond what the input pack had, or how much. `measure` does not judge.
void addCheck(Keys& keys, const Report& r, const char* label, std::uint64_t found,
              std::uint64_t given, const std::string& thing, double largest) {
    const std::string things = thing + "s";
    const bool judged = r.task != "measure";
    if (found == given)
        keys.add(
            label, "none",
            given > 0 ? fmt::format("new; {} {} of the input pack", grouped(given), things) : "",
            judged ? "good" : "");
    else
        keys.add(
            label, fmt::format("{} {}", grouped(found), found == 1 ? thing : things),
            fmt::format("{}largest {:.3g} of a radius", judged ? "CHECK FAILED, " : "", largest),
            judged ? "bad" : "");
}

void addPack(Keys& keys, const Report& r) {
    const DimensionWords words(r.dim);
    if (r.task != "voids")
        keys.add(words.spheres, grouped(r.count),
                 r.count > 0 ? fmt::format("radius {:.4g} to {:.4g} mm", r.radius.min, r.radius.max)
                             : "");
    if (r.solidFractionTotal)
        keys.add("solid fraction", fmt::format("{:.4f}", *r.solidFractionTotal),
                 r.solidFractionInterior ? fmt::format("{:.4f} deeper than three largest radii",
                                                       *r.solidFractionInterior)
                                         : "");
    if (r.overlap)
        addCheck(keys, r, "overlap", r.overlap->pairs, r.inputOverlaps, "pair", r.overlap->max);
    if (r.protrusion)
        addCheck(keys, r, "protrusion", r.protrusion->spheres, r.inputProtrusions, words.sphere,
                 r.protrusion->max);
    if (r.requestedGap > 0 && r.smallestGap)
        keys.add("smallest gap", fmt::format("{:.4g} mm", *r.smallestGap),
                 fmt::format("requested {:.4g} mm", r.requestedGap),
                 failedChecks(r).gap ? "bad" : "good");
    if (r.contacts)
        keys.add("coordination number", fmt::format("{:.2f}", r.contacts->mean),
                 r.domain.kind.empty()
                     ? "walls unknown"
                     : fmt::format("{:.2f} without walls", r.contacts->meanOfSpheres));
    if (r.voids && !r.voids->method.empty())
        keys.add("voids", grouped(r.voids->count),
                 (r.voids->bvtv ? fmt::format("BV/TV {:.4f}, ", *r.voids->bvtv) : "") +
                     fmt::format("{} {} culled", grouped(r.voids->culled), words.spheres));
    if (r.voids)
        for (const TargetReport& t : r.voids->targets)
            keys.add(t.symbol(), fmt::format("{:.4g}{}", t.reached, t.unit()),
                     fmt::format("{:g} asked, measured in a specimen of {:.4g} mm", t.asked,
                                 r.voids->specimen));
}

void addSolid(Keys& keys, const Morphometry& m) {
    const auto length = [&](const char* label, const std::optional<LengthStatistics>& s) {
        if (s)
            keys.add(label, fmt::format("{:.4g} mm", s->mean),
                     fmt::format("± {:.3g}, largest {:.4g}", s->sd, s->max));
    };
    keys.add("BV/TV", fmt::format("{:.4f}", m.solidFraction),
             fmt::format("{:.6g} of {:.6g} mm³", m.solidVolume, m.totalVolume));
    length("Tb.Th", m.thickness);
    length("Tb.Sp", m.separation);
    if (m.number) keys.add("Tb.N, 1/mm", fmt::format("{:.4g}", *m.number));
    if (m.structureModelIndex)
        keys.add("SMI", fmt::format("{:.4g}", *m.structureModelIndex),
                 "0: plates, 3: rods, 4: balls");
    keys.add("Conn.D, 1/mm³", fmt::format("{:.4g}", m.connectivityDensity),
             fmt::format("Euler number {:.6g}", m.eulerNumber));
    if (m.largestComponent)
        keys.add("largest component", fmt::format("{:.4g} %", 100 * *m.largestComponent),
                 "of the solid");
    if (m.anisotropy)
        keys.add("DA", fmt::format("{:.4f}", m.anisotropy->degree),
                 "0: the same in all directions");
}

/// Names of parameters, which messages have in backquotes, as code.
std::string withCode(std::string text) {
    bool open = false;
    for (std::size_t at = 0; (at = text.find('`', at)) != std::string::npos; open = !open)
        text.replace(at, 1, open ? "</code>" : "<code>");
    return open ? text + "</code>" : text;
}

std::string listOf(const std::vector<std::string>& lines) {
    std::string out;
    for (const auto& line : lines) out += "<li>" + withCode(escaped(line)) + "</li>\n";
    return "<ul>" + out + "</ul>\n";
}

std::string titleOf(const ReportPage& page) {
    const Report& r = page.report;
    // The folder is shown below, with the other settings.
    const std::string subject = page.subject.substr(page.subject.rfind('/') + 1);
    if (page.morphometry) return subject + ", bone morphometry";
    const std::string spheres = DimensionWords(r.dim).spheres;
    return r.task == "pack"      ? subject + ", packed with " + spheres
           : r.task == "voids"   ? subject + ", cut by voids"
           : r.task == "carve"   ? subject + ", a pack of " + spheres + " cut by voids"
           : r.task == "densify" ? subject + ", a pack of " + spheres + " densified"
                                 : subject + ", a pack of " + spheres + " measured";
}

/// Whether the page is about spheres: not of a solid, nor of voids alone.
bool hasSpheres(const ReportPage& page) {
    return !page.morphometry && page.report.task != "voids";
}

std::string again(const ReportPage& page) {
    const Report& r = page.report;
    std::string out = "<div class='card'>\n<pre>vdb_pack " + escaped(r.command) + "</pre>\n";
    out += "<p>" + escaped("vdb_pack " + r.version) + "</p>\n" + pairTable(page.settings);
    if (!r.chosen.empty()) out += "<p>Chosen by default:</p>\n" + listOf(r.chosen);
    if (!r.files.empty()) out += "<p>Written:</p>\n" + listOf(r.files);
    if (!r.recipe.empty())
        out += "<details><summary>The whole recipe</summary><pre>" + escaped(r.recipe) +
               "</pre></details>\n";
    if (!hasSpheres(page)) return out + "</div>\n";
    if (r.task == "pack")
        out +=
            "<p>The same version, input and settings give the same pack, for any number of "
            "threads.</p>\n";
    out += fmt::format(
        "<p>Its hash is <code>{}</code>, for any order of the {}. "
        "<code>vdb_pack verify FILE --json</code> computes it from a pack file in mm (any format "
        "but .ply), and so do the ten lines of numpy in assets/guides/files.md.</p>\n",
        hashText(r.hash), DimensionWords(r.dim).spheres);
    return out + "</div>\n";
}

}  // namespace

std::string reportPage(const ReportPage& page, const nlohmann::ordered_json& figures) {
    Report r = page.report;
    dropNotFinite(r);
    const std::string title = titleOf(page);
    Keys keys;
    if (page.morphometry)
        addSolid(keys, *page.morphometry);
    else
        addPack(keys, r);
    keys.add("seconds", fmt::format(r.seconds.total < 0.1 ? "{:.2g}" : "{:.2f}", r.seconds.total),
             fmt::format("on {} thread{}", r.threads, r.threads == 1 ? "" : "s"));
    if (hasSpheres(page)) keys.add("hash", hashText(r.hash), "", "hash");

    std::string out;
    out += "<h1>" + escaped(title) + "</h1>\n<p class='under'>" +
           escaped(fmt::format("vdb_pack {}", r.version)) +
           (r.requested.empty() ? "" : ", radii " + escaped(r.requested)) + "; lengths in mm</p>\n";
    if (r.interrupted) out += "<p class='bad'>Interrupted: the completed part.</p>\n";
    out += keys.html();
    out += pictureFigure(page.picture);
    if (!r.warnings.empty())
        out += "<h2>Warnings</h2>\n<div class='card'>" + listOf(r.warnings) + "</div>\n";
    if (hasSpheres(page))
        out += "<h2>Charts</h2>\n<div class='charts'>\n" +
               reportCharts(r, page.structure, page.radii) + "</div>\n";
    out += "<h2>All figures</h2>\n<div class='tables'>\n" + figureTables(figures, r.dim == 2) +
           "</div>\n";
    out += "<h2>How to repeat the run</h2>\n" + again(page);
    return htmlPage(title, chartStyle() + page.picture.viewStyle, out);
}

}  // namespace vdbpack
