#include "vdbpack/report/report_charts.h"

#include "vdbpack/report/svg_chart.h"
#include "vdbpack/report/words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

using Form = ChartSeries::Form;

/// Stages that take a smaller share of the longest one are left out.
constexpr double kLeastTime = 0.001;

std::vector<double> edgesOf(const RadiusHistogram& radii) {
    std::vector<double> edges;
    for (std::size_t b = 0; b <= radii.counts.size(); ++b)
        edges.push_back(radii.low + static_cast<double>(b) * radii.width);
    return edges;
}

/// Middles of bins from 0 on, in `unit`s.
std::vector<double> middles(std::size_t bins, double width, double unit) {
    std::vector<double> x;
    for (std::size_t b = 0; b < bins; ++b)
        x.push_back((static_cast<double>(b) + 0.5) * width / unit);
    return x;
}

/// Counts as shares of all, in percent.
std::vector<double> percent(const std::vector<std::uint64_t>& counts) {
    const double all =
        static_cast<double>(std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}));
    std::vector<double> shares;
    for (const std::uint64_t n : counts)
        shares.push_back(all > 0 ? 100 * static_cast<double>(n) / all : 0);
    return shares;
}

std::vector<double> percent(std::vector<double> shares) {
    for (double& share : shares) share *= 100;
    return shares;
}

/// Running sum, from 0.
std::vector<double> cumulated(const std::vector<double>& parts) {
    std::vector<double> sums{0};
    for (const double part : parts) sums.push_back(sums.back() + part);
    return sums;
}

/// An empty chart with its texts. @param none  shown instead of a chart without series.
Chart chartOf(const char* id, const char* title, const std::string& xLabel,
              const std::string& yLabel, const std::string& none) {
    Chart chart;
    chart.id = id;
    chart.title = title;
    chart.xLabel = xLabel;
    chart.yLabel = yLabel;
    chart.none = none;
    return chart;
}

std::string noSpheres(const DimensionWords& words) {
    return fmt::format("There are no {}.", words.spheres);
}

std::string requestText(const RadiusHistogram& radii, const Report& report,
                        const DimensionWords& words) {
    const std::string text =
        !radii.requested.empty() ? "Requested: " + report.requested
        : report.parts.empty()   ? "No size distribution to compare with (--radius)"
        : report.requested.empty()
            ? "Of all parts, each of which has sizes of its own"
            : "Of all parts, each of which is compared below with the request: " + report.requested;
    return report.existing > 0 ? text + fmt::format("; without the {} {} that existed before",
                                                    grouped(report.existing), words.spheres)
                               : text;
}

Chart sizes(const RadiusHistogram& radii, const Report& report, const DimensionWords& words) {
    Chart chart =
        chartOf("chart-sizes", "Sizes", "radius, mm",
                fmt::format("{}, % in each of {} bins", words.spheres, radii.counts.size()),
                noSpheres(words));
    chart.note = fmt::format("{}.", requestText(radii, report, words));
    const auto edges = edgesOf(radii);
    chart.series.push_back({"reached", Form::bars, edges, percent(radii.counts), {}});
    if (!radii.requested.empty())
        chart.series.push_back({"requested", Form::steps, edges, percent(radii.requested), {}});
    return chart;
}

Chart cumulatedSizes(const RadiusHistogram& radii, const Report& report,
                     const DimensionWords& words) {
    Chart chart = chartOf("chart-cumulated", "Sizes, cumulated", "radius, mm",
                          fmt::format("{} up to this radius, %", words.spheres), noSpheres(words));
    if (report.ks && report.ksByVolume)
        chart.note = fmt::format("Kolmogorov-Smirnov distance {:.2g}, by {} {:.2g}.", *report.ks,
                                 words.volume, *report.ksByVolume);
    if (radii.counts.empty()) return chart;
    const auto edges = edgesOf(radii);
    chart.series.push_back({"reached", Form::line, edges, cumulated(percent(radii.counts)), {}});
    if (!radii.requested.empty())
        chart.series.push_back(
            {"requested", Form::line, edges, cumulated(percent(radii.requested)), {}});
    return chart;
}

