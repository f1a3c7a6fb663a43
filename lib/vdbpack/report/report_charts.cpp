#include "vdbpack/report/report_charts.h"

#include "vdbpack/report/svg_chart.h"

#include <fmt/format.h>

#include <cstddef>
#include <numeric>

namespace vdbpack {

namespace {

using Form = ChartSeries::Form;

/// Stages that take less of all the time are left out.
constexpr double kLeastTime = 0.001;

/// Words that differ between the plane and space.
struct Words {
    explicit Words(int dim)
        : spheres(dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres),
          sphere(dim == 2 ? Measure<2>::kSphere : Measure<3>::kSphere),
          volume(dim == 2 ? Measure<2>::kVolume : Measure<3>::kVolume) {}
    std::string spheres, sphere, volume;
};

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

std::string askedIn(const RadiusHistogram& radii, const Report& report, const Words& words) {
    const std::string asked = radii.asked.empty()
                                  ? "Without a size distribution to compare with (--radius)"
                                  : "Asked for: " + report.requested;
    return report.existing > 0 ? asked + fmt::format("; without the {} {} that stood already",
                                                     grouped(report.existing), words.spheres)
                               : asked;
}

Chart sizes(const RadiusHistogram& radii, const Report& report, const Words& words) {
    Chart chart;
    chart.id = "chart-sizes";
    chart.title = "Sizes";
    chart.xLabel = "radius, mm";
    chart.yLabel = fmt::format("{}, % in each of {} bins", words.spheres, radii.counts.size());
    chart.none = fmt::format("There are no {}.", words.spheres);
    chart.note = fmt::format("{}.", askedIn(radii, report, words));
    const auto edges = edgesOf(radii);
    chart.series.push_back({"reached", Form::bars, edges, percent(radii.counts), {}});
    if (!radii.asked.empty())
        chart.series.push_back({"asked for", Form::steps, edges, percent(radii.asked), {}});
    return chart;
}

Chart cumulatedSizes(const RadiusHistogram& radii, const Report& report, const Words& words) {
    Chart chart;
    chart.id = "chart-cumulated";
    chart.title = "Sizes, cumulated";
    chart.xLabel = "radius, mm";
    chart.yLabel = fmt::format("{} up to this radius, %", words.spheres);
    chart.none = fmt::format("There are no {}.", words.spheres);
    if (report.ks && report.ksByVolume)
        chart.note = fmt::format("Kolmogorov-Smirnov distance {:.2g}, by {} {:.2g}.", *report.ks,
                                 words.volume, *report.ksByVolume);
    if (radii.counts.empty()) return chart;
    const auto edges = edgesOf(radii);
    chart.series.push_back({"reached", Form::line, edges, cumulated(percent(radii.counts)), {}});
    if (!radii.asked.empty())
        chart.series.push_back(
            {"asked for", Form::points, edges, cumulated(percent(radii.asked)), {}});
    return chart;
}

Chart coordination(const Report& report, const Words& words) {
    Chart chart;
    chart.id = "chart-contacts";
    chart.title = "Contacts";
    chart.xLabel = fmt::format("contacts of a {}", words.sphere);
    chart.yLabel = fmt::format("{}, %", words.spheres);
    chart.none = fmt::format("There are no {}.", words.spheres);
    chart.wholeTicks = true;
    if (!report.contacts) return chart;
    const ContactNetwork& c = *report.contacts;
    const bool walls = !report.domain.kind.empty();
    chart.note = fmt::format(
        "{:.3g} on average{}; touching means a gap within {:g} of the smaller radius. {:.3g} % "
        "have "
        "fewer than {}.",
        c.mean, walls ? fmt::format(", {:.3g} without walls", c.meanOfSpheres) : ", walls unknown",
        report.contactTolerance, 100 * c.fewShare, c.few);
    ChartSeries bars;
    bars.form = Form::bars;
    for (std::size_t n = 0; n <= c.histogram.size(); ++n)
        bars.x.push_back(static_cast<double>(n) - 0.5);
    bars.y = percent(c.histogram);
    chart.series.push_back(std::move(bars));
    return chart;
}

/// Why nothing is known that takes a domain.
std::string noDomain(const Report& report, const std::string& otherwise) {
    return report.domain.kind.empty()
               ? "No domain was given (--domain): nothing is known of depths."
               : otherwise;
}

Chart profile(const Structure& structure, const Report& report, const Words& words) {
    Chart chart;
    chart.id = "chart-profile";
    chart.title = "Solid fraction by depth";
    chart.xLabel = "depth below the wall, mm";
    chart.yLabel = "solid fraction";
    chart.fromZero = true;
    chart.none = report.count == 0
                     ? fmt::format("There are no {}.", words.spheres)
                     : noDomain(report, "The domain is not known as deep as a single bin.");
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

Chart pairs(const Structure& structure, const Report& report, const Words& words) {
    Chart chart;
    chart.id = "chart-pairs";
    chart.title = "Pair correlation";
    chart.xLabel = "distance r, mean diameters";
    chart.yLabel = "g(r)";
    chart.fromZero = true;
    chart.none =
        report.count == 0
            ? fmt::format("There are no {}.", words.spheres)
            : noDomain(report, fmt::format("Fewer than 100 {} lie deep enough below the wall.",
                                           words.spheres));
    if (!structure.pairCorrelation || !(structure.meanDiameter > 0)) return chart;
    const PairCorrelation& g = *structure.pairCorrelation;
    chart.note = fmt::format(
        "Density of centers at a distance from a center, by the mean density; about {} centers.",
        grouped(g.references));
    chart.series.push_back(
        {"", Form::line, middles(g.g.size(), g.width, structure.meanDiameter), g.g, {}});
    chart.level = ChartLevel{"no order", 1};
    return chart;
}

BarChart times(const Report& report) {
    BarChart chart;
    chart.id = "chart-seconds";
    chart.title = "Time";
    chart.unit = "s";
    chart.none = "No time was taken.";
    chart.note = fmt::format("{:.3g} s in all, on {} thread{}.", report.seconds.total,
                             report.threads, report.threads == 1 ? "" : "s");
    const Report::Seconds& s = report.seconds;
    for (const auto& [name, value] :
         {std::pair<const char*, double>{report.task == "pack" ? "mesh" : "read", s.mesh},
          {"domain", s.domain},
          {"pack", s.pack},
          {"voids", s.voids},
          {"measure", s.measure},
          {"write", s.write}})
        if (value > kLeastTime * s.total) chart.bars.emplace_back(name, value);
    return chart;
}

}  // namespace

std::string reportCharts(const Report& report, const Structure& structure,
                         const RadiusHistogram& radii) {
    const Words words(report.dim);
    return figure(sizes(radii, report, words)) + figure(cumulatedSizes(radii, report, words)) +
           figure(coordination(report, words)) + figure(profile(structure, report, words)) +
           figure(pairs(structure, report, words)) + figure(times(report));
}

}  // namespace vdbpack
