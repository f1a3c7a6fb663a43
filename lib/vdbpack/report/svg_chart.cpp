#include "vdbpack/report/svg_chart.h"

#include "vdbpack/report/markup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace vdbpack {

namespace {

/// The drawing is shown at 0.9 to 1.2 times these units, so text of size 12 is at least about 11
/// pixels high.
constexpr double kWidth = 360, kHeight = 232;
constexpr double kLeft = 44, kRight = 14, kTop = 24, kBottom = 40;
constexpr int kMostTicks = 6, kMostAcross = 8;
/// Width of a digit, rounded up.
constexpr double kDigit = 8;

double niceStep(double span, int most, bool whole) {
    const double raw = span / most;
    const double power = std::pow(10, std::floor(std::log10(raw)));
    double step = 10 * power;
    for (const double factor : {5, 2, 1})
        if (factor * power >= raw * (1 - 1e-9)) step = factor * power;
    return whole ? std::max(1.0, std::round(step)) : step;
}

/// A number with as many decimals as the step between ticks.
std::string tickText(double value, double step) {
    if (value == 0) return "0";
    if (step >= 1e5 || step < 1e-4) return fmt::format("{:.4g}", value);
    const double decimals = std::ceil(-std::log10(step) - 1e-9);
    return fmt::format("{:.{}f}", value, static_cast<int>(std::max(0.0, decimals)));
}

/// Maps values to coordinates of the drawing.
struct Axis {
    double low = 0, high = 1;
    double from = 0, to = 1;
    double operator()(double v) const {
        return from + (std::clamp(v, low, high) - low) / (high - low) * (to - from);
    }
};

double stepOf(const std::vector<double>& ticks) {
    return ticks.size() > 1 ? ticks[1] - ticks[0] : 1;
}

struct Extent {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    void add(double v) {
        if (!std::isfinite(v)) return;
        low = std::min(low, v);
        high = std::max(high, v);
    }
    bool any() const { return low <= high; }
};

bool overIntervals(const ChartSeries& s) {
    return s.form == ChartSeries::Form::bars || s.form == ChartSeries::Form::steps;
}

bool isDrawn(const ChartSeries& s, std::size_t i) {
    return i < s.y.size() && i + (overIntervals(s) ? 1 : 0) < s.x.size() && std::isfinite(s.y[i]) &&
           std::isfinite(s.x[i]) && (!overIntervals(s) || std::isfinite(s.x[i + 1]));
}

/// A mark with its value, shown when the pointer is on it.
std::string withTitle(const std::string& open, const char* element, const std::string& title) {
    return fmt::format("{}><title>{}</title></{}>", open, escaped(title), element);
}

std::string bars(const ChartSeries& s, const std::string& color, const Axis& x, const Axis& y) {
    std::string out;
    for (std::size_t i = 0; i < s.y.size(); ++i) {
        if (!isDrawn(s, i) || !(s.y[i] > 0)) continue;
        const double left = x(s.x[i]), right = x(s.x[i + 1]);
        const double between = right - left > 4 ? 1 : 0;
        out += withTitle(
            fmt::format(
                "<rect class='mark {}' x='{:.2f}' y='{:.2f}' width='{:.2f}' height='{:.2f}'", color,
                left + between / 2, y(s.y[i]), right - left - between, y(0) - y(s.y[i])),
            "rect", fmt::format("{:.4g} to {:.4g}: {:.4g}", s.x[i], s.x[i + 1], s.y[i]));
    }
    return out;
}

std::string path(const ChartSeries& s, const std::string& color, const Axis& x, const Axis& y) {
    std::string way;
    bool drawing = false;
    for (std::size_t i = 0; i < s.y.size(); ++i) {
        if (!isDrawn(s, i)) {
            drawing = false;
            continue;
        }
        way += fmt::format("{}{:.2f} {:.2f}", drawing ? "L" : "M", x(s.x[i]), y(s.y[i]));
        if (overIntervals(s)) way += fmt::format("H{:.2f}", x(s.x[i + 1]));
        drawing = true;
    }
    return fmt::format("<path class='mark line {}' d='{}'/>", color, way);
}

std::string errorBars(const ChartSeries& s, const std::string& color, const Axis& x,
                      const Axis& y) {
    std::string out;
    for (std::size_t i = 0; i < s.error.size(); ++i)
        if (isDrawn(s, i) && std::isfinite(s.error[i]))
            out += withTitle(fmt::format("<path class='error {}' d='M{:.2f} {:.2f}V{:.2f}'", color,
                                         x(s.x[i]), y(s.y[i] - s.error[i]), y(s.y[i] + s.error[i])),
                             "path",
                             fmt::format("{:.4g}: {:.4g} ± {:.2g}", s.x[i], s.y[i], s.error[i]));
    return out;
}

/// As many ticks as there is room for their labels.
std::vector<double> ticksAcross(const Axis& x, bool whole) {
    for (int most = kMostAcross;; --most) {
        const auto ticks = roundTicks(x.low, x.high, most, whole);
        double text = 0;
        for (const double v : ticks)
            text += kDigit * static_cast<double>(2 + tickText(v, stepOf(ticks)).size());
        if (text <= x.to - x.from || most == 1) return ticks;
    }
}

std::string axes(const Chart& chart, const Axis& x, const Axis& y) {
    std::string out;
    const auto yTicks = roundTicks(y.low, y.high, kMostTicks);
    for (const double v : yTicks)
        out += fmt::format(
            "<path class='grid' d='M{0:.1f} {1:.1f}H{2:.1f}'/>"
            "<text x='{3:.1f}' y='{4:.1f}' text-anchor='end'>{5}</text>",
            x.from, y(v), x.to, x.from - 6, y(v) + 4, tickText(v, stepOf(yTicks)));
    const auto xTicks = ticksAcross(x, chart.wholeTicks);
    for (const double v : xTicks)
        out += fmt::format(
            "<path class='axis' d='M{0:.1f} {1:.1f}v4'/>"
            "<text x='{0:.1f}' y='{2:.1f}' text-anchor='middle'>{3}</text>",
            x(v), y.from, y.from + 17, tickText(v, stepOf(xTicks)));
    out += fmt::format("<path class='axis' d='M{:.1f} {:.1f}H{:.1f}'/>", x.from, y.from, x.to);
    out += fmt::format("<text class='label' x='{:.1f}' y='{:.1f}' text-anchor='end'>{}</text>",
                       x.to, kHeight - 6, escaped(chart.xLabel));
    out += fmt::format("<text class='label' x='4' y='13'>{}</text>", escaped(chart.yLabel));
    return out;
}

std::string colorOf(std::size_t series) {
    return fmt::format("c{}", series % 2);
}

std::string legendOf(const Chart& chart) {
    std::string keys;
    for (std::size_t i = 0; i < chart.series.size(); ++i)
        if (!chart.series[i].name.empty())
            keys +=
                fmt::format("<span><i class='{} {}'></i>{}</span>\n",
                            chart.series[i].form == ChartSeries::Form::bars ? "block" : "stroke",
                            colorOf(i), escaped(chart.series[i].name));
    if (chart.level)
        keys += fmt::format("<span><i class='stroke dashed'></i>{}</span>\n",
                            escaped(chart.level->name));
    return keys.empty() ? "" : "<p class='legend'>" + keys + "</p>\n";
}

}  // namespace