Chart coordination(const Report& report, const DimensionWords& words) {
    Chart chart = chartOf("chart-contacts", "Contacts", "contacts per " + words.sphere,
                          fmt::format("{}, %", words.spheres), noSpheres(words));
    chart.wholeTicks = true;
    if (!report.contacts) return chart;
    const ContactNetwork& c = *report.contacts;
    const bool walls = !report.domain.kind.empty();
    chart.note = fmt::format(
        "Coordination number {:.3g}{}; a contact is a gap up to {:g} of the smaller radius. "
        "{:.3g} % of the {} have fewer than {} contacts.",
        c.mean, walls ? fmt::format(", {:.3g} without walls", c.meanOfSpheres) : ", walls unknown",
        report.contactTolerance, 100 * c.fewShare, words.spheres, c.few);
    ChartSeries bars;
    bars.form = Form::bars;
    for (std::size_t n = 0; n <= c.histogram.size(); ++n)
        bars.x.push_back(static_cast<double>(n) - 0.5);
    bars.y = percent(c.histogram);
    chart.series.push_back(std::move(bars));
    return chart;
}

/// Why a chart that needs a domain is empty.
std::string noDomain(const Report& report, const std::string& otherwise) {
    return !report.parts.empty() ? "Parts have walls of their own: measure one part alone for this."
           : report.domain.kind.empty() ? "No domain was given (--domain): depths are unknown."
                                        : otherwise;
}

Chart profile(const Structure& structure, const Report& report, const DimensionWords& words) {
    Chart chart = chartOf(
        "chart-profile", "Solid fraction by depth", "depth below the wall, mm", "solid fraction",
        report.count == 0 ? noSpheres(words)
                          : noDomain(report, "The distance field is shallower than one bin."));
    chart.fromZero = true;
    if (!structure.profile) return chart;
    const DensityProfile& p = *structure.profile;
    const auto depth = middles(p.fraction.size(), p.width, 1);
    chart.note = fmt::format("In bins of {:.3g} mm, with standard errors.", p.width);
    chart.series.push_back({"", Form::line, depth, p.fraction, p.error});
    if (report.solidFractionInterior)
        chart.level = ChartLevel{
            fmt::format("{:.4f} deeper than three largest radii", *report.solidFractionInterior),
            *report.solidFractionInterior};
    return chart;
}

Chart pairs(const Structure& structure, const Report& report, const DimensionWords& words) {
    Chart chart = chartOf(
        "chart-pairs", "Pair correlation", "distance r, mean diameters", "g(r)",
        report.count == 0
            ? noSpheres(words)
            : noDomain(report, fmt::format("Fewer than 100 {} lie deep enough below the wall.",
                                           words.spheres)));
    chart.fromZero = true;
    if (!structure.pairCorrelation || !(structure.meanDiameter > 0)) return chart;
    const PairCorrelation& g = *structure.pairCorrelation;
    chart.note = fmt::format(
        "Density of centers at distance r from a center, divided by the mean density; averaged "
        "over {} centers.",
        grouped(g.references));
    chart.series.push_back(
        {"", Form::line, middles(g.g.size(), g.width, structure.meanDiameter), g.g, {}});
    chart.level = ChartLevel{"no order", 1};
    return chart;
}

/// A table of the stages, each with a bar.
std::string times(const Report& report) {
    auto stages = report.seconds.stages();
    if (report.task != "pack") stages.front().first = "read";
    double most = 0;
    for (const auto& [name, value] : stages) most = std::max(most, value);
    if (!(most > 0))
        return "<figure>\n<h3>Time</h3>\n<p class='none'>No times were recorded.</p>\n</figure>\n";
    std::string rows;
    for (const auto& [name, value] : stages)
        if (value > kLeastTime * most)
            rows += fmt::format(
                "<tr><th scope='row'>{0}</th><td><meter max='{1:.3g}' value='{2:.3g}'></meter></td>"
                "<td>{2:.3g} s</td></tr>\n",
                name, most, value);
    return fmt::format(
        "<figure>\n<h3>Time</h3>\n<table class='times' id='chart-seconds'><tbody>\n{}"
        "</tbody></table>\n<figcaption>{:.3g} s in all, on {} thread{}.</figcaption>\n</figure>\n",
        rows, report.seconds.total, report.threads, report.threads == 1 ? "" : "s");
}

}  // namespace

std::string reportCharts(const Report& report, const std::optional<Structure>& structure,
                         const RadiusHistogram& radii) {
    const DimensionWords words(report.dim);
    return figure(sizes(radii, report, words)) + figure(cumulatedSizes(radii, report, words)) +
           figure(coordination(report, words)) +
           (structure || !report.parts.empty()
                ? figure(profile(structure.value_or(Structure()), report, words)) +
                      figure(pairs(structure.value_or(Structure()), report, words))
                : std::string()) +
           times(report);
}

}  // namespace vdbpack