std::vector<double> roundTicks(double low, double high, int most, bool whole) {
    if (!(high > low) || !std::isfinite(high - low)) return {low};
    const double step = niceStep(high - low, most, whole);
    std::vector<double> ticks;
    const double first = std::ceil(low / step - 1e-6), last = std::floor(high / step + 1e-6);
    for (double n = first; n <= last; ++n) ticks.push_back(n * step + 0.0);
    return ticks;
}

std::string figure(const Chart& chart) {
    Extent across, up;
    up.add(0);
    for (const auto& s : chart.series)
        for (std::size_t i = 0; i < s.y.size(); ++i) {
            if (!isDrawn(s, i)) continue;
            across.add(s.x[i]);
            if (overIntervals(s)) across.add(s.x[i + 1]);
            up.add(s.y[i]);
        }
    const std::string title = escaped(chart.title), note = escaped(chart.note);
    if (!across.any())
        return fmt::format("<figure>\n<h3>{}</h3>\n<p class='none'>{}</p>\n</figure>\n", title,
                           escaped(chart.none));
    if (chart.level) up.add(chart.level->y);
    if (chart.fromZero) across.add(0);
    if (!(across.high - across.low > 1e-9 * std::fabs(across.high))) {
        across.low -= 0.5;
        across.high += 0.5;
    }
    if (!(up.high > 0)) up.high = 1;
    const double step = niceStep(up.high, kMostTicks, false);
    const Axis x{across.low, across.high, kLeft, kWidth - kRight};
    const Axis y{0, std::ceil(up.high / step - 1e-6) * step, kHeight - kBottom, kTop};
    std::string content = axes(chart, x, y) + "\n";
    for (std::size_t i = 0; i < chart.series.size(); ++i) {
        const ChartSeries& series = chart.series[i];
        content += series.form == ChartSeries::Form::bars
                       ? bars(series, colorOf(i), x, y)
                       : path(series, colorOf(i), x, y) + errorBars(series, colorOf(i), x, y);
    }
    if (chart.level && std::isfinite(chart.level->y))
        content += fmt::format("<path class='level' d='M{:.1f} {:.2f}H{:.1f}'/>", x.from,
                               y(chart.level->y), x.to);
    return fmt::format(
        "<figure>\n<h3>{1}</h3>\n{2}<svg class='chart' id='{0}' viewBox='0 0 {3} {4}' role='img' "
        "aria-labelledby='{0}-title {0}-note'>\n<title id='{0}-title'>{1}</title>"
        "<desc id='{0}-note'>{5}</desc>\n{6}\n</svg>\n<figcaption>{5}</figcaption>\n</figure>\n",
        chart.id, title, legendOf(chart), kWidth, kHeight, note, content);
}

std::string chartStyle() {
    return R"(figure { margin: 0; }
svg.chart { display: block; width: 100%; max-width: 30rem; height: auto; }
svg.chart text { font: 12px system-ui, sans-serif; fill: var(--soft); }
svg.chart text.label { fill: var(--ink); }
svg.chart path { fill: none; }
.grid { stroke: var(--line); }
.axis { stroke: var(--soft); }
.level { stroke: var(--ink); stroke-dasharray: 5 4; }
rect.c0 { fill: var(--c0); }
rect.c1 { fill: var(--c1); }
path.line, path.error { stroke-width: 2; stroke-linejoin: round; }
path.error { stroke-width: 1.2; }
path.c0 { stroke: var(--c0); }
path.c1 { stroke: var(--c1); }
.legend { margin: 0 0 .3rem; display: flex; flex-wrap: wrap; gap: .2rem 1rem; font-size: .8125rem; }
.legend i { display: inline-block; width: 1rem; margin-right: .4rem; vertical-align: middle; }
.legend .block { height: .7rem; }
.legend .stroke { border-top: 3px solid; }
.legend .dashed { border-top: 2px dashed var(--ink); }
.legend .c0 { color: var(--c0); }
.legend .c1 { color: var(--c1); }
.legend .block { background: currentColor; }
.times th { width: 1%; white-space: nowrap; }
.times td { width: 1%; white-space: nowrap; }
.times td:nth-child(2) { width: 98%; }
.times meter { width: 100%; }
figcaption, .none { font-size: .8125rem; color: var(--soft); margin: .3rem 0 0; }
)";
}

}  // namespace vdbpack
